// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scene files: defaults, limits, errors, overrides, heightmaps and the built-in scenes.

use std::path::Path;

use whitecap::scene::{
    builtin, Border, Camera, Drop, Heightmap, HeightmapError, Model, Override, ProblemKind, Rain, Scene,
    SceneError, Simulation, Start, Sun, TerrainSource, View, Walls,
};
use whitecap::water::LAND_M;

#[allow(dead_code)]
#[path = "../examples/make_terrain.rs"]
mod make_terrain;

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

#[test]
fn a_value_out_of_range_is_shown_with_what_is_allowed() {
    assert_eq!(
        error(&LAKE.replace("2.0", "-2.0")),
        "lake.toml:7:11: water.0.depth_m is -2.0; allowed: 0.0001 to 10000000\n\
         7 | depth_m = -2.0\n  |           ^^^^"
    );
    assert_eq!(
        error(&LAKE.replace("32", "0")),
        "lake.toml:5:14: water.0.cells.1 is 0; allowed: 1 to 16384\n\
         5 | cells = [64, 0]\n  |              ^"
    );
}

#[test]
fn an_unknown_key_is_named_with_its_line() {
    assert_eq!(
        error(&format!("{LAKE}dampning_per_s = 1")),
        "lake.toml:8:1: water.0.dampning_per_s is not a key; did you mean damping_per_s?\n\
         8 | dampning_per_s = 1\n  | ^^^^^^^^^^^^^^"
    );
    assert_eq!(
        error(&format!("{LAKE}[sun]\nradius = 1")),
        "lake.toml:9:1: sun.radius is not a key; allowed here: azimuth_deg, elevation_deg, brightness\n\
         9 | radius = 1\n  | ^^^^^^"
    );
}

#[test]
fn a_wrong_type_and_a_missing_key_say_what_is_allowed() {
    assert_eq!(
        error(&LAKE.replace("[64, 32]", "64")),
        "lake.toml:5:9: water.0.cells is 64; allowed: two whole numbers, each 1 to 16384\n\
         5 | cells = 64\n  |         ^^"
    );
    assert_eq!(
        error(&LAKE.replace("depth_m = 2.0", "")),
        "lake.toml:2:1: water.0.depth_m is missing; allowed: a number, 0.0001 to 10000000\n\
         2 | [[water]]\n  | ^^^^^^^^^"
    );
    assert_eq!(
        error(&LAKE.replace("waves", "wave")),
        "lake.toml:4:9: water.0.model is \"wave\"; allowed: \"book\" or \"waves\" or \"pipes\" or \"wet\" or \"shallow\" or \
         \"auto\"\n\
         4 | model = \"wave\"\n  |         ^^^^^^"
    );
    assert_eq!(
        error("[water]\ndepth_m = 1"),
        "lake.toml:1:1: water is a table; allowed: tables, each headed [[water]]\n1 | [water]\n  | ^^^^^^^"
    );
}

#[test]
fn what_is_not_toml_is_pointed_at() {
    let text = error("title = \"Lake");
    assert!(text.starts_with("lake.toml:1:14: not TOML: "), "{text}");
    assert_eq!(kinds("a = = 1"), [ProblemKind::Syntax]);
    assert_eq!(kinds("seed = 1\nseed = 2"), [ProblemKind::Syntax]);
}

#[test]
fn an_empty_scene_has_nothing_to_see() {
    let nothing = "lake.toml: nothing to see: a scene has [terrain], [[water]], [[emitter]] or [[disks]]";
    assert_eq!(error(""), nothing);
    assert_eq!(error("title = 'x'"), nothing);
}

#[test]
fn every_mistake_is_reported_in_the_order_of_the_text() {
    let text =
        LAKE.replace("64", "0").replace("depth_m = 2.0", "depth = 2.0") + "[output]\nfps = nan\nview = 3";
    use ProblemKind::{MissingKey, OutOfRange, UnknownKey, WrongType};
    assert_eq!(kinds(&text), [MissingKey, OutOfRange, UnknownKey, OutOfRange, WrongType]);
    assert_eq!(error(&text).matches("lake.toml:").count(), 5);
}

