// SPDX-License-Identifier: MIT OR Apache-2.0
//! Effects that impacts throw: `kindled/step` takes births from a step of as many impacts, which lie in no order, and
//! `kindled/materialise` writes a vertex a birth from the full ring.

use super::Measured;
use crate::{
    ballistic::{
        cpu_kindled::Kept, kindled::KindledVertices, Builtin, Effect, GroundGrid, Kindling, KindlingInfo,
        Moment, Params, Vertex,
    },
    gpu::{Access, Gpu},
    impact::{Count, Impact, Stream},
    random::{bits, direction_of, units},
    shaders,
    study::{
        must_be_within,
        runs::{self, Effort},
        Result,
    },
};
use glam::Vec3;

const SEED: u32 = 5;
const BORN_S: f64 = 3.0;
const SEEN_S: f64 = 3.2;
/// Of the largest way: what a device fuses that is not `precise`, a few 2^-24.
const ROUNDING: f64 = 1e-5;

/// A ring, the impacts of a step that fills it, and the vertices of what it throws.
struct Hearth {
    kindling: Kindling,
    vertices: KindledVertices,
    params: Params,
    info: KindlingInfo,
    impacts: Vec<Impact>,
}

fn sparks() -> Effect {
    Effect { burst: 1, ..Builtin::Sparks.effect() }
}

/// Number `i` of them, where atomics might have left it.
fn impact(i: u32, count: u32) -> Impact {
    let (a, b) = (units(bits(SEED, 1, i, 0)), units(bits(SEED, 1, i, 1)));
    // In no order: 7919 is prime and divides no count.
    let order = (u64::from(i) * 7919 % u64::from(count)) as u32;
    Impact {
        at_m: Vec3::new(a[0], a[1], a[2]),
        order,
        normal: direction_of([b[0], b[1]]),
        impulse_mps: 1.0 + b[2],
        ..Impact::default()
    }
}

impl Hearth {
    fn new(gpu: &Gpu, count: u32) -> Result<Self> {
        let effect = sparks();
        let info = KindlingInfo {
            most: count,
            burst: effect.burst,
            life_s: effect.life_s,
            least_impulse_mps: 1.0,
            sources: vec![count],
            meshes: Vec::new(),
        };
        let stream = Stream::new(gpu, count)?;
        let kindling = Kindling::new(gpu, &stream, &info)?;
        let (name, spv) = (c"ballistic.sparks_kindled", shaders::BALLISTIC_SPARKS_KINDLED_COMP);
        let vertices = kindling.vertices(name, spv, None)?;
        let impacts: Vec<_> = (0..count).map(|i| impact(i, count)).collect();
        gpu.upload_to(stream.impacts(), &impacts)?;
        gpu.upload_to(stream.count(), &[Count { appended: count, ..stream.counts()? }])?;
        gpu.once(|rec| {
            stream.record_begin(rec);
            stream.record_end(rec);
            kindling.record(rec, Moment::from_s(BORN_S));
            kindling.record_living(rec, Moment::from_s(SEEN_S));
        })?;
        let params = effect.kindled_params(SEED, 0, &GroundGrid::FLAT, count);
        Ok(Self { kindling, vertices, params, info, impacts })
    }

    /// Largest distance of a vertex from the twin's, of the largest; endless if the rings differ.
    fn apart_from_twin(&self, gpu: &Gpu) -> Result<f64> {
        let mut kept = Kept::new(&self.info);
        kept.step(&self.impacts, Moment::from_s(BORN_S));
        let (ring, strikes) = self.kindling.download()?;
        if kept.strikes != strikes || ring.births() != kept.births || ring.living != self.info.most {
            return Ok(f64::INFINITY);
        }
        gpu.once(|rec| self.vertices.record(rec, &self.params))?;
        let got: Vec<Vertex> = gpu.download(self.vertices.buffer())?;
        let (mut apart, mut largest) = (0.0f32, 0.0f32);
        for (i, vertex) in got.iter().enumerate() {
            let now = Moment::from_s(SEEN_S);
            let want = kept.flight(Builtin::Sparks, &self.params, None, now, i as u32);
            let want = want.map_or(Vec3::NAN, |flight| flight.at_m);
            let off = Vec3::from(vertex.at_m).distance(want);
            apart = if off.is_nan() { f32::INFINITY } else { apart.max(off) };
            largest = largest.max(want.length());
        }
        Ok(f64::from(apart / largest))
    }
}

pub(super) fn run(gpu: &Gpu, variant: &str, size: u32, effort: Effort) -> Result<Measured> {
    must_be_within(variant, Hearth::new(gpu, 3001)?.apart_from_twin(gpu)?, ROUNDING)?;
    let hearth = Hearth::new(gpu, size)?;
    let is_step = variant == "kindled/step";
    let timing = runs::time(gpu, effort, |rec| {
        if is_step {
            hearth.kindling.record(rec, Moment::from_s(BORN_S));
        } else {
            hearth.vertices.record(rec, &hearth.params);
            rec.barrier(Access::ComputeWrite, Access::ComputeWrite);
        }
    })?;
    // An impact in, a birth out; or a birth in, a vertex out.
    let (unit, bytes_per_item) = if is_step { ("impact", 64.0 + 48.0) } else { ("particle", 48.0 + 16.0) };
    Ok(Measured { timing, items: f64::from(size), unit, bytes_per_item })
}
