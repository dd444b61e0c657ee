// SPDX-License-Identifier: MIT OR Apache-2.0
//! The law `colliding`: its twin, exact solutions, and what it keeps.

use crate::common::{gpu, TestGpu};
use glam::{dvec3, uvec3, vec3, DVec3, IVec3, UVec3, Vec3};
use whitecap::{
    cells::{Cells, Extent, Grid, Read},
    gpu::Gpu,
    impact::{cpu::nearest_weights, Impact, Stream},
    mesh::{shapes, Mesh},
    particles::{
        colliding::{Colliding, Method, Slabs, Surroundings},
        cpu_colliding::{self, Law, Scene},
        Compaction, Emitter, Layout, Options, Particle, Particles, PoolInfo, Step, Thrown, Tuning,
        TICKS_PER_S,
    },
    random,
    study::{
        arena::Arena,
        host_cells::{cuboid, fill, rectangle, Triangle},
    },
};

const DT_S: f64 = 1.0 / 60.0;

fn units(seed: u32, i: u32) -> [f32; 4] {
    random::units(random::bits(seed, 0, i, 0)).map(|u| 2.0 * u - 1.0)
}

fn at(at_m: Vec3, velocity_mps: Vec3) -> Particle {
    Particle { at_m, velocity_mps, born: 0 }
}

fn cells_of(gpu: &Gpu, grid: Grid, read: &Read) -> Cells {
    let cells = Cells::new(gpu, grid).unwrap();
    Arena::upload(gpu, &cells, read).unwrap();
    cells
}

fn arena(gpu: &Gpu, law: Colliding, read: &Read, method: Method, particles: &[Particle]) -> Arena {
    let cells = cells_of(gpu, law.grid, read);
    Arena::new(gpu, &Arena::kernels(gpu, method).unwrap(), &cells, law, 3, particles, 1 << 14).unwrap()
}

/// A cube of 16 cells a side round the origin.
fn grid() -> Grid {
    Grid::new(vec3(-1.0, -1.0, -1.0), 0.125, uvec3(16, 16, 16))
}

fn ground(height: f64) -> Vec<Triangle> {
    rectangle(dvec3(-1.0, height, -1.0), DVec3::Z * 2.0, DVec3::X * 2.0).to_vec()
}

/// A ground, a slope, a wall that comes nearer and a few loose triangles.
fn mixed() -> Vec<Triangle> {
    let mut all = ground(-0.61);
    all.extend(rectangle(dvec3(-0.9, -0.6, -0.8), dvec3(0.1, 0.3, 1.5), dvec3(0.8, -0.1, 0.2)));
    let wall = rectangle(dvec3(0.55, -0.9, -0.9), DVec3::Y * 1.6, DVec3::Z * 1.7);
    all.extend(wall.map(|it| Triangle { velocity_mps: dvec3(-0.4, 0.0, 0.1), ..it }));
    for i in 0..12 {
        let corner = |k: u32| Vec3::from_slice(&units(40 + k, i)[..3]).as_dvec3() * 0.4;
        let middle = Vec3::from_slice(&units(50, i)[..3]).as_dvec3() * 0.5;
        all.push(Triangle::new([0, 1, 2].map(|k| middle + corner(k))));
    }
    all
}

fn crowd(count: u32, speed_mps: f32) -> Vec<Particle> {
    let one = |i| {
        let ([x, y, z, _], [u, v, w, _]) = (units(1, i), units(2, i));
        at(vec3(x, y, z) * 0.95, vec3(u, v, w) * speed_mps)
    };
    (0..count).map(one).collect()
}

#[test]
fn every_method_is_its_twin() {
    let gpu = gpu();
    let read = fill(&grid(), &mixed());
    let near = cpu_colliding::near(&grid(), &read, 3, Slabs::OfAll);
    let mut hits = 0;
    for method in Method::ALL {
        // The last in steps of up to four cells, so that the way is cut.
        for (radius_m, friction, speed_mps) in [(0.03, 0.3, 3.0), (0.2, 0.0, 3.0), (0.03, 0.1, 30.0)] {
            let law = Colliding {
                friction,
                surface_mps: 0.5,
                source: 4,
                sources: 3,
                respawns: 1,
                floor_m: -0.95,
                emitter_m: vec3(0.0, 0.8, 0.0),
                emitter_radius_m: 0.1,
                seed: 9,
                ..Colliding::new(grid(), radius_m)
            };
            // Tuned as whoever runs it has it.
            let kernels = Particles::new(&gpu, &Colliding::law(method), Colliding::options(&gpu)).unwrap();
            let cells = cells_of(&gpu, grid(), &read);
            let mut arena =
                Arena::new(&gpu, &kernels, &cells, law, 3, &crowd(301, speed_mps), 1 << 14).unwrap();
            let mut twin = crowd(301, speed_mps);
            let law = *arena.law();
            let scene = Scene { occupied: &read.occupied, planes: &read.planes, near: &near };
            let on_gpu = gpu.download::<u32>(arena.surroundings.near()).unwrap();
            assert_eq!(on_gpu.len(), near.len());
            let apart = on_gpu.iter().zip(&near).enumerate().find(|(_, (a, b))| a != b);
            assert!(!gpu.is_exact() || apart.is_none(), "word {apart:x?} of what is near");
            for step in 0..25 {
                arena.steps(1, DT_S).unwrap();
                let tick = arena.pool.now();
                let mut want: Vec<Impact> = Vec::new();
                for (slot, it) in twin.iter_mut().enumerate() {
                    let twin = Law { law: &law, method, scene, tick, step_s: DT_S as f32 };
                    assert!(twin.advance(it, DT_S as f32, slot as u32, &mut want));
                }
                let (got, counts) = arena.impacts().unwrap();
                let now = arena.particles().unwrap();
                if gpu.is_exact() {
                    for (i, (a, b)) in now.iter().zip(&twin).enumerate() {
                        let same = bytemuck::bytes_of(a) == bytemuck::bytes_of(b);
                        assert!(same, "{method:?} step {step} particle {i}: {a:?} {b:?}");
                    }
                    assert_eq!(got, want, "{method:?} step {step}");
                } else {
                    // Rounding decides what is near a rim: most go the same way.
                    let apart =
                        now.iter().zip(&twin).filter(|(a, b)| (a.at_m - b.at_m).length() > 1e-3).count();
                    assert!(apart < 60, "{method:?} step {step}: {apart} apart");
                }
                assert_eq!(counts.dropped(), 0);
                assert!(got.iter().all(|it| it.source == 4 + it.order / 8 % 3));
                hits += got.len();
            }
        }
    }
    assert!(hits > 3000, "{hits} impacts compared");
}

