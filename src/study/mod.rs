// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is measured: [`hard`] cases, the [`bench`](mod@bench), and the studies of speed against error.

pub mod arena;
pub mod ballistic;
pub mod bench;
pub mod black_hole;
pub mod depths;
pub mod disks;
pub mod hard;
pub mod host_cells;
pub mod linear;
pub mod nonlinear;
pub mod occupancy;
pub mod page;
pub mod pipelines;
pub mod plot;
pub mod runs;
pub mod shapes;
pub mod volume;

use crate::{
    gpu::{self, Gpu},
    particles,
    run::{
        self,
        atomic::{write_atomic, FileError},
    },
    water,
};
use shapes::{Headline, Parts, Study, StudyResult};
use std::{fs, io, io::Write, path::Path};

/// Result with [`enum@Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What can go wrong while measuring.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A basin's.
    #[error(transparent)]
    Water(#[from] water::Error),
    /// A pool's.
    #[error(transparent)]
    Particles(#[from] particles::Error),
    /// A box of disks'.
    #[error(transparent)]
    Disks(#[from] crate::disks::Error),
    /// A canvas's.
    #[error(transparent)]
    Paint(#[from] crate::paint::Error),
    /// Of the meshes of a scene.
    #[error(transparent)]
    Meshes(#[from] crate::mesh::MeshesError),
    /// The device's.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
    /// A scene's.
    #[error(transparent)]
    Run(#[from] run::RunError),
    /// A report could not be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A name that is none.
    #[error("no {what} `{wanted}`; there are {}", have.join(", "))]
    NoSuch {
        /// What was looked for.
        what: &'static str,
        /// Its name.
        wanted: String,
        /// What there is.
        have: Vec<String>,
    },
    /// A variant that this device does not take.
    #[error("`{variant}`: the device has no {what}")]
    Lacks {
        /// The variant.
        variant: String,
        /// What it needs.
        what: &'static str,
    },
    /// A variant computes something else than its twin: its speed would mean nothing.
    #[error("`{variant}` is {apart:e} from its twin, {allowed:e} allowed: not timed")]
    Wrong {
        /// The variant.
        variant: String,
        /// Largest difference, of the largest height.
        apart: f64,
        /// What rounding explains.
        allowed: f64,
    },
    /// What was timed is no state any more.
    #[error("{what}: {spoiled} of {of} numbers are none any more when it has been timed: its time is not believed")]
    BlownUp {
        /// What was timed.
        what: &'static str,
        /// Numbers that are none.
        spoiled: usize,
        /// Of how many.
        of: usize,
    },
}

/// Refuses what is further from its twin than `allowed`, or no number at all.
///
/// # Errors
/// [`Error::Wrong`].
fn must_be_within(variant: &str, apart: f64, allowed: f64) -> Result<()> {
    match apart <= allowed {
        true => Ok(()),
        false => Err(Error::Wrong { variant: variant.into(), apart, allowed }),
    }
}

/// Refuses the time of what has blown up meanwhile: equal words cost a GPU less than a state does.
///
/// # Errors
/// [`Error::BlownUp`].
fn must_be_numbers(what: &'static str, state: &[f32]) -> Result<()> {
    match state.iter().filter(|x| !x.is_finite()).count() {
        0 => Ok(()),
        spoiled => Err(Error::BlownUp { what, spoiled, of: state.len() }),
    }
}

/// Where a measurement is.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Parts done.
    pub done: usize,
    /// Of how many.
    pub of: usize,
    /// What runs now.
    pub now: &'a str,
}

/// Told before each part.
pub type OnProgress<'a> = &'a mut dyn FnMut(Progress<'_>);

/// What a study found.
#[derive(Debug, Default)]
pub struct Found {
    /// Its points.
    pub studies: Vec<StudyResult>,
    /// Its findings.
    pub headlines: Vec<Headline>,
    /// Where the errors come from.
    pub parts: Vec<Parts>,
}

/// Runs the studies whose name contains one of `names`, all if there are none. `quick` leaves out the long ones.
///
/// # Errors
/// [`Error::NoSuch`], or the device's.
pub fn study(gpu: &Gpu, names: &[String], quick: bool, progress: OnProgress<'_>) -> Result<Study> {
    let have = [linear::NAME, nonlinear::NAME, black_hole::NAME, ballistic::NAME, disks::NAME, volume::NAME];
    for name in names {
        if !have.iter().any(|it| it.contains(name.as_str())) {
            let have = have.map(String::from).to_vec();
            return Err(Error::NoSuch { what: "study", wanted: name.clone(), have });
        }
    }
    let is_wanted = |name: &str| names.is_empty() || names.iter().any(|part| name.contains(part.as_str()));
    let mut studies = Vec::new();
    let (mut headlines, mut parts) = (Vec::new(), Vec::new());
    let mut take = |found: Found| {
        headlines.extend(found.headlines);
        parts.extend(found.parts);
        found.studies
    };
    if is_wanted(linear::NAME) {
        studies.extend(take(linear::study(gpu, quick, progress)?));
    }
    if is_wanted(nonlinear::NAME) {
        studies.extend(take(nonlinear::study(gpu, quick, progress)?));
    }
    if is_wanted(black_hole::NAME) {
        studies.extend(black_hole::study(gpu, quick, progress)?);
    }
    if is_wanted(ballistic::NAME) {
        studies.extend(take(ballistic::study(gpu, quick, progress)?));
    }
    if is_wanted(disks::NAME) {
        studies.extend(disks::study(gpu, quick, progress)?);
    }
    if is_wanted(volume::NAME) {
        studies.extend(take(volume::study(gpu, quick, progress)?));
    }
    Ok(Study {
        device: gpu.name().into(),
        driver: gpu.adapter().driver.clone(),
        clock: gpu.clock()?.name().into(),
        edited: gpu.edited_shaders(),
        studies,
        headlines,
        parts,
    })
}

/// Writes `study.json`, `study.csv`, a plot a study, and `index.html`, which needs no other file, into `dir`.
///
/// # Errors
/// [`Error::File`].
pub fn write_report(study: &Study, dir: &Path, date: &str) -> Result<()> {
    fs::create_dir_all(dir).map_err(crate::run::atomic::failed(dir, "make the folder"))?;
    let write = |name: &str, text: &str| write_atomic(&dir.join(name), |to| to.write_all(text.as_bytes()));
    write_atomic(&dir.join("study.json"), |to: &mut dyn Write| {
        serde_json::to_writer_pretty(&mut *to, study).map_err(io::Error::other)?;
        to.write_all(b"\n")
    })?;
    write("study.csv", &study.to_csv())?;
    let mut plots = Vec::new();
    for result in &study.studies {
        let title = format!("{}: {}, on {}", result.sim, result.study, study.device);
        let metric = result.points.first().map_or("error", |point| &point.metric);
        let plot = plot::panels(&title, "ms per simulated second", metric, &page::panels(result));
        write(
            &format!("{}-{}.svg", result.sim, result.study.replace(", ", "-").replace([' ', '/'], "-")),
            &plot,
        )?;
        plots.push(plot);
    }
    write(
        "index.html",
        &page::page(study, &format!("Speed against error on {}", study.device), date, &plots),
    )?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_not_within_anything() {
        assert!(must_be_within("a", 1e-6, 1e-5).is_ok() && must_be_within("a", 0.0, 0.0).is_ok());
        for apart in [1e-4, f64::NAN, f64::INFINITY] {
            let error = must_be_within("a", apart, 1e-5).expect_err("too far");
            assert!(error.to_string().starts_with("`a` is "), "{error}");
        }
    }

    #[test]
    fn a_state_with_a_number_that_is_none_has_blown_up() {
        assert!(must_be_numbers("water", &[1.0, -3e38]).is_ok());
        let error = must_be_numbers("water", &[1.0, f32::NAN, f32::INFINITY]).expect_err("two are none");
        assert!(error.to_string().starts_with("water: 2 of 3 numbers are none"), "{error}");
    }
}
