// SPDX-License-Identifier: MIT OR Apache-2.0
//! A grid of cubic cells in the world, each with up to two planes of the scene's surface: what voxelisation writes, and
//! what particles collide with. Mirrors `glsl/cells/cells.glsl`, which is its shader side.
//!
//! Cell `x + cells_x (y + cells_y z)` is occupied if its bit is set in `Occupied`, and only then do its two planes in
//! `Planes` mean anything. Planes are relative to the centre of their cell, so that no precision is lost far from the
//! origin. Its three words in `Extents` say where in it is what the first plane stands for, what the second does, and what neither
//! does. Outside the grid everything is empty. [`Grid::cell_of`] says which cell a place is in, for whoever stores and
//! for whoever looks up.

use crate::gpu::{Buffer, Gpu, Residence, Result};
use glam::{DVec3, IVec3, UVec3, Vec3};

/// Most cells along an axis.
pub const MOST_CELLS: u32 = 1024;

/// The grid: `Grid` in `glsl/cells/cells.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Grid {
    /// Least corner (m).
    pub low_m: [f32; 3],
    /// Side of a cell (m).
    pub cell_m: f32,
    /// Cells along x, y and z.
    pub cells: [u32; 3],
    /// Triangles of all meshes.
    pub mesh_triangles: u32,
}

/// A plane of a cell: `Plane` in `glsl/cells/cells.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Plane {
    /// Unit.
    pub normal: [f32; 3],
    /// Of the cell's centre from the plane, along the normal (m).
    pub distance_m: f32,
    /// Of the surface, at its point nearest to the centre (m/s).
    pub velocity_mps: [f32; 3],
    /// Of all meshes, plus 1; 0: no plane.
    pub triangle: u32,
}

impl Grid {
    /// A grid over the box from `low_m`, of so many cells along each axis.
    pub fn new(low_m: Vec3, cell_m: f32, cells: UVec3) -> Self {
        Self { low_m: low_m.to_array(), cell_m, cells: cells.to_array(), mesh_triangles: 0 }
    }

    /// # Errors
    /// The first number that is out of range, and what is allowed.
    pub fn check(&self) -> Result<(), String> {
        if !Vec3::from(self.low_m).is_finite() {
            return Err(format!("its least corner is {:?}; allowed: finite", self.low_m));
        }
        if !(self.cell_m > 0.0 && self.cell_m.is_finite()) {
            return Err(format!("cells of {} m; allowed: more than 0", self.cell_m));
        }
        if self.cells.iter().any(|n| !(1..=MOST_CELLS).contains(n)) {
            return Err(format!("{:?} cells; allowed: 1 to {MOST_CELLS} along each axis", self.cells));
        }
        let high_m = Vec3::from(self.low_m) + self.cell_m * UVec3::from(self.cells).as_vec3();
        if !high_m.is_finite() {
            return Err(format!("cells of {} m: its far corner is {high_m}; allowed: finite", self.cell_m));
        }
        let farthest = Vec3::from(self.low_m).abs().max_element();
        let ulp_m = farthest * f32::EPSILON;
        if ulp_m > self.cell_m / 1024.0 {
            return Err(format!(
                "cells of {} m as far as {farthest} m from the origin: an f32 cannot tell a thousandth of one",
                self.cell_m
            ));
        }
        Ok(())
    }

    /// Cells in all.
    pub fn count(&self) -> usize {
        self.cells.iter().map(|&n| n as usize).product()
    }

    /// A place in the world, in cells from the least corner.
    pub fn place(&self, at_m: Vec3) -> Vec3 {
        (at_m - Vec3::from(self.low_m)) / self.cell_m
    }

    /// The cell that a place is in: -1, or as many as there are, along an axis that it is beyond.
    pub fn cell_of(&self, at_m: Vec3) -> IVec3 {
        let place = self.place(at_m);
        if place.is_nan() {
            return IVec3::NEG_ONE;
        }
        place.floor().clamp(Vec3::NEG_ONE, UVec3::from(self.cells).as_vec3()).as_ivec3()
    }

    /// Index of a cell; `None` outside the grid.
    pub fn index(&self, cell: IVec3) -> Option<usize> {
        let cells = UVec3::from(self.cells).as_ivec3();
        let is_inside = cell.cmpge(IVec3::ZERO).all() && cell.cmplt(cells).all();
        let [x, y, z] = cell.to_array().map(|n| n as usize);
        is_inside.then(|| x + self.cells[0] as usize * (y + self.cells[1] as usize * z))
    }

    /// The cell of an index.
    pub fn cell(&self, index: usize) -> IVec3 {
        let [w, h, _] = self.cells.map(|n| n as usize);
        IVec3::new((index % w) as i32, (index / w % h) as i32, (index / w / h) as i32)
    }

    /// Centre of a cell (m).
    pub fn centre_m(&self, cell: IVec3) -> Vec3 {
        Vec3::from(self.low_m) + (cell.as_vec3() + 0.5) * self.cell_m
    }
}

impl Plane {
    /// Signed, of a point in the plane's cell (m).
    pub fn distance_of_m(&self, at_m: Vec3, centre_m: Vec3) -> f32 {
        Vec3::from(self.normal).dot(at_m - centre_m) + self.distance_m
    }
}

