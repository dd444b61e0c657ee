// SPDX-License-Identifier: MIT OR Apache-2.0
//! Paint from impacts: all that touched, in order, the same bits on every run.

use super::*;
use whitecap::{
    impact::{self, Impact, Stream, Surfaces, NO_MESH},
    paint::{cpu, Method, Splat},
};

const PARTICLES: u32 = 400;

/// Impacts at random points of random triangles, of three sources; shuffled by `turn`.
fn impacts(scene: &Scene, count: u32, turn: u32) -> Vec<Impact> {
    let impact = |i: u32| {
        let [a, b, c, d] = random::bits(11, 5, i, 6);
        let triangle = a % scene.triangles.len() as u32;
        let [p, q, r] = scene.triangles[triangle as usize].map(|v| scene.places[v as usize]);
        let (mut s, mut t) = (b as f32 / u32::MAX as f32, c as f32 / u32::MAX as f32);
        if s + t > 1.0 {
            (s, t) = (1.0 - s, 1.0 - t);
        }
        Impact {
            at_m: p + (q - p) * s + (r - p) * t,
            order: 8 * (i % PARTICLES) + i / PARTICLES,
            triangle: triangle + 1,
            mesh: NO_MESH,
            source: d % 3,
            ..Impact::default()
        }
    };
    let mut all: Vec<_> = (0..count).map(impact).collect();
    all.sort_by_key(|impact| random::bits(turn, 7, impact.order * 3 + impact.source, 8)[0]);
    all
}

struct Stage {
    stream: Stream,
    scene: Scene,
}

impl Stage {
    fn new(gpu: &TestGpu, capacity: u32, meshes: &[(&Mesh, UVec2)]) -> Self {
        let scene = Scene::new(gpu, meshes);
        let uvs: Vec<_> = meshes.iter().flat_map(|(mesh, _)| mesh.uv.clone()).collect();
        let mut firsts = vec![0u32];
        meshes.iter().for_each(|(m, _)| firsts.push(firsts[firsts.len() - 1] + m.triangles.len() as u32));
        let (uvs, firsts) =
            (gpu.upload("test.uvs", &uvs).unwrap(), gpu.upload("test.firsts", &firsts).unwrap());
        let mut stream = Stream::new(gpu, capacity).unwrap();
        stream
            .locate_on(&Surfaces {
                places: &scene.place_buffer,
                triangles: &scene.triangle_buffer,
                uvs: &uvs,
                first_triangle: &firsts,
            })
            .unwrap();
        Self { stream, scene }
    }

    /// As a step would have left them.
    fn put(&self, gpu: &TestGpu, impacts: &[Impact]) {
        let mut all = impacts.to_vec();
        all.resize(self.stream.capacity() as usize, Impact::default());
        gpu.upload_to(self.stream.impacts(), &all).unwrap();
        let count = impact::Count { appended: impacts.len() as u32, ..self.stream.counts().unwrap() };
        gpu.upload_to(self.stream.count(), &[count]).unwrap();
        gpu.once(|rec| self.stream.record_end(rec)).unwrap();
    }

    fn located(&self, gpu: &TestGpu, count: usize) -> Vec<Impact> {
        gpu.download::<Impact>(self.stream.impacts()).unwrap()[..count].to_vec()
    }
}

fn turns(coats: &mut [Coat]) {
    let orders = vec![8 * PARTICLES; coats.len()];
    Coat::take_turns(coats, &orders).unwrap();
}

fn run(gpu: &TestGpu, splat: &Splat, method: Method) {
    gpu.once(|rec| {
        rec.barrier(Stream::EXIT, Paint::ENTRY);
        splat.record_by(rec, method);
    })
    .unwrap();
}

