// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scene files: defaults, limits, errors, overrides, heightmaps and the built-in scenes.

use whitecap::scene::{
    Border, Camera, Drop, Model, Override, ProblemKind, Rain, Scene, SceneError, Simulation, Start, Sun,
    View, Walls,
};
use whitecap::water::LAND_M;

#[allow(dead_code)]
#[path = "../../examples/make_terrain.rs"]
mod make_terrain;

mod broken;
mod built_in;
mod heightmaps;
mod mistakes;

/// The smallest scene, to add to: keys of the water, then tables.
const LAKE: &str = r#"
[[water]]
name = "lake"
model = "waves"
cells = [64, 32]
size_m = [16, 8]
depth_m = 2.0
"#;

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse(text, "lake.toml", None, &[])
}

fn error(text: &str) -> String {
    parse(text).expect_err("the scene is wrong").to_string()
}

fn kinds(text: &str) -> Vec<ProblemKind> {
    match parse(text) {
        Err(SceneError::Invalid(problems)) => problems.into_iter().map(|problem| problem.kind).collect(),
        other => panic!("{text}\n{other:?}"),
    }
}

fn set(text: &str, overrides: &[&str]) -> Result<Scene, SceneError> {
    let overrides: Result<Vec<Override>, _> = overrides.iter().map(|text| text.parse()).collect();
    Scene::parse(text, "lake.toml", None, &overrides?)
}

#[test]
fn a_scene_needs_little_and_the_rest_has_defaults() {
    let scene = parse(LAKE).unwrap();
    assert_eq!((scene.title.as_str(), scene.seed), ("", 1));
    assert_eq!((scene.output.size, scene.output.fps, scene.output.frames), ([960, 540], 30.0, 120));
    assert_eq!(scene.output.view, View::Shaded);
    assert_eq!(scene.sun, Sun { azimuth_deg: 135.0, elevation_deg: 32.0, brightness: 1.0 });
    assert!(scene.camera.is_none() && scene.terrain.is_none() && scene.base_dir.is_none());
    let [lake] = scene.water.as_slice() else { panic!("{} waters", scene.water.len()) };
    assert_eq!((lake.cells, lake.size_m, lake.level_m, lake.depth_m), ([64, 32], [16.0, 8.0], 0.0, 2.0));
    assert_eq!((lake.gravity_mps2, lake.damping_per_s, lake.diagonal), (9.81, 0.03, 0.25));
    assert_eq!((lake.walls, lake.dt_s, lake.max_catch_up_steps), (Walls::Folded, None, None));
    assert!(lake.start == Start::Flat && lake.drops.is_empty() && lake.rain.is_none());
}

#[test]
fn a_water_is_called_water_and_the_book_has_its_own_defaults() {
    let scene = parse("[[water]]\nmodel = 'book'\ncells = [4, 4]\nsize_m = [1, 1]\ndepth_m = 1").unwrap();
    let water = &scene.water[0];
    assert_eq!((water.name.as_str(), water.model), ("water", Model::Book));
    assert_eq!((water.diagonal, water.walls), (1.0, Walls::Dropped));
}

