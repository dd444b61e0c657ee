// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twins in f64 of the passes over triangles: `glsl/volume/{triangle,mark,second,extend}.glsl`.

use crate::cells::{Extent, Grid, Plane};
use glam::{DVec2, DVec3, IVec3, UVec3, Vec3, Vec3Swizzles};

/// Half a cell and what single precision rounds: `SLACK` and `SLACK_SHARE` in `glsl/volume/triangle.glsl`.
const SLACK: f64 = 1.0 / 4096.0;
const SLACK_SHARE: f64 = 1.0 / 2_097_152.0;
const LEAST_SINE: f64 = 1.0 / 4_194_304.0;
const FARTHEST_CELLS: f64 = 1e9;
const FARTHEST: f64 = 0.875;
const COS_OTHER: f64 = 0.98480775;
const COS_PARALLEL: f64 = 0.99984770;
const APART: f64 = 0.0625;
const STANDS_FOR: f64 = 0.15;
const ALIKE: f64 = 0.985;
const WIDER: f64 = 0.02;

/// Why a triangle marks nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Skipped {
    /// Narrower than its length by more than single precision tells from a line.
    NoArea,
    /// A corner is no number, or farther out than single precision can compute with.
    NotFinite,
}

/// A triangle among cells: `load_triangle`.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Corners, in cells from the least corner of the grid.
    pub corners: [DVec3; 3],
    /// Unit, by the order of corners.
    pub normal: DVec3,
    /// By which boxes are larger (cells).
    pub slack: f64,
    /// First cell that the triangle's own box overlaps, within the grid.
    pub low: IVec3,
    /// The last.
    pub high: IVec3,
}

impl Shape {
    /// Of corners in the world (m).
    ///
    /// # Errors
    /// Why it marks nothing.
    pub fn new(grid: &Grid, corners_m: [Vec3; 3]) -> Result<Self, Skipped> {
        if corners_m.iter().any(|at| !at.is_finite()) {
            return Err(Skipped::NotFinite);
        }
        let low_m = Vec3::from(grid.low_m).as_dvec3();
        let corners = corners_m.map(|at| (at.as_dvec3() - low_m) / f64::from(grid.cell_m));
        let (ab, ac) = (corners[1] - corners[0], corners[2] - corners[0]);
        let extent = ab.abs().max_element().max(ac.abs().max_element());
        if extent.max(corners[0].abs().max_element()) > FARTHEST_CELLS {
            return Err(Skipped::NotFinite);
        }
        if extent < 1e-30 {
            return Err(Skipped::NoArea);
        }
        let across = (ab / extent).cross(ac / extent);
        if across.length() <= LEAST_SINE {
            return Err(Skipped::NoArea);
        }
        let farthest = corners.iter().map(|at| at.abs().max_element()).fold(0.0, f64::max);
        let slack = SLACK + SLACK_SHARE * farthest;
        let fold = |f: fn(DVec3, DVec3) -> DVec3| f(f(corners[0], corners[1]), corners[2]);
        let cells = UVec3::from(grid.cells).as_dvec3();
        let low = (fold(DVec3::min) - slack).ceil() - 1.0;
        let high = (fold(DVec3::max) + slack).floor();
        Ok(Self {
            corners,
            normal: across.normalize(),
            slack,
            low: low.clamp(DVec3::ZERO, cells).as_ivec3(),
            high: high.clamp(DVec3::NEG_ONE, cells - 1.0).as_ivec3(),
        })
    }