#[test]
fn cells_near_occupied_ones_are_marked_as_by_the_twin() {
    let gpu = gpu();
    for cells in [uvec3(1, 1, 1), uvec3(17, 5, 9), uvec3(32, 3, 3), uvec3(33, 40, 2)] {
        let grid = Grid::new(Vec3::ZERO, 0.1, cells);
        for reach in [1, 2, 14] {
            let mut read = fill(&grid, &[]);
            for k in 0..3 {
                let i = random::bits(7, k, cells.x, reach)[0] as usize % grid.count();
                read.occupied[i / 32] |= 1 << (i % 32);
            }
            near_is_as_the_twin(&gpu, grid, &read, reach, Slabs::of(reach == 2));
        }
    }
    // A part of the scene, in rows that begin anywhere in a word, and bricks that the grid does not fill.
    for cells in [uvec3(17, 13, 11), uvec3(37, 10, 15)] {
        let grid = Grid::new(vec3(-1.01, -0.97, -1.03), 0.125, cells);
        let read = fill(&grid, &mixed());
        assert!((0..grid.count()).filter(|i| read.is_occupied(*i)).count() > 100);
        for slabs in [Slabs::OfEight, Slabs::OfAll] {
            near_is_as_the_twin(&gpu, grid, &read, 2, slabs);
        }
    }
}

fn near_is_as_the_twin(gpu: &TestGpu, grid: Grid, read: &Read, reach: u32, slabs: Slabs) {
    let surroundings = Surroundings::new(gpu, &cells_of(gpu, grid, read), reach, slabs).unwrap();
    gpu.once(|rec| surroundings.record(rec)).unwrap();
    let (got, want) =
        (gpu.download::<u32>(surroundings.near()).unwrap(), cpu_colliding::near(&grid, read, reach, slabs));
    let apart = got.iter().zip(&want).filter(|(a, b)| a != b).count();
    // Elsewhere rounding may put a bound of a slab into the next step.
    assert!(
        apart <= if gpu.is_exact() { 0 } else { want.len() / 100 },
        "{:?} {reach}: {apart} words",
        grid.cells
    );
}

/// What is felt within a cell of a corner, in f64, lies in the slab that is known there; and of a level ground that slab is thin.
#[test]
fn a_slab_holds_all_that_lies_round_a_corner() {
    let (grid, mut looked, mut lent, mut beyond) = (grid(), 0, 0, 0);
    let scenes = [(mixed(), 2.1), (ground(-0.61), 0.03)];
    for ((triangles, thickest), slabs) in
        scenes.iter().flat_map(|scene| [(scene, Slabs::OfEight), (scene, Slabs::OfAll)])
    {
        let read = fill(&grid, triangles);
        let near = cpu_colliding::near(&grid, &read, 2, slabs);
        // Where there is something to know, and how far round.
        let (gaps, around) = if slabs == Slabs::OfAll { (2, 0..4) } else { (1, 1..3) };
        for corner in (0..grid.count()).filter(|i| near[i / 8] >> (4 * (i % 8)) & 15 < gaps) {
            let (n, [low, high]) = cpu_colliding::slab(&near, grid.count(), corner);
            let (n, low, high) = (n.as_dvec3(), f64::from(low), f64::from(high));
            assert!(
                (n.abs().element_sum() - 1.0).abs() < 1e-6 && high - low <= *thickest,
                "{n} {low} {high}"
            );
            let is_asked = |k: &i32| [k & 3, k >> 2 & 3, k >> 4].iter().all(|at| around.contains(at));
            for k in (0..64).filter(is_asked) {
                let cell = grid.cell(corner) + IVec3::new(k & 3, k >> 2 & 3, k >> 4) - 2;
                let Some(i) = grid.index(cell).filter(|i| read.occupied[i / 32] >> (i % 32) & 1 != 0) else {
                    continue;
                };
                for (stored, slot) in cpu_colliding::met_in(&grid, &near, cell) {
                    let plane = read.planes[2 * grid.index(stored).unwrap() + slot];
                    let extents = read.extents[i];
                    let felt = match (stored == cell, slot) {
                        (false, _) => extents[2],
                        (true, 0) => Extent(extents[0].0 | extents[1].0 | extents[2].0), // alone it stands for all
                        (true, _) => extents[1],
                    };
                    let m = Vec3::from(plane.normal).as_dvec3();
                    let away = f64::from(plane.distance_m / grid.cell_m) + m.dot((cell - stored).as_dvec3());
                    for s in 0..40 {
                        // From the middle of the cell, in cells.
                        let y = 0.625 * Vec3::from_slice(&units(70 + s, i as u32)[..3]).as_dvec3();
                        let y = y - m * (m.dot(y) + away);
                        let from_corner = y + 0.5 + (cell - grid.cell(corner)).as_dvec3();
                        // Felt there, and where someone may be who asks.
                        if !felt.has(y.as_vec3(), 1.0) || from_corner.abs().max_element() > 1.0 {
                            continue;
                        }
                        let along = n.dot(from_corner);
                        // Bounds are in f32; who looks at them is a thousandth of a cell wider.
                        assert!(
                            low - 1e-5 <= along && along <= high + 1e-5,
                            "{corner} {cell}: {along}, {low} to {high}"
                        );
                        lent += u32::from(stored != cell);
                        let away = cell - grid.cell(corner);
                        beyond += u32::from(away.min_element() < -1 || away.max_element() > 0);
                        looked += 1;
                    }
                }
            }
        }
    }
    assert!(looked > 10_000 && lent > 100, "{looked} points, {lent} on planes of cells beside");
    assert!(beyond > 100, "{beyond} points of cells that the corner is none of");
}