#[test]
fn every_key_is_read() {
    let text = r#"
        title = "T"
        seed = 18446744073709551615
        output = { size = [64, 48], fps = 12.5, frames = 7, view = "wireframe" }
        camera = { eye_m = [1, 2, 3], target_m = [4, 5, 6.5], fov_deg = 50, orbit_deg_per_s = -3 }
        sun = { azimuth_deg = -10, elevation_deg = 90 }
        [terrain]
        heightmap = "builtin/fjord.png"
        size_m = [10, 20]
        height_m = [3, -1]
        [[water]]
        name = "b-1_"
        model = "waves"
        cells = [3, 6]
        level_m = -1
        depth_m = 0.5
        gravity_mps2 = 1.6
        damping_per_s = 0
        diagonal = 0.5
        walls = "dropped"
        dt_s = 1e-3
        max_catch_up_steps = 80
        start = { shape = "mode", height_m = -0.1, waves = [3, 0] }
        [[water.drop]]
        at_m = [1, 2]
        radius_m = 3
        volume_m3 = 4
        push_m3ps = 5
        start_s = 6
        every_s = 7
        count = 8
        [[water.drop]]
        at_m = [0, 0]
        radius_m = 1
        push_m3ps = -1
        [water.rain]
        drops_per_s = 9
        radius_m = 10
        volume_m3 = -1
        [[water]]
        model = "waves"
        cells = [5, 5]
        size_m = [7, 7]
        depth_m = 1
        start = { shape = "sombrero", height_m = 1, at_m = [2, 3], radius_m = 4 }
    "#;
    let scene = parse(text).unwrap();
    assert_eq!((scene.seed, scene.output.fps, scene.output.view), (u64::MAX, 12.5, View::Wireframe));
    let camera =
        Camera { eye_m: [1.0, 2.0, 3.0], target_m: [4.0, 5.0, 6.5], fov_deg: 50.0, orbit_deg_per_s: -3.0 };
    assert_eq!(scene.camera(), camera);
    assert_eq!(scene.sun, Sun { azimuth_deg: -10.0, elevation_deg: 90.0, brightness: 1.0 });
    assert_eq!(scene.terrain.as_ref().unwrap().height_m, Some([3.0, -1.0]));
    let water = &scene.water[0];
    assert_eq!((water.size_m, water.level_m, water.gravity_mps2), ([10.0, 20.0], -1.0, 1.6));
    assert_eq!((water.damping_per_s, water.diagonal, water.walls), (0.0, 0.5, Walls::Dropped));
    assert_eq!((water.dt_s, water.max_catch_up_steps), (Some(1e-3), Some(80)));
    assert_eq!(water.start, Start::Mode { height_m: -0.1, waves: [3, 0] });
    let drop = Drop {
        at_m: [1.0, 2.0],
        radius_m: 3.0,
        volume_m3: 4.0,
        push_m3ps: 5.0,
        start_s: 6.0,
        every_s: Some(7.0),
        count: Some(8),
    };
    assert_eq!(water.drops[0], drop);
    assert_eq!([0, 1, 7, 8].map(|n| drop.time_s(n)), [Some(6.0), Some(13.0), Some(55.0), None]);
    assert_eq!([0, 1].map(|n| water.drops[1].time_s(n)), [Some(0.0), None]);
    assert_eq!(
        water.rain,
        Some(Rain { mm_per_h: 0.0, drops_per_s: 9.0, radius_m: 10.0, volume_m3: -1.0, push_m3ps: 0.0 })
    );
    let sombrero = Start::Sombrero { height_m: 1.0, at_m: [2.0, 3.0], radius_m: 4.0 };
    assert_eq!(scene.water[1].start, sombrero);
    assert_eq!(scene.water[1].size_m, [7.0, 7.0]);
}

