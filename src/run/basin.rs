// SPDX-License-Identifier: MIT OR Apache-2.0
//! The state of a water on the GPU, whichever rung steps it.

use crate::{
    gpu::{Access, Buffer, Gpu, Recorder},
    scene::{Model, Simulation},
    water::{
        self as sim,
        cpu::laplacians,
        depth::WALL_M,
        draw::{Drawn, Speeds},
        oracle, Book, BookState, Columns, DepthModel, DepthParams, DepthState, Fourth, FourthParams,
        FourthState, Fused, FusedState, FusedTuning, Params, Pipes, PipesState, PipesTuning, Rain, Shallow,
        Surface, Tier, Tuning, Waves, WavesState, Wet, LAND_M,
    },
};

/// The state and what a step of it is.
pub(super) enum Basin {
    Book(BookState, Params, sim::Model),
    Waves(WavesState, Params, sim::Model),
    Fused(FusedState, Params, sim::Model),
    Fourth(FourthState, FourthParams, sim::Model),
    Pipes(PipesState, Params, sim::Model),
    Depth(DepthState, DepthParams, Box<Ground>),
}

/// What only water over ground has.
pub(super) struct Ground {
    model: DepthModel,
    rain_mps: f64,
    rain: Rain,
    /// Fallen on every column since the start (m).
    fallen_m: f64,
    /// Columns that are no walls.
    open: usize,
}

/// What there is in a basin.
#[derive(Default)]
pub(super) struct Tally {
    /// At rest (m^3).
    pub at_rest_m3: f64,
    /// More than that (m^3).
    pub gain_m3: f64,
    /// In the scheme's units; `None` where the scheme has none.
    pub energy: Option<f64>,
    /// Lowest and highest point of the surface (m above rest); `None` if no column is wet.
    pub between_m: Option<[f32; 2]>,
    /// Of water over ground.
    pub depths: Option<Depths>,
}

/// What there is of water over ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Depths {
    /// Deepest column (m).
    pub deepest_m: f64,
    /// Least depth of any column (m); below zero it is a debt that a drain has left.
    pub least_m: f64,
    /// Columns in debt.
    pub in_debt: usize,
    /// Columns with water in them.
    pub wet: usize,
    /// Columns that are no walls.
    pub open: usize,
    /// Fastest current through any face (m/s).
    pub fastest_mps: f64,
    /// Faces that carry as much as a column in a step lets through: the current there is cut off.
    pub cut_off: usize,
}

impl Basin {
    /// At the start of the scene.
    pub fn new(gpu: &Gpu, simulation: &Simulation) -> Result<Self, sim::Error> {
        Ok(match simulation {
            Simulation::Level { model, variant, is_fused, has_land, height_m } => {
                let (cells, at_rest) = (model.cells, vec![0.0; height_m.len()]);
                match (variant.model, variant.order) {
                    (Model::Book, _) => {
                        let state = Book::new(gpu)?.state(cells)?;
                        state.upload(gpu, height_m)?;
                        let params = model.params(state.pitch());
                        Self::Book(state, params, *model)
                    }
                    (Model::Pipes, _) => {
                        let tuning = PipesTuning::for_grid(gpu, cells);
                        let state =
                            Pipes::new(gpu, tuning, model.diagonal != 0.0, *has_land)?.state(cells)?;
                        state.upload(gpu, height_m)?;
                        let params = model.params(state.pitch());
                        Self::Pipes(state, params, *model)
                    }
                    (_, 4) => {
                        let state =
                            Fourth::new(gpu, Tuning::for_grid(gpu, cells), *has_land)?.state(cells)?;
                        state.upload(gpu, height_m, &at_rest)?;
                        let params = model.fourth_order_params(state.pitch());
                        Self::Fourth(state, params, *model)
                    }
                    _ if *is_fused => {
                        let tuning = FusedTuning::for_grid(gpu, cells);
                        let state = Fused::new(gpu, tuning, model.walls, *has_land)?.state(cells)?;
                        state.upload(gpu, height_m, &at_rest)?;
                        let params = model.params(state.pitch());
                        Self::Fused(state, params, *model)
                    }
                    _ => {
                        let state = Waves::new(gpu, Tuning::for_grid(gpu, cells), *has_land)?.state(cells)?;
                        state.upload(gpu, height_m, &at_rest)?;
                        let params = model.params(state.pitch());
                        Self::Waves(state, params, *model)
                    }
                }
            }
            Simulation::Depth { model, tier, columns, rain_mps } => {
                let tuning = tier.tuning(gpu, model.cells);
                let state = match tier {
                    Tier::Wet => Wet::new(gpu, tuning)?.state(model.cells)?,
                    Tier::Shallow => Shallow::new(gpu, tuning)?.state(model.cells)?,
                };
                state.upload(gpu, columns)?;
                let params = model.params(state.pitch());
                let ground = Ground {
                    model: *model,
                    rain_mps: *rain_mps,
                    rain: Rain::default(),
                    fallen_m: 0.0,
                    open: columns.rise_m.iter().filter(|&&rise| rise != LAND_M).count(),
                };
                Self::Depth(state, params, Box::new(ground))
            }
        })
    }