/// Whom the one look lets by meets nothing, at any speed, in a scene whose planes move, also in a part of a step.
#[test]
fn who_passes_the_look_meets_nothing() {
    // What bends comes out of its cells.
    let scene = [mixed(), triangles_of(&shapes::torus(0.6, 0.2, 20))].concat();
    let (grid, read) = (grid(), fill(&grid(), &scene));
    let nears = [Slabs::OfEight, Slabs::OfAll].map(|slabs| cpu_colliding::near(&grid, &read, 3, slabs));
    let (mut passed, mut beside, mut met) = (0, 0, 0);
    for (radius_m, speed_mps, lead_s) in
        [(0.01, 1.0, 0.0), (0.03, 4.0, DT_S as f32), (0.05, 2.0, 0.0), (0.2, 8.0, 0.0)]
    {
        let law = Colliding { surface_mps: 0.5, lead_s, ..Colliding::new(grid, radius_m) };
        for (i, start) in crowd(20_000, speed_mps).into_iter().enumerate() {
            let method = if i % 2 == 0 { Method::TwoPlanes } else { Method::OnePlane };
            let near = &nears[i / 2 % 2];
            let scene = Scene { occupied: &read.occupied, planes: &read.planes, near };
            let twin = Law { law: &law, method, scene, tick: 0, step_s: DT_S as f32 };
            let dt_s = if i % 3 == 0 { 0.3 * DT_S as f32 } else { DT_S as f32 };
            let (mut it, mut impacts) = (start, Vec::new());
            twin.advance(&mut it, dt_s, 0, &mut impacts);
            let flown = start.at_m + (start.velocity_mps * dt_s + law.gravity_mps2 * (0.5 * dt_s * dt_s));
            let is_met = !impacts.is_empty() || it.at_m != flown;
            let passes = twin.passes(&start, dt_s);
            assert!(
                !(passes && is_met),
                "{radius_m} m: {start:?} met {impacts:?}, is at {} and not {flown}",
                it.at_m
            );
            let corner = ((start.at_m - Vec3::from(grid.low_m)) / grid.cell_m).round().as_ivec3();
            let is_near = grid.index(corner).is_some_and(|i| near[i / 8] >> (4 * (i % 8)) & 15 == 0);
            passed += u32::from(passes);
            beside += u32::from(passes && is_near);
            met += u32::from(is_met);
        }
    }
    assert!(
        passed > 20_000 && beside > 2000 && met > 1000,
        "{passed} pass, {beside} near a cell, {met} meet"
    );
}

fn energy(it: &Particle, floor_m: f64) -> f64 {
    let v = it.velocity_mps.as_dvec3();
    0.5 * v.length_squared() + 9.81 * (f64::from(it.at_m.y) - floor_m)
}

#[test]
fn an_elastic_ball_keeps_its_energy_over_a_thousand_bounces() {
    let gpu = gpu();
    let read = fill(&grid(), &ground(-0.53));
    let law = Colliding { restitution: 1.0, friction: 0.0, ..Colliding::new(grid(), 0.05) };
    let height = |i: u32| -0.18 + 0.01 * i as f32;
    let balls: Vec<_> = (0..4).map(|i| at(vec3(0.1 * i as f32, height(i), 0.0), Vec3::ZERO)).collect();
    let mut arena = arena(&gpu, law, &read, Method::TwoPlanes, &balls);
    // From 30 cm a ball comes back every 0.495 s.
    arena.steps(31_200, DT_S).unwrap();
    let bounced = arena.stream.counts().unwrap().stored();
    assert!(bounced > 4 * 1000, "{bounced} bounces");
    for (now, start) in arena.particles().unwrap().iter().zip(&balls) {
        let ratio = energy(now, -0.48) / energy(start, -0.48);
        assert!((ratio - 1.0).abs() < 1e-4, "{start:?}: {ratio}");
    }
}

#[test]
fn a_dropped_ball_comes_to_rest_and_stays() {
    let gpu = gpu();
    for height in [-0.5, -0.53, -0.56, -0.5625] {
        let read = fill(&grid(), &ground(height));
        let radius = 0.1;
        let law = Colliding { restitution: 0.5, ..Colliding::new(grid(), radius) };
        let ball = at(vec3(0.1, 0.0, 0.1), vec3(0.2, 0.0, 0.0));
        let mut arena = arena(&gpu, law, &read, Method::TwoPlanes, &[ball]);
        arena.steps(300, DT_S).unwrap();
        let (mut low, mut high, mut energies) = (f32::INFINITY, f32::NEG_INFINITY, Vec::new());
        for _ in 0..120 {
            arena.steps(30, DT_S).unwrap();
            let it = arena.particles().unwrap()[0];
            (low, high) = (low.min(it.at_m.y), high.max(it.at_m.y));
            energies.push(energy(&it, height));
            assert_eq!(it.velocity_mps.x, 0.0, "friction stops it");
        }
        assert!(high - low <= 0.01 * radius, "{height}: {low} to {high}");
        assert!((f64::from(low) - height - f64::from(radius)).abs() < 1e-3, "{height}: rests at {low}");
        assert!(energies.last().unwrap() - energies[0] < 1e-6, "energy from nowhere");
    }
}