/// Every limit: a key, values that are allowed, values that are not.
#[test]
fn every_limit_is_kept() {
    let start = "water.0.start={shape='hump', height_m=1, radius_m=1}";
    let mode = "water.0.start={shape='mode', height_m=1, waves=[1, 1]}";
    let drop = "water.0.drop=[{at_m=[0, 0], radius_m=1, volume_m3=1, every_s=1}]";
    let rain = "water.0.rain={drops_per_s=1, radius_m=1, volume_m3=1}";
    let even =
        "water.0={name='lake', model='wet', cells=[64, 32], size_m=[16, 8], depth_m=2, rain={mm_per_h=1}}";
    let source = "water.0.source=[{at_m=[0, 0], radius_m=1, rate_m3ps=1, end_s=5}]";
    let block = "water.0.start={shape='block', height_m=1, from_m=[0, 0], to_m=[1, 1]}";
    let absorb = "water.0.borders=absorb";
    let wall = "water.0.wall=[{from_m=[-1, -1], to_m=[1, 1]}]";
    let sphere = "water.0.body=[{shape='sphere', radius_m=1, path=[[0, 1, 2, 3]]}]";
    let circle =
        "water.0.body=[{shape='box', half_m=[1, 2, 3], circle={centre_m=[0, 0, 0], radius_m=1, period_s=1}}]";
    let swing =
        "water.0.body=[{shape='box', half_m=[1, 2, 3], swing={at_m=[0, 0, 0], by_m=[0, 1, 0], period_s=1}}]";
    let terrain = "terrain={heightmap='builtin/fjord.png', size_m=[1, 1], height_m=[0, 1]}";
    let table: &[(&str, &str, &[&str], &[&str])] = &[
        ("", "title", &["''", "'a b'"], &["1", "[]"]),
        ("", "seed", &["0", "18446744073709551615"], &["-1", "1.0", "18446744073709551616", "'1'"]),
        (
            "",
            "output.size",
            &["[16, 8192]"],
            &["[15, 16]", "[16, 8193]", "[16]", "[16, 16, 16]", "16", "[16.0, 16]"],
        ),
        ("", "output.fps", &["1", "1000", "29.97"], &["0.99", "1000.1", "nan", "inf", "[30, 30]"]),
        ("", "output.frames", &["1", "1000000"], &["0", "1000001", "1.5", "-1"]),
        ("", "output.view", &["shaded", "wireframe"], &["Shaded", "1", "voxels"]),
        ("", "camera.eye_m", &["[1, 2, -3]"], &["[0, 0, 0]", "[1, 2]", "[1, nan, 2]", "[1, 1e39, 2]"]),
        ("", "camera.target_m", &["[1, 2, -3]"], &["[inf, 0, 0]", "['a', 0, 0]"]),
        ("", "camera.fov_deg", &["5", "120"], &["4.9", "120.1", "nan"]),
        ("", "camera.orbit_deg_per_s", &["-360", "360"], &["-360.1", "360.1"]),
        ("", "sun.azimuth_deg", &["-360", "360"], &["-361", "361"]),
        ("", "sun.elevation_deg", &["1", "90"], &["0.9", "90.1"]),
        (terrain, "terrain.size_m", &["[0.1, 1e6]"], &["[0, 1]", "[1, -1]", "[1, inf]", "[1e-50, 1]"]),
        (terrain, "terrain.height_m", &["[5, -5]"], &["[nan, 1]", "5"]),
        (terrain, "terrain.heightmap", &["x.PNG"], &["x.jpg", "builtin/x.png", "png", "1"]),
        ("", "water.0.name", &["a", "A_-9"], &["''", "'a.b'", "12", "'12'", "ä"]),
        ("", "water.0.model", &["waves", "book", "pipes", "wet", "shallow", "auto"], &["wave", "true"]),
        ("", "water.0.order", &["2", "4"], &["3", "'4'", "4.0"]),
        ("", "water.0.tolerance", &["0.001", "1"], &["0", "1.1", "nan"]),
        ("water.0.model='pipes'", "water.0.foam", &["true", "false"], &["1", "'yes'"]),
        ("water.0.model='wet'", "water.0.deepest_m", &["2", "9.5"], &["0", "nan"]),
        ("water.0.model='shallow'", "water.0.fastest_mps", &["0", "9.5"], &["-1", "inf"]),
        ("water.0.model='wet'", "water.0.thin_m", &["0", "0.01"], &["-1", "1.1"]),
        ("", "water.0.cells", &["[2, 1]", "[16384, 8192]"], &["[0, 1]", "[2, 16385]", "[2.0, 1]", "[2, 2]"]),
        ("", "water.0.size_m", &["[0.002, 0.001]", "[1e6, 5e5]"], &["[0, 1]", "[1, -0.0]", "[1, nan]"]),
        ("", "water.0.level_m", &["-9", "9.5"], &["nan", "-inf", "1e39"]),
        ("", "water.0.depth_m", &["0.001", "1e6"], &["0", "-1", "nan", "inf"]),
        ("", "water.0.gravity_mps2", &["0.001", "1e6"], &["0", "-1", "nan", "inf"]),
        ("", "water.0.damping_per_s", &["0", "100"], &["-0.1", "100.1", "nan"]),
        ("", "water.0.diagonal", &["0", "1"], &["-0.1", "1.1"]),
        ("", "water.0.walls", &["folded", "dropped"], &["open"]),
        ("", "water.0.dt_s", &["0.01", "0.03"], &["0", "-1", "inf", "5"]),
        ("", "water.0.max_catch_up_steps", &["1", "10000"], &["0", "10001"]),
        (start, "water.0.start.shape", &["hump", "sombrero"], &["cone", "1"]),
        (start, "water.0.start.height_m", &["-1", "0"], &["inf"]),
        (start, "water.0.start.at_m", &["[-1, 2.5]"], &["[nan, 0]", "[0, 0, 0]"]),
        (start, "water.0.start.radius_m", &["0.1"], &["0", "-1"]),
        (
            mode,
            "water.0.start.waves",
            &["[0, 0]", "[64, 32]"],
            &["[65, 0]", "[0, 33]", "[-1, 0]", "[0.5, 0]"],
        ),
        (drop, "water.0.drop.0.at_m", &["[1, 2]"], &["[1, inf]"]),
        (drop, "water.0.drop.0.radius_m", &["1"], &["0"]),
        (drop, "water.0.drop.0.volume_m3", &["-1"], &["0", "inf"]),
        (drop, "water.0.drop.0.push_m3ps", &["-1", "0"], &["nan"]),
        (drop, "water.0.drop.0.start_s", &["0", "1"], &["-0.1", "inf"]),
        (drop, "water.0.drop.0.every_s", &["0.1"], &["0", "inf"]),
        (drop, "water.0.drop.0.count", &["1", "4294967295"], &["0", "4294967296"]),
        (rain, "water.0.rain.drops_per_s", &["0", "1e6"], &["-1", "1000001"]),
        (rain, "water.0.rain.radius_m", &["1"], &["0"]),
        (rain, "water.0.rain.volume_m3", &["-1"], &["0", "nan"]),
        (rain, "water.0.rain.push_m3ps", &["1", "0"], &["inf"]),
        (even, "water.0.rain.mm_per_h", &["0", "1e6"], &["-1", "1000001", "nan"]),
        (source, "water.0.source.0.at_m", &["[1, 2]"], &["[1, inf]", "1"]),
        (source, "water.0.source.0.radius_m", &["1"], &["0"]),
        (source, "water.0.source.0.rate_m3ps", &["-1", "0.5"], &["0", "nan"]),
        (source, "water.0.source.0.start_s", &["0", "1"], &["-0.1", "nan"]),
        (source, "water.0.source.0.end_s", &["1"], &["0", "inf"]),
        (block, "water.0.start.height_m", &["-1", "1"], &["inf"]),
        (block, "water.0.start.from_m", &["[-1, 0.5]"], &["[nan, 0]", "1"]),
        (block, "water.0.start.to_m", &["[3, 9]"], &["[0, 1]", "1"]),
        ("", "water.0.borders", &["reflect", "absorb", "{}", "{west='absorb'}"], &["open", "1", "[1, 2]"]),
        ("", "water.0.borders.east", &["reflect", "absorb"], &["open", "1"]),
        (absorb, "water.0.absorb_width_m", &["0.5", "4"], &["0.4", "4.1", "0", "nan"]),
        (wall, "water.0.wall.0.from_m", &["[-9, 0]", "[7, 9]"], &["[nan, 0]", "[1, 2, 3]"]),
        (wall, "water.0.wall.0.to_m", &["[3, 0]"], &["[-1, 0]", "[inf, 0]"]),
        (wall, "water.0.wall.0.height_m", &["0.1"], &["0", "-1", "nan"]),
        (wall, "water.0.wall.0.look", &["stone", "house"], &["glass", "1"]),
        (sphere, "water.0.body.0.shape", &["sphere"], &["ball", "1"]),
        (sphere, "water.0.body.0.radius_m", &["0.25", "9"], &["0.24", "0", "nan"]),
        (sphere, "water.0.body.0.yaw_deg", &["-900"], &["inf"]),
        (
            sphere,
            "water.0.body.0.path",
            &["[[0, 1, 2, 3], [1, 1, 2, 3]]"],
            &["[]", "1", "[[0, 1, 2]]", "[[0, 1, 2, nan]]", "[[1, 0, 0, 0], [1, 0, 0, 0]]"],
        ),
        (circle, "water.0.body.0.half_m", &["[0.1, 1, 9]"], &["[0, 1, 1]", "1", "[1, 1]"]),
        (circle, "water.0.body.0.circle.centre_m", &["[1, 2, 3]"], &["[1, 2]", "[1, 2, nan]"]),
        (circle, "water.0.body.0.circle.radius_m", &["3"], &["0"]),
        (circle, "water.0.body.0.circle.period_s", &["3"], &["0", "-1", "inf"]),
        (circle, "water.0.body.0.circle.start_deg", &["-30"], &["nan"]),
        (swing, "water.0.body.0.swing.at_m", &["[1, 2, 3]"], &["[1, 2]"]),
        (swing, "water.0.body.0.swing.by_m", &["[0, 0, 0]"], &["[1, 2, inf]"]),
        (swing, "water.0.body.0.swing.period_s", &["0.1"], &["0"]),
    ];
    for (with, key, good, bad) in table {
        let try_value = |value: &str| {
            let change = format!("{key}={value}");
            let changes = [*with, change.as_str()];
            set(LAKE, if with.is_empty() { &changes[1..] } else { &changes })
        };
        for value in *good {
            try_value(value).unwrap_or_else(|error| panic!("{key}={value}: {error}"));
        }
        for value in *bad {
            let Err(error) = try_value(value) else { panic!("{key}={value} is accepted") };
            assert!(error.to_string().contains(key), "{key}={value}: {error}");
        }
    }
}

