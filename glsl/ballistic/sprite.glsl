// The sprites of an effect: draw/sprite.glsl says what they are. A streak ends where its particle is, and began as long ago
// as it is exposed, but not before its path. Needs draw/sprite.glsl and the effect's file.
#include "ballistic/flight.glsl"

bool sprite_of(uint i, out Sprite sprite) {
    if (i >= particles_alive()) return false;
    Who who;
    Flight f;
    if (!flight_of(i, who, f)) return false;
    Look l = look(who, f);
    if (l.half_m.x <= 0.0) return false;
    sprite.along_m = l.is_streak ? 0.5 * min(effect.exposure_s, f.age_s) * f.velocity_mps : vec3(0.0);
    sprite.at_m = f.at_m - sprite.along_m;
    sprite.half_m = l.half_m;
    sprite.turn = l.turn;
    sprite.color = l.color;
    return true;
}
