// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twins of `glsl/paint`, in `f32` to the bit, and in `f64`.

use super::{Bounds, Coat, Drop, Format, Map, Position, Texel, BLOCK, TILE};
use crate::impact::Impact;
use glam::Vec3;
use std::ops::{Add, Mul, Sub};

/// A number to compute in.
pub trait Number:
    Copy + From<f32> + PartialOrd + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
}

impl Number for f32 {}
impl Number for f64 {}

/// Twin of `glsl/paint/place.comp`, without the boxes.
pub fn place(texels: &[Texel], triangles: &[[u32; 3]], places: &[Vec3]) -> Vec<Position> {
    let at = |texel: &Texel| {
        let Some(triangle) = texel.triangle() else { return Position::default() };
        let [a, b, c] = triangles[triangle as usize].map(|i| places[i as usize]);
        let at_m = (a + (b - a) * texel.b) + (c - a) * texel.c;
        if at_m.is_finite() {
            Position { at_m, triangle: texel.triangle }
        } else {
            Position::default()
        }
    };
    texels.iter().map(at).collect()
}

/// Boxes of tiles (`per` is [`TILE`]) or of blocks ([`BLOCK`]), all of mesh `mesh`: twin of the rest, and of
/// `glsl/paint/blocks.comp`.
pub fn boxes(positions: &[Position], per: usize, mesh: u32) -> Vec<Bounds> {
    let farthest = Vec3::splat(3e38);
    let one = |part: &[Position]| {
        let covered = part.iter().filter(|position| position.triangle != 0);
        covered.fold(Bounds { low_m: farthest, mesh, high_m: -farthest, covered: 0 }, |all, position| {
            Bounds {
                low_m: all.low_m.min(position.at_m),
                high_m: all.high_m.max(position.at_m),
                covered: all.covered + 1,
                ..all
            }
        })
    };
    positions.chunks(per).map(one).collect()
}

fn distance_sq<F: Number>(a: Vec3, b: Vec3) -> F {
    let [x, y, z] = [0, 1, 2].map(|i| F::from(a[i]) - F::from(b[i]));
    (x * x + y * y) + z * z
}

/// How far a point is from a box, squared: never more than from any point in it, also as rounded.
pub fn box_distance_sq(at_m: Vec3, bounds: &Bounds) -> f32 {
    let way = (bounds.low_m - at_m).max(at_m - bounds.high_m).max(Vec3::ZERO);
    (way.x * way.x + way.y * way.y) + way.z * way.z
}

/// Particles as drops, `most` of them: twin of `glsl/paint/take.comp`.
pub fn take(at_m: &[Vec3], most: usize, source: u32) -> Vec<Drop> {
    let nobody = Drop { at_m: Vec3::ZERO, source: u32::MAX };
    let all = at_m.iter().map(|&at_m| Drop { at_m, source });
    all.chain(std::iter::repeat(nobody)).take(most).collect()
}

/// A texel under one more coat.
pub fn over<F: Number>(paint: [F; 4], coat: [f32; 4]) -> [F; 4] {
    let keep = F::from(1.0) - F::from(coat[3]);
    std::array::from_fn(|i| paint[i] * keep + F::from(coat[i]))
}

/// What a drop is for a texel: which it hit, whatever the distance, and what it must be nearer than, squared (m^2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// The texel that it hit.
    pub home: Option<u32>,
    /// The mesh that it paints; any if `None`.
    pub mesh: Option<u32>,
    /// (m^2).
    pub reach_sq_m2: f32,
}

/// Coats of `drops`, in their order, on every texel that they reach: twin of `glsl/paint/gather.glsl`. `mesh_of` says whose
/// map a texel is of.
pub fn gather<F: Number>(
    positions: &[Position],
    mesh_of: impl Fn(usize) -> u32,
    drops: &[(Drop, Aim)],
    coats: &[Coat],
    paint: &mut [[F; 4]],
) {
    for (i, (position, texel)) in positions.iter().zip(paint).enumerate() {
        if position.triangle == 0 {
            continue;
        }
        for (drop, aim) in drops {
            let source = if aim.mesh.is_some() { drop.source & 0xffff } else { drop.source };
            let Some(coat) = coats.get(source as usize) else { continue };
            let is_mine = aim.mesh.is_none_or(|mesh| mesh == mesh_of(i));
            let is_near = distance_sq::<F>(drop.at_m, position.at_m) < F::from(aim.reach_sq_m2);
            if is_mine && (is_near || aim.home == Some(i as u32)) {
                *texel = over(*texel, coat.paint);
            }
        }
    }
}

