// SPDX-License-Identifier: MIT OR Apache-2.0
//! Paint from particles that are near.

use super::*;
use whitecap::paint::{
    cpu::{self, Aim},
    Method, TakeParams, Taken,
};

const RADIUS_M: f32 = 0.04;
const METHODS: [Method; 3] = [Method::Brute, Method::Tiles, Method::Sifted];

/// Paint of all drops by one method, on a canvas of its own.
fn paint_by(
    gpu: &TestGpu,
    paint: &Paint,
    scene: &Scene,
    drops: &[Drop],
    coats: &[Coat],
    method: Method,
    taken: &[Taken],
) -> Vec<[f32; 4]> {
    let canvas = scene.canvas(gpu, paint);
    // A buffer of no drops there is not.
    let held = if drops.is_empty() { vec![Drop { at_m: Vec3::ZERO, source: 0 }] } else { drops.to_vec() };
    let buffer = gpu.upload("test.drops", &held).unwrap();
    let gather = paint.gather(&canvas, &buffer, coats).unwrap();
    gpu.once(|rec| {
        for taken in taken {
            gather.record(rec, method, taken, RADIUS_M);
            rec.barrier(Paint::EXIT, Paint::ENTRY);
        }
    })
    .unwrap();
    canvas.download(gpu).unwrap()
}

/// The twin of the same.
fn twin(scene: &Scene, drops: &[Drop], coats: &[Coat], taken: &[Taken], format: Format) -> Vec<[f32; 4]> {
    let positions = cpu::place(&scene.atlas.texels, &scene.triangles, &scene.places);
    let mut paint = vec![[0f32; 4]; positions.len()];
    let aim = Aim { home: None, mesh: None, reach_sq_m2: RADIUS_M * RADIUS_M };
    for taken in taken {
        let these: Vec<_> = taken.indices().map(|i| (drops[i as usize], aim)).collect();
        cpu::gather(&positions, scene.mesh_of(), &these, coats, &mut paint);
        paint.iter_mut().for_each(|texel| *texel = cpu::stored(format, *texel));
    }
    paint
}

/// Inputs that break cullers: none, one, all in a tile, clusters, one beyond a chunk, what is no number.
fn inputs(mesh: &Mesh) -> Vec<(&'static str, Vec<Drop>)> {
    let spread = around(mesh, 5000, 5, 1);
    let corner = mesh.at_m[0];
    let at = |at_m: Vec3, i: usize| Drop { at_m, source: i as u32 % 5 };
    let pile = (0..700).map(|i| at(corner + 1e-4 * Vec3::splat((i % 10) as f32), i)).collect();
    let clusters = spread.iter().enumerate().map(|(i, drop)| {
        let centre = mesh.at_m[i / 300 % mesh.at_m.len()];
        at(centre + 0.1 * (drop.at_m - centre), i)
    });
    let mut odd = spread[..40].to_vec();
    odd[3].at_m.x = f32::NAN;
    odd[5].at_m = Vec3::splat(f32::INFINITY);
    odd[7].at_m = Vec3::splat(3e38);
    odd[9] = Drop { at_m: corner, source: 5 }; // of no coat
    odd[11] = Drop { at_m: corner, source: u32::MAX };
    vec![
        ("none", Vec::new()),
        ("one", vec![at(corner, 2)]),
        ("a pile", pile),
        ("clusters", clusters.collect()),
        ("no numbers", odd),
        ("2049", spread[..2049].to_vec()),
        ("5000", spread),
    ]
}

