// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is drawn into the volume: by layers and in one pass, against each other and against rays in f64.

use super::*;
use common::gpu;
use glam::{dvec2, DVec2, Vec3Swizzles};
use whitecap::{
    gpu::Error,
    volume::{Layered, Once, Router, Way},
};

/// How the scene is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Drawn {
    Layers(Router),
    Once,
}

const ALL: [Drawn; 3] = [Drawn::Layers(Router::Vertex), Drawn::Layers(Router::Geometry), Drawn::Once];

/// Cells of the meshes as they are put; `None` if the device lacks what it takes.
fn drawn(gpu: &TestGpu, grid: Grid, bodies: &[Body], way: Way, drawn: Drawn) -> Option<Read> {
    let meshes = Meshes::new(gpu, bodies).unwrap();
    let cells = Cells::new(gpu, grid).unwrap();
    let lacks = |error: Error| match error {
        Error::Lacks { .. } => println!("SKIP {drawn:?}: {error}"),
        other => panic!("{other}"),
    };
    let run = |record: &dyn Fn(&mut whitecap::gpu::Recorder<'_>)| {
        gpu.once(|rec| {
            meshes.record(rec, 0.0, 0.0, &[]);
            for reader in [Access::GraphicsRead, Access::ComputeReadWrite] {
                rec.barrier(Meshes::EXIT, reader);
            }
            record(rec);
            rec.barrier(Layered::EXIT, Access::ComputeReadWrite);
            record(rec);
        })
        .unwrap();
    };
    match drawn {
        Drawn::Layers(router) => {
            let volume = Layered::new(gpu, &meshes, &cells, way, router).map_err(lacks).ok()?;
            run(&|rec| volume.record(rec));
        }
        Drawn::Once => {
            let volume = Once::new(gpu, &meshes, &cells, way).map_err(lacks).ok()?;
            run(&|rec| volume.record(rec));
        }
    }
    Some(cells.read(gpu).unwrap())
}

/// A triangle that a texel's ray may meet in a cell.
struct Met {
    triangle: u32,
    /// From where particles come (cells).
    depth: f64,
    /// Not within what rasterizing rounds of an edge or of a face of the cell.
    is_sure: bool,
}

/// Of a texel: what snapping corners to a 256th, before and after cutting, may move an edge by.
const SNAP: f64 = 1.0 / 128.0;

fn met(grid: &Grid, (at, triangles): &(Vec<Vec3>, Vec<[u32; 3]>), way: Way) -> Vec<Vec<Met>> {
    let axis = way.axis();
    let flat = |v: glam::DVec3| [v.yz(), v.zx(), v.xy()][axis];
    let mut cells: Vec<Vec<Met>> = (0..grid.count()).map(|_| Vec::new()).collect();
    for (t, corners) in triangles.iter().enumerate() {
        let Ok(shape) = cpu::Shape::new(grid, corners.map(|i| at[i as usize])) else { continue };
        let [a, b, c] = shape.corners.map(flat);
        let (low, high) = (flat(shape.low.as_dvec3()), flat(shape.high.as_dvec3()));
        let n = shape.normal;
        let slope = flat(n).length() / n[axis].abs();
        for y in low.y as i32..=high.y as i32 {
            for x in low.x as i32..=high.x as i32 {
                let texel = dvec2(f64::from(x), f64::from(y)) + 0.5;
                let from_edge = |f: DVec2, t: DVec2| {
                    let edge = t - f;
                    let along = ((texel - f).dot(edge) / edge.length_squared().max(1e-300)).clamp(0.0, 1.0);
                    (f + along * edge).distance(texel)
                };
                let is_near = [(a, b), (b, c), (c, a)].iter().any(|&(f, t)| from_edge(f, t) < SNAP);
                // Off its edge the plane goes on: where a snapped corner lets the triangle cover the texel after all.
                let inside = cpu::texel(&shape, axis, texel);
                if inside.is_none() && !is_near {
                    continue;
                }
                let height = shape.corners[0][axis] - flat(n).dot(texel - a) / n[axis];
                let rounding = 1e-5 * (1.0 + slope);
                for near in [height - rounding, height, height + rounding] {
                    let mut cell = [0; 3];
                    cell[(axis + 1) % 3] = x;
                    cell[(axis + 2) % 3] = y;
                    cell[axis] = near.floor().clamp(-2.0, 1e6) as i32;
                    let Some(i) = grid.index(cell.into()) else { continue };
                    if cells[i].iter().any(|met| met.triangle == t as u32) {
                        continue;
                    }
                    let is_sure = !is_near
                        && inside.is_some()
                        && (height - height.round()).abs() > rounding
                        && height.floor() == near.floor();
                    let depth = if (way as u32) < 3 { height } else { -height };
                    cells[i].push(Met { triangle: t as u32, depth, is_sure });
                }
            }
        }
    }
    cells
}

