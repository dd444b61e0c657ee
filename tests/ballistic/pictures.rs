// SPDX-License-Identifier: MIT OR Apache-2.0
//! Effects in pictures. Set `WHITECAP_PICTURES` to a folder to look at them.

use super::hills;
use crate::common::gpu;
use glam::{uvec2, vec3, UVec2, Vec3};
use std::{env, fs};
use whitecap::{
    ballistic::{Builtin, Drawing, GroundGrid, Moment},
    draw::{Camera, Layers, Stage, TerrainGrid, View},
    gpu::{Gpu, Recorder},
};

const SIZE: UVec2 = uvec2(320, 200);

/// Four bytes a pixel, with the effect and without.
fn pictures(gpu: &Gpu, builtin: Builtin, camera: &Camera, time_s: f64) -> [Vec<u8>; 2] {
    let (grid, heights) = hills();
    let terrain =
        TerrainGrid { cells: grid.cells, size_m: grid.size_m, height_m: heights, built: Vec::new() };
    let mut stage = Stage::new(gpu, SIZE, Some(terrain)).unwrap();
    let ground = stage.terrain().map(|terrain| terrain.height().clone());
    let drawing = Drawing::new(gpu, &stage, builtin, ground.as_ref()).unwrap();
    let mut effect = builtin.effect();
    effect.emitter.at_m.y += 4.0;
    let params = effect.params(Moment::from_s(time_s), 1, 0, &GroundGrid { water_m: -1.0, ..grid }, u32::MAX);
    stage.set_view(&View::new(camera, SIZE, time_s as f32, vec3(0.3, 0.5, 0.4), 0.8));
    [true, false].map(|is_drawn| {
        let mut opaque = |_: &mut Recorder<'_>| {};
        let mut draw = |rec: &mut Recorder<'_>| {
            if is_drawn {
                drawing.record(rec, &params);
            }
        };
        let layers = Layers { opaque: &mut opaque, sprites: Some(&mut draw), splats: None };
        gpu.once(|rec| stage.record_layers(rec, layers)).unwrap();
        stage.read()
    })
}

fn save(name: &str, rgba: &[u8]) {
    let Some(dir) = env::var_os("WHITECAP_PICTURES") else { return };
    let mut ppm = format!("P6 {} {} 255\n", SIZE.x, SIZE.y).into_bytes();
    ppm.extend(rgba.chunks(4).flat_map(|pixel| pixel[..3].to_vec()));
    fs::write(std::path::Path::new(&dir).join(format!("{name}.ppm")), ppm).unwrap();
}

/// Share of the pixels that the effect changes, and the mean change of red and of blue.
fn change([with, without]: &[Vec<u8>; 2]) -> (f64, [f64; 2]) {
    let pixels = with.len() / 4;
    let changed = with.chunks(4).zip(without.chunks(4)).filter(|(a, b)| a != b).count();
    let of = |k: usize| {
        let sum: i64 = (0..pixels).map(|i| i64::from(with[4 * i + k]) - i64::from(without[4 * i + k])).sum();
        sum as f64 / pixels as f64
    };
    (changed as f64 / pixels as f64, [of(0), of(2)])
}

#[test]
fn effects_are_seen() {
    let gpu = gpu();
    if !gpu.has_graphics() {
        eprintln!("SKIP: {} cannot draw", gpu.name());
        return;
    }
    for builtin in Builtin::ALL {
        let (eye_m, target_m, share) = match builtin {
            Builtin::Rain | Builtin::Snow => (vec3(0.0, 6.0, 18.0), vec3(0.0, 5.0, 0.0), 0.02..0.9),
            Builtin::Fireworks => (vec3(0.0, 8.0, 55.0), vec3(0.0, 20.0, 0.0), 0.002..0.7),
            Builtin::Dust => (vec3(0.0, 4.4, 0.9), vec3(0.0, 4.2, 0.0), 0.002..0.7),
            _ => (vec3(0.0, 7.0, 12.0), vec3(0.0, 6.0, 0.0), 0.002..0.7),
        };
        let shots = pictures(&gpu, builtin, &Camera { eye_m, target_m, fov_rad: 0.9 }, 12.7);
        save(builtin.name(), &shots[0]);
        let (changed, [red, blue]) = change(&shots);
        println!("{}: {changed:.3} of the pixels, red {red:+.2}, blue {blue:+.2}", builtin.name());
        assert!(share.contains(&changed), "{builtin:?} changes {changed} of the pixels");
        if matches!(builtin, Builtin::Fire | Builtin::Sparks) {
            assert!(red > 0.0 && red > blue, "{builtin:?} does not glow: red {red}, blue {blue}");
        }
    }
}

/// Where a billboard that is made from the world's up has no axis: straight above.
#[test]
fn fire_is_seen_from_straight_above() {
    let gpu = gpu();
    if !gpu.has_graphics() {
        eprintln!("SKIP: {} cannot draw", gpu.name());
        return;
    }
    let camera = Camera { eye_m: vec3(0.0, 25.0, 0.0), target_m: Vec3::ZERO, fov_rad: 0.9 };
    let (changed, _) = change(&pictures(&gpu, Builtin::Fire, &camera, 5.0));
    assert!((0.01..0.6).contains(&changed), "{changed} of the pixels");
}
