// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fluids: what is conserved, the pressure, and how energy is shared.

use crate::{
    disks::{oracle, starts, Borders, Model, Response, Space},
    study::{
        disks::{seed_pressure, watch, Gas, Seen, Variant, Watch},
        hard::{Context, Outcome},
        runs::{farther, larger},
        Result,
    },
};

/// D2, D3: momentum and energy lost in 100 s of the tutorial's start, with places on a lattice.
pub fn long(context: &Context<'_>, name: &str) -> Result<Vec<f64>> {
    context.shared("disks for 100 s", name, || {
        // The way in a step is 0.09 radii, as in the tutorial.
        let mut start = starts::fluid(Space::Flat, 500, 0.2245, 6);
        start.model.dt_s = 0.09;
        let variant = Variant::named(name);
        start.model.response = variant.response;
        let substeps = start.model.substeps(&start.disks);
        let mut gas = Gas::new(context.gpu, &variant, &start.model, &start.disks, substeps)?;
        let (mut lost, mut energy) = (0.0_f64, 0.0_f64);
        let before = oracle::energy(&start.model, &start.disks);
        let (was, _) = oracle::momentum(&start.model, &start.disks);
        for _ in 0..20 {
            gas.steps(300)?;
            let disks = gas.disks()?;
            let (momentum, lengths) = oracle::momentum(&start.model, &disks);
            lost = larger(lost, (momentum - was).length() / lengths);
            let drift = oracle::energy(&start.model, &disks) / before - 1.0;
            energy = farther(energy, drift);
        }
        Ok(vec![lost, energy])
    })
}

/// D4: from pairs in a box that repeats; the tutorial's, which has no impulse of a pair, from walls, against exact motion
/// in the same box.
pub fn pressure(context: &Context<'_>, name: &str, way: f64) -> Result<Outcome> {
    let packing: f64 = name.rsplit('/').next().and_then(|it| it.parse().ok()).expect("a packing");
    let variant = Variant::named(name);
    // Near freezing, a fluid takes long to forget the lattice that it started from.
    let collisions = if packing > 0.6 { [200.0, 400.0] } else { [40.0, 120.0] };
    let what = Watch { disks: 1600, packing, way, collisions };
    let Seen { pressure, doubt, substeps, .. } = watch(context.gpu, &variant, what, None)?;
    let outcome = Outcome::of(pressure);
    let note = format!("each step in {substeps}; standard error {doubt:.1e}");
    if variant.response != (Response::Matching { rounds: 3, rewinds: true }) || way < 0.5 || packing > 0.6 {
        return Ok(outcome.note(note));
    }
    let (seed, doubt) = seed_pressure(context.gpu, packing, 0.1, 80.0)?;
    Ok(outcome.seed(seed).note(format!("{note}, {doubt:.1e} of the tutorial's")))
}

/// D10: mean energy of the smaller half over that of the larger, and the mean square of the energy over the squared mean.
pub fn mixture(context: &Context<'_>, name: &str) -> Result<Vec<f64>> {
    context.shared("mixture", name, || {
        let variant = Variant::named(name);
        let start = starts::seed(Space::Flat, 2000, Borders::Walls, 3);
        let model = Model { response: variant.response, ..start.model };
        let mut gas = Gas::new(context.gpu, &variant, &model, &start.disks, model.substeps(&start.disks))?;
        gas.steps(900)?; // some twenty collisions a disk
        let mut order: Vec<usize> = (0..start.disks.len()).collect();
        order.sort_by(|&a, &b| start.disks[a].radius_m.total_cmp(&start.disks[b].radius_m));
        let (mut halves, mut squares) = ([0.0; 2], 0.0);
        for _ in 0..60 {
            gas.steps(10)?;
            let disks = gas.disks()?;
            for (rank, &i) in order.iter().enumerate() {
                let energy =
                    0.5 * model.space.mass(disks[i].radius_m) * disks[i].velocity_mps.length_squared();
                halves[rank / 1000] += energy;
                squares += energy * energy;
            }
        }
        let mean = (halves[0] + halves[1]) / 120_000.0;
        Ok(vec![halves[0] / halves[1], squares / 120_000.0 / (mean * mean)])
    })
}