/// What is wrong with drawn cells, and how many a rounding decides.
fn compare_drawn(
    grid: &Grid,
    scene: &(Vec<Vec3>, Vec<[u32; 3]>),
    read: &Read,
    way: Way,
    step: f64,
) -> (Vec<String>, usize) {
    let voxels = cpu::mark(grid, &scene.0, &scene.1);
    let (mut wrong, mut undecided) = (Vec::new(), 0);
    for (cell, met) in met(grid, scene, way).iter().enumerate() {
        let planes = read.planes_of(cell);
        let sure = met.iter().filter(|met| met.is_sure).map(|met| met.depth).fold(f64::INFINITY, f64::min);
        undecided += usize::from(met.iter().any(|met| !met.is_sure));
        let Some(plane) = planes.first() else {
            if sure < f64::INFINITY {
                wrong.push(format!("cell {cell} is empty"));
            }
            continue;
        };
        let mine = met.iter().find(|met| met.triangle + 1 == plane.triangle);
        if planes.len() != 1 || mine.is_none_or(|mine| mine.depth > sure + step) {
            wrong.push(format!("cell {cell} has {planes:?}, the first is {sure}"));
            continue;
        }
        let want = voxels.plane(grid, cell, plane.triangle - 1, [Vec3::ZERO; 3]);
        let apart = (Vec3::from(plane.normal) - Vec3::from(want.normal)).length();
        if apart > 1e-4 || (plane.distance_m - want.distance_m).abs() > 1e-3 * grid.cell_m {
            wrong.push(format!("cell {cell}: {plane:?}, want {want:?}"));
        }
    }
    (wrong, undecided)
}

fn scenes() -> Vec<(&'static str, Grid, Vec<Body>)> {
    let at = Mat4::from_translation(vec3(0.0, 0.5, -0.6));
    let body = |mesh: Mesh| Body {
        mesh,
        world: at * Mat4::from_euler(glam::EulerRot::XYZ, 0.4, 0.3, 0.2),
        moves: true,
    };
    let boxed = Grid::new(vec3(-0.75, 0.0, -1.3), 0.06, glam::uvec3(25, 17, 29));
    vec![
        ("a torus", boxed, vec![body(torus(1000))]),
        (
            "a lizard in a block",
            boxed,
            vec![body(shapes::lizard(1.1)), body(shapes::cuboid(vec3(0.5, 0.2, 0.4)))],
        ),
        ("a tilted sheet over the border", boxed, vec![body(shapes::cuboid(vec3(4.0, 0.01, 4.0)))]),
    ]
}

#[test]
fn texels_are_those_that_rays_meet_whichever_way_they_are_drawn() {
    let gpu = gpu();
    for (what, grid, bodies) in scenes() {
        let one = as_one(&bodies);
        // Of the slab, what a key can tell; and of the whole, what depth of 32 bits can.
        let bits = cpu::key_bits(one.1.len() as u32);
        let step = 1.0 / f64::from((1u32 << (32 - bits)) - 1) + 1e-5;
        for way in Way::ALL {
            for variant in ALL {
                let Some(read) = drawn(&gpu, grid, &bodies, way, variant) else { continue };
                let (wrong, undecided) = compare_drawn(&grid, &one, &read, way, step);
                let marked = read.marked().len();
                println!("{what}, {way:?}, {variant:?}: {marked} marked, {undecided} undecided");
                assert!(
                    wrong.is_empty(),
                    "{what}, {way:?}, {variant:?}: {} wrong, {:#?}",
                    wrong.len(),
                    &wrong[..wrong.len().min(6)]
                );
                assert!(
                    marked > 50 && undecided * 3 < marked,
                    "{what}, {way:?}: {undecided} of {marked} undecided"
                );
            }
        }
    }
}