/// Which drops are near which block, a bit each, `words` of a block: twin of `glsl/paint/sift.comp` for particles.
pub fn sift(blocks: &[Bounds], drops: &[Drop], reach_sq_m2: f32, words: usize) -> Vec<u32> {
    let mut masks = vec![0; blocks.len() * words];
    for (block, bounds) in blocks.iter().enumerate().filter(|(_, bounds)| bounds.covered > 0) {
        for (k, drop) in drops.iter().enumerate() {
            if box_distance_sq(drop.at_m, bounds) < reach_sq_m2 {
                masks[block * words + k / 32] |= 1 << (k % 32);
            }
        }
    }
    masks
}

/// Impacts on meshes as drops, in their order: twin of `glsl/paint/{mark,bits,drops}.comp`.
pub fn in_order(impacts: &[Impact], coats: &[Coat], maps: &[Map]) -> Vec<(Drop, Aim)> {
    let mut keyed: Vec<_> = impacts
        .iter()
        .filter(|impact| (impact.mesh as usize) < maps.len())
        .filter_map(|impact| {
            let coat = coats.get(impact.source as usize).filter(|coat| impact.order < coat.orders)?;
            Some((coat.first_order + impact.order, impact, coat))
        })
        .collect();
    keyed.sort_by_key(|(key, ..)| *key);
    let drop = |(_, impact, coat): (u32, &Impact, &Coat)| {
        let source = impact.source | impact.mesh << 16;
        let home = maps[impact.mesh as usize].texel_at(impact.u, impact.v);
        let aim = Aim { home: Some(home as u32), mesh: Some(impact.mesh), reach_sq_m2: coat.reach_sq_m2 };
        (Drop { at_m: impact.at_m, source }, aim)
    };
    keyed.into_iter().map(drop).collect()
}

/// Twin of `half_of` in `glsl/paint/texel.glsl`: to the nearest, ties to even, of numbers from 0 to 65504.
pub fn half_of(x: f32) -> u16 {
    if x < 6.103_515_6e-5 {
        return (x * 16_777_216.0).round_ties_even() as u16;
    }
    let bits = x.min(65_504.0).to_bits();
    (((bits + 0xfff + (bits >> 13 & 1)) >> 13) - (112 << 10)) as u16
}

/// Twin of `float_of` there.
pub fn float_of(half: u16) -> f32 {
    match u32::from(half) {
        small if small < 0x400 => small as f32 * 5.960_464_5e-8,
        bits => f32::from_bits((bits + (112 << 10)) << 13),
    }
}

/// What a texel is once it is stored.
pub fn stored(format: Format, paint: [f32; 4]) -> [f32; 4] {
    match format {
        Format::Halves => paint.map(|x| float_of(half_of(x))),
        Format::Floats => paint,
    }
}

/// Texels of a map row by row: twin of `glsl/paint/resolve.comp`.
pub fn rows<T: Copy>(map: &Map, texels: &[T]) -> Vec<T> {
    (0..map.height).flat_map(|y| (0..map.width).map(move |x| texels[map.texel(x, y)])).collect()
}

/// Paint under texture coordinates, linearly between four texels: twin of `glsl/paint/lookup.glsl`.
pub fn lookup(map: &Map, texels: &[[f32; 4]], u: f32, v: f32) -> [f32; 4] {
    let x = u.clamp(0.0, 1.0) * map.width as f32 - 0.5;
    let y = v.clamp(0.0, 1.0) * map.height as f32 - 0.5;
    let texel = |dx: f32, dy: f32| {
        let at = |t: f32, side: u32| t.clamp(0.0, side as f32 - 1.0) as u32;
        texels[map.texel(at(x.floor() + dx, map.width), at(y.floor() + dy, map.height))]
    };
    let mix = |a: [f32; 4], b: [f32; 4], t: f32| -> [f32; 4] {
        std::array::from_fn(|i| a[i] * (1.0 - t) + b[i] * t)
    };
    let (s, t) = (x - x.floor(), y - y.floor());
    mix(mix(texel(0.0, 0.0), texel(1.0, 0.0), s), mix(texel(0.0, 1.0), texel(1.0, 1.0), s), t)
}

/// Boxes of tiles and of blocks of one mesh.
pub fn both_boxes(positions: &[Position], mesh: u32) -> (Vec<Bounds>, Vec<Bounds>) {
    (boxes(positions, TILE, mesh), boxes(positions, BLOCK, mesh))
}