#[test]
fn impacts_paint_as_the_twin_says_the_same_bits_in_whatever_order_they_came() {
    let gpu = gpu();
    let (block, lizard) = (block(), shapes::lizard(1.0));
    let mut coats = coats(3);
    turns(&mut coats);
    for (paint, sides) in formats(&gpu).iter().zip([[17, 96], [256, 33]]) {
        let meshes = [(&block, UVec2::splat(sides[0])), (&lizard, UVec2::splat(sides[1]))];
        let stage = Stage::new(&gpu, 1500, &meshes);
        let mut first: Option<Vec<[f32; 4]>> = None;
        for (turn, method) in
            [Method::Sifted, Method::Sifted, Method::Tiles, Method::Brute].into_iter().enumerate()
        {
            let canvas = stage.scene.canvas(&gpu, paint);
            let splat = paint.splat(&canvas, &stage.stream, &coats).unwrap();
            stage.put(&gpu, &impacts(&stage.scene, 1200, turn as u32));
            run(&gpu, &splat, method);
            let got = canvas.download(&gpu).unwrap();
            let work = splat.work(&gpu).unwrap();
            assert_eq!((work.drops, work.lost, work.twice), (1200, 0, 0));
            let want = first.get_or_insert_with(|| {
                let (positions, ..) = canvas.download_places(&gpu).unwrap();
                let located = stage.located(&gpu, 1200);
                let drops = cpu::in_order(&located, &coats, canvas.maps());
                assert_eq!(drops.len(), 1200);
                let order: Vec<Drop> = gpu.download(splat.drops()).unwrap();
                assert!(drops.iter().zip(order).all(|((a, _), b)| *a == b), "order");
                let mut paint_map = vec![[0f32; 4]; positions.len()];
                cpu::gather(&positions, stage.scene.mesh_of(), &drops, &coats, &mut paint_map);
                paint_map.iter().map(|texel| cpu::stored(paint.format(), *texel)).collect()
            });
            assert!(painted(want) > 100, "{}", painted(want));
            if gpu.is_exact() || turn > 0 {
                assert_same(&got, want, &format!("turn {turn}, {method:?}"));
            } else {
                *want = got;
            }
        }
    }
}

#[test]
fn order_decides_what_lies_on_top() {
    let gpu = gpu();
    let block = block();
    let mut coats = [Vec3::X, Vec3::Y].map(|color| Coat::new(color, 1.0, 0.1).unwrap());
    turns(&mut coats);
    let paint = Paint::new(&gpu, Format::Halves).unwrap();
    let stage = Stage::new(&gpu, 10, &[(&block, UVec2::splat(32))]);
    let top = |order: [u32; 2], flipped: bool| {
        let canvas = stage.scene.canvas(&gpu, &paint);
        // Sources of one order: who comes first among them is what the orders say.
        let mut coats = coats;
        if flipped {
            (coats[0].first_order, coats[1].first_order) = (coats[1].first_order, coats[0].first_order);
        }
        let splat = paint.splat(&canvas, &stage.stream, &coats).unwrap();
        let one = impacts(&stage.scene, 1, 0)[0];
        stage.put(&gpu, &[0, 1].map(|i| Impact { order: order[i], source: i as u32, ..one }));
        run(&gpu, &splat, Method::Sifted);
        let paint = canvas.download(&gpu).unwrap();
        paint.into_iter().find(|texel| texel[3] > 0.0).unwrap()
    };
    assert_eq!(top([5, 3], false), [0.0, 1.0, 0.0, 1.0]);
    assert_eq!(top([3, 5], false), [0.0, 1.0, 0.0, 1.0], "sources take turns");
    assert_eq!(top([3, 5], true), [1.0, 0.0, 0.0, 1.0]);
}

#[test]
fn who_touched_has_painted_however_small_and_on_the_mesh_that_it_hit() {
    let gpu = gpu();
    // Two blocks in one place, and drops of no size: the texel that was hit is painted, of the mesh that was hit.
    let block = block();
    let mut coats = [Coat::new(Vec3::ONE, 0.5, 0.0).unwrap()];
    turns(&mut coats);
    let paint = Paint::new(&gpu, Format::Halves).unwrap();
    for side in [1, 9, 64, 200] {
        let size = UVec2::splat(side);
        let stage = Stage::new(&gpu, 64, &[(&block, size), (&block, size)]);
        for impact in impacts(&stage.scene, 20, 3) {
            let canvas = stage.scene.canvas(&gpu, &paint);
            let splat = paint.splat(&canvas, &stage.stream, &coats).unwrap();
            stage.put(&gpu, &[Impact { source: 0, ..impact }]);
            run(&gpu, &splat, Method::Sifted);
            let located = stage.located(&gpu, 1)[0];
            let home = canvas.maps()[located.mesh as usize].texel_at(located.u, located.v);
            let got = canvas.download(&gpu).unwrap();
            assert_eq!(painted(&got), 1, "{side}: {located:?}");
            assert_eq!(got[home][3], 0.5, "{side}: {located:?}");
            assert_eq!(located.mesh, u32::from(impact.triangle > 12));
        }
    }
    // With a size, the disc is on one of the two.
    let mut coats = [Coat::new(Vec3::ONE, 0.5, 0.1).unwrap()];
    turns(&mut coats);
    let stage = Stage::new(&gpu, 64, &[(&block, UVec2::splat(64)), (&block, UVec2::splat(64))]);
    let canvas = stage.scene.canvas(&gpu, &paint);
    let splat = paint.splat(&canvas, &stage.stream, &coats).unwrap();
    stage.put(&gpu, &[Impact { source: 0, triangle: 13, ..impacts(&stage.scene, 1, 0)[0] }]);
    run(&gpu, &splat, Method::Sifted);
    let got = canvas.download(&gpu).unwrap();
    let half = got.len() / 2;
    assert!(painted(&got[..half]) == 0 && painted(&got[half..]) > 10);
}