#[test]
fn one_pass_gives_the_texels_of_the_layers_to_the_bit_but_for_ties() {
    let gpu = gpu();
    for (what, grid, bodies) in scenes() {
        let one = as_one(&bodies);
        for way in Way::ALL {
            let Some(once) = drawn(&gpu, grid, &bodies, way, Drawn::Once) else { continue };
            let tied: Vec<bool> =
                met(&grid, &one, way).iter().map(|met| met.iter().any(|met| !met.is_sure)).collect();
            for router in [Router::Vertex, Router::Geometry] {
                let Some(layers) = drawn(&gpu, grid, &bodies, way, Drawn::Layers(router)) else { continue };
                let (mut same, mut other) = (0, 0);
                for (cell, is_tied) in tied.iter().enumerate() {
                    match (once.planes_of(cell), layers.planes_of(cell)) {
                        ([], []) => {}
                        ([a], [b]) if a.triangle == b.triangle => {
                            let off = (a.distance_m - b.distance_m).abs() / grid.cell_m
                                + (Vec3::from(a.normal) - Vec3::from(b.normal)).length();
                            // Divisions and roots of a GPU may round otherwise from stage to stage.
                            let allowed = if gpu.is_exact() { 0.0 } else { 1e-5 };
                            assert!(off <= allowed, "{what}, cell {cell}: {a:?}, {b:?}");
                            let apart = (Vec3::from(a.velocity_mps) - Vec3::from(b.velocity_mps)).length();
                            assert!(
                                apart <= 1e-3 * (1.0 + Vec3::from(b.velocity_mps).length()),
                                "{a:?}, {b:?}"
                            );
                            same += 1;
                        }
                        // Two that are as near: a key has fewer bits for depth.
                        ([_], [_]) => other += 1,
                        (a, b) => {
                            assert!(is_tied, "{what}, {way:?}, {router:?}, cell {cell}: {a:?}, {b:?}");
                            other += 1;
                        }
                    }
                }
                println!("{what}, {way:?}, {router:?}: {same} the same, {other} tied");
                assert!(same > 50 && other * 50 <= same, "{what}, {way:?}: {same} the same, {other} not");
            }
        }
    }
}

#[test]
fn of_two_floors_in_a_cell_the_one_that_particles_meet_first_stays_in_both_orders() {
    let gpu = gpu();
    let grid = grid(6, 0.2);
    let low = Vec3::from(grid.low_m);
    let sheet = |y: f32| {
        let at = |x: f32, z: f32| low + vec3(x, y, z);
        soup("sheet", &[[at(-1.0, -1.0), at(-1.0, 9.0), at(9.0, -1.0)]])
    };
    let (upper, lower) = (sheet(0.57), sheet(0.45));
    for variant in ALL {
        for (bodies, of_upper) in [
            ([still(upper.clone()), still(lower.clone())], 1),
            ([still(lower.clone()), still(upper.clone())], 2),
        ] {
            for (way, want) in [(Way::DownY, of_upper), (Way::AlongY, 3 - of_upper)] {
                let Some(read) = drawn(&gpu, grid, &bodies, way, variant) else { continue };
                let marked = read.marked();
                assert_eq!(marked.len(), 36, "{variant:?}");
                assert!(
                    marked.iter().all(|&cell| read.planes_of(cell)[0].triangle == want),
                    "{variant:?}, {way:?}"
                );
            }
        }
    }
}

#[test]
fn a_floor_on_the_border_of_the_grid_is_drawn() {
    let gpu = gpu();
    // Round numbers, as a floor at 0 in a grid from 0 has.
    let grid = Grid::new(Vec3::ZERO, 0.25, UVec3::splat(6));
    let at = |x: f32, z: f32| vec3(x, 0.0, z);
    let floor = [still(soup("floor", &[[at(-1.0, -1.0), at(-1.0, 9.0), at(9.0, -1.0)]]))];
    for variant in ALL {
        for way in [Way::DownY, Way::AlongY] {
            let Some(read) = drawn(&gpu, grid, &floor, way, variant) else { continue };
            let marked = read.marked();
            assert_eq!(marked.len(), 36, "{variant:?}, {way:?}");
            assert!(marked.iter().all(|&cell| grid.cell(cell).y == 0), "{variant:?}, {way:?}");
        }
    }
}

#[test]
fn what_is_drawn_loses_what_is_steep() {
    let gpu = gpu();
    for (what, grid, bodies) in scenes() {
        let (exact, _) = conservative(&gpu, grid, &bodies);
        let Some(read) = drawn(&gpu, grid, &bodies, Way::DownY, Drawn::Once) else { continue };
        let (all, found) = (exact.marked().len(), read.marked().len());
        println!("{what}: {found} of {all} cells are drawn");
        assert!(read.marked().iter().all(|&cell| exact.is_occupied(cell)), "{what}");
        assert!(10 * found < 9 * all && 5 * found > all, "{what}: {found} of {all}");
    }
}

