// SPDX-License-Identifier: MIT OR Apache-2.0
//! What compute marks, against the twin.

use super::*;
use common::gpu;
use glam::{ivec3, IVec3};

/// Fails if a cell is wrong, or if rounding decides more than a few.
fn check(what: &str, grid: &Grid, bodies: &[Body], read: &Read) -> Compared {
    let compared = compare(grid, &as_one(bodies), read);
    let (marked, undecided, extents) = (compared.marked, compared.undecided, compared.undecided_extents);
    println!("{what}: {marked} marked, {undecided} undecided, of extents {extents}");
    assert!(compared.marked > 0, "{what}: nothing is marked");
    let wrong = &compared.wrong;
    assert!(wrong.is_empty(), "{what}: {} wrong, such as {:#?}", wrong.len(), &wrong[..wrong.len().min(8)]);
    assert!(compared.undecided * 500 <= compared.marked, "{what}: {compared:?}");
    assert!(compared.undecided_extents * 5000 <= compared.marked, "{what}: {compared:?}");
    compared
}

fn random_triangles(first: u32, count: u32, size_cells: f32, grid: &Grid) -> Mesh {
    let low = Vec3::from(grid.low_m);
    let high = low + UVec3::from(grid.cells).as_vec3() * grid.cell_m;
    // Some reach over the border.
    let margin = Vec3::splat(2.0 * grid.cell_m);
    let size = Vec3::splat(size_cells * grid.cell_m);
    let corners: Vec<[Vec3; 3]> = (first..first + count)
        .map(|t| {
            let at = within(4 * t, low - margin, high + margin);
            [1, 2, 3].map(|k| at + within(4 * t + k, -size, size))
        })
        .collect();
    soup("random", &corners)
}

#[test]
fn random_triangles_mark_what_the_twin_marks() {
    let gpu = gpu();
    for (cells, count, size) in
        [(24, 4000, 0.4), (24, 1500, 2.0), (31, 200, 12.0), (9, 40, 30.0), (1, 30, 1.0)]
    {
        let grid = grid(cells, 0.0713);
        let body = still(random_triangles(count, count, size, &grid));
        let (read, counts) = conservative(&gpu, grid, std::slice::from_ref(&body));
        check(&format!("{count} triangles of {size} cells"), &grid, &[body], &read);
        assert_eq!((counts.no_area, counts.not_finite), (0, 0));
        assert_eq!(counts.large > 0, size > 1.0 && cells > 1, "{counts:?}");
    }
}

/// Triangles that one invocation looks at, and that are in more cells than most: a workgroup of them has more than it deals out at once.
#[test]
fn triangles_of_many_cells_mark_what_the_twin_marks() {
    let gpu = gpu();
    let grid = grid(24, 0.0713);
    let (mut chosen, mut cells) = (Vec::new(), 0);
    let low = Vec3::from(grid.low_m);
    for t in 0.. {
        let at = within(7 * t, low + 0.2, low + 1.2);
        let corners = [1, 2, 3].map(|k| at + within(7 * t + k, Vec3::splat(-0.12), Vec3::splat(0.12)));
        let Ok(shape) = cpu::Shape::new(&grid, corners) else { continue };
        let found = shape.cells();
        let (least, most) =
            found.iter().fold((ivec3(99, 99, 99), IVec3::ZERO), |(least, most), (cell, _)| {
                (least.min(*cell), most.max(*cell))
            });
        if found.len() >= 11 && (most - least + 1).element_product() <= 32 {
            cells += found.len();
            chosen.push(corners);
        }
        if chosen.len() == 256 {
            break;
        }
    }
    assert!(cells > 2 * 1024, "{cells} cells of two workgroups");
    let body = still(soup("many cells", &chosen));
    let (read, counts) = conservative(&gpu, grid, std::slice::from_ref(&body));
    check("triangles of many cells", &grid, &[body], &read);
    assert!(counts.large < 32, "{counts:?}");
}

