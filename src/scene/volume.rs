// SPDX-License-Identifier: MIT OR Apache-2.0
//! `[volume]`: the grid of cells in which particles meet the scene's meshes.

use super::{
    kindled,
    meshes::MeshPlan,
    parse::{Rule::Within, Table},
    schema::{LENGTH, PLACE},
    EmitterScene, MeshScene, PaintPlan, PaintScene, PaintedBy, PlannedBuffer, Scene, Throws, View,
};
use crate::{
    cells::{Grid, MOST_CELLS},
    particles::colliding::Surroundings,
    volume::Way,
};
use glam::{uvec3, UVec3, Vec3};
use serde::Serialize;

/// The grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeScene {
    /// Least corner (m).
    pub low_m: [f32; 3],
    /// Side of a cell (m).
    pub cell_m: f32,
    /// Cells along x, y and z, each 1..=1024.
    pub cells: [u32; 3],
    /// What fills it.
    pub variant: Voxeliser,
    /// Which way most particles go, for what is drawn; default down.
    #[serde(serialize_with = "by_name")]
    pub way: Way,
    /// Step of the meshes and of all that collides (s); `None` is a picture's time, a sixtieth of a second at the most.
    pub dt_s: Option<f64>,
    /// Most impacts of a step.
    pub impacts: u32,
}

/// What fills the cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Voxeliser {
    /// Compute: exact overlap of triangle and cell, two planes a cell.
    #[default]
    Conservative,
    /// The seed's: every triangle drawn once a slice, from above.
    Layered,
    /// Drawn once, the fragment finds its slice.
    OnePass,
}

impl Voxeliser {
    /// With their names.
    pub const ALL: [(&str, Self); 3] =
        [("conservative", Self::Conservative), ("layered", Self::Layered), ("one-pass", Self::OnePass)];

    /// As scenes and results have it.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, it)| *it == self).map_or("", |(name, _)| name)
    }
}

/// Ways, with their names.
const WAYS: [(&str, Way); 6] = [
    ("+x", Way::AlongX),
    ("+y", Way::AlongY),
    ("+z", Way::AlongZ),
    ("-x", Way::DownX),
    ("-y", Way::DownY),
    ("-z", Way::DownZ),
];

fn by_name<S: serde::Serializer>(way: &Way, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(WAYS.iter().find(|(_, it)| it == way).map_or("", |(name, _)| name))
}

/// Most cells: what their planes take of a buffer that 32 bits can count the bytes of.
const MOST: u64 = (1 << 32) / BYTES_A_CELL - 1;
/// Two planes.
const BYTES_A_CELL: u64 = 64;

pub(super) fn volume(mut table: Table<'_>) -> VolumeScene {
    let low_m: [f32; 3] = table.number("low_m", PLACE);
    let size_m: Option<[f32; 3]> = table.maybe("size_m", LENGTH);
    let high_m: Option<[f32; 3]> = table.maybe("high_m", PLACE);
    let size_m = match (size_m, high_m) {
        (Some(_), Some(_)) => {
            table.conflict("high_m", "is given beside size_m; one of them decides");
            [1.0; 3]
        }
        (Some(size), None) => size,
        (None, Some(high)) => {
            let size = [0, 1, 2].map(|k| high[k] - low_m[k]);
            if table.is_clean() && size.iter().any(|side| *side < 1e-4) {
                table.conflict("high_m", format!("is {high:?}; each is more than that of low_m, {low_m:?}"));
            }
            size
        }
        (None, None) => {
            table.missing(
                "size_m",
                format_args!("three numbers, each {LENGTH}; or high_m: three numbers, each {PLACE}"),
            );
            [1.0; 3]
        }
    };
    let longest = size_m.iter().copied().fold(1e-4, f32::max);
    let along: Option<u32> = table.maybe("cells", Within(1.0, f64::from(MOST_CELLS)));
    let cell_m: Option<f32> = table.maybe("cell_m", LENGTH);
    if along.is_some() && cell_m.is_some() {
        table.conflict("cell_m", "is given beside cells; one of them decides");
    }
    let cell_m = cell_m.unwrap_or(longest / along.unwrap_or(32).max(1) as f32).max(1e-6);
    // Whole cells, to the last corner or beyond it.
    let cells = size_m.map(|side| (f64::from(side) / f64::from(cell_m) - 1e-4).ceil().max(1.0));
    let in_all: f64 = cells.iter().product();
    if table.is_clean() {
        if cells.iter().any(|n| *n > f64::from(MOST_CELLS)) {
            let message = format!(
                "makes {} cells along the longest side; allowed: 1 to {MOST_CELLS}",
                cells.iter().copied().fold(0.0, f64::max)
            );
            table.blame("cell_m", super::ProblemKind::OutOfRange, message);
        } else if in_all > MOST as f64 {
            let message = format!("makes {in_all} cells of {BYTES_A_CELL} bytes; allowed: {MOST} of them");
            table.blame(
                if along.is_some() { "cells" } else { "cell_m" },
                super::ProblemKind::OutOfRange,
                message,
            );
        } else if let Err(what) = Grid::new(low_m.into(), cell_m, uvec3(1, 1, 1)).check() {
            table.blame(
                "low_m",
                super::ProblemKind::OutOfRange,
                format!("makes a grid that cannot be: {what}"),
            );
        }
    }
    let volume = VolumeScene {
        low_m,
        cell_m,
        cells: cells.map(|n| n.min(f64::from(MOST_CELLS)) as u32),
        variant: table.choice("variant", &Voxeliser::ALL).unwrap_or_default(),
        way: table.choice("way", &WAYS).unwrap_or(Way::DownY),
        dt_s: table.maybe("dt_s", Within(1e-4, 1.0)),
        impacts: table.maybe("impacts", Within(1.0, f64::from(1u32 << 25))).unwrap_or(1 << 16),
    };
    table.finish();
    volume
}