/// What a scene leaves to be chosen: the key `model`, and the others of `text`.
fn chosen(text: &str) -> String {
    let scene = parse(&LAKE.replace("model = \"waves\"\n", &format!("{text}\n")));
    scene.unwrap_or_else(|error| panic!("{text}\n{error}")).water[0].variant().name()
}

#[test]
fn the_choice_changes_with_tolerance_and_features() {
    let hump = |tolerance: &str| {
        format!("tolerance = {tolerance}\nstart = {{ shape = 'hump', height_m = 1e-4, radius_m = 0.5 }}")
    };
    // Without a tolerance, the lowest rung that has what is asked for.
    let mut wrong = Vec::new();
    for (text, want) in [
        ("", "waves/w0.25"),
        ("order = 4", "waves/fourth"),
        ("foam = true", "pipes/w0.25"),
        ("rain = { mm_per_h = 10 }", "wet"),
        ("source = [{ at_m = [0, 0], radius_m = 1, rate_m3ps = 1 }]", "wet"),
        ("start = { shape = 'block', height_m = 0.5, from_m = [-8, -4], to_m = [0, 4] }", "waves/w0.25"),
        ("start = { shape = 'block', height_m = 1.5, from_m = [-8, -4], to_m = [0, 4] }", "shallow"),
        ("borders = 'absorb'", "waves/w0.25"),
        // With one, the cheapest that is expected to keep within it.
        (&hump("0.9"), "waves/w0"), // one step a picture, as w1 and w0.25 take, and the least error
        (&hump("0.08"), "waves/fourth"),
        (&format!("foam = true\n{}", hump("0.9")), "pipes/w0"),
        ("tolerance = 0.3\nstart = { shape = 'hump', height_m = 0.04, radius_m = 3 }", "waves/w0"),
        ("tolerance = 0.06\nstart = { shape = 'hump', height_m = 0.1, radius_m = 3 }", "shallow"),
    ] {
        if chosen(text) != want {
            wrong.push(format!("{text}: {} and not {want}", chosen(text)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let terrain = "terrain = { heightmap = 'builtin/fjord.png', size_m = [16, 8], height_m = [-2, 3] }\n";
    let scene = parse(&format!("{terrain}{}", LAKE.replace("model = \"waves\"\n", ""))).unwrap();
    assert_eq!(scene.water[0].variant().name(), "wet");
    assert_eq!(parse(&format!("{terrain}{LAKE}")).unwrap().water[0].model, Model::Waves); // asked for
                                                                                          // Nothing has it all, or nothing is so exact.
    let auto = LAKE.replace("waves", "auto");
    let error = error(&format!("{auto}borders = 'absorb'\nrain = {{ mm_per_h = 1 }}"));
    assert!(error.contains("water.0.model is left to be chosen, and none will do"), "{error}");
    assert!(error.contains("\"shallow\" for borders: no velocity of the surface to damp"), "{error}");
    let error = self::error(&format!("{auto}{}", hump("1e-6")));
    assert!(error.contains("water.0.tolerance is 0.000001; allowed: at least "), "{error}");
    assert!(
        error.contains("which `shallow` is expected") || error.contains("which `waves/fourth` is expected"),
        "{error}"
    );
}

#[test]
fn water_over_ground_starts_where_it_lies() {
    let text = "terrain = { heightmap = 'builtin/pond.asc' }\n[[water]]\nname = 'pond'\nmodel = 'wet'\n\
                cells = [64, 64]\ndepth_m = 1.2\n";
    let columns = |text: &str| match parse(text).unwrap().plan().unwrap().waters.remove(0).simulation {
        Simulation::Depth { columns, model, .. } => (columns, model),
        other => panic!("{other:?}"),
    };
    let (pond, model) = columns(text);
    assert_eq!((model.deepest_m, model.thin_m), (1.2, 1e-4));
    // Flat at the level where the ground is below it, dry above.
    for ((&bed, surface), depth) in pond.bed_m.iter().zip(pond.surfaces_m()).zip(pond.depths_m()) {
        assert!(
            depth == f64::from(-bed.min(0.0)) && surface == f64::from(bed.max(0.0)),
            "{bed} {surface} {depth}"
        );
    }
    assert!(pond.bed_m.iter().any(|&bed| bed > 0.2) && pond.bed_m.iter().any(|&bed| bed < -0.2));
    // A block lies on dry ground as well, up to its height above the level.
    let block = "start = { shape = 'block', height_m = 0.5, from_m = [-99, -99], to_m = [0, 99] }\n";
    let (dammed, model) = columns(&format!("{text}{block}"));
    assert_eq!(model.deepest_m, 1.7);
    for (i, (&bed, depth)) in dammed.bed_m.iter().zip(dammed.depths_m()).enumerate() {
        let surface = if i % 64 < 32 { 0.5 } else { 0.0 };
        assert!((depth - (surface - f64::from(bed)).max(0.0)).abs() < 1e-6, "{i}: {depth} over {bed}");
    }
    // Deeper than the scene says is an error that says how deep.
    let error = parse(&text.replace("1.2", "0.5")).unwrap().plan().unwrap_err().to_string();
    assert!(error.starts_with("water `pond`: deepest_m is 0.5, and the water is "), "{error}");
}

#[test]
fn walls_are_land_borders_have_strips_and_bodies_go_their_ways() {
    let text = format!(
        "{LAKE}borders = {{ west = 'absorb' }}\n\
         [[water.wall]]\nfrom_m = [1, 4]\nto_m = [0.9, -4]\n\
         [[water.wall]]\nfrom_m = [-8, -4]\nto_m = [-7, -3.5]\nheight_m = 1\n\
         [[water.body]]\nshape = 'box'\nhalf_m = [1, 2, 3]\nyaw_deg = 90\n\
         circle = {{ centre_m = [1, 2, 3], radius_m = 4, period_s = 5 }}\n\
         [[water.body]]\nshape = 'sphere'\nradius_m = 1\npath = [[0, 1, 2, 3]]"
    );
    let scene = parse(&text).unwrap();
    assert_eq!((scene.water[0].borders.west, scene.water[0].borders.east), (Border::Absorb, Border::Reflect));
    assert_eq!(scene.water[0].barriers[0].height_m, 0.5);
    let plan = scene.plan().unwrap();
    let water = &plan.waters[0];
    let Simulation::Level { height_m, has_land: true, is_fused: false, .. } = &water.simulation else {
        panic!("{:?}", water.simulation)
    };
    let land: Vec<usize> = (0..64 * 32).filter(|&i| height_m[i] == LAND_M).collect();
    // A column wide at x = 0.875..1.125, and 4 x 2 columns in the corner.
    let want = |i: &usize| i % 64 == 36 || (i % 64 < 4 && i / 64 < 2);
    assert_eq!(land, (0..64 * 32).filter(want).collect::<Vec<_>>());
    let highest = plan.terrain.height_m.iter().fold(f32::MIN, |m, &h| m.max(h));
    let lowest = plan.terrain.height_m.iter().fold(f32::MAX, |m, &h| m.min(h));
    assert_eq!((highest, lowest, plan.terrain.height_m[0]), (1.0, -2.0, 1.0));
    // A quarter of the shorter side: less than 32 columns.
    let borders = water.absorbing.unwrap();
    assert_eq!((borders.west, borders.east, borders.strip), (true, false, 8));
    assert_eq!(water.bodies.len(), 2);
    let passes: Vec<_> = plan.passes.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(passes[..4], ["water.draught", "water.body", "water.waves", "water.absorb"]);
    let seventeen = "[[water.body]]\nshape = 'sphere'\nradius_m = 1\npath = [[0, 1, 2, 3]]\n".repeat(17);
    assert!(error(&format!("{LAKE}{seventeen}")).contains("has 17 bodies; allowed: 16"));
}

#[test]
fn an_override_replaces_adds_and_finds_waters_by_name() {
    let changes = [
        "water.0.cells = [8, 4]",
        "water.lake.depth_m=1",
        "output.frames=10",
        "output.view=wireframe",
        "output.size.0=64",
        "title=a bare word",
    ];
    let error = set(LAKE, &changes).unwrap_err().to_string();
    assert_eq!(
        error,
        "--set output.size.0=64: output.size is a table; allowed: two whole numbers, each 16 to 8192"
    );
    let scene = set(&format!("output = {{ size = [32, 32] }}{LAKE}"), &changes).unwrap();
    assert_eq!((scene.water[0].cells, scene.water[0].depth_m), ([8, 4], 1.0));
    assert_eq!((scene.output.size, scene.output.frames), ([64, 32], 10));
    assert_eq!((scene.output.view, scene.title.as_str()), (View::Wireframe, "a bare word"));
    let scene = set(&LAKE.replace("name = \"lake\"", ""), &["water.water.depth_m=3"]).unwrap();
    assert_eq!(scene.water[0].depth_m, 3.0);
}

#[test]
fn a_wrong_override_is_named_as_the_file() {
    for (change, message) in [
        ("water.0.depth_m=-1", "water.0.depth_m is -1; allowed: 0.0001 to 10000000"),
        ("water.0.dept_m=1", "water.0.dept_m is not a key; did you mean depth_m?"),
        ("water.1.depth_m=1", "water has no 1; its length is 1"),
        ("water.pond.depth_m=1", "water has no pond; its length is 1"),
        ("water.0.depth_m.x=1", "water.0.depth_m is a value, it has no x"),
        ("output.view=grey", "output.view is grey; allowed: \"shaded\" or \"wireframe\" or \"voxels\" or \"planes\" or \"position_map\" or \"paint_map\""),
    ] {
        let error = set(LAKE, &[change]).unwrap_err().to_string();
        assert_eq!(error, format!("--set {change}: {message}"));
    }
    for change in ["", "a", "=1", "a..b=1", "a=", "a=[1", "a='", "a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q=1"] {
        let error = change.parse::<Override>().expect_err(change).to_string();
        assert!(error.starts_with(&format!("--set {change}: ")), "{error}");
    }
    assert_eq!("a.b = [1]".parse::<Override>().unwrap().to_string(), "a.b = [1]");
}

#[test]
fn the_default_camera_sees_the_whole_scene_and_orbits_keep_the_distance() {
    let scene = set(LAKE, &["water.0.level_m=3"]).unwrap();
    assert_eq!(scene.extent_m(), 16.0);
    let camera = scene.camera();
    assert_eq!(camera.target_m, [0.0, 3.0, 0.0]);
    let eye = glam::Vec3::from(camera.eye_m);
    assert!((16.0..32.0).contains(&eye.distance(camera.target_m.into())));
    let scene = set(LAKE, &["camera={eye_m=[0, 5, 10], orbit_deg_per_s=90}"]).unwrap();
    let quarter = glam::Vec3::from(scene.camera().eye_at(1.0));
    assert!(quarter.distance(glam::vec3(10.0, 5.0, 0.0)) < 1e-5, "{quarter}");
    let late = glam::Vec3::from(scene.camera().eye_at(4e6 + 1.0));
    assert!(late.distance(quarter) < 1e-5, "{late}");
    let sun = glam::Vec3::from(Sun { azimuth_deg: 90.0, elevation_deg: 30.0, brightness: 1.0 }.direction());
    assert!(sun.distance(glam::vec3(0.75_f32.sqrt(), 0.5, 0.0)) < 1e-6, "{sun}");
}

#[test]
fn a_box_of_disks_is_read_checked_and_filled_without_overlaps() {
    let read = |text: &str| Scene::parse(text, "box.toml", None, &[]);
    let scene =
        read("[[disks]]\ncount = 700\nsize_m = [2, 1]\n[[disks.heavy]]\nat_m = [1, 0.5, 0]\nradius_m = 0.2")
            .unwrap();
    let start = scene.disks[0].start(scene.seed);
    start.model.check(&start.disks).unwrap();
    assert!((500..700).contains(&start.disks.len()), "{} beside the heavy one", start.disks.len());
    assert_eq!(whitecap::disks::oracle::overlap(&start.model, &start.disks), 0.0);
    assert!(scene.plan().unwrap().buffers.iter().any(|buffer| buffer.name == "disks.place_m"));
    for (text, part) in [
        ("[[disks]]\nsize_m = [2, 1]", "count"),
        ("[[disks]]\ncount = 0\nsize_m = [2, 1]", "count"),
        ("[[disks]]\ncount = 9\nsize_m = [2, 1]\nradius_m = [2, 1]", "the least comes first"),
        ("[[disks]]\ncount = 9\nsize_m = [2, 1]\nto_m = [3, 1, 1]", "within it"),
        ("[[disks]]\ncount = 9\nspace = \"solid\"\nsize_m = [2, 1]", "size_m"),
        ("[[disks]]\ncount = 9\nsize_m = [2, 1]\nmass_kg = 1", "mass_kg"),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains(part), "{text:?}: {error}");
    }
}
