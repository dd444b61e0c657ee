// SPDX-License-Identifier: MIT OR Apache-2.0
//! `waves` with heights and velocities stored as halves: half the traffic of a step, for previews. Reads
//! `glsl/water/waves_f16.comp`, `fused_f16.comp`, `pack.comp` and `unpack.comp`. Scene files do not offer it: docs/water.md says
//! why.
//!
//! A half holds 11 bits. What a step adds to a height is often less than its last bit, so an error is not small: docs/water.md
//! has it measured. Several steps a dispatch round once for all of them, and are better by as much.

use super::{
    check_heights,
    planes::{in_blocks, padded, plain, Planes, Rates},
    tiles::{Step, TileKernels, Tiles},
    Error, FusedParams, Invalid, Params, PipesTuning, Surface, Tuning, Walls,
};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    shaders,
};
use glam::UVec2;

/// The kernels. They hold no basin, so they step any number of them. There is no land: it has no half.
pub struct Halves {
    step: Step,
    pack: Kernel,
    unpack: Kernel,
    tuning: PipesTuning,
    walls: Walls,
    gpu: Gpu,
}

impl Halves {
    /// What the state must be visible to before [`HalvesState::record`], [`HalvesState::pack`] and
    /// [`HalvesState::unpack`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How they touched it last.
    pub const EXIT: Access = Access::ComputeReadWrite;
    /// Largest height (m) and velocity (m/s): a half goes to 65504.
    pub const MOST: f32 = 6e4;

    /// For basins with these walls; one step a dispatch takes any.
    ///
    /// # Errors
    /// If the device does not take the tuning.
    pub fn new(gpu: &Gpu, tuning: PipesTuning, walls: Walls) -> Result<Self> {
        let step = match tuning {
            PipesTuning::OneStep(Tuning { group, rows }) => {
                let info = KernelInfo {
                    name: c"water.waves_f16",
                    spv: shaders::WATER_WAVES_F16_COMP,
                    blocks: &["Height", "Velocity", "NewHeight"],
                    constants: &[group.x, group.y, rows, 0],
                };
                Step::One(Kernel::new::<Params>(gpu, &info)?)
            }
            PipesTuning::Fused(tuning) => {
                let blocks = ["Height", "Velocity", "NewHeight", "NewVelocity"];
                let (what, drops) =
                    ((c"water.fused_f16", shaders::WATER_FUSED_F16_COMP), walls == Walls::Dropped);
                Step::Tiles(TileKernels::new(gpu, what, blocks, tuning, false, drops)?)
            }
        };
        let convert = |name, spv, blocks: &[&str]| {
            Kernel::new::<UVec2>(gpu, &KernelInfo { name, spv, blocks, constants: &[] })
        };
        let pack = convert(c"water.pack", shaders::WATER_PACK_COMP, &["Floats", "Halves"])?;
        let unpack = convert(c"water.unpack", shaders::WATER_UNPACK_COMP, &["Halves", "Floats"])?;
        Ok(Self { step, pack, unpack, tuning, walls, gpu: gpu.clone() })
    }

    /// A basin whose memory is not set yet: [`HalvesState::upload`].
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    pub fn state(&self, cells: UVec2) -> Result<HalvesState> {
        let rates = match self.tuning {
            PipesTuning::OneStep(_) => {
                Rates { names: ["water.velocity_f16", ""], blocks: &["Velocity"], planes: 1, bytes: 2 }
            }
            PipesTuning::Fused(_) => Rates {
                names: ["water.velocity_f16.0", "water.velocity_f16.1"],
                blocks: &["Velocity", "NewVelocity"],
                planes: 1,
                bytes: 2,
            },
        };
        let (halves, tiles) = self.step.state(&self.gpu, cells, &rates, false)?;
        let bytes = 4 * u64::from(halves.pitch()) * u64::from(cells.y);
        let floats = |name: &str| Buffer::new(&self.gpu, name, bytes, Residence::Device);
        let floats = [floats("water.height_m")?, floats("water.velocity_mps")?];
        let of_floats = [&floats[0], &floats[1]];
        let of_halves =
            |i: usize| [halves.surfaces()[i].height_m, halves.rates()[i].expect("a plane of velocities")];
        let pack = |i| bind(&self.pack, ("Floats", of_floats), ("Halves", of_halves(i)));
        let unpack = |i| bind(&self.unpack, ("Halves", of_halves(i)), ("Floats", of_floats));
        let (packs, unpacks) = ([pack(0)?, pack(1)?], [unpack(0)?, unpack(1)?]);
        Ok(HalvesState { halves, tiles, floats, packs, unpacks, tuning: self.tuning, walls: self.walls })
    }
}

/// Heights and velocities, from one pair of buffers to another.
fn bind(kernel: &Kernel, from: (&str, [&Buffer; 2]), to: (&str, [&Buffer; 2])) -> Result<[Bound; 2]> {
    let one = |i: usize| kernel.bind(&[(from.0, from.1[i].into()), (to.0, to.1[i].into())]);
    Ok([one(0)?, one(1)?])
}