#[test]
fn grids_that_are_no_cubes_and_lie_far_out_mark_what_the_twin_marks() {
    let gpu = gpu();
    let grid = Grid::new(vec3(800.0, -400.0, 90.0), 0.25, glam::uvec3(17, 5, 66));
    let body = still(random_triangles(1, 600, 3.0, &grid));
    let (read, _) = conservative(&gpu, grid, std::slice::from_ref(&body));
    check("far out", &grid, &[body], &read);
}

#[test]
fn plates_needles_and_duplicates_mark_what_the_twin_marks() {
    let gpu = gpu();
    let grid = grid(20, 0.1);
    let low = Vec3::from(grid.low_m);
    let plate = shapes::cuboid(vec3(0.63, 0.004, 0.51));
    let placed = |mesh: Mesh, at: Vec3| Body { mesh, world: Mat4::from_translation(low + at), moves: false };
    let needles: Vec<[Vec3; 3]> = (0..300)
        .map(|i| {
            let (from, to) = (within(2 * i, low, low + 2.0), within(2 * i + 1, low, low + 2.0));
            let wide = (to - from).any_orthonormal_vector() * 10f32.powi(-2 - i as i32 % 3);
            [from, to, from + wide * 0.1]
        })
        .collect();
    let mut twice = needles[..40].to_vec();
    twice.extend(needles[..40].iter().map(|[a, b, c]| [*a, *c, *b]));
    for (what, body) in [
        ("plate", placed(plate, vec3(1.0, 0.933, 1.1))),
        ("needles", still(soup("needles", &needles))),
        ("the same twice and from behind", still(soup("twice", &[&twice[..], &twice[..]].concat()))),
    ] {
        let (read, counts) = conservative(&gpu, grid, std::slice::from_ref(&body));
        check(what, &grid, &[body], &read);
        assert_eq!((counts.no_area, counts.not_finite), (0, 0), "{what}");
    }
}

#[test]
fn a_hundred_thousand_triangles_mark_what_the_twin_marks() {
    let gpu = gpu();
    let grid = Grid::new(vec3(-0.75, -0.3, -0.75), 1.5 / 32.0, glam::uvec3(32, 13, 32));
    let bodies = [still(torus(100_000)), moving(shapes::lizard(0.8))];
    let (read, counts) = conservative(&gpu, grid, &bodies);
    let compared = check("a torus and a lizard", &grid, &bodies, &read);
    assert!(
        compared.marked > 1500 && counts == Counts { large: counts.large, ..Counts::default() },
        "{counts:?}"
    );
    // The order of threads decides nothing.
    let (again, _) = conservative(&gpu, grid, &bodies);
    assert!(same(&read, &again), "two runs differ");
}

/// Whether two are the same where they mean anything.
pub fn same(a: &Read, b: &Read) -> bool {
    let bytes = |read: &Read, cell: usize| bytemuck::cast_slice::<_, u32>(read.planes_of(cell)).to_vec();
    let is_same = |&cell: &usize| bytes(a, cell) == bytes(b, cell) && a.extents[cell] == b.extents[cell];
    a.occupied == b.occupied && a.marked().iter().all(is_same)
}

