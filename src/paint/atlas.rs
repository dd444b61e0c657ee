// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which triangle each texel of a paint map lies in, and where in it: found once, when meshes are loaded. Texture coordinates
//! do not move, so nothing of this has to be drawn again when the mesh does.
//!
//! Corners are rounded to 1/256 of a texel and texels decided in integers by the rule of the rasterizers (a centre on an
//! edge belongs to the triangle whose top or left edge it is): two triangles that share an edge share no texel and leave no
//! gap. So a texel in two triangles is an overlap, and is reported.
//!
//! Texels beside a chart, as far as the gutter reaches, are given the point of the mesh that is nearest in the map. They take
//! the paint of the border, and a filter that looks beyond it finds that and no seam. Triangles so small that they hold no
//! centre are found there too.

use super::{Map, BLOCK_SIDE};
use crate::mesh::{Mesh, MeshError};
use glam::{dvec2, DVec2, UVec2, Vec2};

/// Marks a texel of the gutter in [`Texel::triangle`].
pub const GUTTER: u32 = 1 << 31;
/// Parts of a texel that corners are rounded to.
const PARTS: f64 = 256.0;
/// Longest side of a map (texels).
pub const MOST_SIDE: u32 = 8192;
/// Most blocks of all maps.
pub const MOST_BLOCKS: u32 = 1 << 15;

/// Where a texel lies: three words of `Texels` in `glsl/paint/place.comp`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Texel {
    /// 0: in none. Else 1 + the triangle, of all meshes, with [`GUTTER`] if the texel is only beside it.
    pub triangle: u32,
    /// Weight of the second corner.
    pub b: f32,
    /// Weight of the third.
    pub c: f32,
}

impl Texel {
    /// The triangle, of all meshes.
    pub fn triangle(self) -> Option<u32> {
        (self.triangle & !GUTTER).checked_sub(1)
    }

    /// Whether it is only beside the triangle.
    pub fn is_gutter(self) -> bool {
        self.triangle & GUTTER != 0
    }
}

/// What was found about the texture coordinates of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Charts {
    /// Texels with their centre in a triangle.
    pub covered: u64,
    /// Texels beside one.
    pub gutter: u64,
    /// Of the covered, those in more than one triangle: where one is painted, so is the other.
    pub overlapping: u64,
    /// The first of them.
    pub example: Option<Overlap>,
    /// Triangles without area on the map: they cannot be painted.
    pub flat: u64,
}

impl Charts {
    /// Part of the covered texels that is in more than one triangle.
    pub fn overlap(&self) -> f64 {
        self.overlapping as f64 / (self.covered as f64).max(1.0)
    }
}

/// Two triangles of a mesh in one texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overlap {
    /// The texel.
    pub at: UVec2,
    /// The triangles, of the mesh; the first is painted.
    pub triangles: [u32; 2],
}

/// The texels of all meshes, as they lie in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Atlas {
    /// One a mesh.
    pub maps: Vec<Map>,
    /// Of all maps, block by block.
    pub texels: Vec<Texel>,
    /// One a mesh.
    pub charts: Vec<Charts>,
}

impl Atlas {
    /// Maps for meshes, each of its size in texels, with `gutter` texels beside each chart. Triangles are counted on from
    /// mesh to mesh.
    ///
    /// # Errors
    /// A mesh without texture coordinates or with some outside 0 to 1, or a size that is none, by name.
    pub fn new(meshes: &[(&Mesh, UVec2)], gutter: u32) -> Result<Self, MeshError> {
        let mut atlas = Self { maps: Vec::new(), texels: Vec::new(), charts: Vec::new() };
        let (mut first_triangle, mut first_block) = (0, 0);
        for (mesh, size) in meshes {
            check(mesh, *size)?;
            let map = Map::new(*size, first_block);
            first_block += map.blocks();
            if first_block > MOST_BLOCKS {
                let what = format!(
                    "with its paint map there are {first_block} blocks of {BLOCK_SIDE} x {BLOCK_SIDE} texels; allowed are {MOST_BLOCKS} for all meshes"
                );
                return Err(MeshError { name: mesh.name.clone(), what });
            }
            atlas.maps.push(map);
        }
        for ((mesh, _), map) in meshes.iter().zip(atlas.maps.clone()) {
            atlas.texels.resize(atlas.texels.len() + map.texels(), Texel::default());
            let mut drawn =
                Drawn { map, texels: &mut atlas.texels, first_triangle, charts: Charts::default() };
            drawn.cover(mesh);
            drawn.surround(mesh, f64::from(gutter));
            atlas.charts.push(drawn.charts);
            first_triangle += mesh.triangles.len() as u32;
        }
        Ok(atlas)
    }

