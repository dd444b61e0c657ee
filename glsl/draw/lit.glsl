// What sun, sky and lamp make of a surface in a scene of meshes. Needs draw/view.glsl and draw/shadow.glsl.

// `mirrors`: share of the sun in the highlight.
vec3 surface_lit(vec3 albedo, float mirrors, vec3 at_m, vec3 n) {
    vec3 from_eye = at_m - view.eye_m.xyz, ray = normalize(from_eye), to_sun = view.to_sun.xyz;
    float facing = dot(n, to_sun), sun = facing > 0.0 ? facing * sun_share(at_m, n) : 0.0;
    vec3 bounce = vec3(0.2, 0.18, 0.15) * (1.0 - 0.5 * n.y);
    vec3 light = SUN_LIGHT * sun + SKY_LIGHT * (0.55 + 0.45 * n.y) + bounce;
    float shine = pow(max(dot(reflect(ray, n), to_sun), 0.0), 60.0) * mirrors;
    float rim = mirrors * 0.5 * pow(1.0 - max(-dot(ray, n), 0.0), 5.0);
    vec3 lit = albedo * light + SUN_LIGHT * (shine * (sun > 0.0 ? sun / facing : 0.0)) + SKY_LIGHT * rim;
    vec3 to_lamp = view.lamp_m.xyz - at_m;
    float far2 = dot(to_lamp, to_lamp);
    vec3 lamp = view.lamp.rgb * max(dot(n, to_lamp) * inversesqrt(far2 + 1e-6), 0.0) / (far2 + 0.1);
    return with_haze(lit * view.daylight, from_eye) + albedo * lamp;
}