/// What needs what: notes the tables that are missing, or for nothing.
pub(super) fn check_together(
    root: &mut Table<'_>,
    (volume, paint): (Option<&VolumeScene>, Option<&PaintScene>),
    meshes: &[MeshScene],
    emitters: &[EmitterScene],
    view: View,
) {
    let collides = emitters.iter().any(|it| it.colliding().is_some());
    if !root.is_clean() {
        return;
    }
    if volume.is_some() && meshes.iter().all(|mesh| !mesh.solid) {
        root.conflict("volume", "has nothing to hold: the scene has no [[mesh]] that is solid");
    }
    if volume.is_none() && collides {
        root.conflict("emitter", "has the law \"colliding\", and the scene has no [volume] to collide in");
    }
    kindled::check_together(root, volume.is_some(), emitters, meshes);
    if let Some(i) = meshes.iter().position(|mesh| mesh.map > 0 && !mesh.solid) {
        root.conflict(
            "mesh",
            format!("number {i} takes paint (paints = true), and is not solid: nothing hits it"),
        );
    }
    let is_painted = meshes.iter().any(|mesh| mesh.map > 0);
    if paint.is_some() && !is_painted {
        root.conflict("paint", "has nothing to paint: no [[mesh]] with paints = true");
    }
    if paint.is_some() && !collides {
        root.conflict("paint", "has no one who paints: no [[emitter]] with law = \"colliding\"");
    }
    let of_volume = matches!(view, View::Voxels | View::Planes);
    if of_volume && volume.is_none() || matches!(view, View::PositionMap | View::PaintMap) && paint.is_none()
    {
        let what = if of_volume { "[volume]" } else { "[paint]" };
        root.conflict("output", format!("has a view of {what}, and the scene has none"));
    }
    if paint.is_none() && is_painted {
        root.conflict("mesh", "takes paint (paints = true), and the scene has no [paint]");
    }
}

impl VolumeScene {
    /// As the kernels have it.
    pub fn grid(&self) -> Grid {
        Grid::new(self.low_m.into(), self.cell_m, self.cells.into())
    }

    /// Its greatest corner (m).
    pub fn high_m(&self) -> Vec3 {
        Vec3::from(self.low_m) + self.cell_m * UVec3::from(self.cells).as_vec3()
    }

    /// Cells in all.
    pub fn count(&self) -> u64 {
        self.cells.iter().map(|&n| u64::from(n)).product()
    }

    /// Bytes of bits and planes.
    pub fn bytes(&self) -> [u64; 2] {
        [4 * self.count().div_ceil(32), BYTES_A_CELL * self.count()]
    }
}

/// The grid as it will run.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumePlan {
    /// Where and what of.
    pub scene: VolumeScene,
    /// Step of meshes, cells and what collides (s).
    pub dt_s: f64,
    /// Size, step, and what the fastest particle does in one.
    pub reason: String,
    /// Cells that the fastest particle crosses in a step.
    pub cells_a_step: f64,
    /// No surface is faster (m/s).
    pub surface_mps: f32,
    /// Cells within which a particle looks for surfaces before it flies on without.
    pub reach: u32,
}

