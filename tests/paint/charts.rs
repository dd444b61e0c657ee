// SPDX-License-Identifier: MIT OR Apache-2.0
//! Texture coordinates: what is covered, what overlaps, what is refused, and seams.

use super::*;
use glam::{vec2, vec3, Vec2};
use whitecap::paint::{cpu, Method, Taken};

fn made() -> Vec<Mesh> {
    vec![block(), shapes::sphere(0.7, 32), shapes::torus(1.0, 0.3, 24), shapes::lizard(1.0)]
}

fn atlas(mesh: &Mesh, side: u32, gutter: u32) -> Atlas {
    Atlas::new(&[(mesh, UVec2::splat(side))], gutter).unwrap()
}

#[test]
fn charts_cover_their_area_and_no_texel_twice() {
    for mesh in made() {
        for side in [1, 17, 256, 300] {
            let charts = &atlas(&mesh, side, 2).charts[0];
            assert_eq!(charts.overlapping, 0, "{}, {side}: {charts:?}", mesh.name);
            let area: f64 = mesh
                .triangles
                .iter()
                .map(|corners| {
                    let [a, b, c] = corners.map(|i| mesh.uv[i as usize].as_dvec2());
                    (b - a).perp_dot(c - a).abs() / 2.0
                })
                .sum();
            let texels = area * f64::from(side).powi(2);
            // Centres against area: off by less than a texel along the border of the charts, of tens of sides.
            let border = 12.0 * f64::from(side) + 20.0;
            let apart = charts.covered as f64 - texels;
            assert!(
                apart.abs() < border.min(0.02 * texels + 40.0),
                "{}, {side}: {charts:?}, {texels}",
                mesh.name
            );
        }
    }
}

#[test]
fn two_triangles_share_an_edge_and_no_texel_of_it() {
    // Fans round a point, with edges through centres of texels, at every turn: each texel inside belongs to one.
    for spokes in [3, 4, 7, 8, 16] {
        let rim = |k: u32| {
            let angle = k as f32 / spokes as f32 * std::f32::consts::TAU;
            vec2(0.5, 0.5) + 0.4375 * vec2(angle.cos(), angle.sin())
        };
        let uv: Vec<Vec2> = std::iter::once(vec2(0.5, 0.5)).chain((0..spokes).map(rim)).collect();
        let at = uv.iter().map(|uv| vec3(uv.x, uv.y, 0.0)).collect();
        let fan = (0..spokes).map(|k| {
            let corners = [0, 1 + k, 1 + (k + 1) % spokes];
            if k % 2 == 0 {
                corners
            } else {
                [corners[0], corners[2], corners[1]]
            } // also mirrored
        });
        let mesh = Mesh::still("fan", at, uv.clone(), fan.collect()).unwrap();
        for side in [16, 17, 64] {
            let atlas = atlas(&mesh, side, 0);
            assert_eq!(atlas.charts[0].overlapping, 0, "{spokes} spokes, {side}");
            // No hole: well inside the fan all are covered.
            let map = atlas.maps[0];
            let inside = (0..side * side).map(|i| (i % side, i / side)).filter(|&(x, y)| {
                let centre = (vec2(x as f32, y as f32) + 0.5) / side as f32;
                (centre - vec2(0.5, 0.5)).length()
                    < 0.4375 * (std::f32::consts::PI / spokes as f32).cos() - 0.01
            });
            for (x, y) in inside {
                let texel = atlas.texels[map.texel(x, y)];
                assert!(texel.triangle().is_some() && !texel.is_gutter(), "{spokes}, {side}: {x}, {y}");
                // And where it says: its place is its texture coordinates.
                let [a, b, c] = mesh.triangles[texel.triangle().unwrap() as usize].map(|i| uv[i as usize]);
                let uv = a + (b - a) * texel.b + (c - a) * texel.c;
                let apart = (uv * side as f32 - vec2(x as f32 + 0.5, y as f32 + 0.5)).length();
                assert!(apart < 0.01, "{apart} texels at {x}, {y}"); // corners are rounded to 1/256
            }
        }
    }
}

