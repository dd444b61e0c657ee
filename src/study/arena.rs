// SPDX-License-Identifier: MIT OR Apache-2.0
//! A pool of particles in cells that were filled on the host or by a voxelisation: what hard cases, the study and tests of
//! the law `colliding` run.

use super::Result;
use crate::{
    cells::{Cells, Read},
    gpu::{Gpu, Recorder},
    impact::{Count, Impact, Stream},
    particles::{
        colliding::{Colliding, Method, Surroundings},
        Options, Particle, Particles, Pool, PoolInfo, Step,
    },
};

/// Longer than any run: a quarter of the clock.
const LIFE_S: f64 = 16_384.0;

/// A pool, its scene and its impacts.
pub struct Arena {
    /// The particles.
    pub pool: Pool,
    /// The scene.
    pub surroundings: Surroundings,
    /// What they hit.
    pub stream: Stream,
    law: Colliding,
    index: u64,
    gpu: Gpu,
}

impl Arena {
    /// `particles` among `cells`, which are voxelised already; `law.reach` is made that of steps of `dt_s` at up to
    /// `speed_mps`.
    ///
    /// # Errors
    /// The device's, or if a number is out of range.
    pub fn new(
        gpu: &Gpu,
        cells: &Cells,
        law: Colliding,
        (method, options): (Method, Options),
        reach: u32,
        particles: &[Particle],
        most_impacts: u32,
    ) -> Result<Self> {
        let law = Colliding { reach, grid: cells.grid(), ..law };
        law.check().map_err(crate::particles::Error::from)?;
        let surroundings = Surroundings::new(gpu, cells, reach)?;
        gpu.once(|rec| surroundings.record(rec))?;
        let stream = Stream::new(gpu, most_impacts)?;
        let tile = options.tuning.tile();
        let info = PoolInfo {
            capacity: (particles.len() as u32).next_multiple_of(tile),
            life_s: LIFE_S,
            seed: 1,
            start: 0,
            emitters: &[],
            law: bytemuck::bytes_of(&law),
        };
        let mut pool = Particles::new(gpu, &Colliding::law(method), options)?
            .pool_with(&info, &surroundings.resources(&stream))?;
        pool.upload(particles)?;
        Ok(Self { pool, surroundings, stream, law, index: 0, gpu: gpu.clone() })
    }

    /// Cells on the device as they are on the host.
    ///
    /// # Errors
    /// The device's.
    pub fn upload(gpu: &Gpu, cells: &Cells, read: &Read) -> Result<()> {
        gpu.upload_to(cells.occupied(), &read.occupied)?;
        gpu.upload_to(cells.planes(), &read.planes)?;
        Ok(())
    }

    /// Records the next step of `dt_s`.
    pub fn record(&mut self, rec: &mut Recorder<'_>, dt_s: f64) {
        self.stream.record_begin(rec);
        self.pool.record(rec, &Step::nth(self.index, dt_s));
        self.stream.record_end(rec);
        rec.barrier(Particles::EXIT, Particles::ENTRY);
        self.index += 1;
    }

    /// Runs steps of `dt_s`. Submits and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn steps(&mut self, count: u64, dt_s: f64) -> Result<()> {
        const AT_ONCE: u64 = 500;
        let gpu = self.gpu.clone();
        for from in (0..count).step_by(AT_ONCE as usize) {
            let part = AT_ONCE.min(count - from);
            gpu.once(|rec| (0..part).for_each(|_| self.record(rec, dt_s)))?;
        }
        Ok(())
    }

    /// The particles, slot by slot.
    ///
    /// # Errors
    /// The device's.
    pub fn particles(&self) -> Result<Vec<Particle>> {
        Ok(self.pool.living()?)
    }

    /// Impacts of the last step, and counts.
    ///
    /// # Errors
    /// The device's.
    pub fn impacts(&self) -> Result<(Vec<Impact>, Count)> {
        Ok(self.stream.download()?)
    }

    /// Numbers of the law, with the reach of the scene.
    pub fn law(&self) -> &Colliding {
        &self.law
    }
}