impl Scene {
    /// Ends of steps and pictures are one, and no step is longer than a sixtieth of a second unless it is asked for.
    pub(super) fn step_s(&self, asked: Option<f64>) -> f64 {
        let picture_s = 1.0 / self.output.fps;
        asked.unwrap_or(picture_s / (60.0 * picture_s - 1e-9).ceil().max(1.0))
    }

    pub(super) fn plan_volume(&self, meshes: &[MeshPlan]) -> Option<VolumePlan> {
        let volume = self.volume.as_ref()?;
        let dt_s = self.step_s(volume.dt_s);
        let movers = meshes.iter().filter(|mesh| mesh.solid && mesh.moves()).count();
        let still = meshes.iter().filter(|mesh| mesh.solid).count() - movers;
        let [surface_mps, fastest_mps] = self.fastest_mps(volume, meshes, dt_s);
        let cells_a_step = f64::from(surface_mps + fastest_mps) * dt_s / f64::from(volume.cell_m);
        let [x, y, z] = volume.cells;
        let reason = format!(
            "{x} x {y} x {z} cells of {} m, `{}`; {still} meshes at rest fill it once, {movers} that move again in every step; step \
             {dt_s:.6} s: at up to {:.3} m/s a particle crosses {cells_a_step:.2} cells in it",
            volume.cell_m,
            volume.variant.name(),
            surface_mps + fastest_mps,
        );
        let mut plan =
            VolumePlan { scene: volume.clone(), dt_s, reason, cells_a_step, surface_mps, reach: 1 };
        let reach = self.emitters.iter().filter_map(|it| {
            let colliding = self.colliding(it, it.colliding()?, &plan);
            Some(colliding.reach_of(surface_mps + fastest_mps, dt_s as f32))
        });
        plan.reach = reach.max().unwrap_or(1);
        Some(plan)
    }

    /// Fastest surface, and fastest particle: thrown, pushed by that surface, and fallen as high as the volume is (m/s).
    fn fastest_mps(&self, volume: &VolumeScene, meshes: &[MeshPlan], dt_s: f64) -> [f32; 2] {
        let surface = meshes.iter().filter(|mesh| mesh.solid).map(|mesh| mesh.fastest_mps(dt_s));
        let surface_mps = surface.fold(0.0, f32::max);
        let high_m = volume.high_m() - Vec3::from(volume.low_m);
        let thrown = self.emitters.iter().filter_map(|it| {
            let (Throws::Law(law), Some(colliding)) = (&it.throws, it.colliding()) else { return None };
            let own = Vec3::from(it.velocity_mps.unwrap_or_default()).length() + law.speed_mps.abs();
            let fallen = 2.0 * Vec3::from(colliding.gravity_mps2).abs().dot(high_m);
            Some((own * own + fallen).sqrt())
        });
        [surface_mps, thrown.fold(0.0, f32::max)]
    }
}

impl VolumePlan {
    pub(super) fn list_buffers(&self, paint: Option<&PaintPlan>, list: &mut Vec<PlannedBuffer>) {
        let mut add = |name: &str, bytes: u64, because: &str| {
            list.push(PlannedBuffer { name: name.into(), bytes, because: because.into() });
        };
        let [occupied, planes] = self.scene.bytes();
        add("cells.occupied", occupied, "volume");
        add("cells.planes", planes, "volume");
        add("cells.extents", 12 * self.scene.count(), "volume");
        add("particles.near", Surroundings::bytes(&self.scene.grid()), "volume");
        add("impact.impacts", 64 * u64::from(self.scene.impacts), "volume.impacts");
        add("volume.first_keys, .second_keys, .still_keys", 16 * self.scene.count(), "volume");
        add("volume.still_extents", 12 * self.scene.count(), "volume");
        if let Some(paint) = paint {
            let texels = paint.atlas.texels.len() as u64;
            add("paint.paint", 8 * texels, "mesh.map");
            add(
                "paint.texels, .positions, .tiles, .blocks",
                28 * texels + texels / 2 + texels / 128,
                "mesh.map",
            );
            let drops = paint.most_drops(self.scene.impacts);
            let because =
                if paint.scene.from == PaintedBy::Impacts { "volume.impacts" } else { "paint.from" };
            add("paint.drops, .homes", 20 * u64::from(drops), because);
            add(
                "paint.masks",
                u64::from(paint.atlas.blocks()) * 32 * u64::from(drops.div_ceil(256)),
                because,
            );
        }
    }
}