/// One basin: a plane of heights and one of velocities as halves, which the steps take to and fro, and one of each as
/// floats, for drawing and disturbing.
pub struct HalvesState {
    halves: Planes,
    tiles: Option<Tiles>,
    floats: [Buffer; 2],
    packs: [[Bound; 2]; 2],
    unpacks: [[Bound; 2]; 2],
    tuning: PipesTuning,
    walls: Walls,
}

impl HalvesState {
    /// Records `steps` steps, as [`FusedState::record`](super::FusedState::record) does.
    ///
    /// # Panics
    /// If `params` are of another grid, or of walls that the kernel was not built for.
    pub fn record(&mut self, rec: &mut Recorder<'_>, params: &Params, steps: u32) {
        let walls = if params.folded == 1 { Walls::Folded } else { Walls::Dropped };
        assert_eq!(walls, self.walls, "walls of the parameters and of the state");
        let halves = &mut self.halves;
        in_blocks(rec, steps, self.tuning.steps(), |rec, steps| match (&self.tiles, self.tuning) {
            (Some(tiles), _) => tiles.record(rec, halves, &FusedParams { water: *params, steps }),
            (None, tuning) => {
                let (threads, grid) = (tuning.threads(halves.cells()), (params.cells, params.pitch));
                halves.dispatch(rec, c"water.waves_f16", threads, grid, params);
            }
        });
    }

    /// Records what makes [`HalvesState::surface`] and [`HalvesState::velocity`] what the halves are.
    pub fn unpack(&self, rec: &mut Recorder<'_>) {
        let [height, velocity] = &self.unpacks[self.halves.current()];
        rec.span(c"water.unpack", |rec| {
            rec.dispatch(height, self.threads(), &self.size());
            rec.dispatch(velocity, self.threads(), &self.size());
        });
    }

    /// Records the inverse, after the floats were disturbed.
    pub fn pack(&self, rec: &mut Recorder<'_>) {
        let [height, velocity] = &self.packs[self.halves.current()];
        rec.span(c"water.pack", |rec| {
            rec.dispatch(height, self.threads(), &self.size());
            rec.dispatch(velocity, self.threads(), &self.size());
        });
    }

    fn size(&self) -> UVec2 {
        UVec2::new(self.halves.pitch() / 4, self.halves.cells().y)
    }

    fn threads(&self) -> [u32; 3] {
        [self.size().x, self.size().y, 1]
    }

    /// Columns from one row to the next.
    pub fn pitch(&self) -> u32 {
        self.halves.pitch()
    }

    /// The surface at the last [`HalvesState::unpack`], for drawing and disturbing. It is always the same buffer.
    pub fn surface(&self) -> Surface<'_> {
        Surface { height_m: &self.floats[0], ..self.halves.surface() }
    }

    /// `f32` a column (m/s) at the last [`HalvesState::unpack`]: how fast it rises, half a step before the heights.
    pub fn velocity(&self) -> &Buffer {
        &self.floats[1]
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.halves.bytes() + 2 * self.floats[0].bytes()
    }

    /// Sets heights (m above rest) and velocities (m/s), without padding.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is above [`Halves::MOST`] or none, or the sizes differ, else the device's.
    pub fn upload(&self, gpu: &Gpu, height_m: &[f32], velocity_mps: &[f32]) -> Result<(), Error> {
        let cells = self.halves.cells();
        let planes = [("height_m", height_m), ("velocity_mps", velocity_mps)];
        for (key, numbers) in planes {
            check_heights(key, numbers, cells, false)?;
            if let Some(i) = numbers.iter().position(|number| number.abs() > Halves::MOST) {
                let value = format!("{} in cell {i}", numbers[i]);
                let allowed = format!("within {}, as halves are", Halves::MOST);
                return Err(Invalid { key, value, allowed }.into());
            }
        }
        for ((_, numbers), floats) in planes.into_iter().zip(&self.floats) {
            gpu.upload_to(floats, &padded(numbers, cells, self.pitch(), 0.0))?;
        }
        gpu.once(|rec| {
            rec.barrier(Access::CopyWrite, Halves::ENTRY);
            self.pack(rec);
        })?;
        Ok(())
    }

    /// Heights (m above rest) and velocities (m/s), without padding.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self, gpu: &Gpu) -> Result<(Vec<f32>, Vec<f32>)> {
        gpu.once(|rec| {
            rec.barrier(Halves::EXIT, Halves::ENTRY);
            self.unpack(rec);
        })?;
        let read = |floats| -> Result<Vec<f32>> {
            Ok(plain(&gpu.download(floats)?, self.halves.cells(), self.pitch()))
        };
        Ok((read(&self.floats[0])?, read(&self.floats[1])?))
    }
}