#[test]
fn values_that_do_not_go_together_are_conflicts() {
    for (text, message) in [
        ("[[water.drop]]\nat_m = [0, 0]\nradius_m = 1", "a drop without both does nothing"),
        ("[[water.drop]]\nat_m = [0, 0]\nradius_m = 1\nvolume_m3 = 1\ncount = 3", "count needs every_s"),
        (
            "[[water.source]]\nat_m = [0, 0]\nradius_m = 1\nrate_m3ps = 1\nstart_s = 5\nend_s = 5",
            "end_s is not after start_s",
        ),
        (
            "[[water.source]]\nat_m = [0, 0]\nradius_m = 1\nrate_m3ps = 0",
            "a source without water does nothing",
        ),
        ("[camera]\neye_m = [1, 2, 3]\ntarget_m = [1, 2, 3]", "the camera would look nowhere"),
        (
            "[[water]]\nname = 'lake'\nmodel = 'waves'\ncells = [1, 1]\nsize_m = [1, 1]\ndepth_m = 1",
            "name is \"lake\", as water.0 is called already",
        ),
        ("[terrain]\nheightmap = 'builtin/pond.asc'\nheight_m = [0, 1]", "has its own heights"),
        ("[[water.wall]]\nfrom_m = [0, 1]\nto_m = [3, 1]", "a wall has two corners across"),
        (
            "[[water.body]]\nshape = 'sphere'\nradius_m = 1\npath = [[1, 0, 0, 0], [0, 0, 0, 0]]",
            "goes back in time",
        ),
        (
            "[[water.body]]\nshape = 'sphere'\nradius_m = 1\npath = [[1, 0, 0, 0]]\nswing = {}",
            "a body has one way",
        ),
        ("absorb_width_m = 2", "needs borders that absorb"),
    ] {
        let text = format!("{LAKE}{text}");
        assert_eq!(kinds(&text), [ProblemKind::Conflict], "{text}");
        assert!(error(&text).contains(message), "{}", error(&text));
    }
    let book = LAKE.replace("waves", "book");
    for (text, message) in [
        ("borders = 'absorb'", "does not go with model \"book\", which has no velocity of the surface to damp; allowed: \"waves\""),
        ("[[water.wall]]\nfrom_m = [0, 0]\nto_m = [1, 1]", "which has the whole grid as its basin; allowed: \"waves\", \"pipes\", \"wet\", \"shallow\""),
    ] {
        let text = format!("{book}{text}");
        assert!(
            kinds(&text) == [ProblemKind::Conflict] && error(&text).contains(message),
            "{}",
            error(&text)
        );
    }
    let book = LAKE.replace("\"waves\"", "\"book\"\nwalls = \"folded\"");
    assert!(error(&book).contains("walls is \"folded\"; allowed: \"dropped\""), "{}", error(&book));
}

