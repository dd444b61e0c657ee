// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes: those made by rule, those read, damaged files, and posing on the GPU against its twin.
#![allow(missing_docs)]

mod common;

use common::gpu;
use glam::{vec2, vec3, Mat4, Quat, Vec3};
use std::{
    collections::HashMap,
    mem::{offset_of, size_of},
};
use whitecap::{
    gpu::reflect::reflect,
    mesh::{cpu, shapes, walls, walls::Side, Curve, Mesh, Pose, PoseParams, Track, Value},
    random, shaders,
};

fn made() -> Vec<Mesh> {
    vec![
        shapes::cuboid(vec3(0.4, 0.13, 0.4)),
        shapes::sphere(0.7, 32),
        shapes::torus(1.0, 0.3, 24),
        shapes::capsule(vec3(0.1, 0.0, 0.2), vec3(-0.3, 1.0, 0.4), 0.25, 16),
        shapes::lizard(1.0),
        walls::stencil(vec3(1.2, 0.8, 0.05), &["#####", "#. .#", "##.##", "#####"]),
        // A funnel with a wall as thick as a finger.
        walls::lathe(&[vec2(0.5, 0.4), vec2(0.12, 0.0), vec2(0.1, 0.0), vec2(0.48, 0.4), vec2(0.5, 0.4)], 24),
        walls::lathe(&[vec2(0.0, 0.2), vec2(0.3, 0.0), vec2(0.0, -0.1)], 9),
    ]
}

#[test]
fn a_room_is_seen_from_inside_and_may_be_open() {
    let closed = walls::room(vec3(0.5, 1.0, 2.0), &[]);
    assert!((volume(&closed) + 8.0).abs() < 1e-5, "{}", volume(&closed));
    let open = walls::room(vec3(0.5, 1.0, 2.0), &[Side::Front, Side::Top]);
    assert_eq!((closed.triangles.len(), open.triangles.len()), (12, 8));
    assert!(
        open.normals.iter().all(|n| n.y > -0.5 && n.z > -0.5),
        "walls that look in from the front or the top"
    );
    assert_eq!(overlapping_texels(&closed, 512), 0);
}

/// Vertices in one place are one.
fn welded(mesh: &Mesh) -> Vec<[usize; 3]> {
    let mut places = HashMap::new();
    let one = mesh.at_m.iter().map(|at| {
        let next = places.len();
        *places.entry((*at * 1e5).round().to_array().map(|x| x as i64)).or_insert(next)
    });
    let one: Vec<usize> = one.collect();
    mesh.triangles.iter().map(|corners| corners.map(|i| one[i as usize])).collect()
}

fn volume(mesh: &Mesh) -> f64 {
    let six = mesh.triangles.iter().map(|corners| {
        let [a, b, c] = corners.map(|i| mesh.at_m[i as usize].as_dvec3());
        a.dot(b.cross(c))
    });
    six.sum::<f64>() / 6.0
}

#[test]
fn made_meshes_are_closed_and_face_outward() {
    for mesh in made() {
        let mut edges = HashMap::<(usize, usize), i32>::new();
        for [a, b, c] in welded(&mesh) {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                assert_ne!(from, to, "{}: a triangle without area", mesh.name);
                *edges.entry((from, to)).or_default() += 1;
            }
        }
        for (&(from, to), &count) in &edges {
            assert_eq!((count, edges.get(&(to, from))), (1, Some(&1)), "{}: edge {from} {to}", mesh.name);
        }
        assert!(volume(&mesh) > 0.0, "{} is inside out", mesh.name);
        let away = mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5);
        assert!(away, "{}: normals of unit length", mesh.name);
    }
    // 32 squares round the equator hold 1.4 % less than the ball.
    let ball = 4.0 / 3.0 * std::f64::consts::PI * 0.7f64.powi(3);
    let share = volume(&shapes::sphere(0.7, 32)) / ball;
    assert!((0.97..0.99).contains(&share), "{share}");
    assert!((volume(&shapes::cuboid(vec3(0.4, 0.13, 0.4))) - 8.0 * 0.4 * 0.13 * 0.4).abs() < 1e-6);
}