#[test]
fn speed_down_a_slope_does_not_depend_on_the_step() {
    let gpu = gpu();
    let angle = 30f64.to_radians();
    let (sin, cos) = angle.sin_cos();
    let slope =
        rectangle(dvec3(-0.9, 0.9 * sin / cos, -0.9), DVec3::Z * 1.8, dvec3(1.8, -1.8 * sin / cos, 0.0));
    let read = fill(&grid(), &slope);
    let (friction, radius) = (0.3, 0.05);
    let law = Colliding { friction, restitution: 0.2, ..Colliding::new(grid(), radius) };
    let normal = vec3(sin as f32, cos as f32, 0.0);
    let start = vec3(-0.8, (0.8 * sin / cos) as f32, 0.0) + normal * radius;
    let time_s = 0.5;
    let exact = 9.81 * (sin - f64::from(friction) * cos) * time_s;
    for hz in [30u32, 60, 144, 250, 1000] {
        let mut arena = arena(&gpu, law, &read, Method::TwoPlanes, &[at(start, Vec3::ZERO)]);
        arena.steps(u64::from(hz) / 2, 1.0 / f64::from(hz)).unwrap();
        let it = arena.particles().unwrap()[0];
        let speed = f64::from(it.velocity_mps.length());
        assert!((speed / exact - 1.0).abs() < 1e-3, "{hz} Hz: {speed} m/s, {exact} expected");
        let fallen = f64::from((it.at_m - start).length());
        assert!((fallen / (0.5 * exact * time_s) - 1.0).abs() < 1e-3, "{hz} Hz: {fallen} m");
    }
    // Steeper friction than the slope: it stays.
    let law = Colliding { friction: 0.6, ..law };
    let mut arena = arena(&gpu, law, &read, Method::TwoPlanes, &[at(start, Vec3::ZERO)]);
    arena.steps(120, DT_S).unwrap();
    assert!((arena.particles().unwrap()[0].at_m - start).length() < 1e-3);
}

#[test]
fn a_piston_gives_its_velocity_twice() {
    let gpu = gpu();
    for u in [-2.0, -1.0, -0.01, 0.01, 0.5, 1.0, 2.0] {
        for v in [-3.0f32, -2.5] {
            let piston = ground(0.0).into_iter().map(|it| Triangle { velocity_mps: DVec3::Y * u, ..it });
            let read = fill(&grid(), &piston.collect::<Vec<_>>());
            let law = Colliding {
                restitution: 1.0,
                friction: 0.0,
                gravity_mps2: Vec3::ZERO,
                surface_mps: 2.0,
                ..Colliding::new(grid(), 0.05)
            };
            let ball = at(vec3(0.01, 0.055, 0.02), vec3(0.3, v, 0.0));
            let mut arena = arena(&gpu, law, &read, Method::TwoPlanes, &[ball]);
            arena.steps(1, DT_S).unwrap();
            let got = arena.particles().unwrap()[0].velocity_mps;
            let want = vec3(0.3, 2.0 * u as f32 - v, 0.0);
            assert!((got - want).length() <= 1e-5, "u {u}: {got} not {want}");
        }
    }
}

/// Two walls that meet in an edge along z at the origin, `degrees` apart, and particles thrown at it from between.
fn corner(degrees: f64) -> (Vec<Triangle>, Vec3) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let mut walls = rectangle(dvec3(0.0, 0.0, -1.0), DVec3::Z * 2.0, DVec3::X * 2.0).to_vec();
    walls.extend(rectangle(dvec3(0.0, 0.0, -1.0), dvec3(2.0 * cos, 2.0 * sin, 0.0), DVec3::Z * 2.0));
    let half = (0.5 * degrees).to_radians();
    (walls, vec3(half.cos() as f32, half.sin() as f32, 0.0))
}

#[test]
fn corners_of_90_and_60_degrees_let_nobody_through_at_any_step() {
    let gpu = gpu();
    for offset in [Vec3::ZERO, vec3(0.011, 0.037, 0.0)] {
        let grid = Grid::new(vec3(-0.5, -0.5, -0.5) - offset, 0.0625, uvec3(24, 24, 16));
        for degrees in [90.0, 60.0] {
            let (walls, middle) = corner(degrees);
            let read = fill(&grid, &walls);
            for radius_m in [0.01, 0.1] {
                for cells_a_step in [0.27, 1.0, 4.0, 16.0] {
                    let law = Colliding {
                        restitution: 1.0,
                        friction: 0.0,
                        gravity_mps2: Vec3::ZERO,
                        ..Colliding::new(grid, radius_m)
                    };
                    let speed = cells_a_step * 0.0625 * 60.0;
                    let thrown = (0..200).map(|i| {
                        let [a, b, c, d] = units(3, i);
                        let from = middle * (0.6 + 0.1 * a) + vec3(-middle.y, middle.x, 0.0) * 0.12 * b;
                        let to = middle * (0.05 * c.abs()) + vec3(0.0, 0.0, 0.2 * d);
                        at(from, (to - from).normalize() * speed)
                    });
                    let mut arena = arena(&gpu, law, &read, Method::TwoPlanes, &thrown.collect::<Vec<_>>());
                    let inner = [
                        Vec3::Y,
                        vec3(degrees.to_radians().sin() as f32, -degrees.to_radians().cos() as f32, 0.0),
                    ];
                    let steps = (20.0 / cells_a_step).ceil().max(2.0) as u64;
                    arena.steps(steps, DT_S).unwrap();
                    let now = arena.particles().unwrap();
                    let out = now.iter().filter(|it| inner.iter().any(|n| n.dot(it.at_m) < 0.0)).count();
                    assert_eq!(out, 0, "{degrees} degrees, R {radius_m}, {cells_a_step} cells a step");
                    for it in &now {
                        assert!((it.velocity_mps.length() / speed - 1.0).abs() < 1e-5, "elastic");
                    }
                    assert!(arena.stream.counts().unwrap().stored() > 150, "they came to the corner");
                }
            }
        }
    }
}