#[test]
fn overlaps_are_found_counted_and_shown() {
    let twice = block().with(&block());
    let atlas = atlas(&twice, 128, 2);
    let charts = &atlas.charts[0];
    assert_eq!(charts.overlapping, charts.covered, "each lies on its twin");
    assert_eq!(charts.overlap(), 1.0);
    let example = charts.example.unwrap();
    assert_eq!(example.triangles[1], example.triangles[0] + 12, "{example:?}");
    let painted = atlas.texels[atlas.maps[0].texel(example.at.x, example.at.y)];
    assert_eq!(painted.triangle(), Some(example.triangles[0]), "the first is painted");
    // One chart moved over another: as much as they share.
    let mut moved = block();
    let shift = moved.uv[4] - moved.uv[0];
    moved.uv[4..8].iter_mut().for_each(|uv| *uv -= 0.5 * shift);
    let share = super::Atlas::new(&[(&moved, UVec2::splat(256))], 2).unwrap().charts[0].overlap();
    assert!((0.05..0.12).contains(&share), "{share}"); // half of a sixth
                                                       // Three on a texel count once.
    let thrice = twice.with(&block());
    let charts = &super::Atlas::new(&[(&thrice, UVec2::splat(64))], 2).unwrap().charts[0];
    assert_eq!(charts.overlapping, charts.covered);
}

#[test]
fn what_cannot_be_painted_is_refused_by_name() {
    let error = |mesh: &Mesh, size| Atlas::new(&[(mesh, size)], 2).unwrap_err().to_string();
    let size = UVec2::splat(64);
    let mut bare = block();
    bare.uv.clear();
    assert_eq!(error(&bare, size), "box: no texture coordinates: it cannot be painted");
    for (uv, said) in [(vec2(1.25, 0.5), "(1.25, 0.5)"), (vec2(0.5, -0.1), "(0.5, -0.1)")] {
        let mut outside = block();
        outside.uv[7] = uv;
        let want = format!(
            "box: vertex 7 has the texture coordinates {said}; allowed are 0 to 1 where a mesh is painted"
        );
        assert_eq!(error(&outside, size), want);
    }
    let mut wild = block();
    wild.uv[0].x = f32::NAN;
    assert!(error(&wild, size).contains("NaN"));
    assert!(error(&block(), UVec2::new(0, 5)).contains("0 x 5 texels; allowed are sides of 1 to 8192"));
    assert!(error(&block(), UVec2::new(8193, 5)).contains("8193"));
    assert!(error(&block(), UVec2::MAX).contains("4294967295"));
    let block = block();
    let many = Atlas::new(&[(&block, UVec2::splat(8192)); 3], 2).unwrap_err().to_string();
    assert!(many.contains("49152 blocks of 64 x 64 texels; allowed are 32768 for all meshes"), "{many}");
    // A triangle that is a line on the map is counted.
    let mut flat = block.clone();
    let one = flat.uv[0];
    flat.uv[..4].iter_mut().for_each(|uv| *uv = one);
    assert_eq!(atlas(&flat, 64, 2).charts[0].flat, 2);
}

#[test]
fn the_gutter_holds_the_nearest_point_of_the_mesh() {
    for mesh in made() {
        let side = 61;
        let atlas = atlas(&mesh, side, 3);
        let map = atlas.maps[0];
        let mut gutter = 0;
        for (x, y) in (0..side * side).map(|i| (i % side, i / side)) {
            let texel = atlas.texels[map.texel(x, y)];
            let centre = vec2(x as f32 + 0.5, y as f32 + 0.5);
            let point = |corners: &[u32; 3], b: f32, c: f32| {
                let [p, q, r] = corners.map(|i| mesh.uv[i as usize] * side as f32);
                p + (q - p) * b + (r - p) * c
            };
            let Some(triangle) = texel.triangle() else {
                // Then no corner of any triangle is in reach.
                let nearest =
                    mesh.uv.iter().map(|uv| (*uv * side as f32 - centre).length()).fold(9.0, f32::min);
                assert!(nearest > 3.0 - 0.01, "{x}, {y}: a corner at {nearest}");
                continue;
            };
            let away = (point(&mesh.triangles[triangle as usize], texel.b, texel.c) - centre).length();
            if texel.is_gutter() {
                gutter += 1;
                assert!(away <= 3.0 + 0.01, "{x}, {y}: {away}");
                assert!(texel.b >= 0.0 && texel.c >= 0.0 && texel.b + texel.c <= 1.0 + 1e-6);
            } else {
                assert!(away < 0.02, "{x}, {y}: {away}");
            }
        }
        assert_eq!(gutter, atlas.charts[0].gutter);
        assert_eq!(mesh.name == "torus", gutter == 0, "{}", mesh.name); // which leaves nothing free
    }
}