    /// By how much a cell's half side must grow for the triangle to touch it (cells): up to [`Shape::slack`] they overlap.
    pub fn gap(&self, cell: IVec3) -> f64 {
        let centre = cell.as_dvec3() + 0.5;
        let [a, b, c] = self.corners.map(|at| at - centre);
        // What an axis asks for: how far the interval of the triangle is from the centre, by the extent of a half side of 1.
        let ask = |axis: DVec3| -> f64 {
            let on = [a, b, c].map(|at| at.dot(axis));
            let (low, high) = (on[0].min(on[1]).min(on[2]), on[0].max(on[1]).max(on[2]));
            let extent = axis.abs().element_sum();
            if extent > 0.0 {
                low.max(-high) / extent - 0.5
            } else {
                f64::NEG_INFINITY
            }
        };
        let mut most = ask(self.normal);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            most = most.max(ask(axis));
            for edge in [b - a, c - b, a - c] {
                most = most.max(ask(edge.cross(axis)));
            }
        }
        most
    }

    /// Cells that it overlaps, and how far it is from their centres (cells).
    pub fn cells(&self) -> Vec<(IVec3, f64)> {
        let mut found = Vec::new();
        for z in self.low.z..=self.high.z {
            for y in self.low.y..=self.high.y {
                for x in self.low.x..=self.high.x {
                    let cell = IVec3::new(x, y, z);
                    if self.gap(cell) <= self.slack {
                        found.push((
                            cell,
                            (cell.as_dvec3() + 0.5 - self.nearest(cell.as_dvec3() + 0.5).0).length(),
                        ));
                    }
                }
            }
        }
        found
    }

    /// The point that is nearest to another (cells), and the shares of its second and third corner.
    pub fn nearest(&self, to: DVec3) -> (DVec3, DVec2) {
        let [a, b, c] = self.corners;
        let (ab, ac, from_a) = (b - a, c - a, to - a);
        let area = ab.cross(ac).length();
        let inside = DVec2::new(from_a.cross(ac).dot(self.normal), ab.cross(from_a).dot(self.normal)) / area;
        let point = |shares: DVec2| a + shares.x * ab + shares.y * ac;
        if inside.x >= 0.0 && inside.y >= 0.0 && inside.x + inside.y <= 1.0 {
            return (point(inside), inside);
        }
        let on = |from: DVec3, edge: DVec3| {
            ((to - from).dot(edge) / edge.length_squared().max(1e-300)).clamp(0.0, 1.0)
        };
        let bc = on(b, c - b);
        [DVec2::new(on(a, ab), 0.0), DVec2::new(0.0, on(a, ac)), DVec2::new(1.0 - bc, bc)]
            .map(|shares| (point(shares), shares))
            .into_iter()
            .min_by(|p, q| p.0.distance_squared(to).total_cmp(&q.0.distance_squared(to)))
            .expect("three edges")
    }

    /// Corners of what is left of it in the cell round `centre`, from there (cells); one where it touches that by rounding alone. After Sutherland and Hodgman, "Reentrant Polygon
    /// Clipping" (1974).
    pub fn within(&self, centre: DVec3) -> Vec<DVec3> {
        let half = 0.501 + self.slack;
        let mut left = self.corners.map(|at| at - centre).to_vec();
        for (axis, side) in [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, -1.0), (2, 1.0)] {
            let inside = |at: DVec3| half - side * at[axis];
            let next = left.iter().cycle().skip(1);
            left = left
                .iter()
                .zip(next)
                .flat_map(|(&a, &b)| {
                    let (of_a, of_b) = (inside(a), inside(b));
                    let crosses = (of_a < 0.0) != (of_b < 0.0);
                    let cut = crosses.then(|| a + (b - a) * (of_a / (of_a - of_b)));
                    [Some(a).filter(|_| of_a >= 0.0), cut].into_iter().flatten()
                })
                .collect();
        }
        if left.is_empty() {
            left.push((self.nearest(centre).0 - centre).clamp(DVec3::splat(-half), DVec3::splat(half)));
        }
        left
    }

    /// Of a point from the plane, along the normal (cells).
    pub fn distance(&self, at: DVec3) -> f64 {
        self.normal.dot(at - self.corners[0])
    }
}

/// Bits of a key that say which of so many triangles.
pub fn key_bits(triangles: u32) -> u32 {
    u32::BITS - triangles.leading_zeros()
}

/// `key_of`.
pub fn key(share: f64, triangle: u32, bits: u32) -> u32 {
    let most = (1u32 << (32 - bits)) - 1;
    ((share.clamp(0.0, 1.0) * f64::from(most)) as u32).min(most) << bits | triangle
}

/// What all triangles do to all cells.
pub struct Voxels {
    /// For each cell the triangles that overlap it, with their distances from its centre (cells), in their order.
    pub cells: Vec<Vec<(u32, f64)>>,
    /// By triangle; `Err` says why it marks nothing.
    pub shapes: Vec<Result<Shape, Skipped>>,
}

/// Every triangle's cells: twin of `volume.mark`.
pub fn mark(grid: &Grid, at_m: &[Vec3], triangles: &[[u32; 3]]) -> Voxels {
    let mut cells = vec![Vec::new(); grid.count()];
    let shapes: Vec<_> =
        triangles.iter().map(|corners| Shape::new(grid, corners.map(|i| at_m[i as usize]))).collect();
    for (t, shape) in shapes.iter().enumerate() {
        for (cell, distance) in shape.iter().flat_map(Shape::cells) {
            let i = grid.index(cell).expect("a cell within the grid");
            cells[i].push((t as u32, distance));
        }
    }
    Voxels { cells, shapes }
}

impl Voxels {
    fn shape(&self, t: u32) -> &Shape {
        self.shapes[t as usize].as_ref().expect("a triangle that marks")
    }