/// Texels of a square texture whose centres lie in more than one triangle.
fn overlapping_texels(mesh: &Mesh, side: usize) -> usize {
    let mut cover = vec![0u8; side * side];
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|i| mesh.uv[i as usize].as_dvec2() * side as f64);
        let area = (b - a).perp_dot(c - a);
        if area == 0.0 {
            continue;
        }
        let (lo, hi) = (a.min(b).min(c).floor(), a.max(b).max(c).ceil());
        for y in lo.y as usize..(hi.y as usize).min(side) {
            for x in lo.x as usize..(hi.x as usize).min(side) {
                // Off the lattice, so that no centre lies on an edge that two share.
                let p = glam::dvec2(x as f64 + 0.5003, y as f64 + 0.5007);
                let inside = [(a, b), (b, c), (c, a)]
                    .iter()
                    .all(|(f, t)| (*t - *f).perp_dot(p - *f) * area.signum() > 0.0);
                cover[y * side + x] += u8::from(inside);
            }
        }
    }
    cover.iter().filter(|&&n| n > 1).count()
}

#[test]
fn made_meshes_can_be_painted_no_texel_twice() {
    for mesh in made() {
        assert_eq!(overlapping_texels(&mesh, 512), 0, "{}", mesh.name);
        assert!(mesh.uv.iter().all(|uv| uv.cmpge(vec2(0.0, 0.0)).all() && uv.cmple(vec2(1.0, 1.0)).all()));
    }
    let twice = shapes::cuboid(Vec3::ONE).with(&shapes::cuboid(Vec3::ONE));
    assert!(overlapping_texels(&twice, 512) > 1000, "the test sees no overlap");
}