#[test]
fn the_gather_is_its_twin_and_every_method_paints_the_same_bits() {
    let gpu = gpu();
    let (block, coats) = (block(), coats(5));
    for paint in formats(&gpu) {
        for side in [1, 17, 256] {
            let scene = Scene::new(&gpu, &[(&block, UVec2::splat(side))]);
            for (name, drops) in inputs(&block) {
                // At full size the twin takes long, and brute force longer.
                if side == 256 && !matches!(name, "a pile" | "clusters") {
                    continue;
                }
                let taken = [Taken::all(drops.len() as u32)];
                let by = |method| paint_by(&gpu, &paint, &scene, &drops, &coats, method, &taken);
                let brute = by(Method::Brute);
                assert_same(&by(Method::Tiles), &brute, &format!("tiles, {side}, {name}"));
                assert_same(&by(Method::Sifted), &brute, &format!("sifted, {side}, {name}"));
                let format = if paint_is_halves(&paint) { Format::Halves } else { Format::Floats };
                let want = twin(&scene, &drops, &coats, &taken, format);
                if gpu.is_exact() {
                    assert_same(&brute, &want, &format!("{side}, {name}"));
                }
                if name == "clusters" && side == 17 {
                    // Control: the same drops the other way round are other paint.
                    let back: Vec<Drop> = drops.iter().rev().copied().collect();
                    let other = paint_by(&gpu, &paint, &scene, &back, &coats, Method::Tiles, &taken);
                    assert!(other.iter().zip(&brute).any(|(a, b)| (a[0] - b[0]).abs() > 0.01));
                }
                if side == 256 || side > 1 && drops.len() > 2000 {
                    assert!(painted(&brute) > 0, "{side}, {name}: nothing is compared");
                }
            }
        }
    }
}

fn paint_is_halves(paint: &Paint) -> bool {
    paint.format() == Format::Halves
}

#[test]
fn blocks_see_the_drops_that_the_twin_sees() {
    let gpu = gpu();
    let (lizard, coats) = (shapes::lizard(1.0), coats(1));
    let scene = Scene::new(&gpu, &[(&lizard, UVec2::new(200, 130))]);
    let paint = Paint::new(&gpu, Format::Halves).unwrap();
    let canvas = scene.canvas(&gpu, &paint);
    let drops = around(&lizard, 1000, 1, 3);
    let buffer = gpu.upload("test.drops", &drops).unwrap();
    let gather = paint.gather(&canvas, &buffer, &coats).unwrap();
    gpu.once(|rec| gather.record(rec, Method::Sifted, &Taken::all(1000), RADIUS_M)).unwrap();
    let (masks, words) = gather.masks();
    let (positions, tiles, blocks) = canvas.download_places(&gpu).unwrap();
    let (want_tiles, want_blocks) = cpu::both_boxes(&positions, 0);
    assert!(tiles == want_tiles && blocks == want_blocks, "boxes");
    let got = gpu.download::<u32>(masks).unwrap();
    let want = cpu::sift(&blocks, &drops, RADIUS_M * RADIUS_M, words as usize);
    let bits = |masks: &[u32]| masks.iter().map(|word| word.count_ones()).sum::<u32>();
    assert!(bits(&want) > 100 && bits(&want) < 12 * 1000 / 2, "{} bits", bits(&want));
    assert!(got == want, "{} bits, {} wanted", bits(&got), bits(&want));
}

#[test]
fn in_so_many_frames_every_particle_paints_once() {
    for (total, frames) in [(5000, 25), (5001, 25), (7, 25), (0, 3), (1, 1)] {
        let mut seen = vec![0; total as usize];
        for frame in 100..100 + frames {
            Taken::share(total, frame, frames).indices().for_each(|i| seen[i as usize] += 1);
        }
        assert!(seen.iter().all(|&times| times == 1), "{total} in {frames} frames");
    }
    // In one colour their order is none, and what n frames leave is what one would.
    let gpu = gpu();
    let (block, coats) = (block(), coats(1));
    let scene = Scene::new(&gpu, &[(&block, UVec2::splat(32))]);
    let paint = Paint::new(&gpu, Format::Floats).unwrap();
    let drops = around(&block, 1003, 1, 4);
    let shares: Vec<_> = (0..25).map(|frame| Taken::share(1003, frame, 25)).collect();
    let all = [Taken::all(1003)];
    for method in METHODS {
        let by = |taken: &[Taken]| paint_by(&gpu, &paint, &scene, &drops, &coats, method, taken);
        let (one, many) = (by(&all), by(&shares));
        if gpu.is_exact() {
            assert_same(&many, &twin(&scene, &drops, &coats, &shares, Format::Floats), "frames");
        }
        assert!(painted(&one) > 200);
        let apart = one.iter().zip(&many).flat_map(|(a, b)| (0..4).map(|i| (a[i] - b[i]).abs()));
        let apart = apart.fold(0.0, f32::max);
        assert!(apart < 1e-5, "{method:?}: {apart}"); // some tens of roundings of 6e-8
                                                      // Control: a frame left out shows.
        let less = by(&shares[1..]);
        assert!(less.iter().zip(&one).any(|(a, b)| (a[3] - b[3]).abs() > 0.01));
    }
}

