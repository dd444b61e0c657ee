// SPDX-License-Identifier: MIT OR Apache-2.0
//! Borders that waves leave through: `glsl/water/absorb.comp`, run after each step of `waves` or `fourth`.
//!
//! In a strip of width `W` along a border, `h_tt + gamma(x) h_t = c^2 laplace(h)` with `gamma = 12 c / W (1 - x / W)^2` at
//! `x` from the border: a wave that runs in and out squarely keeps `exp(-4)`, and one that runs at a slant less. The last
//! column radiates as well: `h_t + c h_n = 0` at the border (Engquist and Majda, "Absorbing Boundary Conditions for the
//! Numerical Simulation of Waves", 1977) is, on this grid, a damping of that column by `c / dx`. Level water stays level,
//! whatever its height: only what moves is damped.
//!
//! The longest stable step stays as it is. With `E` the shares kept, one step is `(I + E) / 2 (g'' - 2 g' + g) +
//! (I - E) / 2 (g'' - g) + M g' = 0` for `g = E^-1/2 h`, with `M = E^1/2 K E^1/2`; it is stable if `M <= 2 (I + E)`, and
//! `K <= 4` gives `M <= 4 E <= 2 (I + E)`. Damping the velocity alone, after the height has moved, would not do.

use super::{Model, Surface};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Result},
    shaders,
};
use glam::{uvec2, UVec2};

/// Which borders waves leave through; they come back from the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Borders {
    /// At the least x.
    pub west: bool,
    /// At the greatest x.
    pub east: bool,
    /// At the least z.
    pub north: bool,
    /// At the greatest z.
    pub south: bool,
    /// Width of a strip (columns). Of waves up to 3/4 of it long, 1 % come back at right angles and 3.4 % at 45 degrees; of
    /// waves twice as long as it is wide, 16 %.
    pub strip: u32,
}

impl Borders {
    /// A strip that is wide enough for waves of 8 to 24 columns.
    pub const STRIP: u32 = 32;

    /// Whether there is any.
    pub fn any(&self) -> bool {
        self.west || self.east || self.north || self.south
    }

    /// The rectangles that the strips are made of, none of which overlap: origin and size.
    fn rectangles(&self, cells: UVec2) -> Vec<(UVec2, UVec2)> {
        let strip = |side: bool, most: u32| if side { self.strip.min(most) } else { 0 };
        let north = strip(self.north, cells.y);
        let south = strip(self.south, cells.y - north);
        let west = strip(self.west, cells.x);
        let east = strip(self.east, cells.x - west);
        let rows = cells.y - north - south;
        let all = [
            (UVec2::ZERO, uvec2(cells.x, north)),
            (uvec2(0, cells.y - south), uvec2(cells.x, south)),
            (uvec2(0, north), uvec2(west, rows)),
            (uvec2(cells.x - east, north), uvec2(east, rows)),
        ];
        all.into_iter().filter(|(_, size)| size.min_element() > 0).collect()
    }
}

/// Share of the velocity kept per step, by columns from the border.
pub(super) fn keep(model: &Model, strip: u32) -> Vec<f64> {
    let width = f64::from(strip);
    let share = |i: u32| {
        let deep = 1.0 - (f64::from(i) + 0.5) / width;
        let radiated = if i == 0 { 1.0 / (1.0 + model.courant()) } else { 1.0 };
        radiated * (-12.0 * model.courant() / width * deep * deep).exp()
    };
    (0..strip).map(share).collect()
}

/// Push constants: `Push` in `glsl/water/absorb.comp`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct AbsorbParams {
    cells: UVec2,
    origin: UVec2,
    size: UVec2,
    pitch: u32,
    strip: u32,
    sides: u32,
    dt_s: f32,
}

/// The kernel.
pub struct Absorb {
    kernel: Kernel,
    gpu: Gpu,
}

impl Absorb {
    /// What surface and velocity must be visible to before [`Absorbing::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Absorbing::record`] touched them last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// # Errors
    /// If the device cannot build the kernel.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let info = KernelInfo {
            name: c"water.absorb",
            spv: shaders::WATER_ABSORB_COMP,
            blocks: &["Height", "Velocity", "Keep"],
            constants: &[],
        };
        Ok(Self { kernel: Kernel::new::<AbsorbParams>(gpu, &info)?, gpu: gpu.clone() })
    }

    /// For the two surfaces between which a model goes to and fro, and its velocity.
    ///
    /// # Errors
    /// If the device has no room.
    ///
    /// # Panics
    /// If no border absorbs, or a strip has no columns.
    pub fn borders(
        &self,
        model: &Model,
        borders: Borders,
        surfaces: [Surface<'_>; 2],
        velocity: &Buffer,
    ) -> Result<Absorbing> {
        assert!(borders.any() && borders.strip > 0, "borders that absorb: {borders:?}");
        let shares: Vec<f32> = keep(model, borders.strip).into_iter().map(|share| share as f32).collect();
        let keep = self.gpu.upload("water.absorb_keep", &shares)?;
        let bind = |surface: &Surface<'_>| -> Result<_> {
            let bound = self.kernel.bind(&[
                ("Height", surface.height_m.into()),
                ("Velocity", velocity.into()),
                ("Keep", (&keep).into()),
            ])?;
            Ok((surface.height_m.clone(), bound))
        };
        let sides = [borders.west, borders.east, borders.north, borders.south];
        let sides = (0..4).map(|i| u32::from(sides[i]) << i).sum();
        let of = |(origin, size)| AbsorbParams {
            cells: model.cells,
            origin,
            size,
            pitch: surfaces[0].pitch,
            strip: borders.strip,
            sides,
            dt_s: model.dt_s as f32,
        };
        let rectangles = borders.rectangles(model.cells).into_iter().map(of).collect();
        Ok(Absorbing { bound: [bind(&surfaces[0])?, bind(&surfaces[1])?], rectangles })
    }
}

/// The absorbing borders of one basin.
pub struct Absorbing {
    bound: [(Buffer, Bound); 2],
    rectangles: Vec<AbsorbParams>,
}

impl Absorbing {
    /// Damps the strips of `surface`, after the step that made it.
    ///
    /// # Panics
    /// If `surface` is not one of the two that this was made for.
    pub fn record(&self, rec: &mut Recorder<'_>, surface: &Surface<'_>) {
        let bound = self.bound.iter().find(|(height, _)| height.is(surface.height_m));
        let (_, bound) = bound.expect("a surface that this was made for");
        rec.span(c"water.absorb", |rec| {
            for params in &self.rectangles {
                rec.dispatch(bound, [params.size.x, params.size.y, 1], params);
            }
        });
    }
}