/// Where in a cell something is: its shadow on the three axes, ten bits each, x lowest, an eighth of a cell a bit, from 5/8 before the
/// centre of the cell to 5/8 behind. `glsl/cells/cells.glsl` says what for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct Extent(pub u32);

impl Extent {
    const BINS: f32 = 10.0;
    const PER_CELL: f32 = 8.0;
    /// All of the cell, and an eighth of one around it: for what is known no better.
    pub const ALL: Self = Self(0x3fff_ffff);

    /// Of a box, in cells from the centre of its cell.
    pub fn of(low: DVec3, high: DVec3) -> Self {
        let (per_cell, bins) = (f64::from(Self::PER_CELL), f64::from(Self::BINS));
        let bin =
            |at: DVec3| (at * per_cell + 0.5 * bins).floor().clamp(DVec3::ZERO, DVec3::splat(bins - 1.0));
        let (first, last) = (bin(low).as_uvec3(), bin(high).as_uvec3());
        let bits = (0..3).map(|axis| ((2 << last[axis]) - (1 << first[axis])) << (10 * axis as u32));
        Self(bits.fold(0, |all, bits| all | bits))
    }

    /// The box in which it is, in cells from the centre of its cell; `None` if nowhere.
    pub fn bounds(self) -> Option<[Vec3; 2]> {
        let bins = [0, 10, 20].map(|axis| self.0 >> axis & 0x3ff);
        let side = |bin: [f32; 3]| (Vec3::from(bin) - 0.5 * Self::BINS) * (1.0 / Self::PER_CELL);
        (!bins.contains(&0)).then(|| {
            [
                side(bins.map(|bins| bins.trailing_zeros() as f32)),
                side(bins.map(|bins| (bins.ilog2() + 1) as f32)),
            ]
        })
    }

    /// Whether it has the point that is `from_centre_m` from the centre of its cell: twin of `is_in_extent`.
    pub fn has(self, from_centre_m: Vec3, cell_m: f32) -> bool {
        let place = from_centre_m * (Self::PER_CELL / cell_m) + 0.5 * Self::BINS;
        let is_near = place.cmpge(Vec3::ZERO).all() && place.cmplt(Vec3::splat(Self::BINS)).all();
        is_near && (0..3).all(|axis| self.0 >> (10 * axis as u32 + place[axis] as u32) & 1 != 0)
    }
}

/// The three buffers of a grid on the device.
#[derive(Clone)]
pub struct Cells {
    grid: Grid,
    occupied: Buffer,
    planes: Buffer,
    extents: Buffer,
}

/// What [`Cells`] hold, read back.
#[derive(Clone, Debug, PartialEq)]
pub struct Read {
    /// One bit a cell.
    pub occupied: Vec<u32>,
    /// Two a cell.
    pub planes: Vec<Plane>,
    /// Three a cell: of its first plane, of its second, and of what is like neither.
    pub extents: Vec<[Extent; 3]>,
}

impl Read {
    /// Whether the bit of a cell is set.
    pub fn is_occupied(&self, cell: usize) -> bool {
        self.occupied[cell / 32] >> (cell % 32) & 1 != 0
    }

    /// The planes of a cell, none to two.
    pub fn planes_of(&self, cell: usize) -> &[Plane] {
        let both = &self.planes[2 * cell..2 * cell + 2];
        match (self.is_occupied(cell), both[1].triangle) {
            (false, _) => &[],
            (true, 0) => &both[..1],
            (true, _) => both,
        }
    }

    /// Indices of the cells whose bit is set, rising.
    pub fn marked(&self) -> Vec<usize> {
        let words = self.occupied.iter().enumerate();
        words
            .flat_map(|(w, word)| (0..32).filter(move |b| word >> b & 1 != 0).map(move |b| 32 * w + b))
            .collect()
    }
}

impl Cells {
    /// Cells that are all empty.
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    ///
    /// # Panics
    /// If the grid is not one that [`Grid::check`] lets pass.
    pub fn new(gpu: &Gpu, grid: Grid) -> Result<Self> {
        grid.check().unwrap_or_else(|what| panic!("grid of cells: {what}"));
        let count = grid.count() as u64;
        let words = vec![0u32; grid.count().div_ceil(32)];
        let occupied = gpu.upload("cells.occupied", &words)?;
        let planes =
            Buffer::new(gpu, "cells.planes", 2 * size_of::<Plane>() as u64 * count, Residence::Device)?;
        let extents = Buffer::new(gpu, "cells.extents", 12 * count, Residence::Device)?;
        Ok(Self { grid, occupied, planes, extents })
    }

    /// Where they are.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// One bit a cell: `Occupied`.
    pub fn occupied(&self) -> &Buffer {
        &self.occupied
    }

    /// Two [`Plane`]s a cell: `Planes`.
    pub fn planes(&self) -> &Buffer {
        &self.planes
    }

    /// Three [`Extent`]s a cell: `Extents`.
    pub fn extents(&self) -> &Buffer {
        &self.extents
    }

    /// All of it, for tests and tools. Submits and waits.
    ///
    /// # Errors
    /// As [`Gpu::download`].
    pub fn read(&self, gpu: &Gpu) -> Result<Read> {
        Ok(Read {
            occupied: gpu.download(&self.occupied)?,
            planes: gpu.download(&self.planes)?,
            extents: gpu.download(&self.extents)?,
        })
    }
}