#[test]
fn what_is_painted_is_counted_without_the_gutter_and_what_is_nowhere_is_counted_too() {
    let gpu = gpu();
    let (block, ball) = (block(), shapes::sphere(0.4, 24));
    let mut scene = Scene::new(&gpu, &[(&block, UVec2::splat(61)), (&ball, UVec2::splat(70))]);
    // A corner of the block is nowhere, and the ball has no corner that is.
    scene.places[2].y = f32::NAN;
    scene.places[7].x = f32::NEG_INFINITY;
    let six: Vec<[f32; 6]> = scene.places.iter().map(|p| [p.x, p.y, p.z, 0.0, 0.0, 0.0]).collect();
    gpu.upload_to(&scene.place_buffer, &six).unwrap();
    let want = cpu::place(&scene.atlas.texels, &scene.triangles, &scene.places);
    for paint in formats(&gpu) {
        let canvas = scene.canvas(&gpu, &paint);
        let (positions, tiles, blocks) = canvas.download_places(&gpu).unwrap();
        assert!(positions == want);
        let is_wild = |it: &Bounds| it.covered > 0 && !(it.low_m.is_finite() && it.high_m.is_finite());
        assert!(!tiles.iter().chain(&blocks).any(is_wild), "a box of no size");
        let drops = gpu.upload("test.drops", &around(&block, 40, 1, 3)).unwrap();
        let gather = paint.gather(&canvas, &drops, &coats(1)).unwrap();
        gpu.once(|rec| gather.record(rec, Method::Sifted, &Taken::all(40), 0.2)).unwrap();
        let texels = canvas.download(&gpu).unwrap();
        let (mut beside, mut nowhere) = (0, 0);
        for (mesh, (cover, map)) in canvas.covers(&gpu).unwrap().iter().zip(canvas.maps()).enumerate() {
            let all = map.first_texel()..map.first_texel() + map.texels();
            let is_painted = |i: &usize| texels[*i][3] > 0.0;
            let (gutter, own): (Vec<usize>, Vec<usize>) =
                all.clone().filter(is_painted).partition(|&i| scene.atlas.texels[i].is_gutter());
            let lost = all.filter(|&i| scene.atlas.texels[i].triangle != 0 && want[i].triangle == 0).count();
            assert_eq!((cover.painted, cover.nowhere), (own.len() as u64, lost as u64), "{mesh}");
            assert!(!own.is_empty() && own.len() < scene.atlas.charts[mesh].covered as usize, "{mesh}");
            (beside, nowhere) = (beside + gutter.len(), nowhere + lost);
        }
        assert!(beside > 5 && nowhere > 200, "{beside} beside a chart, {nowhere} nowhere");
    }
}

/// Lookups at points of the mesh, corners and edges among them, after one coat on everything.
fn least_and_most(gpu: &TestGpu, mesh: &Mesh, gutter: u32) -> (f32, f32) {
    let paint = Paint::new(gpu, Format::Floats).unwrap();
    let mut scene = Scene::new(gpu, &[(mesh, UVec2::splat(53))]);
    scene.atlas = atlas(mesh, 53, gutter);
    let canvas = scene.canvas(gpu, &paint);
    let drops = gpu.upload("test.drops", &[Drop { at_m: Vec3::ZERO, source: 0 }]).unwrap();
    let coat = Coat::new(Vec3::new(0.2, 0.4, 0.8), 0.5, 1.0).unwrap();
    let gather = paint.gather(&canvas, &drops, &[coat]).unwrap();
    gpu.once(|rec| gather.record(rec, Method::Sifted, &Taken::all(1), 10.0)).unwrap();
    let texels = canvas.download(gpu).unwrap();
    let weights = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.3, 0.0), (0.0, 0.7), (0.3, 0.3)];
    let looked = mesh.triangles.iter().flat_map(|corners| {
        let [a, b, c] = corners.map(|i| mesh.uv[i as usize]);
        weights.map(|(s, t)| a + (b - a) * s + (c - a) * t)
    });
    let alphas = looked.map(|uv| cpu::lookup(&canvas.maps()[0], &texels, uv.x, uv.y)[3]);
    alphas.fold((9.0, 0.0), |(low, high), alpha| (f32::min(low, alpha), f32::max(high, alpha)))
}

#[test]
fn no_seam_shows_at_the_border_of_a_chart() {
    let gpu = gpu();
    for mesh in made() {
        let (least, most) = least_and_most(&gpu, &mesh, 2);
        assert!((least - 0.5).abs() < 1e-6 && (most - 0.5).abs() < 1e-6, "{}: {least} to {most}", mesh.name);
    }
    let (least, _) = least_and_most(&gpu, &block(), 0);
    assert!(least < 0.45, "without a gutter there is a seam: {least}");
}