    /// Records the steps from `first` to before `end`, in as few dispatches as the kernel can, and the barriers between
    /// and after them.
    pub fn record(&mut self, rec: &mut Recorder<'_>, first: u64, end: u64) {
        let mut step = first;
        while step < end {
            // From rest the first flow is half a step's: second order from the start.
            let is_first = step == 0;
            let run = if is_first { 1 } else { (end - step).min(u64::from(u32::MAX)) as u32 };
            let taken = match self {
                Self::Fused(state, params, _) => {
                    state.record(rec, &if is_first { params.first_from_rest() } else { *params }, run);
                    run
                }
                Self::Pipes(state, params, _) => {
                    state.record(rec, &if is_first { params.first_from_rest() } else { *params }, run);
                    run
                }
                Self::Book(state, params, _) => {
                    state.record(rec, &if is_first { params.first_from_rest() } else { *params });
                    1
                }
                Self::Waves(state, params, _) => {
                    state.record(rec, &if is_first { params.first_from_rest() } else { *params });
                    1
                }
                Self::Fourth(state, params, _) => {
                    state.record(rec, &if is_first { params.first_from_rest() } else { *params });
                    1
                }
                Self::Depth(state, params, ground) => {
                    let params = if is_first { params.first_from_rest() } else { *params };
                    state.record(rec, &params.with_rain(ground.rain_of_a_step()));
                    1
                }
            };
            rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
            step += u64::from(taken);
        }
    }