/// Every key that only goes with some models, refused by the others with what it does go with.
#[test]
fn what_a_model_cannot_do_is_refused_with_the_models_that_can() {
    let push = "[[water.drop]]\nat_m = [0, 0]\nradius_m = 1\npush_m3ps = 1";
    let rain = "[water.rain]\nmm_per_h = 10";
    let body = "[[water.body]]\nshape = 'sphere'\nradius_m = 1\npath = [[0, 1, 2, 3]]";
    let wall = "[[water.wall]]\nfrom_m = [0, 0]\nto_m = [1, 1]";
    let table: &[(&str, &str, &[&str])] = &[
        (push, "drop", &["waves"]),
        (&push.replace("[[water.drop]]\nat_m = [0, 0]", "[water.rain]\ndrops_per_s = 1"), "rain", &["waves"]),
        (rain, "rain", &["wet", "shallow"]),
        ("borders = 'absorb'", "borders", &["waves"]),
        (wall, "wall", &["waves", "pipes", "wet", "shallow"]),
        (body, "body", &["book", "waves", "pipes"]),
        ("foam = true", "foam", &["pipes", "wet", "shallow"]),
        ("diagonal = 0.5", "diagonal", &["book", "waves", "pipes"]),
        ("walls = 'dropped'", "walls", &["book", "waves", "pipes"]),
        ("order = 4", "order", &["waves"]),
        ("deepest_m = 3", "deepest_m", &["wet", "shallow"]),
        ("thin_m = 1e-3", "thin_m", &["wet", "shallow"]),
        ("fastest_mps = 3", "fastest_mps", &["shallow"]),
    ];
    for (text, key, allowed) in table {
        for model in ["book", "waves", "pipes", "wet", "shallow"] {
            let text = format!("{}{text}", LAKE.replace("waves", model));
            if allowed.contains(&model) {
                parse(&text).unwrap_or_else(|error| panic!("{text}\n{error}"));
                continue;
            }
            let error = error(&text);
            let list = allowed.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
            assert_eq!(kinds(&text), [ProblemKind::Conflict], "{error}");
            assert!(error.contains(&format!("water.0.{key} does not go with model {model:?}")), "{error}");
            assert!(error.contains(&format!("allowed: {list}")), "{error}");
        }
    }
    let fourth = format!("{LAKE}order = 4\n");
    for (text, message) in [
        ("diagonal = 0", "water.0.diagonal does not go with model \"waves\" and order 4, which has one stencil; allowed: 0.25"),
        ("walls = 'dropped'", "which has walls that are mirrors; allowed: \"folded\""),
    ] {
        assert!(error(&format!("{fourth}{text}")).contains(message), "{}", error(&format!("{fourth}{text}")));
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
        ("output.view=grey", "output.view is grey; allowed: \"shaded\" or \"wireframe\" or \"voxels\""),
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

fn png_file(width: u32, height: u32, color: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    file
}

fn load(name: &str, bytes: &[u8]) -> Result<Heightmap, SceneError> {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join(name), bytes).unwrap();
    let heights = if name.ends_with(".png") { "height_m = [-1, 1]" } else { "" };
    let scene = format!("[terrain]\nheightmap = '{name}'\nsize_m = [4, 2]\n{heights}");
    std::fs::write(dir.path().join("scene.toml"), scene).unwrap();
    let scene = Scene::load(&dir.path().join("scene.toml"), &[]).unwrap();
    scene.terrain_heights().map(|heights| heights.expect("the scene has terrain"))
}

fn load_error(name: &str, bytes: &[u8]) -> HeightmapError {
    match load(name, bytes) {
        Err(SceneError::Heightmap { file, reason }) if file == name => reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn grey_images_of_8_and_16_bits_span_the_heights() {
    use png::{BitDepth::*, ColorType::Grayscale};
    let map = load("a.png", &png_file(3, 2, Grayscale, Eight, &[0, 51, 255, 0, 0, 102])).unwrap();
    assert_eq!((map.columns, map.rows, map.size_m), (3, 2, [4.0, 2.0]));
    assert_eq!(map.height_m, [-1.0, -0.6, 1.0, -1.0, -1.0, -0.2]);
    let map =
        load("a.png", &png_file(2, 2, Grayscale, Sixteen, &[0, 0, 255, 255, 0x33, 0x33, 0, 0])).unwrap();
    assert_eq!(map.height_m, [-1.0, 1.0, -0.6, -1.0]);
    assert!(map.warnings.is_empty());
}

#[test]
fn other_images_are_refused_by_what_they_are() {
    use png::{BitDepth::*, ColorType::*};
    for (color, depth, bytes, message) in [
        (Rgb, Eight, 12, "Rgb of 8 bits; allowed: grey of 8 or 16 bits, without alpha and interlacing"),
        (GrayscaleAlpha, Sixteen, 16, "GrayscaleAlpha of 16 bits; allowed: grey of 8 or 16 bits"),
        (Grayscale, Four, 2, "Grayscale of 4 bits; allowed: grey of 8 or 16 bits"),
    ] {
        let error = load_error("a.png", &png_file(2, 2, color, depth, &vec![0; bytes])).to_string();
        assert!(error.starts_with(message), "{error}");
    }
    let error = load_error("a.png", &png_file(1, 2, Grayscale, Eight, &[0, 0]));
    assert_eq!(error.to_string(), "1 x 2 samples; allowed: 2 x 2 to 16384 x 16384");
}

/// A PNG whose header, with a right checksum, claims another size than its data has.
fn png_claiming(width: u32, height: u32) -> Vec<u8> {
    let mut file = png_file(2, 2, png::ColorType::Grayscale, png::BitDepth::Eight, &[0; 4]);
    file[16..20].copy_from_slice(&width.to_be_bytes());
    file[20..24].copy_from_slice(&height.to_be_bytes());
    let crc = file[12..29].iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    });
    file[29..33].copy_from_slice(&(!crc).to_be_bytes());
    file
}

#[test]
fn broken_images_are_errors() {
    let good = png_file(2, 2, png::ColorType::Grayscale, png::BitDepth::Eight, &[0; 4]);
    assert_eq!(png_claiming(2, 2), good);
    for length in 0..good.len() - 16 {
        assert!(matches!(load_error("a.png", &good[..length]), HeightmapError::Png(_)), "{length} bytes");
    }
    assert!(matches!(load_error("a.png", &png_claiming(u32::MAX, 2)), HeightmapError::Png(_)));
    assert!(matches!(load_error("a.png", &png_claiming(16385, 2)), HeightmapError::Size { .. }));
    assert!(matches!(load_error("a.png", &png_claiming(16384, 16384)), HeightmapError::Png(_)));
    assert!(matches!(load_error("a.png", b"no image"), HeightmapError::Png(_)));
}

#[test]
fn an_esri_grid_is_read_from_the_north_and_brings_its_size() {
    let text =
        "\u{feff}NCOLS 3\r\nnrows 2\r\nxllcorner 5\r\nyllcorner 6\r\ncellsize 2.5\r\n1 2 3\r\n-4 5e-1 6\r\n";
    let map = load("a.asc", text.as_bytes()).unwrap();
    assert_eq!((map.columns, map.rows, map.size_m), (3, 2, [4.0, 2.0]));
    assert_eq!(map.height_m, [1.0, 2.0, 3.0, -4.0, 0.5, 6.0]);

    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("a.asc"), text).unwrap();
    let read = |text: &str| Scene::parse(text, "s.toml", Some(dir.path()), &[]);
    let scene = read("[terrain]\nheightmap = 'a.asc'").unwrap();
    assert_eq!(scene.terrain.as_ref().unwrap().size_m, [7.5, 5.0]);
    assert_eq!(scene.terrain_heights().unwrap().unwrap().size_m, [7.5, 5.0]);
    let error = read("[terrain]\nheightmap = 'b.asc'").unwrap_err().to_string();
    assert!(error.starts_with("s.toml:2:13: terrain.heightmap cannot be used: "), "{error}");
}