#[test]
fn a_right_angle_sends_back_where_it_came_from() {
    let gpu = gpu();
    let grid = Grid::new(vec3(-0.5, -0.5, -0.5), 0.0625, uvec3(24, 24, 16));
    let (walls, _) = corner(90.0);
    let read = fill(&grid, &walls);
    let law =
        Colliding { restitution: 1.0, friction: 0.0, gravity_mps2: Vec3::ZERO, ..Colliding::new(grid, 0.03) };
    for step in [0.27, 2.0, 16.0] {
        let thrown: Vec<_> = (0..64)
            .map(|i| {
                let [a, b, c, _] = units(5, i);
                let from = vec3(0.5 + 0.1 * a, 0.5 + 0.1 * b, 0.0);
                let way = (vec3(0.1, 0.1, 0.1 * c) - from).normalize();
                at(from, way * (step * 0.0625 * 60.0))
            })
            .collect();
        let mut arena = arena(&gpu, law, &read, Method::TwoPlanes, &thrown);
        arena.steps((24.0f32 / step).ceil() as u64, DT_S).unwrap();
        for (now, then) in arena.particles().unwrap().iter().zip(&thrown) {
            let want = then.velocity_mps * vec3(-1.0, -1.0, 1.0);
            let apart = (now.velocity_mps - want).length() / want.length();
            assert!(apart <= 1e-6, "{then:?}: {now:?}");
        }
    }
}

fn outside_after(gpu: &TestGpu, read: &Read, grid: Grid, radius_m: f32, steps: u64, method: Method) -> usize {
    let law = Colliding { restitution: 1.0, friction: 0.0, ..Colliding::new(grid, radius_m) };
    let (low, high) = (Vec3::splat(-0.7043), vec3(0.6911, 0.7099, 0.6871));
    let middle = (low + high) * 0.5;
    let fast: Vec<_> =
        crowd(200, 30.0).iter().map(|it| at(middle + it.at_m * 0.5, it.velocity_mps)).collect();
    let mut arena = arena(gpu, law, read, method, &fast);
    arena.steps(steps, DT_S).unwrap();
    let is_out = |it: &&Particle| it.at_m.cmplt(low).any() || it.at_m.cmpgt(high).any();
    arena.particles().unwrap().iter().filter(is_out).count()
}

#[test]
fn a_closed_room_keeps_everybody_in() {
    let gpu = gpu();
    let room = cuboid(dvec3(-0.7043, -0.7043, -0.7043), dvec3(0.6911, 0.7099, 0.6871), true);
    for (radius_m, steps) in [(0.002, 10_000), (0.05, 2_000), (0.2, 1_000)] {
        let read = fill(&grid(), &room);
        assert_eq!(outside_after(&gpu, &read, grid(), radius_m, steps, Method::TwoPlanes), 0, "R {radius_m}");
    }
    // The test sees leaks: one plane a cell lets some through at the edges, and a look at one's own cell nearly all.
    let read = fill(&grid(), &room);
    assert!(outside_after(&gpu, &read, grid(), 0.05, 500, Method::Seed) > 100);
    assert!(outside_after(&gpu, &read, grid(), 0.002, 2_000, Method::OnePlane) > 0);
}

#[test]
fn planes_end_with_their_triangles_cells() {
    let gpu = gpu();
    let plate = rectangle(dvec3(-0.3, 0.0, -0.3), DVec3::Z * 0.6, DVec3::X * 0.6);
    let read = fill(&grid(), &plate);
    let law = Colliding { restitution: 0.0, ..Colliding::new(grid(), 0.05) };
    let drops: Vec<_> =
        [-0.8f32, -0.5, 0.0, 0.25, 0.45, 0.6].map(|x| at(vec3(x, 0.4, 0.0), Vec3::ZERO)).to_vec();
    let mut arena = arena(&gpu, law, &read, Method::TwoPlanes, &drops);
    arena.steps(60, DT_S).unwrap();
    let lies: Vec<bool> = arena.particles().unwrap().iter().map(|it| it.at_m.y > 0.0).collect();
    assert_eq!(lies, [false, false, true, true, false, false]);
}

/// The cells at an edge hold the planes of both faces, and neither goes on beyond it.
#[test]
fn who_passes_an_edge_meets_nothing() {
    let gpu = gpu();
    let half = dvec3(0.27, 0.03, 0.31);
    let read = fill(&grid(), &cuboid(-half, half, false));
    let law = Colliding {
        gravity_mps2: Vec3::ZERO,
        restitution: 1.0,
        friction: 0.0,
        ..Colliding::new(grid(), 0.03)
    };
    // Over the top, in from both sides; down past the sides, near enough for the cells of the edge.
    let (over, beside) = (0.03 + 0.03 + 0.02, 0.27 + 0.03 + 0.02);
    let passers = [
        at(vec3(-0.6, over, 0.0), Vec3::X * 2.0),
        at(vec3(0.6, over, 0.1), -Vec3::X * 2.0),
        at(vec3(beside, 0.4, 0.0), -Vec3::Y * 2.0),
        at(vec3(-beside, -0.4, 0.1), Vec3::Y * 2.0),
        at(vec3(beside, 0.4, 0.36), -Vec3::Y * 2.0),
    ];
    let mut arena = arena(&gpu, law, &read, Method::TwoPlanes, &passers);
    arena.steps(30, DT_S).unwrap();
    for (now, start) in arena.particles().unwrap().iter().zip(&passers) {
        assert_eq!(now.velocity_mps, start.velocity_mps, "{start:?} is at {:?}", now.at_m);
    }
    assert_eq!(arena.stream.counts().unwrap().stored(), 0);
    // Lower by a little they do meet it.
    let into = at(vec3(-0.6, 0.0, 0.0), Vec3::X * 2.0);
    let mut arena = self::arena(&gpu, law, &read, Method::TwoPlanes, &[into]);
    arena.steps(30, DT_S).unwrap();
    assert_eq!(arena.particles().unwrap()[0].velocity_mps, -Vec3::X * 2.0);
}

