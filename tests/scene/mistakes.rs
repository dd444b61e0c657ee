// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is wrong in a scene is named, with where and with what is allowed.

use super::{error, kinds, parse, LAKE};
use whitecap::scene::ProblemKind;

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
    let nothing =
        "lake.toml: nothing to see: a scene has [terrain], [[water]], [[emitter]], [[disks]] or [[mesh]]";
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
    let splash = "[[water.splash]]\nfrom = 'rain'\ndrop_radius_m = 0.02\nradius_m = 1\nbrings = 'momentum'\n\
                  [[emitter]]\neffect = 'rain'\nimpacts = 100";
    let body = "[[water.body]]\nshape = 'sphere'\nradius_m = 1\npath = [[0, 1, 2, 3]]";
    let wall = "[[water.wall]]\nfrom_m = [0, 0]\nto_m = [1, 1]";
    let table: &[(&str, &str, &[&str])] = &[
        (push, "drop", &["waves"]),
        (&push.replace("[[water.drop]]\nat_m = [0, 0]", "[water.rain]\ndrops_per_s = 1"), "rain", &["waves"]),
        (rain, "rain", &["wet", "shallow"]),
        (splash, "splash", &["waves"]),
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