#[test]
fn samples_without_data_are_filled_from_the_nearest_and_counted() {
    let header = "ncols 4\nnrows 2\ncellsize 1\n";
    let map = load("a.asc", format!("{header}-9999 1 -9999 -9999\n-9999 -9999 -9999 2").as_bytes()).unwrap();
    assert_eq!(map.height_m, [1.0, 1.0, 1.0, 2.0, 1.0, 1.0, 2.0, 2.0]);
    assert_eq!(map.warnings, ["6 of 8 heights are NODATA; each was given that of a nearest neighbour"]);
    let map = load("a.asc", format!("{header}nodata_value nan\nnan 1 2 3 4 5 6 7").as_bytes()).unwrap();
    assert_eq!((map.height_m[0], map.warnings.len()), (1.0, 1));
    let error = load_error("a.asc", format!("{header}nodata_value 0\n0 0 0 0 0 0 0 0").as_bytes());
    assert_eq!(error.to_string(), "all 8 heights are NODATA");
}

#[test]
fn broken_grids_are_errors_with_their_line() {
    for (text, message) in [
        ("", "line 1: the header ends without ncols"),
        ("ncols 2\nnrows 2\n1 2 3 4", "line 3: the header ends without cellsize"),
        ("ncols 2\nnrows x\ncellsize 1\n", "line 2: nrows has no number"),
        ("ncols 2\nnrows\n", "line 2: nrows has no number"),
        ("ncols 2.5\nnrows 2\ncellsize 1\n", "0 x 2 samples; allowed: 2 x 2 to 16384 x 16384"),
        ("ncols 99999\nnrows 1e300\ncellsize 1\n", "99999 x 18446744073709551615 samples; allowed: 2"),
        ("ncols 2\nnrows 2\ncellsize 0\n", "line 4: cellsize is 0; allowed: finite, more than 0"),
        ("ncols 2\nnrows 2\ncellsize 1\n1 2\n3", "3 heights of 2 x 2; the file is cut short"),
        ("ncols 2\nnrows 2\ncellsize 1\n1 2\n3 4 5", "line 5: more than 2 x 2 heights"),
        ("ncols 2\nnrows 2\ncellsize 1\n1 two\n3 4", "line 4: \"two\" is not a number"),
        ("ncols 2\nnrows 2\ncellsize 1\n1 inf\n3 4", "line 4: \"inf\" is not a finite height"),
        ("ncols 2\nnrows 2\ncellsize 1\n1 1e39\n3 4", "line 4: \"1e39\" is not a finite height"),
        ("ncols 16384\nnrows 16384\ncellsize 1\n1", "1 heights of 16384 x 16384; the file is cut short"),
    ] {
        let error = load_error("a.asc", text.as_bytes()).to_string();
        assert!(error.starts_with(message), "{text}\n{error}");
    }
    let error = load_error("a.asc", b"ncols 2\nnrows 2\ncellsize 1\n1 \xff\n").to_string();
    assert_eq!(error, "line 4: not a text");
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = Scene::load(Path::new("nowhere/lake.toml"), &[]).unwrap_err().to_string();
    assert!(error.starts_with("nowhere/lake.toml: "), "{error}");
    let scene = parse("[terrain]\nheightmap = 'none.png'\nsize_m = [1, 1]\nheight_m = [0, 1]").unwrap();
    let error = scene.terrain_heights().unwrap_err().to_string();
    assert!(error.starts_with("none.png: "), "{error}");
    let scene = Scene { base_dir: Some(std::env::temp_dir()), ..scene };
    let folder = Scene {
        terrain: scene.terrain.map(|t| TerrainSource { heightmap: ".".into(), ..t }),
        ..parse(LAKE).unwrap()
    };
    assert_eq!(folder.terrain_heights().unwrap_err().to_string(), ".: not a file");
}