#[test]
fn n_coats_cover_as_much_as_they_should_and_white_on_white_stays_white() {
    let gpu = gpu();
    let block = block();
    let scene = Scene::new(&gpu, &[(&block, UVec2::splat(16))]);
    for paint in formats(&gpu) {
        for opacity in [0.01, 0.1, 0.5, 1.0] {
            let coats = [Coat::new(Vec3::ONE, opacity, 0.1).unwrap()];
            // On one corner, as many as a dispatch has; then the same again, dispatch by dispatch.
            let drops = vec![Drop { at_m: block.at_m[0], source: 0 }; 50];
            let taken = vec![Taken { total: 50, first: 0, stride: 1 }; 4];
            let got = paint_by(&gpu, &paint, &scene, &drops, &coats, Method::Tiles, &taken);
            let covered = 1.0 - (1.0 - f64::from(opacity)).powi(200);
            // A half is rounded once a dispatch: 2^-12 of at most 1, four times; floats 200 times 2^-25.
            let allowed = if paint_is_halves(&paint) { 4.0 / 4096.0 } else { 200.0 / 3.3e7 };
            let touched: Vec<_> = got.iter().filter(|texel| texel[3] > 0.0).collect();
            assert!(!touched.is_empty());
            for texel in touched {
                let apart = (f64::from(texel[3]) - covered).abs();
                assert!(apart <= allowed, "opacity {opacity}: {texel:?}, {covered} wanted");
                assert!(texel.iter().all(|x| x.to_bits() == texel[3].to_bits()), "not white: {texel:?}");
                assert_eq!(texel[0] + (1.0 - texel[3]), 1.0, "white on white");
            }
        }
    }
}

/// Faint coats, one a dispatch: what halves cost. A coat is lost when what it adds, a (1 - A), is below half a step of a
/// half, 2^-12 where more than half is covered.
#[test]
fn faint_coats_stop_short_in_halves_and_go_on_in_floats() {
    let gpu = gpu();
    let block = block();
    let scene = Scene::new(&gpu, &[(&block, UVec2::splat(16))]);
    let opacity = 0.01;
    let coats = [Coat::new(Vec3::ONE, opacity, 0.1).unwrap()];
    let drops = [Drop { at_m: block.at_m[0], source: 0 }];
    let taken = vec![Taken::all(1); 1500];
    let cover = |paint: &Paint| {
        let got = paint_by(&gpu, paint, &scene, &drops, &coats, Method::Tiles, &taken);
        got.iter().map(|texel| texel[3]).fold(0.0, f32::max)
    };
    let [halves, floats] = [Format::Halves, Format::Floats].map(|f| cover(&Paint::new(&gpu, f).unwrap()));
    let short = 1.0 - halves;
    assert!(short <= 1.0 / 4096.0 / opacity + 1.0 / 2048.0, "{short} short");
    assert!(short > 0.01, "halves are better than the document says: {short}");
    assert!((1.0 - floats) < 1e-5, "{floats}");
    // Eight bits, as the seed has, would stop at 50 of 255.
    assert!(halves > 0.95);
}