    /// The heights after the steps recorded so far.
    pub fn surface(&self) -> Surface<'_> {
        match self {
            Self::Book(state, ..) => state.surface(),
            Self::Waves(state, ..) => state.surface(),
            Self::Fused(state, ..) => state.surface(),
            Self::Fourth(state, ..) => state.surface(),
            Self::Pipes(state, ..) => state.surface(),
            Self::Depth(state, ..) => state.surface(),
        }
    }

    /// The two between which the steps go to and fro.
    pub fn surfaces(&self) -> [Surface<'_>; 2] {
        match self {
            Self::Book(state, ..) => state.surfaces(),
            Self::Waves(state, ..) => state.surfaces(),
            Self::Fused(state, ..) => state.surfaces(),
            Self::Fourth(state, ..) => state.surfaces(),
            Self::Pipes(state, ..) => state.surfaces(),
            Self::Depth(state, ..) => state.surfaces(),
        }
    }

    /// The velocities that go with each of [`Basin::surfaces`], where there are any.
    pub fn velocities(&self) -> [Option<&Buffer>; 2] {
        match self {
            Self::Waves(state, ..) => state.velocities(),
            Self::Fused(state, ..) => state.velocities(),
            Self::Fourth(state, ..) => state.velocities(),
            Self::Book(..) | Self::Pipes(..) | Self::Depth(..) => [None; 2],
        }
    }

    /// How it is drawn; `has_foam` asks for the speeds too, where there are any.
    pub fn drawn(&self, has_foam: bool) -> Drawn<'_> {
        match self {
            Self::Pipes(state, ..) if has_foam => Drawn::Pipes(state),
            Self::Depth(state, ..) => Drawn::Depth(state),
            _ => Drawn::Level(self.surfaces()),
        }
    }

    /// What a stored flow is as a speed.
    pub fn speeds(&self, depth_m: f64) -> Speeds {
        match self {
            Self::Pipes(_, _, model) => Speeds::Times((model.cell_m / depth_m) as f32),
            Self::Depth(state, ..) if state.tier() == Tier::Wet => Speeds::ByDepth,
            _ => Speeds::Times(1.0),
        }
    }

    /// What a step reads, and what the next steps follow from.
    fn buffers(&self) -> Vec<&Buffer> {
        match self {
            Self::Book(state, ..) => vec![state.columns()],
            Self::Waves(state, ..) => vec![state.height(), state.velocity()],
            Self::Fused(state, ..) => vec![state.height(), state.velocity()],
            Self::Fourth(state, ..) => vec![state.height(), state.velocity()],
            Self::Pipes(state, ..) => vec![state.height(), state.flow()],
            Self::Depth(state, ..) => {
                [Some(state.rise()), state.before(), Some(state.flow())].into_iter().flatten().collect()
            }
        }
    }

    /// All of it, padding included.
    pub fn download(&self, gpu: &Gpu) -> Result<Vec<f32>, sim::Error> {
        let mut all = Vec::new();
        for buffer in self.buffers() {
            all.extend(gpu.download::<f32>(buffer)?);
        }
        Ok(all)
    }

    /// Goes on from what [`Basin::download`] gave after `steps` steps. `false` if it is of another grid or model.
    pub fn upload(&mut self, gpu: &Gpu, mut floats: &[f32], steps: u64) -> Result<bool, sim::Error> {
        let sizes: Vec<usize> = self.buffers().iter().map(|buffer| buffer.bytes() as usize / 4).collect();
        if sizes.iter().sum::<usize>() != floats.len() {
            return Ok(false);
        }
        for (buffer, size) in self.buffers().into_iter().zip(sizes) {
            let (now, later) = floats.split_at(size);
            gpu.upload_to(buffer, now)?;
            floats = later;
        }
        if let Self::Depth(_, _, ground) = self {
            (ground.rain, ground.fallen_m) = (Rain::default(), 0.0);
            for _ in 0..steps {
                ground.rain_of_a_step();
            }
        }
        Ok(true)
    }

    /// Volume that even rain has brought (m^3).
    pub fn rained_m3(&self) -> f64 {
        match self {
            Self::Depth(_, _, ground) => {
                ground.fallen_m * ground.open as f64 * ground.model.cell_m * ground.model.cell_m
            }
            _ => 0.0,
        }
    }

    /// What there is now; `depth_m` is that at rest.
    pub fn tally(&self, gpu: &Gpu, depth_m: f64) -> Result<Tally, sim::Error> {
        let level = |model: &sim::Model, height: &[f32], energy: Option<f64>| {
            let wet = height.iter().filter(|&&h| h != LAND_M);
            let area = model.cell_m.powi(2);
            Tally {
                at_rest_m3: area * depth_m * wet.clone().count() as f64,
                gain_m3: area * oracle::volume(height),
                energy,
                between_m: between(wet.copied()),
                depths: None,
            }
        };
        let moving = |model: &sim::Model, (height, velocity): (Vec<f32>, Vec<f32>)| {
            level(model, &height, Some(oracle::energy(model, &height, &velocity)))
        };
        Ok(match self {
            Self::Waves(state, _, model) => moving(model, state.download(gpu)?),
            Self::Fused(state, _, model) => moving(model, state.download(gpu)?),
            // Of another stencil, whose energy is not this one's.
            Self::Fourth(state, _, model) => level(model, &state.download(gpu)?.0, None),
            Self::Book(state, _, model) => {
                let height: Vec<_> = state.download(gpu)?.iter().map(|column| column.height_m).collect();
                level(model, &height, None)
            }
            Self::Pipes(state, _, model) => {
                let height: Vec<_> = state.download(gpu)?.iter().map(|column| column.height_m).collect();
                level(model, &height, None)
            }
            Self::Depth(state, _, ground) => ground.tally(state.tier(), &state.columns(gpu)?),
        })
    }

    /// Energy of the start, which was at rest, in the units of [`Tally::energy`].
    pub fn start_energy(simulation: &Simulation) -> Option<f64> {
        match simulation {
            Simulation::Level { model, variant, height_m, .. } => {
                let has_energy = variant.model == Model::Waves && variant.order == 2;
                has_energy.then(|| energy_from_rest(model, height_m))
            }
            Simulation::Depth { model, tier, columns, .. } => energy(model, *tier, columns),
        }
    }

    /// Volume above rest of the start (m^3).
    pub fn start_gain_m3(simulation: &Simulation) -> f64 {
        let area = simulation.cell_m().powi(2);
        match simulation {
            Simulation::Level { height_m, .. } => area * oracle::volume(height_m),
            Simulation::Depth { columns, .. } => area * oracle::volume(&columns.rise_m),
        }
    }
}

impl Ground {
    fn rain_of_a_step(&mut self) -> f32 {
        if self.rain_mps == 0.0 {
            return 0.0;
        }
        let falls = self.rain.fall(self.rain_mps, self.model.dt_s);
        self.fallen_m += f64::from(falls);
        falls
    }