/// A GLB of one triangle strip of three bones, its keys a turn of the last.
fn glb(change: impl Fn(&mut String, &mut Vec<u8>)) -> Vec<u8> {
    let floats: Vec<f32> = vec![
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, // POSITION
        1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, // WEIGHTS_0
        0.0, 1.0, // times
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.70710677, 0.70710677, // turns
    ];
    let mut bin: Vec<u8> = floats.iter().flat_map(|f| f.to_le_bytes()).collect();
    bin.extend([0u8, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0]); // JOINTS_0
    bin.extend([0u16, 1, 2, 1, 3, 2].iter().flat_map(|i| i.to_le_bytes())); // indices
    let mut json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
        "nodes":[{"mesh":0,"skin":0},{"translation":[0,0,0.5],"children":[2]},{"name":"tip"}],
        "skins":[{"joints":[1,2]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"WEIGHTS_0":1,"JOINTS_0":4},"indices":5}]}],
        "animations":[{"samplers":[{"input":2,"output":3,"interpolation":"LINEAR"}],
                       "channels":[{"sampler":0,"target":{"node":2,"path":"rotation"}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
            {"bufferView":0,"byteOffset":48,"componentType":5126,"count":4,"type":"VEC4"},
            {"bufferView":0,"byteOffset":112,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[1]},
            {"bufferView":0,"byteOffset":120,"componentType":5126,"count":2,"type":"VEC4"},
            {"bufferView":0,"byteOffset":152,"componentType":5121,"count":4,"type":"VEC4"},
            {"bufferView":0,"byteOffset":168,"componentType":5123,"count":6,"type":"SCALAR"}],
        "bufferViews":[{"buffer":0,"byteLength":180}],"buffers":[{"byteLength":180}]}"#
        .to_string();
    change(&mut json, &mut bin);
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let mut file = Vec::new();
    let word = |file: &mut Vec<u8>, n: usize| file.extend((n as u32).to_le_bytes());
    file.extend(b"glTF");
    word(&mut file, 2);
    word(&mut file, 12 + 8 + json.len() + 8 + bin.len());
    word(&mut file, json.len());
    file.extend(b"JSON");
    file.extend(json.as_bytes());
    word(&mut file, bin.len());
    file.extend(b"BIN\0");
    file.extend(bin);
    file
}

fn nothing(uri: &str) -> Result<Vec<u8>, String> {
    Err(format!("`{uri}` is not there"))
}

#[test]
fn a_skinned_file_is_read_and_moves_as_it_says() {
    let mesh = Mesh::decode("strip.glb", &glb(|_, _| {}), nothing).unwrap();
    assert_eq!((mesh.at_m.len(), mesh.triangles.len(), mesh.rig.joints.len()), (4, 2, 2));
    assert_eq!(mesh.rig.period_s, 1.0);
    assert_eq!(mesh.hold[2].weights, [0.0, 1.0, 0.0, 0.0], "weights are scaled to a sum of 1");
    // Half way, the tip has turned by 45 degrees about its joint, half a metre up.
    let half = cpu::pose(&mesh, &mesh.rig.pose(0.5), &mesh.rig.pose(0.4), &mesh.rig.pose(0.5), 10.0);
    let root = std::f32::consts::FRAC_1_SQRT_2;
    assert!((half[1].0 - vec3(0.5 + 0.5 * root, 0.5 * root, 0.5)).length() < 1e-6, "{}", half[1].0);
    assert!((half[2].0 - vec3(-root, root, 0.5)).length() < 1e-6, "{}", half[2].0);
    // It turns by 90 degrees a second, about (0, 0): speed of a point a metre away.
    assert!((half[2].1.length() - std::f32::consts::FRAC_PI_2).abs() < 0.03, "{}", half[2].1);
    assert!(half[0].1.length() == 0.0);
}

#[test]
fn an_object_file_is_read_with_its_faces_cut_to_triangles() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    let mesh = Mesh::decode("square.obj", text.as_bytes(), nothing).unwrap();
    assert_eq!((mesh.at_m.len(), mesh.triangles.len()), (4, 2));
    assert_eq!(mesh.uv[2], vec2(1.0, 0.0), "v is down");
    assert!(mesh.normals.iter().all(|n| *n == Vec3::Z));
}