#[test]
fn heights_between_samples_are_linear_and_constant_outside() {
    let map = Heightmap {
        columns: 2,
        rows: 2,
        height_m: vec![0.0, 1.0, 2.0, 3.0],
        size_m: [4.0, 8.0],
        warnings: Vec::new(),
    };
    for (x, z, height) in [
        (-1.0, -2.0, 0.0),
        (1.0, -2.0, 1.0),
        (-1.0, 2.0, 2.0),
        (0.0, 0.0, 1.5),
        (9.0, 9.0, 3.0),
        (-9.0, 0.0, 1.0),
    ] {
        assert_eq!(map.height_at(x, z), height, "at {x}, {z}");
    }
}

#[test]
fn the_built_in_scenes_load_with_their_terrains() {
    assert_eq!(
        builtin::list().map(|(name, _)| name).collect::<Vec<_>>(),
        [
            "fjord",
            "pond",
            "sombrero",
            "ripple_tank",
            "harbour",
            "dam_break",
            "puddles",
            "black_hole",
            "binary_hole",
            "campfire",
            "rain",
            "fireworks",
            "gas",
            "brownian",
            "avalanche",
            "paint_shower",
            "marbles",
            "sandblast"
        ]
    );
    for (name, title) in builtin::list() {
        let scene = builtin::load(name, &[]).unwrap_or_else(|error| panic!("{error}"));
        assert!(!title.is_empty() && !scene.title.is_empty());
        let simulates = !scene.water.is_empty() || !scene.emitters.is_empty() || !scene.disks.is_empty();
        assert!(simulates, "{name}");
        let heights = scene.terrain_heights().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(heights.is_some(), scene.terrain.is_some());
        let Some(map) = heights else { continue };
        assert!(map.warnings.is_empty());
        let (columns, rows) = (map.columns as usize, map.rows as usize);
        let border = (0..map.height_m.len()).filter(|i| {
            let (column, row) = (i % columns, i / columns);
            column == 0 || row == 0 || column == columns - 1 || row == rows - 1
        });
        let lowest = border.map(|i| map.height_m[i]).fold(f32::MAX, f32::min);
        let Some(water) = scene.water.first() else { continue };
        // Room for waves: half a metre; of a puddle, which is not that deep, 0.4 of its depth.
        let room_m = if water.depth_m < 0.5 { 0.4 * water.depth_m as f32 } else { 0.5 };
        assert!(lowest > water.level_m + room_m, "{name} runs out at the border, {lowest} m");
    }
    let smaller = builtin::load("fjord", &["water.lake.cells=[64, 64]".parse().unwrap()]).unwrap();
    assert_eq!(smaller.water[0].cells, [64, 64]);
    let error = builtin::load("fiord", &[]).unwrap_err().to_string();
    assert_eq!(
        error,
        "no built-in scene is called \"fiord\"; there are: fjord, pond, sombrero, ripple_tank, harbour, dam_break, puddles, \
         black_hole, binary_hole, campfire, rain, fireworks, gas, brownian, avalanche, paint_shower, marbles, \
         sandblast"
    );
}