    fn tally(&self, tier: Tier, columns: &Columns) -> Tally {
        let area = self.model.cell_m.powi(2);
        let depths_m = columns.depths_m();
        let wet = |i: &usize| depths_m[*i] > self.model.thin_m;
        let is_open = |i: &usize| columns.rise_m[*i] != LAND_M;
        let open = || (0..depths_m.len()).filter(is_open);
        let surfaces_m = columns.surfaces_m();
        let still = |i: usize| f64::from((-columns.bed_m[i]).max(0.0));
        let limit = self.model.cell_m / self.model.dt_s;
        let speeds = || speeds(&self.model, tier, columns, &depths_m);
        Tally {
            at_rest_m3: area * open().map(still).sum::<f64>(),
            gain_m3: area * oracle::volume(&columns.rise_m),
            energy: energy(&self.model, tier, columns),
            between_m: between(open().filter(wet).map(|i| surfaces_m[i] as f32)),
            depths: Some(Depths {
                deepest_m: open().map(|i| depths_m[i]).fold(0.0, f64::max),
                least_m: open().map(|i| depths_m[i]).fold(f64::MAX, f64::min),
                in_debt: open().filter(|&i| depths_m[i] < 0.0).count(),
                wet: open().filter(wet).count(),
                open: self.open,
                fastest_mps: speeds().fold(0.0, f64::max),
                cut_off: speeds().filter(|&speed| speed >= limit * (1.0 - 1e-6)).count(),
            }),
        }
    }
}

/// Speeds through all faces under water (m/s).
fn speeds<'a>(
    model: &DepthModel,
    tier: Tier,
    columns: &'a Columns,
    depths_m: &'a [f64],
) -> impl Iterator<Item = f64> + 'a {
    let (width, thin_m) = (model.cells.x as usize, model.thin_m.max(1e-6));
    (0..depths_m.len()).flat_map(move |i| {
        let through = move |flow: f32, other: usize| {
            let depth = depths_m[i].max(depths_m.get(other).copied().unwrap_or(0.0));
            let by = if tier == Tier::Wet { depth.max(thin_m) } else { 1.0 };
            f64::from(flow).abs() / by
        };
        [through(columns.east[i], i + 1), through(columns.south[i], i + width)]
    })
}

/// Energy of shallow water against water at rest, by its density and a column (m^3/s^2): what lifts it, and what moves it
/// through the faces between. Bores lose some. The upstream depths of wet water have no energy of their own.
fn energy(model: &DepthModel, tier: Tier, columns: &Columns) -> Option<f64> {
    let (width, depths_m) = (model.cells.x as usize, columns.depths_m());
    let lifted = |i: usize| {
        let (bed, rise) = (f64::from(columns.bed_m[i]), f64::from(columns.rise_m[i]));
        match () {
            () if columns.rise_m[i] == LAND_M || bed >= f64::from(WALL_M) => 0.0,
            () if bed <= 0.0 => 0.5 * rise * rise,
            () => rise * (bed + 0.5 * rise),
        }
    };
    let moved = |i: usize, speed: f32, other: usize| {
        let depth = 0.5 * (depths_m[i].max(0.0) + depths_m.get(other).copied().unwrap_or(0.0).max(0.0));
        0.5 * f64::from(speed).powi(2) * depth
    };
    let column = |i: usize| {
        let moved = moved(i, columns.east[i], i + 1) + moved(i, columns.south[i], i + width);
        model.gravity_mps2 * lifted(i) + moved
    };
    (tier == Tier::Shallow).then(|| (0..depths_m.len()).map(column).sum())
}

/// Energy of a start at rest. The energy is that of the surfaces on either side of a flow, and the flow half a step before
/// a start at rest is the mirror image of the one half a step after.
fn energy_from_rest(model: &sim::Model, height_m: &[f32]) -> f64 {
    let heights: Vec<f64> = height_m.iter().map(|&h| f64::from(h)).collect();
    let pulls = laplacians(model, &heights);
    let velocity: Vec<f32> = pulls.iter().map(|pull| (-0.5 * model.pull() * pull) as f32).collect();
    oracle::energy(model, height_m, &velocity)
}

/// Lowest and highest of some heights (m), if there are any.
fn between(heights_m: impl Iterator<Item = f32>) -> Option<[f32; 2]> {
    heights_m.fold(None, |so_far: Option<[f32; 2]>, h| {
        Some(so_far.map_or([h, h], |[low, high]| [low.min(h), high.max(h)]))
    })
}