    /// Blocks of all maps.
    pub fn blocks(&self) -> u32 {
        self.maps.iter().map(Map::blocks).sum()
    }
}

fn check(mesh: &Mesh, size: UVec2) -> Result<(), MeshError> {
    let fail = |what: String| Err(MeshError { name: mesh.name.clone(), what });
    if size.min_element() == 0 || size.max_element() > MOST_SIDE {
        return fail(format!(
            "a paint map of {} x {} texels; allowed are sides of 1 to {MOST_SIDE}",
            size.x, size.y
        ));
    }
    if mesh.uv.is_empty() {
        return fail("no texture coordinates: it cannot be painted".into());
    }
    let outside = |&&i: &&u32| {
        let uv = mesh.uv[i as usize];
        !(uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all())
    };
    if let Some(&i) = mesh.triangles.as_flattened().iter().find(outside) {
        let uv = mesh.uv[i as usize];
        return fail(format!(
            "vertex {i} has the texture coordinates ({}, {}); allowed are 0 to 1 where a mesh is painted",
            uv.x, uv.y
        ));
    }
    Ok(())
}

/// A map under way.
struct Drawn<'a> {
    map: Map,
    texels: &'a mut [Texel],
    first_triangle: u32,
    charts: Charts,
}

/// A triangle on the map, in [`PARTS`] of a texel, turned so that its area is above 0.
struct Corners {
    at: [[i64; 2]; 3],
    area: i64,
    is_turned: bool,
}

impl Corners {
    fn of(mesh: &Mesh, triangle: usize, map: Map) -> Option<Self> {
        let size = dvec2(f64::from(map.width), f64::from(map.height)) * PARTS;
        let mut at = mesh.triangles[triangle].map(|i| {
            let place = (mesh.uv[i as usize].as_dvec2() * size).round();
            [place.x as i64, place.y as i64]
        });
        let mut area = edge(at[0], at[1], at[2]);
        let is_turned = area < 0;
        if is_turned {
            at.swap(1, 2);
            area = -area;
        }
        (area != 0).then_some(Self { at, area, is_turned })
    }

    /// Texels from the first to behind the last whose centres may lie in it, or `around` texels from it.
    fn reach(&self, map: Map, around: i64) -> [std::ops::Range<u32>; 2] {
        std::array::from_fn(|axis| {
            let side = i64::from([map.width, map.height][axis]);
            let all = self.at.iter().map(|p| p[axis].div_euclid(PARTS as i64));
            let (low, high) = all.fold((i64::MAX, i64::MIN), |(l, h), t| (l.min(t), h.max(t)));
            (low - around).clamp(0, side) as u32..(high + 1 + around).clamp(0, side) as u32
        })
    }

    fn texel(&self, triangle: u32, b: f64, c: f64) -> Texel {
        let (b, c) = if self.is_turned { (c, b) } else { (b, c) };
        Texel { triangle, b: b as f32, c: c as f32 }
    }
}