#[test]
fn bad_files_are_refused_by_what_is_wrong() {
    let of = |change: &dyn Fn(&mut String, &mut Vec<u8>)| {
        Mesh::decode("a.glb", &glb(change), nothing).unwrap_err().to_string()
    };
    let swap = |from: &'static str, to: &'static str| {
        move |json: &mut String, _: &mut Vec<u8>| {
            assert!(json.contains(from), "{from}");
            *json = json.replace(from, to);
        }
    };
    for (message, wanted) in [
        (
            of(&swap(
                r#""byteOffset":168,"componentType":5123,"count":6"#,
                r#""byteOffset":168,"componentType":5123,"count":9"#,
            )),
            "reaches beyond its buffer",
        ),
        (of(&swap(r#""children":[2]"#, r#""children":[1]"#)), "two parents"),
        (of(&swap(r#""indices":5"#, r#""indices":5,"mode":1"#)), "allowed: Triangles"),
        (of(&swap(r#"{"asset""#, r#"{"extensionsRequired":["KHR_x"],"asset""#)), "KHR_x"),
        (of(&swap(r#""joints":[1,2]"#, r#""joints":[1]"#)), "a weight of joint 1; the skin has 1"),
        (of(&|_, bin| bin[4..8].copy_from_slice(&f32::NAN.to_le_bytes())), "vertex 0 is at"),
        (of(&|_, bin| bin[168] = 200), "corners of 4 vertices"),
        (Mesh::decode("a.stl", b"", nothing).unwrap_err().to_string(), "allowed are .glb, .gltf and .obj"),
        (Mesh::decode("a.obj", b"v 0 0 0\nf 1 2 9\n", nothing).unwrap_err().to_string(), "a.obj: "),
        (Mesh::decode("a.obj", b"", nothing).unwrap_err().to_string(), "0 vertices; allowed: 1 to"),
    ] {
        assert!(message.contains(wanted), "{message}");
    }
    let away = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[]}],"buffers":[{"byteLength":4,"uri":"../up.bin"}]}"#;
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("away.gltf");
    std::fs::write(&path, away).unwrap();
    let message = Mesh::read(&path).unwrap_err().to_string();
    assert!(message.contains("`../up.bin`; allowed are files beside it"), "{message}");
}

/// Damages whole files at random; each must be read or refused. `WHITECAP_FUZZ_RUNS` says how often.
#[test]
fn damaged_files_never_panic() {
    let runs = std::env::var("WHITECAP_FUZZ_RUNS").ok().and_then(|n| n.parse().ok()).unwrap_or(20_000u32);
    let obj = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\ng a\nf 1/1/1 2/1/1 3/1/1\nf -3 -2 -1\n".to_vec();
    let files = [("a.glb", glb(|_, _| {})), ("a.obj", obj)];
    let words: [&[u8]; 8] =
        [b"0", b"-1", b"4294967295", b"1e39", b"\"\"", b"null", b"[]", b"99999999999999999999"];
    let mut read = 0;
    for run in 0..runs {
        let (name, whole) = &files[run as usize % files.len()];
        let mut file = whole.clone();
        for cut in 0..1 + run % 4 {
            let [a, b, c, d] = random::bits(run, cut, 0, 77);
            let at = a as usize % file.len();
            match b % 5 {
                0 => file[at] = c as u8,
                1 => file[at] ^= 1 << (c % 8),
                2 => file.truncate(at.max(1)),
                3 => {
                    // A number of the text becomes another.
                    let digits = |file: &[u8], i: usize| file.get(i).is_some_and(u8::is_ascii_digit);
                    if let Some(from) = (at..file.len()).find(|&i| digits(&file, i)) {
                        let to = (from..file.len()).find(|&i| !digits(&file, i)).unwrap_or(file.len());
                        file.splice(from..to, words[c as usize % words.len()].iter().copied());
                        if name.ends_with("glb") && file.len() > 20 {
                            let grown = file.len() as i64 - whole.len() as i64;
                            let json = u32::from_le_bytes(file[12..16].try_into().unwrap());
                            let json = (i64::from(json) + grown).max(0) as u32;
                            file[12..16].copy_from_slice(&json.to_le_bytes());
                            let all = file.len() as u32;
                            file[8..12].copy_from_slice(&all.to_le_bytes());
                        }
                    }
                }
                _ => {
                    let to = at + d as usize % 16;
                    file.drain(at..to.min(file.len()));
                }
            }
            if file.is_empty() {
                file.push(0);
            }
        }
        read += usize::from(Mesh::decode(name, &file, nothing).is_ok());
    }
    assert!(
        read > runs as usize / 100 && read < runs as usize,
        "{read} of {runs} were read: nothing is tested"
    );
}

/// Where the first corner of a mesh is, and its velocity, at the end of a step.
fn first_corner(mesh: &Mesh, time_s: f64, dt_s: f64) -> (Vec3, Vec3) {
    let (from, to, rate) = mesh.rig.velocity_window(time_s, dt_s);
    let rig = &mesh.rig;
    cpu::pose(mesh, &rig.pose(time_s), &rig.pose_within(from), &rig.pose_within(to), rate)[0]
}

#[test]
fn velocities_are_finite_at_the_start_the_seam_and_without_time() {
    let mut mesh = shapes::cuboid(Vec3::ONE);
    // Two metres in a second, and then back at once: the loop has a seam.
    let value = Value::Move(vec![Vec3::ZERO, vec3(2.0, 0.0, 0.0)]);
    mesh.rig.tracks.push(Track { node: 0, time_s: vec![0.0, 1.0], value, curve: Curve::Linear });
    mesh.rig.period_s = 1.0;
    mesh.check().unwrap();
    let frame_s = 1.0 / 60.0;
    for (time_s, dt_s, speed_mps) in [
        (0.0, frame_s, 2.0),
        (0.5, frame_s, 2.0),
        (1.0, frame_s, 2.0),
        (1.004, frame_s, 2.0),
        (7.999, 0.5, 2.0),
        // No time, no way; and a step of nine loops has come along one.
        (0.0, 0.0, 0.0),
        (0.5, 0.0, 0.0),
        (3.2, 9.0, 2.0 / 9.0),
    ] {
        let (_, velocity) = first_corner(&mesh, time_s, dt_s);
        assert!(
            (velocity - vec3(speed_mps, 0.0, 0.0)).length() < 2e-3,
            "at {time_s} s, step {dt_s} s: {velocity}"
        );
    }
}

#[test]
fn a_loop_without_a_jump_moves_by_its_way_in_the_step_at_its_seam_too() {
    let mut swing = shapes::cuboid(Vec3::ONE);
    let value = Value::Move(vec![Vec3::ZERO, vec3(2.0, 0.0, 0.0), Vec3::ZERO]);
    swing.rig.tracks.push(Track { node: 0, time_s: vec![0.0, 0.5, 1.0], value, curve: Curve::Linear });
    swing.rig.period_s = 1.0;
    let dt_s = 1.0 / 60.0;
    for mesh in [swing, shapes::lizard(1.0)] {
        for time_s in [0.25 * dt_s, 0.3, 1.0, 1.0 + 0.4 * dt_s, 1.0 + dt_s, 7.0 + 0.9 * dt_s] {
            let (at, velocity) = first_corner(&mesh, time_s, dt_s);
            let came = (at - first_corner(&mesh, time_s - dt_s, dt_s).0) / dt_s as f32;
            assert!(
                (velocity - came).length() < 1e-4,
                "{} at {time_s} s: {velocity}, moved {came}",
                mesh.name
            );
        }
    }
}

/// Longest way of a vertex in a step by its length (m/s), and farthest place (m), over steps that begin at many times.
fn looked_at(mesh: &Mesh, dt_s: f64, times: impl Iterator<Item = f64>) -> (f32, f32) {
    let mut most = (0f32, 0f32);
    for time_s in times {
        let (from, to, rate) = mesh.rig.velocity_window(time_s, dt_s);
        let rig = &mesh.rig;
        let posed = cpu::pose(mesh, &rig.pose(time_s), &rig.pose_within(from), &rig.pose_within(to), rate);
        for (at, velocity) in posed {
            most = (most.0.max(velocity.length()), most.1.max(at.length()));
        }
    }
    most
}

#[test]
fn no_vertex_is_faster_or_farther_than_the_extent() {
    let block = shapes::cuboid(vec3(0.3, 0.1, 0.2));
    let with = |curve, value: Value, time_s: &[f32]| {
        let mut mesh = block.clone();
        mesh.rig.tracks.push(Track { node: 0, time_s: time_s.to_vec(), value, curve });
        mesh.rig.period_s = *time_s.last().unwrap();
        mesh.check().unwrap();
        mesh
    };
    let turn = |deg: f32| Quat::from_axis_angle(vec3(1.0, 2.0, 3.0).normalize(), deg.to_radians());
    let x = |x: f32| vec3(x, 0.1, 0.0);
    // A stroke of a fifth of a second in ten: what is looked at 64 times does not see it.
    let stroke = vec![x(0.0), x(0.0), x(0.6), x(0.0), x(0.0)];
    let stroke = with(Curve::Linear, Value::Move(stroke), &[0.0, 5.005, 5.105, 5.205, 10.0]);
    let turns = vec![turn(0.0), turn(170.0), turn(10.0), turn(0.0)];
    let cubic = |keys: &[Vec3]| keys.iter().flat_map(|&at| [0.4 * at, at, vec3(3.0, at.x, -1.0)]).collect();
    let cubic_turn = [0.0, 80.0, 160.0, 0.0].into_iter();
    let cubic_turn = cubic_turn.flat_map(|deg| [turn(30.0) * 0.3, turn(deg), turn(-20.0) * 0.2]).collect();
    let times = [0.0, 0.3, 0.7, 1.1];
    let meshes = [
        (stroke, 1.0),
        (with(Curve::Linear, Value::Turn(turns.clone()), &times), 1.0),
        (with(Curve::Step, Value::Turn(turns), &times), 4.0),
        (with(Curve::Linear, Value::Scale(vec![Vec3::ONE, x(2.0), Vec3::ONE, Vec3::ONE]), &times), 1.0),
        (with(Curve::Cubic, Value::Move(cubic(&[x(0.0), x(1.0), x(0.5), x(0.0)])), &times), 1.0),
        // How short a cubic gets before it is made unit is known by a bound of its own.
        (with(Curve::Cubic, Value::Turn(cubic_turn), &times), 1.8),
        (shapes::lizard(1.0), 1.0),
    ];
    for (i, (mesh, loose)) in meshes.into_iter().enumerate() {
        let period_s = f64::from(mesh.rig.period_s);
        for dt_s in [1.0 / 240.0, 1.0 / 60.0, 0.05] {
            let extent = mesh.extent(dt_s);
            let looks = if mesh.at_m.len() > 100 { 400 } else { 20_000 };
            let times = (0..looks).map(|k| period_s * (1.0 + f64::from(k) / f64::from(looks)));
            let (speed, far) = looked_at(&mesh, dt_s, times);
            let rounding = 16.0 * f32::EPSILON * far / dt_s as f32;
            assert!(
                speed <= extent.speed_mps + rounding && far <= extent.reach_m * (1.0 + 8.0 * f32::EPSILON),
                "{i}, {dt_s} s: {speed} m/s, {far} m: {extent:?}"
            );
            // Of a step of a key or two what is fast is averaged: bounds are of any moment.
            if dt_s < 0.005 {
                let most = loose * 1.5 * speed + 0.05;
                assert!(
                    extent.speed_mps < most && extent.reach_m < 1.3 * far,
                    "{i}: {speed} m/s, {far} m: {extent:?}"
                );
            }
        }
    }
    assert_eq!(block.extent(0.1).speed_mps, 0.0);
}

#[test]
fn a_plan_counts_the_keys_of_the_scene_and_of_the_file() {
    use whitecap::scene::{Key, MeshPlan, Motion};
    let mut mesh = shapes::cuboid(Vec3::splat(0.1));
    let value = Value::Move([0.0, 0.0, 0.6, 0.0, 0.0].map(|x| vec3(x, 0.0, 0.0)).to_vec());
    let time_s = vec![0.0, 5.005, 5.105, 5.205, 10.0];
    mesh.rig.tracks.push(Track { node: 0, time_s, value, curve: Curve::Linear });
    mesh.rig.period_s = 10.0;
    let key = |t_s, turn| Key { t_s, at_m: [0.0; 3], turn_deg: [0.0, turn, 0.0] };
    let plan = MeshPlan {
        name: "piston".into(),
        mesh,
        motion: Motion { keys: vec![key(0.0, 0.0), key(1.0, 360.0)], loops: true, scale: 2.0 },
        color: Vec3::ONE,
        mirrors: 0.0,
        tile_m: 0.0,
        map: 0,
        solid: true,
    };
    // 6 m/s by the file, twice as large; and a turn a second of what it reaches, which is 0.7 m on x and 0.1 m beside it.
    let least = 12.0 + std::f32::consts::TAU * 2.0 * vec3(0.7, 0.1, 0.1).length();
    let fastest = plan.fastest_mps(1.0 / 60.0);
    assert!((least..1.05 * least).contains(&fastest), "{fastest} m/s, {least} of them");
}

#[test]
fn what_overflows_between_its_keys_is_refused() {
    let mut mesh = shapes::cuboid(Vec3::ONE);
    let value = Value::Scale(vec![Vec3::ONE, Vec3::splat(3e38), Vec3::ONE]);
    mesh.rig.tracks.push(Track { node: 0, time_s: vec![0.0, 0.5, 1.0], value, curve: Curve::Linear });
    mesh.rig.period_s = 1.0;
    let said = mesh.check().unwrap_err().to_string();
    assert!(
        said.starts_with("box: its joints take it ") && said.ends_with("allowed: within 200000 m"),
        "{said}"
    );
}

#[test]
fn poses_are_those_of_the_twin() {
    let gpu = gpu();
    let pose = Pose::new(&gpu).unwrap();
    let mesh = shapes::lizard(1.3);
    let posed = pose.mesh(&mesh).unwrap();
    let world = Mat4::from_rotation_translation(Quat::from_rotation_y(0.7), vec3(0.3, 1.0, -2.0));
    let before = Mat4::from_rotation_translation(Quat::from_rotation_y(0.68), vec3(0.28, 1.0, -2.0));
    for (time_s, dt_s) in [(0.0, 0.0), (0.31, 1.0 / 60.0), (2.999, 1.0 / 30.0)] {
        gpu.once(|rec| {
            posed.record(rec, time_s, dt_s, world, before);
            rec.barrier(Pose::EXIT, whitecap::gpu::Access::CopyRead);
        })
        .unwrap();
        let got: Vec<[f32; 6]> = gpu.download(posed.places()).unwrap();
        let (from, to, rate) = mesh.rig.velocity_window(time_s, dt_s);
        let of = |world: Mat4, joints: Vec<Mat4>| {
            joints.into_iter().map(|joint| world * joint).collect::<Vec<_>>()
        };
        let rig = &mesh.rig;
        let want = cpu::pose(
            &mesh,
            &of(world, rig.pose(time_s)),
            &of(before, rig.pose_within(from)),
            &of(world, rig.pose_within(to)),
            rate,
        );
        let mut moved = 0;
        for (got, (at, velocity)) in got.iter().zip(&want) {
            let (got_at, got_velocity) = (Vec3::from_slice(&got[..3]), Vec3::from_slice(&got[3..]));
            if gpu.is_exact() {
                assert_eq!((got_at, got_velocity), (*at, *velocity), "at {time_s} s");
            }
            // A difference of places of some metres, a sixtieth of a second apart.
            assert!((got_at - *at).length() < 1e-5 && (got_velocity - *velocity).length() < 1e-3);
            moved += usize::from(velocity.length() > 0.01);
        }
        // A step of no length moves nothing.
        let least = if dt_s > 0.0 { want.len() / 2 } else { 0 };
        assert!(moved >= least && (moved > 0) == (dt_s > 0.0), "{moved} of {} vertices move", want.len());
    }
}

#[test]
fn push_constants_are_laid_out_alike() {
    let interface = reflect(shaders::MESH_POSE_COMP, &[]).unwrap();
    let members: Vec<_> =
        interface.structs["PoseParams"].members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
    let want = [
        ("vertices", offset_of!(PoseParams, vertices)),
        ("joints", offset_of!(PoseParams, joints)),
        ("rate_per_s", offset_of!(PoseParams, rate_per_s)),
        ("first_vertex", offset_of!(PoseParams, first_vertex)),
        ("first_joint", offset_of!(PoseParams, first_joint)),
    ];
    assert_eq!(members, want);
    assert_eq!(interface.push_bytes, size_of::<PoseParams>());
}