/// Balls thrown at a solid from all around, by the twin: share of impacts more than a tenth of a cell from any triangle, and the
/// farthest (cells).
fn off_the_surface(grid: &Grid, triangles: &[Triangle], radius_m: f32) -> (f64, f64) {
    let read = fill(grid, triangles);
    let near = cpu_colliding::near(grid, &read, 3, Slabs::OfAll);
    let scene = Scene { occupied: &read.occupied, planes: &read.planes, near: &near };
    let law = Colliding {
        gravity_mps2: Vec3::ZERO,
        restitution: 1.0,
        friction: 0.0,
        ..Colliding::new(*grid, radius_m)
    };
    let twin = Law { law: &law, method: Method::TwoPlanes, scene, tick: 0, step_s: DT_S as f32 };
    let mut impacts = Vec::new();
    for i in 0..500 {
        let mut it = thrown_at_the_middle(i, 0.5 * grid.cell_m);
        (0..(4.0 / grid.cell_m) as u32).for_each(|_| {
            twin.advance(&mut it, DT_S as f32, 0, &mut impacts);
        });
    }
    let from_scene = |it: &Impact| {
        let to = |triangle: &Triangle| {
            let [a, b, c] = triangle.corners_m.map(|corner| corner.as_vec3());
            let weights = nearest_weights(it.at_m, a, b, c);
            it.at_m.distance(a * weights.x + b * weights.y + c * weights.z)
        };
        f64::from(triangles.iter().map(to).fold(f32::INFINITY, f32::min) / grid.cell_m)
    };
    let far: Vec<f64> = impacts.iter().map(from_scene).collect();
    assert!(far.len() > 150, "{} impacts", far.len());
    (
        far.iter().filter(|far| **far > 0.1).count() as f64 / far.len() as f64,
        far.into_iter().fold(0.0, f64::max),
    )
}

fn triangles_of(mesh: &Mesh) -> Vec<Triangle> {
    let corner = |i: &u32| mesh.at_m[*i as usize].as_dvec3();
    mesh.triangles.iter().map(|it| Triangle::new([0, 1, 2].map(|k| corner(&it[k])))).collect()
}

/// Of a surface that bends in every cell a plane is a cell's part at the most, and leaves the cell elsewhere than it does: before cells knew
/// where in them a plane stands for something, up to 13 of 3000 balls came in.
#[test]
fn nobody_comes_into_what_is_round() {
    type Outside = fn(Vec3) -> f32;
    let torus: Outside = |at| (at.with_y(0.0).length() - 0.5).hypot(at.y) - 0.2;
    let ball: Outside = |at| at.length() - 0.45;
    let solids = [
        ("torus", shapes::torus(0.5, 0.2, 48), torus),
        ("coarse torus", shapes::torus(0.5, 0.2, 16), torus),
        ("ball", shapes::sphere(0.45, 24), ball),
    ];
    for (name, mesh, outside_m) in solids {
        for (cells, radius) in [(16, 0.25), (24, 0.1), (32, 0.25), (32, 0.05), (32, 0.8)] {
            let cell_m = 2.0 / cells as f32;
            let grid = Grid::new(vec3(-1.003, -1.007, -0.998), cell_m, UVec3::splat(cells));
            let read = fill(&grid, &triangles_of(&mesh));
            let near = cpu_colliding::near(&grid, &read, 3, Slabs::OfAll);
            let scene = Scene { occupied: &read.occupied, planes: &read.planes, near: &near };
            let law = Colliding {
                gravity_mps2: Vec3::ZERO,
                restitution: 1.0,
                friction: 0.0,
                ..Colliding::new(grid, radius * cell_m)
            };
            let twin = Law { law: &law, method: Method::TwoPlanes, scene, tick: 0, step_s: DT_S as f32 };
            let (mut inside, mut impacts) = (0, Vec::new());
            for i in 0..1500 {
                let mut it = thrown_at_the_middle(i, 0.5 * cell_m);
                let is_in = (0..5 * cells / 2).any(|_| {
                    twin.advance(&mut it, DT_S as f32, 0, &mut impacts);
                    // What is inscribed is a little smaller.
                    outside_m(it.at_m) < -0.02
                });
                inside += u32::from(is_in);
            }
            assert!(impacts.len() > 700, "{name}: {} impacts", impacts.len());
            assert_eq!(inside, 0, "{name}, {cells} cells, balls of {radius} cells");
        }
    }
}

/// Steps that are lower than a cell: one tread is a cell's first plane, a riser the second, and the other tread is parallel to the first.
#[test]
fn nobody_falls_through_stairs() {
    let cell_m = 0.0625f64;
    let grid = Grid::new(vec3(-1.003, -1.007, -0.998), cell_m as f32, UVec3::splat(32));
    for (rise, tread) in [(0.3, 0.5), (0.4, 1.0), (0.4, 0.6), (0.6, 1.1), (0.9, 1.5)] {
        let (rise, tread) = (rise * cell_m, tread * cell_m);
        let steps = (1.4 / tread).min(1.4 / rise) as u32;
        let at = |i: u32, j: u32| dvec3(-0.8, f64::from(i) * rise - 0.7, f64::from(j) * tread - 0.7);
        let stairs: Vec<Triangle> = (0..steps)
            .flat_map(|i| {
                let tread = rectangle(at(i, i), DVec3::Z * tread, DVec3::X * 1.6);
                let riser = rectangle(at(i, i + 1), DVec3::Y * rise, DVec3::X * 1.6);
                [tread, riser].into_iter().flatten()
            })
            .collect();
        let read = fill(&grid, &stairs);
        let near = cpu_colliding::near(&grid, &read, 3, Slabs::OfAll);
        let scene = Scene { occupied: &read.occupied, planes: &read.planes, near: &near };
        let law = Colliding { restitution: 0.0, ..Colliding::new(grid, 0.02 * cell_m as f32) };
        let twin = Law { law: &law, method: Method::TwoPlanes, scene, tick: 0, step_s: DT_S as f32 };
        let through = (0..300).filter(|&i| {
            let [x, z, ..] = units(90, i);
            let z = f64::from(z + 1.0) * 0.5 * tread * f64::from(steps) - 0.7;
            let floor = ((z + 0.7) / tread).floor() * rise - 0.7;
            let mut it = at_rest(vec3(0.7 * x, (floor + 2.0 * cell_m) as f32, z as f32));
            (0..30).for_each(|_| {
                twin.advance(&mut it, DT_S as f32, 0, &mut Vec::new());
            });
            f64::from(it.at_m.y) < floor - 2.0 * cell_m - rise
        });
        assert_eq!(through.count(), 0, "steps of {rise} m by {tread} m");
    }
}