#[test]
fn halves_round_to_the_nearest() {
    for bits in 0..0x7c00u16 {
        let x = cpu::float_of(bits);
        assert_eq!(cpu::half_of(x), bits, "{x}");
        let next = cpu::float_of((bits + 1).min(0x7bff));
        let middle = 0.5 * (x + next);
        let even = if bits % 2 == 0 { bits } else { bits + 1 };
        if next > x {
            assert_eq!(cpu::half_of(middle), even, "{middle}");
            assert_eq!(cpu::half_of(f32::from_bits(middle.to_bits() - 1)), bits);
        }
    }
    assert_eq!([0.0, 1.0, 65504.0, 1e9].map(cpu::half_of), [0, 0x3c00, 0x7bff, 0x7bff]);
}

#[test]
fn what_is_far_paints_nothing_and_texels_without_a_mesh_are_not_at_the_origin() {
    let gpu = gpu();
    let mut far = block();
    far.at_m.iter_mut().for_each(|at| at.x += 5.0);
    let scene = Scene::new(&gpu, &[(&far, UVec2::splat(40))]);
    let paint = Paint::new(&gpu, Format::Halves).unwrap();
    for method in METHODS {
        let by = |at_m| {
            let drops = [Drop { at_m, source: 0 }];
            painted(&paint_by(&gpu, &paint, &scene, &drops, &coats(1), method, &[Taken::all(1)]))
        };
        assert_eq!(by(Vec3::ZERO), 0, "{method:?}: a drop at the origin");
        assert_eq!(by(far.at_m[0] + Vec3::Y), 0, "{method:?}: a drop one metre away");
        assert!(by(far.at_m[0]) > 0, "{method:?}: control");
    }
}

#[test]
fn in_f64_the_same_texels_are_painted_but_those_on_the_rim() {
    let gpu = gpu();
    let (lizard, coats) = (shapes::lizard(1.0), coats(5));
    let scene = Scene::new(&gpu, &[(&lizard, UVec2::splat(128))]);
    let paint = Paint::new(&gpu, Format::Floats).unwrap();
    let drops = around(&lizard, 400, 5, 6);
    let got = paint_by(&gpu, &paint, &scene, &drops, &coats, Method::Sifted, &[Taken::all(400)]);
    let positions = cpu::place(&scene.atlas.texels, &scene.triangles, &scene.places);
    let mut want = vec![[0f64; 4]; positions.len()];
    let aim = Aim { home: None, mesh: None, reach_sq_m2: RADIUS_M * RADIUS_M };
    let aimed: Vec<_> = drops.iter().map(|drop| (*drop, aim)).collect();
    cpu::gather(&positions, |_| 0, &aimed, &coats, &mut want);
    let apart: Vec<f64> = got
        .iter()
        .zip(&want)
        .map(|(a, b)| (0..4).map(|i| (f64::from(a[i]) - b[i]).abs()).fold(0.0, f64::max))
        .collect();
    // A rim is decided by the last bit of a distance: 1 in 10^6 of the pairs that are near at all.
    let beyond = apart.iter().filter(|&&d| d > 1e-5).count();
    assert!(painted(&got) > 1000 && beyond <= 2, "{beyond} of {}", painted(&got));
}

