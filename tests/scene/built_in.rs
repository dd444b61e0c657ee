// SPDX-License-Identifier: MIT OR Apache-2.0
//! The scenes that come with the tool, and their terrains.

use super::make_terrain;
use whitecap::scene::{builtin, Start};

#[test]
fn the_built_in_scenes_load_with_their_terrains() {
    assert_eq!(
        builtin::list().map(|(name, _)| name).collect::<Vec<_>>(),
        [
            "fjord",
            "pond",
            "sombrero",
            "ripple_tank",
            "harbour",
            "dam_break",
            "puddles",
            "black_hole",
            "binary_hole",
            "campfire",
            "rain",
            "fireworks",
            "gas",
            "brownian",
            "avalanche",
            "paint_shower",
            "marbles",
            "sandblast"
        ]
    );
    for (name, title) in builtin::list() {
        let scene = builtin::load(name, &[]).unwrap_or_else(|error| panic!("{error}"));
        assert!(!title.is_empty() && !scene.title.is_empty());
        let simulates = !scene.water.is_empty() || !scene.emitters.is_empty() || !scene.disks.is_empty();
        assert!(simulates, "{name}");
        let heights = scene.terrain_heights().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(heights.is_some(), scene.terrain.is_some());
        let Some(map) = heights else { continue };
        assert!(map.warnings.is_empty());
        let (columns, rows) = (map.columns as usize, map.rows as usize);
        let border = (0..map.height_m.len()).filter(|i| {
            let (column, row) = (i % columns, i / columns);
            column == 0 || row == 0 || column == columns - 1 || row == rows - 1
        });
        let lowest = border.map(|i| map.height_m[i]).fold(f32::MAX, f32::min);
        let Some(water) = scene.water.first() else { continue };
        // Room for waves: half a metre; of a puddle, which is not that deep, 0.4 of its depth.
        let room_m = if water.depth_m < 0.5 { 0.4 * water.depth_m as f32 } else { 0.5 };
        assert!(lowest > water.level_m + room_m, "{name} runs out at the border, {lowest} m");
    }
    let smaller = builtin::load("fjord", &["water.lake.cells=[64, 64]".parse().unwrap()]).unwrap();
    assert_eq!(smaller.water[0].cells, [64, 64]);
    let error = builtin::load("fiord", &[]).unwrap_err().to_string();
    assert_eq!(
        error,
        "no built-in scene is called \"fiord\"; there are: fjord, pond, sombrero, ripple_tank, harbour, dam_break, puddles, \
         black_hole, binary_hole, campfire, rain, fireworks, gas, brownian, avalanche, paint_shower, marbles, \
         sandblast"
    );
}

#[test]
fn drops_of_the_built_in_scenes_fall_into_water() {
    for (name, _) in builtin::list() {
        let scene = builtin::load(name, &[]).unwrap();
        let Some(map) = scene.terrain_heights().unwrap() else { continue };
        for water in &scene.water {
            let start = match &water.start {
                Start::Hump { at_m, .. } | Start::Sombrero { at_m, .. } => Some(*at_m),
                Start::Flat | Start::Mode { .. } | Start::Block { .. } => None,
            };
            for [x, z] in water.drops.iter().map(|drop| drop.at_m).chain(start) {
                assert!(map.height_at(x, z) < water.level_m, "{name}: dry at {x}, {z}");
            }
        }
    }
}

#[test]
fn the_sombrero_has_the_books_wave_speed() {
    let water = &builtin::load("sombrero", &[]).unwrap().water[0];
    assert!(((water.gravity_mps2 * water.depth_m).sqrt() - 4.24).abs() < 1e-5);
}

/// The PNGs' samples are compared, not their bytes, which depend on the version of the encoder.
#[test]
fn the_terrains_are_what_make_terrain_makes() {
    let samples = |name: &str| -> Vec<u16> {
        let mut reader =
            png::Decoder::new(std::io::Cursor::new(builtin::asset(name).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        bytes.chunks_exact(2).map(|two| u16::from_be_bytes([two[0], two[1]])).collect()
    };
    assert!(samples("builtin/fjord.png") == make_terrain::fjord());
    assert!(samples("builtin/town.png") == make_terrain::town());
    assert!(samples("builtin/yard.png") == make_terrain::yard());
    assert!(builtin::asset("builtin/pond.asc").unwrap() == make_terrain::pond().as_bytes());
}