#[test]
fn triangles_without_an_area_and_without_a_place_are_counted() {
    let gpu = gpu();
    let grid = grid(8, 0.25);
    let low = Vec3::from(grid.low_m);
    let at = |x: f32, y: f32, z: f32| low + vec3(x, y, z);
    let bad = [
        [at(0.5, 0.5, 0.5); 3],
        [at(0.1, 0.2, 0.3), at(0.5, 0.2, 0.3), at(1.3, 0.2, 0.3)], // a line
        [at(0.1, 0.1, 0.1), at(0.1, 0.1, 0.1), at(0.9, 1.3, 0.4)],
    ];
    let good = [at(0.3, 0.4, 0.9), at(1.2, 1.1, 0.2), at(0.2, 1.3, 1.4)];
    let body = still(soup("one of four", &[bad[0], good, bad[1], bad[2]]));
    let (read, counts) = conservative(&gpu, grid, std::slice::from_ref(&body));
    assert_eq!(counts, Counts { no_area: 3, not_finite: 0, large: counts.large });
    check("one of four", &grid, std::slice::from_ref(&body), &read);
    assert!(read.marked().iter().all(|&cell| read.planes_of(cell)[0].triangle == 2));
    // A place that is no number comes from the matrix of a body.
    let nowhere = Body { world: Mat4::from_translation(Vec3::splat(f32::NAN)), ..body.clone() };
    let (read, counts) = conservative(&gpu, grid, &[nowhere, body]);
    assert_eq!((counts.no_area, counts.not_finite), (3, 4));
    assert!(read.marked().iter().all(|&cell| read.planes_of(cell)[0].triangle == 6));
}

#[test]
fn corners_too_far_out_to_compute_with_are_counted_and_no_plane_is_no_number() {
    let gpu = gpu();
    let grid = grid(8, 0.25);
    let centre = Vec3::from(grid.low_m) + 1.03;
    // In its middle is the origin, whatever the size.
    let corners = [vec3(-1.0, 0.25, -0.75), vec3(1.0, 0.125, -0.875), vec3(0.0, -0.375, 1.625)];
    let floor = soup("floor", &[corners]);
    for (larger, not_finite) in [(1e3, 0), (1e8, 0), (1e9, 1), (1e20, 1), (3e38, 1)] {
        let world = Mat4::from_translation(centre) * Mat4::from_scale(Vec3::splat(larger));
        let body = Body { mesh: floor.clone(), world, moves: false };
        let (read, counts) = conservative(&gpu, grid, &[body]);
        assert_eq!((counts.no_area, counts.not_finite), (0, not_finite), "{larger} times as large");
        assert_eq!(read.marked().is_empty(), not_finite > 0, "{larger} times as large");
        for plane in read.marked().iter().flat_map(|&cell| read.planes_of(cell)) {
            let numbers = [plane.normal, plane.velocity_mps].concat();
            assert!(plane.distance_m.is_finite() && numbers.iter().all(|x| x.is_finite()), "{plane:?}");
            assert!((Vec3::from(plane.normal).length() - 1.0).abs() < 1e-5, "{plane:?}");
        }
    }
}

#[test]
fn what_is_outside_marks_nothing_and_what_crosses_the_border_marks_up_to_it() {
    let gpu = gpu();
    let grid = grid(8, 0.25);
    let low = Vec3::from(grid.low_m);
    let sheet = |y: f32, far: f32| {
        let at = |x: f32, z: f32| low + vec3(x, y, z);
        soup("sheet", &[[at(-far, -far), at(-far, 3.0 * far), at(3.0 * far, -far)]])
    };
    let (read, counts) = conservative(&gpu, grid, &[still(sheet(-0.1, 50.0))]);
    assert_eq!((read.marked().len(), counts.large), (0, 0));
    let (read, _) = conservative(&gpu, grid, &[still(sheet(0.6, 50.0))]);
    assert_eq!(read.marked().len(), 64, "one layer");
    assert!(read.marked().iter().all(|&cell| grid.cell(cell).y == 2));
}