fn at_rest(at_m: Vec3) -> Particle {
    at(at_m, Vec3::ZERO)
}

/// Number `i` of balls from all around, by so much a step.
fn thrown_at_the_middle(i: u32, step_m: f32) -> Particle {
    let ([u, v, x, y], [z, ..]) =
        (random::units(random::bits(5, 0, i, 0)), random::units(random::bits(5, 1, i, 0)));
    let (from, to) = (random::direction_of([u, v]) * 0.9, (vec3(x, y, z) - 0.5) * 1.1);
    at(from, (to - from).normalize() * (step_m / DT_S as f32))
}

#[test]
fn impacts_lie_on_the_scene() {
    let of = triangles_of;
    let half = dvec3(0.313, 0.321, 0.307);
    let (share, far) = off_the_surface(&grid(), &cuboid(-half, half, false), 0.03);
    println!("box: {share:.3} are more than a tenth of a cell off, the farthest {far:.2} cells");
    assert!(share < 0.06 && far < 0.35, "box: {share}, {far} cells");
    // Curved within every cell, the hardest there is.
    let fine = Grid::new(Vec3::NEG_ONE, 0.0625, uvec3(32, 32, 32));
    let (share, far) = off_the_surface(&fine, &of(&shapes::torus(0.5, 0.2, 48)), 0.015);
    println!("torus: {share:.3}, {far:.2} cells");
    assert!(share < 0.08 && far < 0.25, "torus: {share}, {far} cells");
}

/// The cells have the scene as it is at the end of the step; who is born within it has less than a step to go.
#[test]
fn who_is_born_within_a_step_meets_a_wall_where_it_is_then() {
    let gpu = gpu();
    let speed = 0.6;
    let wall = ground(0.01).into_iter().map(|it| Triangle { velocity_mps: DVec3::Y * speed, ..it });
    let cells = cells_of(&gpu, grid(), &fill(&grid(), &wall.collect::<Vec<_>>()));
    let law = Colliding {
        gravity_mps2: Vec3::ZERO,
        restitution: 1.0,
        friction: 0.0,
        surface_mps: speed as f32,
        lead_s: DT_S as f32,
        ..Colliding::new(grid(), 0.05)
    };
    let surroundings = Surroundings::new(&gpu, &cells, 3, Slabs::OfEight).unwrap();
    gpu.once(|rec| surroundings.record(rec)).unwrap();
    // Half a step before its end, where the wall comes after three quarters of it; and where it does not come.
    for (quarters, is_hit) in [(1.0, true), (-1.0, false)] {
        let stream = Stream::new(&gpu, 64).unwrap();
        let emitters = [Emitter {
            at_m: vec3(0.1, 0.01 + 0.05 - quarters * (speed * DT_S) as f32 / 4.0, 0.1),
            velocity_mps: Vec3::ZERO,
            speed_mps: 0.0,
            rate_per_s: 120.0,
            thrown: Thrown::Singly,
        }];
        let info = PoolInfo {
            capacity: 64,
            life_s: 100.0,
            seed: 1,
            start: 0,
            emitters: &emitters,
            law: bytemuck::bytes_of(&law),
        };
        let kernels = Arena::kernels(&gpu, Method::TwoPlanes).unwrap();
        let mut pool = kernels.pool_with(&info, &surroundings.resources(&stream)).unwrap();
        gpu.once(|rec| {
            stream.record_begin(rec);
            pool.record(rec, &Step::nth(0, DT_S));
            stream.record_end(rec);
        })
        .unwrap();
        let born = pool.living().unwrap();
        let fastest = born.iter().map(|it| it.velocity_mps.y).fold(0.0, f32::max);
        let want = if is_hit { 2.0 * speed as f32 } else { 0.0 };
        assert!(!born.is_empty() && (fastest - want).abs() < 1e-5, "{quarters}: {born:?}");
    }
}

#[test]
fn what_finds_no_room_in_the_stream_is_counted() {
    let gpu = gpu();
    let read = fill(&grid(), &ground(-0.5));
    let law = Colliding { restitution: 0.0, ..Colliding::new(grid(), 0.05) };
    let balls: Vec<_> =
        (0..100).map(|i| at(vec3(0.01 * i as f32 - 0.5, -0.44, 0.0), -Vec3::Y * 5.0)).collect();
    let cells = cells_of(&gpu, grid(), &read);
    let kernels = Arena::kernels(&gpu, Method::TwoPlanes).unwrap();
    let mut arena = Arena::new(&gpu, &kernels, &cells, law, 3, &balls, 30).unwrap();
    arena.steps(1, DT_S).unwrap();
    let (impacts, counts) = arena.impacts().unwrap();
    assert_eq!((impacts.len(), counts.count, counts.dropped(), counts.stored()), (30, 30, 70, 30));
    for it in &impacts {
        assert!((it.at_m.y + 0.5).abs() < 1e-5 && it.normal == Vec3::Y && it.triangle > 0);
        assert!((it.impulse_mps - 5.0).abs() < 0.1 && it.velocity_mps.y < -4.9, "{it:?}");
    }
    arena.steps(1, DT_S).unwrap();
    assert_eq!(arena.impacts().unwrap().1.stored(), 30, "who lies there hits nothing");
}

