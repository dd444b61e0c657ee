// SPDX-License-Identifier: MIT OR Apache-2.0
//! A pool of particles in cells that were filled on the host or by a voxelisation: what hard cases, the study and tests of
//! the law `colliding` run.

use super::{Error, Result};
use crate::{
    cells::{Cells, Grid, Read},
    gpu::{Access, Buffer, Gpu, Recorder, Residence},
    impact::{Count, Impact, Stream},
    mesh::{Body, Mesh, Meshes},
    particles::{
        colliding::{Colliding, Method, Slabs, Surroundings},
        Particle, Particles, Pool, PoolInfo, Step,
    },
    volume::{Conservative, Layered, Router, Way},
};
use glam::Mat4;

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
    thrown: usize,
    index: u64,
    start: Option<Buffer>,
    gpu: Gpu,
}

impl Arena {
    /// The kernels of a method, for a few hundred particles at the most.
    ///
    /// # Errors
    /// The device's.
    pub fn kernels(gpu: &Gpu, method: Method) -> Result<Particles> {
        let mut options = Colliding::options(gpu);
        if gpu.adapter().is_software() {
            // Such a driver computes a whole tile for one particle, and compiles the law once for each item.
            options.tuning.items = 1;
        }
        Ok(Particles::new(gpu, &Colliding::law(method), options)?)
    }

    /// `particles` among `cells`, which are voxelised already, looked at within `reach`.
    ///
    /// # Errors
    /// The device's, or if a number is out of range.
    pub fn new(
        gpu: &Gpu,
        kernels: &Particles,
        cells: &Cells,
        law: Colliding,
        reach: u32,
        particles: &[Particle],
        most_impacts: u32,
    ) -> Result<Self> {
        let law = Colliding { grid: cells.grid(), ..law };
        law.check().map_err(crate::particles::Error::from)?;
        let surroundings = Surroundings::new(gpu, cells, reach, Slabs::OfAll)?;
        gpu.once(|rec| surroundings.record(rec))?;
        let stream = Stream::new(gpu, most_impacts)?;
        let info = PoolInfo {
            capacity: particles.len() as u32,
            life_s: LIFE_S,
            seed: 1,
            start: 0,
            emitters: &[],
            law: bytemuck::bytes_of(&law),
        };
        let mut pool = kernels.pool_with(&info, &surroundings.resources(&stream))?;
        pool.upload(particles)?;
        Ok(Self {
            pool,
            surroundings,
            stream,
            law,
            thrown: particles.len(),
            index: 0,
            start: None,
            gpu: gpu.clone(),
        })
    }

    /// Cells of meshes that do not move: exactly, or as slices drawn from above have them.
    ///
    /// # Errors
    /// The device's; it may have no layered rendering.
    pub fn voxelise(gpu: &Gpu, grid: Grid, meshes: &[Mesh], is_layered: bool) -> Result<Cells> {
        let still = |mesh: &Mesh| Body { mesh: mesh.clone(), world: Mat4::IDENTITY, moves: false };
        let bodies: Vec<Body> = meshes.iter().map(still).collect();
        let meshes = Meshes::new(gpu, &bodies)?;
        let cells = Cells::new(gpu, grid)?;
        if is_layered {
            let volume = Layered::new(gpu, &meshes, &cells, Way::DownY, Router::of(gpu)?)?;
            gpu.once(|rec| volume.record(rec))?;
        } else {
            let volume = Conservative::new(gpu, &meshes, &cells)?;
            gpu.once(|rec| volume.record(rec))?;
        }
        Ok(cells)
    }

    /// Cells on the device as they are on the host.
    ///
    /// # Errors
    /// The device's.
    pub fn upload(gpu: &Gpu, cells: &Cells, read: &Read) -> Result<()> {
        gpu.upload_to(cells.occupied(), &read.occupied)?;
        gpu.upload_to(cells.planes(), &read.planes)?;
        gpu.upload_to(cells.extents(), &read.extents)?;
        Ok(())
    }

    /// Records that the particles are put back to where they began, if [`Arena::rewinds`] has been asked for.
    pub fn restart(&self, rec: &mut Recorder<'_>) {
        if let Some(start) = &self.start {
            rec.barrier(Access::ComputeReadWrite, Access::CopyWrite);
            rec.copy(start, self.pool.particles());
            rec.barrier(Access::CopyWrite, Access::ComputeReadWrite);
        }
    }

    /// Keeps the particles as they are now, for [`Arena::restart`].
    ///
    /// # Errors
    /// The device's.
    pub fn rewinds(mut self) -> Result<Self> {
        let from = self.pool.particles();
        let start = Buffer::new(&self.gpu, "arena.start", from.bytes(), Residence::Device)?;
        self.gpu.once(|rec| rec.copy(from, &start))?;
        self.start = Some(start);
        Ok(self)
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

    /// The particles, slot by slot, all that were put in: nobody who is lost counts as kept.
    ///
    /// # Errors
    /// The device's, and [`Error::Wrong`] if the law has lost some, as what is no number is.
    pub fn particles(&self) -> Result<Vec<Particle>> {
        let all = self.pool.living()?;
        if all.len() != self.thrown {
            let apart = self.thrown.abs_diff(all.len()) as f64;
            return Err(Error::Wrong {
                variant: "colliding: particles in the pool".into(),
                apart,
                allowed: 0.0,
            });
        }
        Ok(all)
    }

    /// Impacts of the last step, and counts.
    ///
    /// # Errors
    /// The device's.
    pub fn impacts(&self) -> Result<(Vec<Impact>, Count)> {
        Ok(self.stream.download()?)
    }

    /// Numbers of the law.
    pub fn law(&self) -> &Colliding {
        &self.law
    }
}
