// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes made by rule to build scenes of: rooms, plates with holes, and what a lathe turns. As in [`super::shapes`], no two
//! triangles share a place of the texture.

use super::{
    shapes::{one_joint, rename, sheet, smooth_seams, wrapped, Patch, WHOLE},
    Mesh,
};
use glam::{vec2, vec3, Vec2, Vec3};
use std::f32::consts::TAU;

/// Sides of a room.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// At the least x.
    Left,
    /// At the greatest x.
    Right,
    /// At the least y.
    Floor,
    /// At the greatest y.
    Top,
    /// At the least z.
    Back,
    /// At the greatest z.
    Front,
}

impl Side {
    /// All of them, with their names.
    pub const ALL: [(&str, Self); 6] = [
        ("left", Self::Left),
        ("right", Self::Right),
        ("floor", Self::Floor),
        ("top", Self::Top),
        ("back", Self::Back),
        ("front", Self::Front),
    ];

    /// To the right and down, as seen from inside, and outward.
    fn axes(self) -> [Vec3; 3] {
        match self {
            Self::Left => [Vec3::NEG_Z, Vec3::NEG_Y, Vec3::NEG_X],
            Self::Right => [Vec3::Z, Vec3::NEG_Y, Vec3::X],
            Self::Floor => [Vec3::X, Vec3::Z, Vec3::NEG_Y],
            Self::Top => [Vec3::X, Vec3::NEG_Z, Vec3::Y],
            Self::Back => [Vec3::X, Vec3::NEG_Y, Vec3::NEG_Z],
            Self::Front => [Vec3::NEG_X, Vec3::NEG_Y, Vec3::Z],
        }
    }
}

/// Walls of a room of half edges `half_m` (m), seen from inside; those of `open` are left out.
///
/// # Panics
/// If all are.
pub fn room(half_m: Vec3, open: &[Side]) -> Mesh {
    let sides = Side::ALL.iter().enumerate().filter(|(_, (_, side))| !open.contains(side));
    let walls = sides.map(|(i, (_, side))| {
        let [right, down, out] = side.axes();
        sheet(1, 1, Patch::of(i, 3, 2), |u, v| {
            half_m * (out + right * (2.0 * u - 1.0) + down * (2.0 * v - 1.0))
        })
    });
    rename(walls.reduce(|all, wall| one_joint(all.with(&wall))).expect("a room has a wall"), "room")
}

/// Share of the texture, from below, that the edges of a [`stencil`] have.
const EDGES: f32 = 0.14;

/// An upright plate of `size_m` (m) round the origin, seen from +z, with a hole for every blank or dot of `pattern`, whose
/// rows go from the top down. Closed.
///
/// # Panics
/// If the rows differ in length, or nothing is left of the plate.
pub fn stencil(size_m: Vec3, pattern: &[&str]) -> Mesh {
    let solid: Vec<Vec<bool>> =
        pattern.iter().map(|row| row.chars().map(|c| c != ' ' && c != '.').collect()).collect();
    let (rows, columns) = (solid.len(), solid.first().map_or(0, Vec::len));
    assert!(solid.iter().all(|row| row.len() == columns), "rows of {pattern:?} differ in length");
    let is_solid = |c: i64, r: i64| {
        usize::try_from(r).ok().and_then(|r| solid.get(r)?.get(usize::try_from(c).ok()?)).copied()
            == Some(true)
    };
    let cell = vec2(1.0 / columns as f32, 1.0 / rows as f32);
    // Of the plate, x to the right and y down from 0 to 1, z half the thickness.
    let place = |at: Vec2, z: f32| size_m * vec3(at.x - 0.5, 0.5 - at.y, 0.5 * z);
    let mut parts = Vec::new();
    let mut edges: Vec<[Vec2; 2]> = Vec::new();
    for (r, c) in (0..rows as i64).flat_map(|r| (0..columns as i64).map(move |c| (r, c))) {
        if !is_solid(c, r) {
            continue;
        }
        let at = cell * vec2(c as f32, r as f32);
        let own = |left: f32, at: Vec2| {
            let share = vec2(0.49, 0.99 - EDGES);
            Patch { corner: vec2(left, 0.005) + share * at, size: share * cell }
        };
        parts.push(sheet(1, 1, own(0.005, at), |u, v| place(at + cell * vec2(u, v), 1.0)));
        let mirrored = vec2(1.0 - at.x - cell.x, at.y);
        parts.push(sheet(1, 1, own(0.505, mirrored), |u, v| place(at + cell * vec2(1.0 - u, v), -1.0)));
        let [a, b, d, e] = [at, at + cell * Vec2::X, at + cell * Vec2::Y, at + cell];
        // Clockwise as seen from the front: the plate is to the right of an edge.
        let bounds = [((c, r - 1), [a, b]), ((c + 1, r), [b, e]), ((c, r + 1), [e, d]), ((c - 1, r), [d, a])];
        edges.extend(bounds.into_iter().filter(|((c, r), _)| !is_solid(*c, *r)).map(|(_, edge)| edge));
    }
    let wide = 0.99 / edges.len().max(1) as f32;
    for (i, [from, to]) in edges.into_iter().enumerate() {
        let patch = Patch {
            corner: vec2(0.005 + wide * i as f32, 1.0 - EDGES + 0.005),
            size: vec2(0.8 * wide, EDGES - 0.01),
        };
        parts.push(sheet(1, 1, patch, |u, v| place(from.lerp(to, u), 2.0 * v - 1.0)));
    }
    let plate = parts.into_iter().reduce(|all, part| one_joint(all.with(&part)));
    rename(plate.expect("something is left of the plate"), "stencil")
}

/// What turns about the y axis: a line of (radius, height) (m), seen from outside where it goes down. Closed if the line is,
/// or begins and ends on the axis.
///
/// # Panics
/// If the line has less than two points.
pub fn lathe(profile_m: &[Vec2], around: u32) -> Mesh {
    assert!(profile_m.len() > 1, "a line of {} points", profile_m.len());
    let lengths: Vec<f32> = profile_m.windows(2).map(|ends| ends[0].distance(ends[1])).collect();
    let whole: f32 = lengths.iter().sum::<f32>().max(1e-12);
    let mut above = 0.0;
    // A sheet for each part of the line, so that its corners stay sharp.
    let parts = profile_m.windows(2).zip(&lengths).map(|(ends, length)| {
        let patch = Patch {
            corner: WHOLE.corner + vec2(0.005, 0.005 + 0.99 * above / whole),
            size: vec2(0.99, 0.99 * 0.98 * length / whole),
        };
        above += length;
        let place = |u: f32, v: f32| {
            let ((sin, cos), at) = ((TAU * wrapped(u)).sin_cos(), ends[0].lerp(ends[1], v));
            vec3(at.x * sin, at.y, at.x * cos)
        };
        smooth_seams(sheet(around.max(3), 1, patch, place))
    });
    rename(parts.reduce(|all, part| one_joint(all.with(&part))).expect("a line has a part"), "lathe")
}
