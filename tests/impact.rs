// SPDX-License-Identifier: MIT OR Apache-2.0
//! The impact stream against its twin. What producers append is tested with them.
#![allow(missing_docs)]

mod common;

use common::gpu;
use glam::{vec2, vec3, DVec3, Vec2, Vec3};
use whitecap::{
    impact::{cpu, Count, Impact, Stream, Surfaces, NO_MESH},
    random,
};

/// Numbers from 0 to 1.
fn unit(seed: u32, i: usize, of: u32) -> f32 {
    let bits = random::bits(seed, of, i as u32, 0);
    (bits[0] >> 8) as f32 / 16_777_216.0
}

fn point(seed: u32, i: usize) -> Vec3 {
    vec3(unit(seed, i, 0), unit(seed, i, 1), unit(seed, i, 2))
}

struct Scene {
    places: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    uvs: Vec<Vec2>,
    first_triangle: Vec<u32>,
}

/// Three meshes of 5, 0 and 40 triangles, one of them a needle and one a point.
fn scene() -> Scene {
    let mut places: Vec<Vec3> = (0..135).map(|i| point(3, i)).collect();
    places[5] = places[4].lerp(places[3], 0.5);
    (places[7], places[8]) = (places[6], places[6]);
    let uvs = (0..135).map(|i| vec2(unit(4, i, 0), unit(4, i, 1))).collect();
    let triangles = (0..45).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Scene { places, triangles, uvs, first_triangle: vec![0, 5, 5, 45] }
}

impl Scene {
    fn on_host(&self) -> cpu::Surfaces<'_> {
        cpu::Surfaces {
            places: &self.places,
            triangles: &self.triangles,
            uvs: &self.uvs,
            first_triangle: &self.first_triangle,
        }
    }
}

fn impacts(count: usize) -> Vec<Impact> {
    let of = |i: usize| Impact {
        at_m: point(1, i) * 1.4 - 0.2,
        order: i as u32,
        normal: Vec3::Y,
        triangle: random::bits(2, 0, i as u32, 0)[0] % 46,
        mesh: NO_MESH,
        source: 7,
        ..Impact::default()
    };
    (0..count).map(of).collect()
}

#[test]
fn impacts_are_located_as_by_the_twin_and_those_of_no_mesh_left_alone() {
    let gpu = gpu();
    let scene = scene();
    let flat: Vec<f32> =
        scene.places.iter().flat_map(|at| [at.x, at.y, at.z, f32::NAN, f32::NAN, f32::NAN]).collect();
    let on = |name, words: &[u32]| gpu.upload(name, words).unwrap();
    let [places, triangles, uvs, firsts] = [
        on("places", bytemuck::cast_slice(&flat)),
        on("triangles", scene.triangles.as_flattened()),
        on("uvs", bytemuck::cast_slice(&scene.uvs)),
        on("firsts", &scene.first_triangle),
    ];
    let capacity = 1000;
    let mut stream = Stream::new(&gpu, capacity).unwrap();
    stream
        .locate_on(&Surfaces { places: &places, triangles: &triangles, uvs: &uvs, first_triangle: &firsts })
        .unwrap();
    for appended in [0, 1, 64, 777, 1000, 1003] {
        let mut want = impacts(capacity as usize);
        gpu.upload_to(stream.impacts(), &want).unwrap();
        let count = Count { appended, ..stream.counts().unwrap() };
        gpu.upload_to(stream.count(), &[count]).unwrap();
        gpu.once(|rec| {
            stream.record_begin(rec);
            stream.record_end(rec);
        })
        .unwrap();
        want.truncate(appended as usize);
        want.iter_mut().for_each(|it| cpu::locate(&scene.on_host(), it));
        let (got, counts) = stream.download().unwrap();
        let mut count = count;
        cpu::close(&mut count);
        assert_eq!(counts, count);
        assert_eq!(got.len(), want.len());
        for (got, want) in got.iter().zip(&want) {
            assert_eq!((got.mesh, got.order, got.triangle), (want.mesh, want.order, want.triangle));
            assert_eq!(want.mesh == NO_MESH, want.triangle == 0);
            assert_ne!(got.mesh, 1, "a mesh without triangles is hit by nobody");
            let off = vec2(got.u - want.u, got.v - want.v).abs().max_element();
            assert!(off <= if gpu.is_exact() { 0.0 } else { 1e-4 }, "{got:?} {want:?}");
        }
    }
    let counts = stream.counts().unwrap();
    assert_eq!((counts.stored(), counts.dropped()), (2842, 3));
}

#[test]
fn the_nearest_point_of_a_triangle_is_nearer_than_any_other() {
    for i in 0..300 {
        let [a, b, c] = [0, 1, 2].map(|k| point(10 + k, i));
        let at = point(20, i) * 3.0 - 1.0;
        let to = |w: Vec3| {
            let on = a.as_dvec3() * f64::from(w.x) + b.as_dvec3() * f64::from(w.y);
            (on + c.as_dvec3() * f64::from(w.z)).distance(at.as_dvec3())
        };
        let weights = cpu::nearest_weights(at, a, b, c);
        assert!((weights.element_sum() - 1.0).abs() < 1e-6 && weights.min_element() >= -1e-6, "{weights}");
        let found = to(weights);
        let nearest = (0..=40)
            .flat_map(|v| (0..=40 - v).map(move |w| (v as f32 / 40.0, w as f32 / 40.0)))
            .map(|(v, w)| to(vec3(1.0 - v - w, v, w)))
            .fold(f64::INFINITY, f64::min);
        assert!(found <= nearest + 1e-5, "{i}: {found} and {nearest}");
    }
    // Of what has no area there is no face; of a point only itself.
    let at = DVec3::new(0.3, 2.0, 0.1).as_vec3();
    assert_eq!(cpu::nearest_weights(at, Vec3::ONE, Vec3::ONE, Vec3::ONE).element_sum(), 1.0);
}

#[test]
fn counts_of_64_bits_carry_and_rows_of_workgroups_stay_short() {
    let mut count = Count {
        capacity: 1 << 30,
        appended: (1 << 30) + 5,
        dropped_low: u32::MAX - 2,
        stored_low: u32::MAX,
        stored_high: 1,
        ..Count::default()
    };
    let gpu = gpu();
    let stream = Stream::new(&gpu, 8).unwrap();
    gpu.upload_to(stream.count(), &[count]).unwrap();
    gpu.once(|rec| {
        stream.record_begin(rec);
        stream.record_end(rec);
    })
    .unwrap();
    cpu::close(&mut count);
    assert_eq!(stream.counts().unwrap(), count);
    assert_eq!((count.dropped(), count.stored()), ((1 << 32) + 2, (1 << 33) + (1 << 30) - 1));
    assert!(count.groups_x <= 65_535 && u64::from(count.groups_x * count.groups_y) * 64 >= 1 << 30);
}