#[test]
fn a_vertical_wall_is_whole_v2() {
    let gpu = gpu();
    let grid = grid(16, 0.1);
    let low = Vec3::from(grid.low_m);
    let at = |y: f32, z: f32| low + vec3(0.55, y, z);
    let wall = mesh(
        "wall",
        vec![at(0.0, 0.0), at(1.6, 0.0), at(1.6, 1.6), at(0.0, 1.6)],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let (read, _) = conservative(&gpu, grid, &[still(wall)]);
    let want: Vec<usize> = (0..grid.count()).filter(|&cell| grid.cell(cell).x == 5).collect();
    assert_eq!(read.marked(), want);
}

#[test]
fn a_plane_on_a_face_marks_both_cells_v7() {
    let gpu = gpu();
    // Corners on whole cells, in a grid whose numbers are not round.
    for low in [Vec3::ZERO, vec3(-0.7, 0.2, -1.3)] {
        let grid = Grid::new(low, 0.1, UVec3::splat(8));
        for axis in 0..3 {
            let at = |a: f32, b: f32| {
                let mut at = [a, b, a];
                at[axis] = 3.0;
                at[(axis + 1) % 3] = a;
                at[(axis + 2) % 3] = b;
                low + Vec3::from(at) * grid.cell_m
            };
            let floor = soup(
                "floor",
                &[[at(0.0, 0.0), at(8.0, 0.0), at(0.0, 8.0)], [at(8.0, 8.0), at(0.0, 8.0), at(8.0, 0.0)]],
            );
            let (read, _) = conservative(&gpu, grid, &[still(floor)]);
            let want: Vec<usize> =
                (0..grid.count()).filter(|&cell| [2, 3].contains(&grid.cell(cell)[axis])).collect();
            assert_eq!(read.marked(), want, "axis {axis}, from {low}");
            for cell in want {
                let plane = read.planes_of(cell)[0];
                let side = (grid.centre_m(grid.cell(cell)) - low)[axis] - 3.0 * grid.cell_m;
                assert!((plane.distance_m.abs() - side.abs()).abs() < 1e-6, "{plane:?}, {side} m off");
            }
        }
    }
}

#[test]
fn a_right_angle_has_two_planes_and_a_thin_wall_both_faces() {
    let gpu = gpu();
    let grid = grid(10, 0.1);
    let low = Vec3::from(grid.low_m);
    let block = |half: Vec3, at: Vec3| Body {
        mesh: shapes::cuboid(half),
        world: Mat4::from_translation(low + at),
        moves: false,
    };
    // The edge runs along z through cells 5, 5.
    let (read, _) = conservative(&gpu, grid, &[block(vec3(0.56, 0.53, 2.0), Vec3::splat(0.0))]);
    for z in 0..10 {
        let cell = grid.index(ivec3(5, 5, z)).unwrap();
        let planes = read.planes_of(cell);
        assert_eq!(planes.len(), 2, "cell {z}");
        let normals: Vec<Vec3> = planes.iter().map(|plane| plane.normal.into()).collect();
        assert!(normals.contains(&Vec3::X) && normals.contains(&Vec3::Y), "{normals:?}");
        // The edge is at 0.56, 0.53 of the grid: both planes pass there.
        let edge = low + vec3(0.56, 0.53, 0.1 * z as f32 + 0.05);
        for plane in planes {
            assert!(plane.distance_of_m(edge, grid.centre_m(grid.cell(cell))).abs() < 1e-6, "{plane:?}");
        }
        assert_eq!(read.planes_of(grid.index(ivec3(5, 2, z)).unwrap()).len(), 1, "away from the edge");
    }
    // A wall of 8 mm within one layer of cells.
    let (read, _) = conservative(&gpu, grid, &[block(vec3(0.004, 2.0, 2.0), vec3(0.455, 0.5, 0.5))]);
    let marked = read.marked();
    assert_eq!(marked.len(), 100);
    for cell in marked {
        let planes = read.planes_of(cell);
        let mut x: Vec<f32> = planes.iter().map(|plane| plane.normal[0]).collect();
        x.sort_by(f32::total_cmp);
        assert_eq!(x, [-1.0, 1.0], "cell {:?}", grid.cell(cell));
        let apart = planes[0].distance_m + planes[1].distance_m;
        assert!((apart + 0.008).abs() < 1e-6, "the centre is {apart} m off both faces together");
    }
}

#[test]
fn parallel_sheets_that_face_one_way_are_two_planes() {
    let gpu = gpu();
    let grid = grid(4, 0.5);
    let low = Vec3::from(grid.low_m);
    let sheet = |y: f32| {
        let at = |x: f32, z: f32| low + vec3(x, y, z);
        [at(-1.0, -1.0), at(-1.0, 9.0), at(9.0, -1.0)]
    };
    let (read, _) = conservative(&gpu, grid, &[still(soup("two", &[sheet(0.6), sheet(0.85)]))]);
    assert!(read.marked().iter().all(|&cell| read.planes_of(cell).len() == 2));
    // A twentieth of a cell apart they are one surface.
    let (read, _) = conservative(&gpu, grid, &[still(soup("one", &[sheet(0.6), sheet(0.625)]))]);
    assert!(read.marked().iter().all(|&cell| read.planes_of(cell).len() == 1));
    assert_eq!(read.marked().len(), 16);
}

#[test]
fn a_point_and_its_tiny_triangle_are_in_one_cell() {
    let gpu = gpu();
    let grid = grid(16, 0.0713);
    let (low, high) = (Vec3::from(grid.low_m), Vec3::from(grid.low_m) + 16.0 * 0.0713);
    let points: Vec<Vec3> = (0..3000).map(|i| within(i, low, high)).collect();
    let tiny = 1e-5;
    let triangles: Vec<[Vec3; 3]> =
        points.iter().map(|&at| [at, at + Vec3::X * tiny, at + Vec3::Y * tiny]).collect();
    let (read, counts) = conservative(&gpu, grid, &[still(soup("tiny", &triangles))]);
    assert_eq!(counts, Counts::default());
    let missed =
        points.iter().filter(|&&at| grid.index(grid.cell_of(at)).is_some_and(|cell| !read.is_occupied(cell)));
    assert_eq!(missed.count(), 0);
}

#[test]
fn the_comparison_sees_a_cell_too_many_one_too_few_and_a_wrong_plane() {
    let gpu = gpu();
    let grid = grid(12, 0.1);
    let body = still(random_triangles(77, 60, 3.0, &grid));
    let bodies = [body];
    let (read, _) = conservative(&gpu, grid, &bodies);
    let one = as_one(&bodies);
    assert_eq!(compare(&grid, &one, &read).wrong, [""; 0]);
    let marked = read.marked();
    let (full, empty) =
        (marked[marked.len() / 2], (0..grid.count()).find(|&cell| !read.is_occupied(cell)).unwrap());
    let change = |change: &dyn Fn(&mut Read)| {
        let mut changed = read.clone();
        change(&mut changed);
        // Of several complaints about a cell the first counts.
        let wrong = compare(&grid, &one, &changed).wrong;
        wrong.iter().map(|it| it.split(':').next()).collect::<std::collections::HashSet<_>>().len()
    };
    assert_eq!(change(&|read| read.occupied[full / 32] ^= 1 << (full % 32)), 1, "one too few");
    assert_eq!(
        change(&|read| {
            read.occupied[empty / 32] ^= 1 << (empty % 32);
            read.planes[2 * empty] = read.planes[2 * full];
        }),
        1,
        "one too many"
    );
    assert_eq!(change(&|read| read.planes[2 * full].distance_m += 1e-4), 1, "a thousandth of a cell");
    assert_eq!(change(&|read| read.planes[2 * full].normal[0] += 1e-3), 1, "a normal");
    let is_corner = |cell: usize| match read.planes_of(cell) {
        [a, b] => Vec3::from(a.normal).dot(b.normal.into()) < 0.9,
        _ => false,
    };
    let two = marked.iter().copied().find(|&cell| is_corner(cell)).unwrap();
    assert_eq!(change(&|read| read.planes[2 * two + 1].triangle = 0), 1, "a second plane that is lost");
    assert_eq!(change(&|read| read.planes[2 * two + 1] = read.planes[2 * two]), 1, "one that is the first");
    assert_eq!(
        change(&|read| read.extents[full] = [Extent::default(); 3]),
        1,
        "a plane that stands for nothing"
    );
    assert_eq!(change(&|read| read.extents[full] = [Extent::ALL; 3]), 1, "planes that stand for all");
}