#[test]
fn a_wall_along_the_way_is_lost_by_all_that_is_drawn_v2() {
    let gpu = gpu();
    let grid = grid(8, 0.2);
    let low = Vec3::from(grid.low_m);
    let block = [Body {
        mesh: shapes::cuboid(vec3(0.5, 0.5, 0.5)),
        world: Mat4::from_translation(low + Vec3::splat(0.83)),
        moves: false,
    }];
    let (exact, _) = conservative(&gpu, grid, &block);
    for variant in ALL {
        let Some(read) = drawn(&gpu, grid, &block, Way::DownY, variant) else { continue };
        let walls = read.marked().iter().filter(|&&cell| (2..6).contains(&grid.cell(cell).y)).count();
        assert_eq!(walls, 0, "{variant:?}");
        assert!(read.marked().iter().all(|&cell| exact.is_occupied(cell)), "{variant:?}");
        assert!(read.marked().len() * 2 < exact.marked().len(), "{variant:?}");
    }
}

#[test]
fn velocities_are_those_of_the_triangle_that_is_drawn() {
    let gpu = gpu();
    let grid = grid(16, 0.1);
    let now = Mat4::from_translation(vec3(0.1, 0.9, -0.5));
    let before = now * Mat4::from_rotation_y(-0.02);
    let bodies = [moving(shapes::sphere(0.5, 32))];
    let meshes = Meshes::new(&gpu, &bodies).unwrap();
    let cells = Cells::new(&gpu, grid).unwrap();
    let Ok(volume) = Once::new(&gpu, &meshes, &cells, Way::DownY) else { return };
    gpu.once(|rec| {
        meshes.record(rec, 0.0, 0.01, &[[now, before]]);
        for reader in [Access::GraphicsRead, Access::ComputeReadWrite] {
            rec.barrier(Meshes::EXIT, reader);
        }
        volume.record(rec);
        rec.barrier(Once::EXIT, Access::ComputeReadWrite);
    })
    .unwrap();
    let read = cells.read(&gpu).unwrap();
    assert!(read.marked().len() > 100);
    for cell in read.marked() {
        let plane = read.planes_of(cell)[0];
        let centre = grid.centre_m(grid.cell(cell));
        // Below the texel's centre, on the sphere: turning by 2 rad/s about y.
        let arm = centre - now.transform_point3(Vec3::ZERO);
        let want = Vec3::Y.cross(arm) * 2.0;
        let apart = (Vec3::from(plane.velocity_mps) - want).with_y(0.0).length();
        assert!(apart < 0.02, "{plane:?}, want {want}");
    }
}

#[test]
fn a_device_without_a_feature_is_refused_by_name() {
    let gpu = gpu();
    let error = gpu.require("volume.slices", "a feature that no device has").unwrap_err().to_string();
    assert_eq!(error, format!("`volume.slices`: {} has no a feature that no device has", gpu.name()));
    // More slices than can be layers, or more cells than an image of three dimensions takes.
    let most = gpu.limits().max_framebuffer_layers.min(gpu.limits().max_image_array_layers);
    if most < 1024 {
        let long = Grid::new(Vec3::ZERO, 0.1, glam::uvec3(2, most + 1, 2));
        let meshes = Meshes::new(&gpu, &[still(shapes::cuboid(Vec3::ONE))]).unwrap();
        let cells = Cells::new(&gpu, long).unwrap();
        let error =
            Layered::new(&gpu, &meshes, &cells, Way::DownY, Router::Vertex).err().unwrap().to_string();
        assert!(error.contains("maxFramebufferLayers"), "{error}");
    }
}

#[test]
fn the_comparison_of_what_is_drawn_sees_a_texel_too_many_and_one_too_few() {
    let gpu = gpu();
    let (_, grid, bodies) = scenes().remove(0);
    let one = as_one(&bodies);
    let Some(read) = drawn(&gpu, grid, &bodies, Way::DownY, Drawn::Once) else { return };
    let wrong = |read: &Read| compare_drawn(&grid, &one, read, Way::DownY, 1e-3).0.len();
    assert_eq!(wrong(&read), 0);
    let sure = met(&grid, &one, Way::DownY);
    let full = read.marked().into_iter().find(|&cell| sure[cell].iter().any(|met| met.is_sure)).unwrap();
    let empty = (0..grid.count()).find(|&cell| !read.is_occupied(cell)).unwrap();
    let mut changed = read.clone();
    changed.occupied[full / 32] ^= 1 << (full % 32);
    changed.occupied[empty / 32] ^= 1 << (empty % 32);
    assert_eq!(wrong(&changed), 2);
}
