// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rain that makes its own ripples: `land`, drops that land in a step; `rings`, what as many impacts do to a lake, from the
//! stream to the surface. A size is the drops of a step.

use super::{Measured, Suite};
use crate::{
    ballistic::{land::landings, Builtin, Effect, Ground, GroundGrid, Land, Landing, Moment},
    gpu::{Access, Gpu, Recorder},
    impact::{Count, Impact, Stream},
    random,
    study::{
        runs::{self, Effort, Timing},
        Error, Result,
    },
    water::{
        cpu_splash, splash::Hit, Disturb, DisturbParams, Splash, SplashParams, Splashing, Tuning, Waves,
        WavesState,
    },
};
use glam::{uvec2, vec2, vec3, Vec3};

/// Its rows.
pub const SUITE: Suite = Suite {
    sim: "ripples",
    variants: &["land", "rings"],
    sizes: &[1 << 10, 1 << 12, 1 << 14],
    largest_on_cpu: 1 << 12,
    label: |size| size.to_string(),
    run: |gpu, variant, size, effort| {
        let (timing, unit) = match variant {
            "land" => (land(gpu, size, effort)?, "drop"),
            _ => (rings(gpu, size, effort)?, "ring"),
        };
        // An impact is written, or read and made two disturbances, which are read.
        let bytes_per_item = if variant == "land" { 64.0 } else { 64.0 + 4.0 * 32.0 };
        Ok(Measured { timing, items: f64::from(size), unit, bytes_per_item })
    },
};

const SEED: u32 = 5;
const FPS: u32 = 60;

fn wrong(variant: &str, apart: f64, allowed: f64) -> Error {
    Error::Wrong { variant: variant.into(), apart, allowed }
}

/// Rain of which `size` drops land in a sixtieth of a second, on level ground in 2.02 s.
fn land(gpu: &Gpu, size: u32, effort: Effort) -> Result<Timing> {
    let rain = Builtin::Rain.effect();
    let rate_per_s = f64::from(size) / f64::from(rain.burst) * f64::from(FPS);
    let mut effect = Effect { rate_per_s, life_s: 2.1, ..rain };
    effect.emitter.at_m = Vec3::ZERO;
    let stream = Stream::new(gpu, 2 * size)?;
    let ground_m = gpu.upload("bench.ground_m", &[0f32])?;
    let (landing, grid) = (Landing { effect, source: 0 }, GroundGrid::FLAT);
    let spv = (c"ballistic.land", Builtin::Rain.landing().expect("rain lands"));
    let land = Land::new(gpu, spv, landing.clone(), (SEED, 0), (&ground_m, &grid), &stream)?;
    let mut frame = 600;
    let mut step = |rec: &mut Recorder<'_>| {
        stream.record_begin(rec);
        land.record(rec, Some(Moment::of_frame(frame, FPS)), Moment::of_frame(frame + 1, FPS));
        stream.record_end(rec);
        rec.barrier(Stream::EXIT, Stream::ENTRY);
        frame += 1;
    };
    gpu.once(&mut step)?;
    let (got, counts) = stream.download()?;
    let p = landing.params(SEED, 0, &grid);
    let (after, by) = (Moment::of_frame(600, FPS), Moment::of_frame(601, FPS));
    let parts = landing.parts(Some(after), by);
    let want: Vec<Impact> =
        parts.flat_map(|part| landings(Builtin::Rain, &p, &Ground(&[0.0]), &part)).collect();
    // Where a device fuses, one may land a step earlier or later.
    let apart = (got.len() as f64 - want.len() as f64).abs();
    if counts.dropped() > 0 || apart > 2.0 || (want.len() as f64 / f64::from(size) - 1.0).abs() > 0.05 {
        return Err(wrong("land", apart, 2.0));
    }
    runs::time(gpu, effort, step)
}

/// A lake of 384 x 384 columns of 25 cm, as in the scene.
fn lake(gpu: &Gpu, size: u32) -> Result<(WavesState, Stream, Splashing, SplashParams, DisturbParams)> {
    let cells = uvec2(384, 384);
    let state = Waves::new(gpu, Tuning::for_grid(gpu, cells), false)?.state(cells)?;
    let flat = vec![0.0; cells.as_usizevec2().element_product()];
    state.upload(gpu, &flat, &flat)?;
    let surface = state.surface();
    let (pitch, stride) = (surface.pitch, surface.stride);
    let disturb = DisturbParams { cells, pitch, stride, cell_m: 0.25, limit_m: 10.0, has_velocity: 1 };
    let hit = Hit { radius_m: 0.6, volume_m3: 1e-4, volume: true, momentum_in_m: Some(1.6) };
    let params = SplashParams::new(&surface, 0.25, vec2(-48.0, -48.0), &hit);
    let stream = Stream::new(gpu, size)?;
    let list = Disturb::new(gpu)?.list_of(state.surfaces(), state.velocities(), params.items * size)?;
    let splashing = Splash::new(gpu)?.bind(&stream, state.surfaces(), list, params.items)?;
    Ok((state, stream, splashing, params, disturb))
}

/// Impacts all over the lake, in no order.
fn rings(gpu: &Gpu, size: u32, effort: Effort) -> Result<Timing> {
    let (state, stream, splashing, params, disturb) = lake(gpu, size)?;
    let impact = |i: u32| {
        let [x, z, ..] = random::units(random::bits(SEED, 1, i, 0));
        let order = 8 * (i.wrapping_mul(40_503) % size);
        Impact {
            at_m: vec3(96.0 * x - 48.0, 0.0, 96.0 * z - 48.0),
            order,
            impulse_mps: 20.0,
            ..Impact::default()
        }
    };
    let impacts: Vec<Impact> = (0..size).map(impact).collect();
    gpu.upload_to(stream.impacts(), &impacts)?;
    gpu.upload_to(stream.count(), &[Count { appended: size, ..stream.counts()? }])?;
    gpu.once(|rec| {
        stream.record_begin(rec);
        stream.record_end(rec);
    })?;
    let both = Access::ComputeReadWrite;
    let step = |rec: &mut Recorder<'_>| {
        rec.barrier(both, Access::IndirectRead);
        splashing.record(rec, &state.surface(), &params, &disturb);
        rec.barrier(Splash::EXIT, both);
    };
    gpu.once(step)?;
    let mut got = splashing.download()?;
    got.iter_mut().for_each(|it| it.scale = 0.0);
    let heights: Vec<f32> = gpu.download(state.surface().height_m)?;
    if got != cpu_splash::splash(&params, &heights, &impacts).0 {
        return Err(wrong("rings", 1.0, 0.0));
    }
    runs::time(gpu, effort, step)
}