#[test]
fn a_place_between_texels_is_the_place_on_the_mesh_also_at_borders() {
    // Half a texel of the gutter is the border itself: what is looked up there is off by a quarter of a texel.
    let mesh = block();
    let side = 256; // charts of the box lie a hundredth apart: two texels and a half
    let atlas = atlas(&mesh, side, 2);
    let positions = cpu::place(&atlas.texels, &mesh.triangles, &mesh.at_m);
    let field: Vec<[f32; 4]> = positions.iter().map(|p| [p.at_m.x, p.at_m.y, p.at_m.z, 0.0]).collect();
    let texel_m = 0.802 / (0.333 * side as f32 - 0.01 * side as f32);
    for corners in &mesh.triangles {
        let corner = corners.map(|i| (mesh.uv[i as usize], mesh.at_m[i as usize]));
        for k in 0..=20 {
            let t = k as f32 / 20.0;
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let uv = corner[from].0.lerp(corner[to].0, t);
                let want = corner[from].1.lerp(corner[to].1, t);
                let [x, y, z, _] = cpu::lookup(&atlas.maps[0], &field, uv.x, uv.y);
                let apart = (vec3(x, y, z) - want).length() / texel_m;
                assert!(apart < 0.4, "{apart} texels at {uv}"); // a quarter along each of two axes
            }
        }
    }
}

#[test]
fn shaders_look_up_what_the_twin_looks_up() {
    let gpu = gpu();
    let (block, coats) = (block(), coats(5));
    let source = "#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#define FORMAT_CONSTANT 0
layout(set = 0, binding = 0, std430) readonly buffer Paint { uvec2 paint[]; };
#include \"paint/lookup.glsl\"
layout(set = 0, binding = 1, std430) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 2, std430) readonly buffer Uvs { vec2 uvs[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Found { vec4 found[]; };
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < found.length()) found[i] = paint_at(maps[0], uvs[i]);
}";
    let spv = whitecap::gpu::compiler()
        .unwrap()
        .compile(source, "lookup.comp", whitecap::gpu::glsl::Stage::of_extension("comp").unwrap())
        .unwrap();
    for paint in formats(&gpu) {
        let scene = Scene::new(&gpu, &[(&block, UVec2::new(37, 90))]);
        let canvas = scene.canvas(&gpu, &paint);
        let drops = gpu.upload("test.drops", &around(&block, 300, 5, 8)).unwrap();
        let gather = paint.gather(&canvas, &drops, &coats).unwrap();
        gpu.once(|rec| gather.record(rec, Method::Tiles, &Taken::all(300), 0.05)).unwrap();
        let uvs: Vec<Vec2> = (0..1000)
            .map(|i| {
                let [u, v, ..] = random::bits(2, 2, i, 2);
                vec2(u as f32, v as f32) / u32::MAX as f32 * 1.1 - 0.05
            })
            .collect();
        let uv_buffer = gpu.upload("test.uvs", &uvs).unwrap();
        let found = gpu.upload("test.found", &vec![[0f32; 4]; 1000]).unwrap();
        let info = whitecap::gpu::KernelInfo {
            name: c"test.lookup",
            spv: bytemuck::cast_slice(&spv),
            blocks: &["Paint", "Maps", "Uvs", "Found"],
            constants: &[paint.format() as u32],
        };
        let bound = whitecap::gpu::Kernel::new::<()>(&gpu, &info)
            .unwrap()
            .bind(&[
                ("Paint", canvas.paint().into()),
                ("Maps", canvas.map_table().into()),
                ("Uvs", (&uv_buffer).into()),
                ("Found", (&found).into()),
            ])
            .unwrap();
        gpu.once(|rec| rec.dispatch(&bound, [1000, 1, 1], &())).unwrap();
        let texels = canvas.download(&gpu).unwrap();
        let got: Vec<[f32; 4]> = gpu.download(&found).unwrap();
        let mut sum = 0.0;
        for (uv, got) in uvs.iter().zip(got) {
            let want = cpu::lookup(&canvas.maps()[0], &texels, uv.x, uv.y);
            sum += want[3];
            // A share of 90 texels is known to 90 * 2^-24, times a step of 1 between texels.
            assert!((0..4).all(|i| (got[i] - want[i]).abs() < 2e-5), "{uv}: {got:?}, {want:?}");
        }
        assert!(sum > 10.0);
    }
}
