// SPDX-License-Identifier: MIT OR Apache-2.0
//! Paint: every kernel against its twin, every method the same bits, and what holds of coats, charts and impacts.
#![allow(missing_docs)]

mod charts;
#[path = "../common/mod.rs"]
mod common;
mod gather;
mod splat;

use common::{gpu, TestGpu};
use glam::{UVec2, Vec3};
use std::mem::{offset_of, size_of};
use whitecap::{
    gpu::{reflect::reflect, Buffer},
    mesh::{shapes, Mesh},
    paint::{
        Atlas, Bounds, Canvas, Coat, Drop, Format, GatherParams, Map, Paint, PlaceParams, Position,
        SplatParams, Work,
    },
    random, shaders,
};

/// Meshes at rest on the device, one after the other.
struct Scene {
    atlas: Atlas,
    places: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    place_buffer: Buffer,
    triangle_buffer: Buffer,
}

impl Scene {
    fn new(gpu: &TestGpu, meshes: &[(&Mesh, UVec2)]) -> Self {
        let atlas = Atlas::new(meshes, 2).unwrap();
        let (mut places, mut triangles) = (Vec::<Vec3>::new(), Vec::new());
        for (mesh, _) in meshes {
            let first = places.len() as u32;
            places.extend(&mesh.at_m);
            triangles.extend(mesh.triangles.iter().map(|corners| corners.map(|i| first + i)));
        }
        let six: Vec<[f32; 6]> = places.iter().map(|p| [p.x, p.y, p.z, 0.0, 0.0, 0.0]).collect();
        let place_buffer = gpu.upload("test.places", &six).unwrap();
        let triangle_buffer = gpu.upload("test.triangles", &triangles).unwrap();
        Self { atlas, places, triangles, place_buffer, triangle_buffer }
    }

    fn canvas(&self, gpu: &TestGpu, paint: &Paint) -> Canvas {
        let canvas = paint.canvas(&self.atlas, &self.place_buffer, &self.triangle_buffer).unwrap();
        let all: Vec<usize> = (0..self.atlas.maps.len()).collect();
        gpu.once(|rec| canvas.record_place(rec, &all)).unwrap();
        canvas
    }

    fn mesh_of(&self) -> impl Fn(usize) -> u32 + '_ {
        |texel| {
            let after = self.atlas.maps.iter().rposition(|map| map.first_texel() <= texel);
            after.unwrap() as u32
        }
    }
}

/// The seed's block.
fn block() -> Mesh {
    shapes::cuboid(Vec3::new(0.401, 0.128, 0.401))
}

/// Anywhere in a box a little larger than `mesh`, of `sources` sources.
fn around(mesh: &Mesh, count: u32, sources: u32, seed: u32) -> Vec<Drop> {
    let (low, high) = mesh.bounds_m();
    let drop = |i| {
        let [x, y, z, w] = random::bits(seed, 1, i, 2);
        let part = |bits: u32| bits as f32 / u32::MAX as f32 * 1.2 - 0.1;
        let at_m = low + (high - low) * Vec3::new(part(x), part(y), part(z));
        Drop { at_m, source: w % sources }
    };
    (0..count).map(drop).collect()
}

fn coats(count: u32) -> Vec<Coat> {
    let coat = |i| {
        let [r, g, b, a] = random::bits(9, 3, i, 4).map(|bits| bits as f32 / u32::MAX as f32);
        Coat::new(Vec3::new(r, g, b), 0.05 + 0.9 * a, 0.03 + 0.05 * g).unwrap()
    };
    (0..count).map(coat).collect()
}

/// Not drawn with, only compared: what differs, and where first.
#[track_caller]
fn assert_same(got: &[[f32; 4]], want: &[[f32; 4]], what: &str) {
    assert_eq!(got.len(), want.len());
    let differs = |(a, b): (&[f32; 4], &[f32; 4])| a.map(f32::to_bits) != b.map(f32::to_bits);
    let count = got.iter().zip(want).filter(|pair| differs(*pair)).count();
    let first = got.iter().zip(want).position(differs);
    let shown = first.map(|i| (i, got[i], want[i]));
    assert_eq!(count, 0, "{what}: first {shown:?}");
}

fn painted(paint: &[[f32; 4]]) -> usize {
    paint.iter().filter(|texel| texel[3] > 0.0).count()
}

#[test]
fn structs_are_laid_out_alike() {
    macro_rules! assert_layout {
        ($spv:expr, $constants:expr, $name:literal == $rust:ty { $($glsl:ident = $field:ident),* }) => {
            let interface = reflect($spv, $constants).unwrap();
            let found = &interface.structs[$name];
            let members: Vec<_> = found.members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
            assert_eq!(members, [$((stringify!($glsl), offset_of!($rust, $field))),*], $name);
        };
    }
    assert_layout!(shaders::PAINT_PLACE_COMP, &[],
        "PlaceParams" == PlaceParams { first = first, count = count, mesh = mesh });
    assert_layout!(shaders::PAINT_PLACE_COMP, &[],
        "Position" == Position { at_m = at_m, triangle = triangle });
    assert_layout!(shaders::PAINT_BLOCKS_COMP, &[],
        "Box" == Bounds { low_m = low_m, mesh = mesh, high_m = high_m, covered = covered });
    assert_layout!(shaders::PAINT_RESOLVE_COMP, &[0],
        "Map" == Map { width = width, height = height, first_block = first_block, blocks_x = blocks_x });
    assert_layout!(shaders::PAINT_BRUTE_COMP, &[0, 0, 64],
        "Drop" == Drop { at_m = at_m, source = source });
    assert_layout!(shaders::PAINT_BRUTE_COMP, &[0, 0, 64],
        "Coat" == Coat { paint = paint, reach_sq_m2 = reach_sq_m2, first_order = first_order, orders = orders, unused = unused });
    assert_layout!(shaders::PAINT_BRUTE_COMP, &[0, 0, 64],
        "GatherParams" == GatherParams { total = total, first = first, stride = stride, blocks = blocks,
            words = words, coats = coats, reach_sq_m2 = reach_sq_m2, total_at = total_at });
    let work = reflect(shaders::PAINT_BEGIN_COMP, &[0]).unwrap().structs["Work"].clone();
    let at = |name: &str| work.members.iter().find(|m| m.name == name).unwrap().offset;
    assert_eq!([at("sift_x") as u64, at("tiles_x") as u64], [Work::SIFT, Work::TILES]);
    assert_eq!([at("lost"), at("twice")], [offset_of!(Work, lost), offset_of!(Work, twice)]);
    assert_eq!((work.bytes, size_of::<Work>()), (48, 48));
    for spv in [shaders::PAINT_MARK_COMP, shaders::PAINT_DROPS_COMP] {
        let interface = reflect(spv, &[0]).unwrap();
        let names: Vec<_> =
            interface.structs["SplatParams"].members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
        assert_eq!(
            names[..2],
            [("coats", offset_of!(SplatParams, coats)), ("meshes", offset_of!(SplatParams, meshes))]
        );
        assert_eq!(interface.push_bytes, size_of::<SplatParams>());
    }
}

fn formats(gpu: &TestGpu) -> Vec<Paint> {
    vec![Paint::new(gpu, Format::Halves).unwrap(), Paint::tuned(gpu, Format::Floats, 128).unwrap()]
}