    /// The triangle of the first plane of a cell.
    pub fn first(&self, cell: usize) -> Option<u32> {
        let bits = key_bits(self.shapes.len() as u32);
        let keys = self.cells[cell].iter().map(|&(t, distance)| (key(distance / FARTHEST, t, bits), t));
        keys.min().map(|(_, t)| t)
    }

    /// How a triangle would do as the second plane beside the first, `None` if not at all: the cosine of the angle of their
    /// planes, 0 at best. Twin of `offer`.
    pub fn beside(&self, centre: DVec3, first: u32, t: u32) -> Option<f64> {
        let (mine, other) = (self.shape(t), self.shape(first));
        let cosine = mine.normal.dot(other.normal);
        let is_parallel =
            cosine >= COS_PARALLEL && (mine.distance(centre) - other.distance(centre)).abs() >= APART;
        (t != first && (cosine < COS_OTHER || is_parallel)).then_some(cosine.abs())
    }

    /// The triangle of the second plane of a cell: twin of `volume.second`.
    pub fn second(&self, grid: &Grid, cell: usize) -> Option<u32> {
        let (bits, first) = (key_bits(self.shapes.len() as u32), self.first(cell)?);
        let centre = grid.cell(cell).as_dvec3() + 0.5;
        let offers = self.cells[cell]
            .iter()
            .filter_map(|&(t, _)| Some((key(self.beside(centre, first, t)?, t, bits), t)));
        offers.min().map(|(_, t)| t)
    }

    /// Where in a cell is what its planes stand for, and what neither does: twin of `volume.extend`. Boxes are wider by `more` (cells)
    /// than they are there, for who compares.
    pub fn extents(&self, grid: &Grid, cell: usize, planes: [Option<u32>; 2], more: f64) -> [Extent; 3] {
        let mut extents = [Extent::default(); 3];
        let centre = grid.cell(cell).as_dvec3() + 0.5;
        for &(t, _) in &self.cells[cell] {
            let points = self.shape(t).within(centre);
            let (low, high) =
                points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| {
                    (low.min(*at), high.max(*at))
                });
            let off = |plane: Option<u32>| {
                let shape = self.shape(plane?);
                let off = points.iter().map(|at| shape.distance(*at + centre).abs()).fold(0.0, f64::max);
                Some((off, shape.normal))
            };
            let [one, two] = planes.map(off);
            let Some(one) = one else { continue };
            let (slot, (off, normal)) = match two {
                Some(two) if two.0 < one.0 => (1, two),
                _ => (0, one),
            };
            let mut set = |slot: usize, wider: DVec3| {
                let wider = wider + WIDER + more;
                extents[slot].0 |= Extent::of(low - wider, high + wider).0;
            };
            if off <= STANDS_FOR || two.is_none() {
                set(slot, normal.abs() * off.min(STANDS_FOR));
                continue;
            }
            set(2, normal.abs() * STANDS_FOR);
            for (slot, (off, normal)) in [Some(one), two].into_iter().flatten().enumerate() {
                if normal.dot(self.shape(t).normal).abs() > ALIKE {
                    set(slot, normal.abs() * off);
                }
            }
        }
        extents
    }

    /// A plane as it is stored: twin of `volume.resolve`.
    pub fn plane(&self, grid: &Grid, cell: usize, t: u32, velocity_mps: [Vec3; 3]) -> Plane {
        let (shape, centre) = (self.shape(t), grid.cell(cell).as_dvec3() + 0.5);
        let shares = shape.nearest(centre).1;
        let [a, b, c] = velocity_mps.map(Vec3::as_dvec3);
        Plane {
            normal: shape.normal.as_vec3().to_array(),
            distance_m: (shape.distance(centre) * f64::from(grid.cell_m)) as f32,
            velocity_mps: (a + shares.x * (b - a) + shares.y * (c - a)).as_vec3().to_array(),
            triangle: t + 1,
        }
    }
}

/// Where the ray of a texel meets a triangle's plane, in layers along `axis`, if the texel's centre is in the triangle: twin
/// of what the rasterizer and `glsl/volume/slices.frag` do. `None` also where the triangle is seen edge-on.
pub fn texel(shape: &Shape, axis: usize, at: DVec2) -> Option<f64> {
    let flat = |v: DVec3| match axis {
        0 => v.yz(),
        1 => v.zx(),
        _ => v.xy(),
    };
    let [a, b, c] = shape.corners.map(flat);
    let area = (b - a).perp_dot(c - a);
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| (to - from).perp_dot(at - from) * area.signum());
    let n = shape.normal[axis];
    let rise = flat(shape.normal).dot(at - a) / n;
    (area != 0.0 && sides.iter().all(|side| *side >= 0.0)).then(|| shape.corners[0][axis] - rise)
}