#[test]
fn a_mesh_that_moves_is_painted_where_it_is() {
    let gpu = gpu();
    let lizard = shapes::lizard(1.0);
    let pose = whitecap::mesh::Pose::new(&gpu).unwrap();
    let posed = pose.mesh(&lizard).unwrap();
    let atlas = Atlas::new(&[(&lizard, UVec2::new(96, 64))], 2).unwrap();
    let paint = Paint::new(&gpu, Format::Halves).unwrap();
    let canvas = paint.canvas(&atlas, posed.places(), posed.triangles()).unwrap();
    let unit = glam::Mat4::IDENTITY;
    let mut before = Vec::new();
    for time_s in [0.0, 0.3] {
        gpu.once(|rec| {
            posed.record(rec, time_s, 1.0 / 60.0, unit, unit);
            rec.barrier(whitecap::mesh::Pose::EXIT, Paint::ENTRY);
            canvas.record_place(rec, &[0]);
        })
        .unwrap();
        let (positions, tiles, blocks) = canvas.download_places(&gpu).unwrap();
        let places: Vec<Vec3> = gpu
            .download::<[f32; 6]>(posed.places())
            .unwrap()
            .iter()
            .map(|p| Vec3::new(p[0], p[1], p[2]))
            .collect();
        let want = cpu::place(&atlas.texels, &lizard.triangles, &places);
        let apart = positions.iter().zip(&want).map(|(a, b)| (a.at_m - b.at_m).length()).fold(0.0, f32::max);
        assert!(apart <= if gpu.is_exact() { 0.0 } else { 1e-6 }, "{apart} m");
        assert!(positions.iter().zip(&want).all(|(a, b)| a.triangle == b.triangle));
        let (want_tiles, want_blocks) = cpu::both_boxes(&positions, 0);
        assert!(tiles == want_tiles && blocks == want_blocks);
        let moved = positions.iter().zip(&before).filter(|(a, b): &(&Position, &Position)| a != b).count();
        assert!(before.is_empty() || moved > 1000, "{moved} texels moved");
        before = positions;
    }
}

#[test]
fn rows_are_the_map_in_the_order_of_a_texture() {
    let gpu = gpu();
    let (block, coats) = (block(), coats(5));
    for paint in formats(&gpu) {
        let sizes = [UVec2::new(100, 17), UVec2::new(70, 131)];
        let scene = Scene::new(&gpu, &[(&block, sizes[0]), (&block, sizes[1])]);
        let canvas = scene.canvas(&gpu, &paint);
        let drops = around(&block, 300, 5, 8);
        let buffer = gpu.upload("test.drops", &drops).unwrap();
        let gather = paint.gather(&canvas, &buffer, &coats).unwrap();
        let rows = [0, 1].map(|mesh| paint.rows(&canvas, mesh).unwrap());
        gpu.once(|rec| {
            gather.record(rec, Method::Sifted, &Taken::all(300), RADIUS_M);
            rec.barrier(Paint::EXIT, Paint::ENTRY);
            rows.iter().for_each(|rows| rows.record(rec));
        })
        .unwrap();
        for (rows, map) in rows.iter().zip(canvas.maps()) {
            let per = paint.format().bytes() as usize;
            let all: Vec<u8> = gpu.download(canvas.paint()).unwrap();
            let texels: Vec<&[u8]> = all.chunks(per).collect();
            let want = cpu::rows(map, &texels).concat();
            assert!(gpu.download::<u8>(rows.rows()).unwrap() == want, "{map:?}");
            assert!(want.iter().any(|&byte| byte != 0));
        }
    }
}

#[test]
fn particles_of_a_pool_become_drops() {
    let gpu = gpu();
    let at: Vec<Vec3> = around(&block(), 700, 1, 5).iter().map(|drop| drop.at_m).collect();
    let stride = 1024;
    let mut planes = vec![7f32; 4 * stride];
    for (i, at) in at.iter().enumerate() {
        (0..3).for_each(|w| planes[w * stride + i] = at[w]);
    }
    let planes = gpu.upload("test.planes", &planes).unwrap();
    let counts = gpu.upload("test.counts", &[0u32, 3, 700]).unwrap();
    let drops = gpu.upload("test.drops", &vec![Drop { at_m: Vec3::ONE, source: 9 }; 1100]).unwrap();
    let take = Paint::new(&gpu, Format::Halves).unwrap().take(&planes, &counts, &drops).unwrap();
    let params = TakeParams { most: 1000, stride: 1024, count_at: 2, source: 4, to: 100 };
    gpu.once(|rec| take.record(rec, &params)).unwrap();
    let got: Vec<Drop> = gpu.download(&drops).unwrap();
    assert!(got[..100].iter().all(|drop| drop.source == 9));
    assert!(got[100..] == cpu::take(&at, 1000, 4));
}