/// Twice the area of a, b, p: above 0 if p is to the right of the way from a to b, where y points down.
fn edge(a: [i64; 2], b: [i64; 2], p: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

/// Of two triangles on both sides of an edge, it is one's top or left edge and not the other's.
fn is_top_or_left(a: [i64; 2], b: [i64; 2]) -> bool {
    b[1] < a[1] || b[1] == a[1] && b[0] > a[0]
}

fn centre(x: u32, y: u32) -> [i64; 2] {
    [x, y].map(|n| (i64::from(n) * 2 + 1) * (PARTS as i64 / 2))
}

impl Drawn<'_> {
    fn cover(&mut self, mesh: &Mesh) {
        let mut is_twice = vec![false; self.map.texels()];
        for triangle in 0..mesh.triangles.len() {
            let Some(corners) = Corners::of(mesh, triangle, self.map) else {
                self.charts.flat += 1;
                continue;
            };
            let [a, b, c] = corners.at;
            let least = [(a, b), (b, c), (c, a)].map(|(from, to)| i64::from(!is_top_or_left(from, to)));
            let number = self.first_triangle + triangle as u32 + 1;
            let [across, down] = corners.reach(self.map, 0);
            for y in down {
                for x in across.clone() {
                    let p = centre(x, y);
                    let edges = [edge(a, b, p), edge(b, c, p), edge(c, a, p)];
                    if edges.iter().zip(least).any(|(edge, least)| *edge < least) {
                        continue;
                    }
                    let i = self.map.texel(x, y);
                    match self.texels[i].triangle() {
                        None => {
                            let area = corners.area as f64;
                            self.texels[i] =
                                corners.texel(number, edges[2] as f64 / area, edges[0] as f64 / area);
                            self.charts.covered += 1;
                        }
                        Some(before) => {
                            let i = i - self.map.first_texel();
                            self.charts.overlapping += u64::from(!is_twice[i]);
                            is_twice[i] = true;
                            self.charts.example.get_or_insert(Overlap {
                                at: UVec2::new(x, y),
                                triangles: [before - self.first_triangle, triangle as u32],
                            });
                        }
                    }
                }
            }
        }
    }

    fn surround(&mut self, mesh: &Mesh, gutter: f64) {
        let mut nearest = vec![f64::INFINITY; self.map.texels()];
        for triangle in 0..mesh.triangles.len() {
            let Some(corners) = Corners::of(mesh, triangle, self.map) else { continue };
            let number = (self.first_triangle + triangle as u32 + 1) | GUTTER;
            let [across, down] = corners.reach(self.map, gutter.ceil() as i64);
            for y in down {
                for x in across.clone() {
                    let i = self.map.texel(x, y);
                    if self.texels[i].triangle != 0 && !self.texels[i].is_gutter() {
                        continue;
                    }
                    let (b, c, away_sq) = nearest_point(&corners, x, y);
                    let best = &mut nearest[i - self.map.first_texel()];
                    if away_sq <= gutter * gutter && away_sq < *best {
                        self.charts.gutter += u64::from(*best == f64::INFINITY);
                        *best = away_sq;
                        self.texels[i] = corners.texel(number, b, c);
                    }
                }
            }
        }
    }
}

/// Weights of the second and the third corner in the point of the border that is nearest to the centre of a texel, and the
/// square of how far that is (texels).
fn nearest_point(corners: &Corners, x: u32, y: u32) -> (f64, f64, f64) {
    let place = |p: [i64; 2]| dvec2(p[0] as f64, p[1] as f64) / PARTS;
    let (p, at) = (place(centre(x, y)), corners.at.map(place));
    let along = |from: usize, to: usize| {
        let way: DVec2 = at[to] - at[from];
        let t = ((p - at[from]).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        let mut weights = [0.0; 3];
        (weights[from], weights[to]) = (1.0 - t, t);
        (weights[1], weights[2], (at[from] + t * way).distance_squared(p))
    };
    let all = [along(0, 1), along(1, 2), along(2, 0)];
    all.into_iter().min_by(|one, other| one.2.total_cmp(&other.2)).expect("three edges")
}
