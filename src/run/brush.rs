// SPDX-License-Identifier: MIT OR Apache-2.0
//! Paint maps of a scene on the GPU, and what a step leaves on them.

use super::{checkpoint::fnv, stats::PaintStats, RunError};
use crate::{
    draw::{
        map_view::{MapViews, Maps},
        Stage,
    },
    gpu::{Access, Buffer, Gpu, Recorder},
    impact::Stream,
    mesh::Meshes,
    paint::{self, Canvas, Format, Method, Splat},
    scene::{PaintPlan, View},
};
use glam::Vec3;
use std::ops::Range;

/// Halves: white on white stays white, and coats fainter than a thousandth are not asked for.
const FORMAT: Format = Format::Halves;

pub(super) struct Brush {
    canvas: Canvas,
    splat: Splat,
    method: Method,
    names: Vec<String>,
    moving: Vec<usize>,
    still: Vec<usize>,
    charts: Vec<paint::Charts>,
}

impl Brush {
    /// `meshes` begin with those that are painted, which are called `names`.
    pub fn new(
        gpu: &Gpu,
        plan: &PaintPlan,
        meshes: &Meshes,
        names: &[&str],
        stream: &Stream,
    ) -> Result<Self, RunError> {
        let paint = paint::Paint::new(gpu, FORMAT)?;
        let canvas = paint.canvas(&plan.atlas, meshes.places(), meshes.triangles())?;
        let splat = paint.splat(&canvas, stream, &plan.coats)?;
        let all = 0..plan.atlas.maps.len();
        let (moving, still) = all.partition(|&i| meshes.parts()[i].moves);
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        let charts = plan.atlas.charts.clone();
        Ok(Self { canvas, splat, method: plan.scene.variant.method(), names, moving, still, charts })
    }

    /// The paint, and how a texel of it is stored.
    pub fn paint(&self) -> (&Buffer, u32) {
        (self.canvas.paint(), FORMAT as u32)
    }

    /// Where the map of a painted mesh is.
    pub fn map(&self, mesh: usize) -> Option<[u32; 4]> {
        self.canvas.maps().get(mesh).map(|map| [map.width, map.height, map.first_block, map.blocks_x])
    }

    /// A debug view of all maps; positions go from black to white between the corners `box_m`.
    pub fn view(
        &self,
        gpu: &Gpu,
        stage: &Stage,
        view: View,
        box_m: (Vec3, Vec3),
    ) -> Result<Option<MapViews>, RunError> {
        let maps = match view {
            View::PositionMap => Maps::Positions(self.canvas.positions()),
            View::PaintMap => Maps::Paint(self.canvas.paint(), FORMAT as u32),
            _ => return Ok(None),
        };
        let list: Vec<_> = (0..self.names.len()).filter_map(|i| self.map(i)).collect();
        Ok(Some(MapViews::new(gpu, stage, maps, &list, box_m)?))
    }

    /// Finds the texels in the world again: of what moves, or of all.
    pub fn place(&self, rec: &mut Recorder<'_>, all: bool) {
        rec.barrier(Access::ComputeReadWrite, paint::Paint::ENTRY);
        if all && !self.still.is_empty() {
            self.canvas.record_place(rec, &self.still);
            rec.barrier(Access::ComputeReadWrite, paint::Paint::ENTRY);
        }
        if !self.moving.is_empty() {
            self.canvas.record_place(rec, &self.moving);
        }
        rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
    }

    /// Paints from the impacts of a step.
    pub fn paint_step(&self, rec: &mut Recorder<'_>) {
        self.splat.record_by(rec, self.method);
    }

    /// Words of all maps, floats in name only.
    pub fn state(&self, gpu: &Gpu) -> Result<Vec<f32>, RunError> {
        Ok(gpu.download(self.canvas.paint())?)
    }

    /// Goes on from a state. `false` if it is of other maps.
    pub fn restore(&self, gpu: &Gpu, state: &[f32]) -> Result<bool, RunError> {
        if 4 * state.len() as u64 != self.canvas.paint().bytes() {
            return Ok(false);
        }
        gpu.upload_to(self.canvas.paint(), state)?;
        Ok(true)
    }

    pub fn hash(&self, gpu: &Gpu) -> Result<String, RunError> {
        let words: Vec<u32> = gpu.download(self.canvas.paint())?;
        Ok(format!("{:016x}", fnv(bytemuck::cast_slice::<_, u8>(&words).iter().copied())))
    }

    /// What became of the paint of each mesh.
    pub fn stats(&self, gpu: &Gpu) -> Result<Vec<PaintStats>, RunError> {
        let texels = self.canvas.download(gpu)?;
        let of = |(i, name): (usize, &String)| {
            let map = self.canvas.maps()[i];
            let range: Range<usize> = map.first_texel()..map.first_texel() + map.texels();
            let covered = self.charts[i].covered;
            // Opacity of what is covered; gutters take the paint of their border, so they are of no account.
            let painted = texels[range].iter().filter(|texel| texel[3] > 0.0).count() as u64;
            PaintStats {
                name: name.clone(),
                texels: covered,
                overlapping: self.charts[i].overlapping,
                painted: painted.min(covered),
            }
        };
        Ok(self.names.iter().enumerate().map(of).collect())
    }

    /// Impacts that could not paint, since the start.
    pub fn lost(&self, gpu: &Gpu) -> Result<u64, RunError> {
        let work = self.splat.work(gpu)?;
        Ok(u64::from(work.lost) + u64::from(work.twice))
    }
}
