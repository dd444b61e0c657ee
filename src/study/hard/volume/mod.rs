// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hard cases of particles in a voxelised scene: V1 to V10. Beside each stands the figure of the sample of 2007: its response
//! (`seed`), and where marking is the matter (V2, V3, V7) its slices drawn from above.

mod bounces;
mod leaks;

use super::{Case, Context, Outcome};
use crate::{
    cells::{Cells, Grid},
    gpu::Gpu,
    particles::{
        colliding::{Colliding, Method},
        Particle,
    },
    random,
    study::{
        arena::Arena,
        host_cells::{fill, mesh, rectangle, Triangle},
        Result,
    },
};
use bounces::{edges, elastic, pistons, resting, right_angle};
use glam::{dvec3, uvec3, vec3, DVec3, Vec3};
use leaks::{behind, bullets, corners, marked, on_faces};

const DT_S: f64 = 1.0 / 60.0;
const CELL_M: f32 = 0.0625;
/// The seed's.
const RADIUS_M: f32 = 0.1;
const SWEPT: &[&str] = &["dda2"];
const BOTH: &[&str] = &["dda1", "dda2"];

/// The table.
pub const CASES: &[Case] = &[
    Case {
        id: "V1",
        title: "bullets of 16 cells a step do not go through the ground",
        variants: BOTH,
        unit: "of the particles gone through",
        limit: 0.0,
        run: |context, variant| compare(context, "V1", variant, bullets),
    },
    Case {
        id: "V2",
        title: "a vertical wall stops what is thrown at it",
        variants: BOTH,
        unit: "of the particles gone through",
        limit: 0.0,
        run: |context, variant| marked(context, "V2", variant, &[90.], 0.0),
    },
    Case {
        id: "V3",
        title: "slopes of 0 to 89 degrees stop what comes along their normal",
        variants: BOTH,
        unit: "of the particles gone through, at the worst slope",
        limit: 0.0,
        run: |context, variant| {
            marked(context, "V3", variant, &[0., 20., 40., 50., 60., 70., 80., 85., 89.], 0.0131)
        },
    },
    Case {
        id: "V4",
        title: "a corner of 90 degrees keeps its particles at 0.27 to 16 cells a step",
        variants: SWEPT,
        unit: "of the particles gone through, at the worst step",
        limit: 0.0,
        run: |context, variant| {
            compare(context, "V4, 90 degrees", variant, |gpu, method| corners(gpu, method, 90.0))
        },
    },
    Case {
        id: "V4",
        title: "a corner of 60 degrees keeps its particles at 0.27 to 16 cells a step",
        variants: SWEPT,
        unit: "of the particles gone through, at the worst step",
        limit: 0.0,
        run: |context, variant| {
            compare(context, "V4, 60 degrees", variant, |gpu, method| corners(gpu, method, 60.0))
        },
    },
    Case {
        id: "V4",
        title: "a right angle sends a particle back with -v",
        variants: SWEPT,
        unit: "of the speed",
        limit: 1e-6,
        run: |context, variant| compare(context, "V4, turned", variant, right_angle),
    },
    Case {
        id: "V5",
        title: "a ball lies still for 60 s, and gains no energy",
        variants: BOTH,
        unit: "radii from its lowest to its highest",
        limit: 0.01,
        run: resting,
    },
    Case {
        id: "V6",
        title: "pistons of 0.01 to 2 m/s, coming and going, give twice their velocity",
        variants: BOTH,
        unit: "m/s off",
        limit: 1e-5,
        run: |context, variant| compare(context, "V6", variant, pistons),
    },
    Case {
        id: "V7",
        title: "planes exactly on the faces of cells stop what comes from both sides",
        variants: BOTH,
        unit: "of the particles gone through, at the worst axis",
        limit: 0.0,
        run: on_faces,
    },
    Case {
        id: "V8",
        title: "behind a thin wall, and in reach of it, a particle stays behind",
        variants: BOTH,
        unit: "particles on the other side",
        limit: 0.0,
        run: |context, variant| compare(context, "V8", variant, behind),
    },
    Case {
        id: "V9",
        title: "an elastic ball keeps its energy over 1000 bounces (the seed's: 10 s)",
        variants: SWEPT,
        unit: "of the energy",
        limit: 1e-4,
        run: elastic,
    },
    Case {
        id: "V10",
        title: "births with nothing left of their step, and particles beside the volume, stay as they are",
        variants: &["dda2", "seed"],
        unit: "particles moved or no numbers",
        limit: 0.0,
        run: edges,
    },
];

fn method_of(variant: &str) -> Method {
    Method::of(variant).unwrap_or_default()
}

/// A number of the method, and that of the seed's, which the rows of a case share.
fn compare(
    context: &Context<'_>,
    name: &'static str,
    variant: &str,
    run: impl Fn(&Gpu, Method) -> Result<f64>,
) -> Result<Outcome> {
    let outcome = Outcome::of(run(context.gpu, method_of(variant))?);
    Ok(outcome.seed(seed(context, name, || run(context.gpu, Method::Seed))?))
}

/// The seed's number, run once for all rows of a case.
fn seed(context: &Context<'_>, name: &'static str, run: impl FnOnce() -> Result<f64>) -> Result<f64> {
    Ok(context.shared(name, "seed", || Ok(vec![run()?]))?[0])
}

fn units(seed: u32, i: u32) -> [f32; 4] {
    random::units(random::bits(seed, 0, i, 0)).map(|u| 2.0 * u - 1.0)
}

fn at(at_m: Vec3, velocity_mps: Vec3) -> Particle {
    Particle { at_m, velocity_mps, born: 0 }
}

/// The seed's volume: a box of two metres, here round the origin.
fn grid() -> Grid {
    Grid::new(Vec3::splat(-1.0), CELL_M, uvec3(32, 32, 32))
}

/// Without friction, losses and gravity.
fn pure(radius_m: f32) -> Colliding {
    let law = Colliding::new(grid(), radius_m);
    Colliding { restitution: 1.0, friction: 0.0, gravity_mps2: Vec3::ZERO, ..law }
}

fn ground(height_m: f64) -> Vec<Triangle> {
    rectangle(dvec3(-1.0, height_m, -1.0), DVec3::Z * 2.0, DVec3::X * 2.0).to_vec()
}

/// Cells of triangles, filled on the host.
fn host(gpu: &Gpu, grid: Grid, triangles: &[Triangle]) -> Result<Cells> {
    let cells = Cells::new(gpu, grid)?;
    Arena::upload(gpu, &cells, &fill(&grid, triangles))?;
    Ok(cells)
}

fn cells_of(gpu: &Gpu, triangles: &[Triangle], is_layered: bool) -> Result<Cells> {
    let mesh = mesh("walls", triangles).map_err(crate::mesh::MeshesError::from)?;
    Arena::voxelise(gpu, grid(), &[mesh], is_layered)
}

/// Two walls along z, `degrees` apart, that meet off the faces of cells.
fn walls(degrees: f64) -> (Vec<Triangle>, Vec3) {
    let edge = dvec3(-0.713, -0.671, -1.0);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let mut walls = rectangle(edge, DVec3::Z * 2.0, DVec3::X * 3.0).to_vec();
    walls.extend(rectangle(edge, dvec3(3.0 * cos, 3.0 * sin, 0.0), DVec3::Z * 2.0));
    (walls, vec3(edge.x as f32, edge.y as f32, 0.0))
}
