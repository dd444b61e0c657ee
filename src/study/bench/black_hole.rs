// SPDX-License-Identifier: MIT OR Apache-2.0
//! Throughput of the black hole's integrators, in place in a pool, and of the closed form that stores nothing.

use super::{Measured, Suite};
use crate::{
    gpu::Gpu,
    particles::{
        black_hole_fate::Fates,
        cpu_black_hole::{Body, Law},
        kepler_stateless::{Fountain, Stateless},
    },
    study::{
        black_hole::{ellipses, frame, hole, law, stateless_frame, FRAME_TICKS},
        must_be_within,
        runs::{larger, Effort},
        Result,
    },
};
use glam::DVec3;

/// Its rows.
pub const SUITE: Suite = Suite {
    sim: "particles",
    variants: &VARIANTS,
    sizes: &[1 << 20, 1 << 22, 1 << 24],
    largest_on_cpu: 1 << 20,
    label: |size| size.to_string(),
    run: |gpu, variant, size, effort| run(gpu, variant, size, effort),
};

/// `logh` takes at least a step a frame, and a frame is 1/150 of a radian of these orbits: below x150 all cost alike.
const VARIANTS: [&str; 12] = [
    "law/euler",
    "law/leapfrog",
    "law/leapfrog/x4",
    "law/leapfrog/x16",
    "law/forest-ruth",
    "law/rk4",
    "law/rk4/x4",
    "law/logh/x64",
    "law/logh/x512",
    "law/kepler",
    "kepler-stateless",
    "kepler-stateless/written",
];

/// What rounding explains after ten frames, over the apocentre: 60 roundings of a place, and a periapsis that turns each
/// into fifty times as much.
const ROUNDING: f64 = 60.0 * 50.0 / (1 << 24) as f64;

fn run(gpu: &Gpu, variant: &str, size: u32, effort: Effort) -> Result<Measured> {
    must_be_within(variant, from_twin(gpu, variant)?, ROUNDING)?;
    let (timing, bytes_per_item) = match variant {
        "kepler-stateless" => (stateless_frame(gpu, size, false, effort)?, 0.0),
        "kepler-stateless/written" => (stateless_frame(gpu, size, true, effort)?, 16.0),
        stepped => {
            let orbits = ellipses(size.min(4096), 20.0, 60.0, true); // over and over
            (frame(gpu, &law(stepped, hole()), &orbits, size, effort)?, 56.0)
        }
    };
    Ok(Measured { timing, items: f64::from(size), unit: "particle", bytes_per_item })
}

/// Largest distance from the twin, over the apocentre.
fn from_twin(gpu: &Gpu, variant: &str) -> Result<f64> {
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    if variant.starts_with("kepler-stateless") {
        let (fountain, count) = (Fountain::book(100.0), 1000);
        let places = Stateless::new(gpu, &fountain, count, true)?.places(655_359, 0, count)?;
        let apart = |(n, (at, is_there)): (u32, ([f32; 3], bool))| {
            let (want, is_wanted) = fountain.thrown_at(n, 655_359);
            match is_there == is_wanted {
                true => (wide(at) - wide(want.at_m)).length() / 100.0,
                false => 1.0,
            }
        };
        return Ok((0..count).zip(places).map(apart).fold(0.0, larger));
    }
    let (bodies, law) = (ellipses(500, 20.0, 60.0, true), law(variant, hole()));
    let got = Fates::new(gpu, &law, &bodies)?.run(0, FRAME_TICKS, 10)?;
    let twin = Law::<f32>::new(&law);
    let apart = |(from, (body, _)): (&Body<f32>, (Body<f32>, Option<f32>))| {
        let mut want = *from;
        twin.run(&mut want, 0, FRAME_TICKS, 10);
        (wide(body.at_m) - wide(want.at_m)).length() / 60.0
    };
    Ok(bodies.iter().zip(got).map(apart).fold(0.0, larger))
}