#[test]
fn drops_of_the_built_in_scenes_fall_into_water() {
    for (name, _) in builtin::list() {
        let scene = builtin::load(name, &[]).unwrap();
        let Some(map) = scene.terrain_heights().unwrap() else { continue };
        for water in &scene.water {
            let start = match &water.start {
                Start::Hump { at_m, .. } | Start::Sombrero { at_m, .. } => Some(*at_m),
                Start::Flat | Start::Mode { .. } | Start::Block { .. } => None,
            };
            for [x, z] in water.drops.iter().map(|drop| drop.at_m).chain(start) {
                assert!(map.height_at(x, z) < water.level_m, "{name}: dry at {x}, {z}");
            }
        }
    }
}

#[test]
fn the_sombrero_has_the_books_wave_speed() {
    let water = &builtin::load("sombrero", &[]).unwrap().water[0];
    assert!(((water.gravity_mps2 * water.depth_m).sqrt() - 4.24).abs() < 1e-5);
}

/// The PNGs' samples are compared, not their bytes, which depend on the version of the encoder.
#[test]
fn the_terrains_are_what_make_terrain_makes() {
    let samples = |name: &str| -> Vec<u16> {
        let mut reader =
            png::Decoder::new(std::io::Cursor::new(builtin::asset(name).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        bytes.chunks_exact(2).map(|two| u16::from_be_bytes([two[0], two[1]])).collect()
    };
    assert!(samples("builtin/fjord.png") == make_terrain::fjord());
    assert!(samples("builtin/town.png") == make_terrain::town());
    assert!(samples("builtin/yard.png") == make_terrain::yard());
    assert!(builtin::asset("builtin/pond.asc").unwrap() == make_terrain::pond().as_bytes());
}

/// A deterministic stream of numbers (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 33) as usize % n
    }

    /// Replaces, inserts, deletes or repeats a few bytes.
    fn mutate(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        for _ in 0..=self.below(4) {
            let at = self.below(bytes.len());
            let byte = if self.below(2) == 0 {
                self.below(256) as u8
            } else {
                b"0123456789.-[]{}=\"'e\n#,"[self.below(23)]
            };
            match self.below(4) {
                0 => bytes.insert(at, byte),
                1 if bytes.len() > 1 => drop(bytes.remove(at)),
                2 => {
                    let end = (at + self.below(20)).min(bytes.len());
                    let copy = bytes[at..end].to_vec();
                    let to = self.below(bytes.len());
                    bytes.splice(to..to, copy);
                }
                _ => bytes[at] = byte,
            }
        }
        bytes
    }
}

#[test]
fn no_scene_however_broken_panics() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for (name, _) in builtin::list() {
        let text = builtin::toml(name).unwrap();
        for _ in 0..1500 {
            let broken = random.mutate(text.as_bytes());
            let broken = String::from_utf8_lossy(&broken);
            if let Err(error) = Scene::parse(&broken, "broken.toml", None, &[]) {
                assert!(!error.to_string().is_empty());
            }
            let change = random.mutate(b"water.0.start={shape='hump', height_m=1}");
            if let Ok(change) = String::from_utf8_lossy(&change).parse() {
                let _ = Scene::parse(text, "lake.toml", None, &[change]).map_err(|error| error.to_string());
            }
        }
    }
}

#[test]
fn no_heightmap_however_broken_panics() {
    let mut random = Random(0xd1b5_4a32_d192_ed03);
    let grey: Vec<u8> = (0..128).collect();
    let png = png_file(8, 8, png::ColorType::Grayscale, png::BitDepth::Sixteen, &grey);
    let asc = b"ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 0.5\nNODATA_value -9\n1 2 3 4\n5 -9 7 8\n9 1 2 3\n";
    for (name, bytes) in [("a.png", png.as_slice()), ("a.asc", asc)] {
        let source =
            TerrainSource { heightmap: name.to_owned(), size_m: [4.0, 2.0], height_m: Some([-1.0, 1.0]) };
        for _ in 0..5000 {
            if let Ok(map) = Heightmap::decode(&source, &random.mutate(bytes)) {
                assert_eq!(map.height_m.len(), map.columns as usize * map.rows as usize);
                assert!(map.height_m.iter().all(|height| height.is_finite()));
            }
        }
    }
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