#[test]
fn what_cannot_paint_is_counted_and_water_is_not_painted() {
    let gpu = gpu();
    let block = block();
    let mut coats = coats(2);
    turns(&mut coats);
    let paint = Paint::new(&gpu, Format::Halves).unwrap();
    let stage = Stage::new(&gpu, 64, &[(&block, UVec2::splat(32))]);
    let canvas = stage.scene.canvas(&gpu, &paint);
    let splat = paint.splat(&canvas, &stage.stream, &coats).unwrap();
    let one = Impact { source: 0, ..impacts(&stage.scene, 1, 0)[0] };
    let all = [
        Impact { triangle: 0, ..one },          // on water
        Impact { source: 2, order: 1, ..one },  // of nobody
        Impact { order: 8 * PARTICLES, ..one }, // of no particle
        Impact { order: 7, ..one },
        Impact { order: 7, ..one },            // of the same
        Impact { order: 7, source: 1, ..one }, // of another pool
    ];
    stage.put(&gpu, &all);
    run(&gpu, &splat, Method::Sifted);
    let work = splat.work(&gpu).unwrap();
    assert_eq!((work.drops, work.lost, work.twice), (2, 2, 1));
    // A step without impacts paints nothing and counts nothing.
    let before = canvas.download(&gpu).unwrap();
    stage.put(&gpu, &[]);
    run(&gpu, &splat, Method::Sifted);
    assert_same(&canvas.download(&gpu).unwrap(), &before, "no impacts");
    assert_eq!(splat.work(&gpu).unwrap().drops, 0);
    // Wrong input is refused by name.
    let none = paint.splat(&canvas, &stage.stream, &self::coats(1)).err().unwrap().to_string();
    assert!(none.starts_with("orders = 0: allowed is 1 to"), "{none}");
    for (color, opacity, radius_m, said) in [
        (Vec3::ONE, 1.5, 0.1, "opacity = 1.5: allowed is 0 to 1"),
        (Vec3::ONE, f32::NAN, 0.1, "opacity = NaN"),
        (Vec3::splat(-1.0), 0.5, 0.1, "color = [-1, -1, -1]"),
        (Vec3::ONE, 0.5, -0.1, "radius_m = -0.1: allowed is 0 or more"),
    ] {
        let error = Coat::new(color, opacity, radius_m).unwrap_err().to_string();
        assert!(error.starts_with(said), "{error}");
    }
}

#[test]
fn a_full_stream_paints_what_it_holds() {
    let gpu = gpu();
    let sphere = shapes::sphere(0.7, 32);
    let mut coats = coats(3);
    turns(&mut coats);
    let paint = Paint::new(&gpu, Format::Halves).unwrap();
    let stage = Stage::new(&gpu, 257, &[(&sphere, UVec2::new(70, 140))]);
    let canvas = stage.scene.canvas(&gpu, &paint);
    let splat = paint.splat(&canvas, &stage.stream, &coats).unwrap();
    stage.put(&gpu, &impacts(&stage.scene, 257, 0));
    gpu.once(|rec| {
        rec.barrier(Stream::EXIT, Paint::ENTRY);
        splat.record(rec);
    })
    .unwrap();
    assert_eq!(splat.work(&gpu).unwrap().drops, 257);
    let got = canvas.download(&gpu).unwrap();
    for impact in stage.located(&gpu, 257) {
        assert!(got[canvas.maps()[0].texel_at(impact.u, impact.v)][3] > 0.0);
    }
}