#[test]
fn who_falls_below_the_floor_begins_anew_and_nobody_is_lost() {
    let gpu = gpu();
    let read = fill(&grid(), &[]);
    let law = Colliding {
        respawns: 1,
        floor_m: -0.9,
        emitter_m: vec3(0.1, 0.5, 0.2),
        emitter_radius_m: 0.3,
        seed: 3,
        ..Colliding::new(grid(), 0.05)
    };
    for method in [Method::Seed, Method::TwoPlanes] {
        let mut arena = arena(&gpu, law, &read, method, &crowd(300, 1.0));
        for _ in 0..10 {
            arena.steps(20, DT_S).unwrap();
            let now = arena.particles().unwrap();
            assert_eq!(now.len(), 300);
            assert!(now.iter().all(|it| it.at_m.y >= -0.9 && it.at_m.y < 1.5));
        }
        let born = arena.particles().unwrap().iter().filter(|it| it.born > 0).count();
        assert_eq!(born, 300, "all have fallen at least once");
    }
}

#[test]
fn numbers_out_of_range_are_refused_by_name() {
    let good = Colliding::new(grid(), 0.05);
    assert_eq!(good.check(), Ok(()));
    for (bad, key) in [
        (Colliding { radius_m: 0.0, ..good }, "radius_m"),
        (Colliding { radius_m: f32::NAN, ..good }, "radius_m"),
        (Colliding { restitution: 1.1, ..good }, "restitution"),
        (Colliding { friction: -0.1, ..good }, "friction"),
        (Colliding { sources: 0, ..good }, "sources"),
        (Colliding { gravity_mps2: Vec3::NAN, ..good }, "gravity"),
        (Colliding { grid: Grid { cell_m: 0.0, ..grid() }, ..good }, "grid"),
    ] {
        assert!(bad.check().unwrap_err().to_string().starts_with(key), "{key}");
    }
}

/// Who is put off is moved alike whatever the pool; some come beyond 2^127 m, and end.
#[test]
fn every_pool_moves_those_who_are_put_off() {
    const FAST_MPS: f32 = 1.6e38;
    let gpu = gpu();
    let (read, law) = (fill(&grid(), &mixed()), Colliding::new(grid(), 0.05));
    let cells = cells_of(&gpu, grid(), &read);
    let surroundings = Surroundings::new(&gpu, &cells, 3, Slabs::OfEight).unwrap();
    gpu.once(|rec| surroundings.record(rec)).unwrap();
    let emitters = [Emitter {
        at_m: vec3(0.0, 0.2, 0.0),
        velocity_mps: Vec3::ZERO,
        speed_mps: 3.0,
        rate_per_s: 600.0,
        thrown: Thrown::Singly,
    }];
    let info = PoolInfo {
        capacity: 4096,
        life_s: 2.5,
        seed: 5,
        start: 0,
        emitters: &emitters,
        law: bytemuck::bytes_of(&law),
    };
    let mut start = crowd(600, 2.0);
    start.iter_mut().step_by(9).for_each(|it| it.velocity_mps.x = FAST_MPS);
    let fast = start.iter().filter(|it| it.velocity_mps.x == FAST_MPS).count() as u64;
    let run = |compaction, layout, gathers| {
        let tuning = Tuning { group: 64, items: 2, gathers };
        let options = Options { compaction, layout, tuning };
        let kernels = Particles::new(&gpu, &Colliding::law(Method::TwoPlanes), options).unwrap();
        let stream = Stream::new(&gpu, 1 << 14).unwrap();
        let mut pool = kernels.pool_with(&info, &surroundings.resources(&stream)).unwrap();
        pool.upload(&start).unwrap();
        let ticks = |s: f64| (s * f64::from(TICKS_PER_S)) as u32;
        let mut steps = vec![Step::between(0, ticks(1.0)), Step::between(ticks(1.0), ticks(2.0))];
        steps.extend((0..50).map(|i| Step::between(ticks(2.0) + i * 1000, ticks(2.0) + (i + 1) * 1000)));
        for part in steps.chunks(10) {
            gpu.once(|rec| {
                stream.record_begin(rec);
                for step in part {
                    pool.record(rec, step);
                    rec.barrier(Particles::EXIT, Particles::ENTRY);
                }
                stream.record_end(rec);
            })
            .unwrap();
        }
        let counts = pool.counts().unwrap();
        let mut living = pool.living().unwrap();
        let key = |it: &Particle| (it.born, it.at_m.to_array().map(f32::to_bits));
        living.sort_by_key(key);
        (counts, living)
    };
    let (counts, living) = run(Compaction::Stable, Layout::Planes, false);
    assert_eq!(counts.spoiled, fast);
    assert!(counts.aged > 600 - fast && living.len() > 1000, "{counts:?}, {}", living.len());
    for compaction in
        [Compaction::Stable, Compaction::Group, Compaction::Atomic, Compaction::InPlace, Compaction::Ring]
    {
        for (layout, gathers) in [(Layout::Planes, true), (Layout::Planes, false), (Layout::Packed, true)] {
            let (other, there) = run(compaction, layout, gathers);
            if layout == Layout::Planes {
                assert_eq!(other, counts, "{compaction:?} {gathers}");
                assert!(there == living, "{compaction:?} {gathers}");
            } else {
                // Halves and rounded births: as many to a round of births, all near the scene.
                assert_eq!(other.spoiled, fast, "{compaction:?}");
                assert!(there.len().abs_diff(living.len()) < 30, "{compaction:?} {}", there.len());
                assert!(there.iter().all(|it| it.at_m.is_finite()), "{compaction:?}");
            }
        }
    }
}
