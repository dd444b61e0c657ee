// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scenes that come with the library: examples to run, and to start a scene of one's own from.

use super::{Override, Scene, SceneError};

/// A built-in scene: name, one line for people, TOML.
struct Builtin(&'static str, &'static str, &'static str);

const SCENES: [Builtin; 18] = [
    Builtin("fjord", "Waves among rocky islands in a mountain lake", include_str!("../../scenes/fjord.toml")),
    Builtin("pond", "Drops falling into a stony pond", include_str!("../../scenes/pond.toml")),
    Builtin(
        "sombrero",
        "The book's water: sin(r)/r in a square basin",
        include_str!("../../scenes/sombrero.toml"),
    ),
    Builtin(
        "ripple_tank",
        "Waves through two slits, from above",
        include_str!("../../scenes/ripple_tank.toml"),
    ),
    Builtin("harbour", "Swell and a launch between breakwaters", include_str!("../../scenes/harbour.toml")),
    Builtin("dam_break", "A flood from a burst dam in a town", include_str!("../../scenes/dam_break.toml")),
    Builtin(
        "puddles",
        "Rain that collects in the hollows of a yard",
        include_str!("../../scenes/puddles.toml"),
    ),
    Builtin(
        "black_hole",
        "Particles that a black hole swallows: the book's particle storm",
        include_str!("../../scenes/black_hole.toml"),
    ),
    Builtin(
        "binary_hole",
        "Two black holes that circle each other, and what they stir",
        include_str!("../../scenes/binary_hole.toml"),
    ),
    Builtin("campfire", "Flames, sparks and smoke at night", include_str!("../../scenes/campfire.toml")),
    Builtin("rain", "Rain that splashes on a lake and its shore", include_str!("../../scenes/rain.toml")),
    Builtin("fireworks", "Shells that burst over a bay", include_str!("../../scenes/fireworks.toml")),
    Builtin(
        "gas",
        "Two thousand disks that collide: the tutorial's box",
        include_str!("../../scenes/gas.toml"),
    ),
    Builtin(
        "brownian",
        "A heavy disk among ten thousand light ones",
        include_str!("../../scenes/brownian.toml"),
    ),
    Builtin(
        "avalanche",
        "A hundred thousand spheres that tumble down",
        include_str!("../../scenes/avalanche.toml"),
    ),
    Builtin(
        "paint_shower",
        "Paint rains on a block and a lizard that walks",
        include_str!("../../scenes/paint_shower.toml"),
    ),
    Builtin("marbles", "Marbles on an obstacle course", include_str!("../../scenes/marbles.toml")),
    Builtin(
        "sandblast",
        "Sand through a stencil, faster than cells are wide",
        include_str!("../../scenes/sandblast.toml"),
    ),
];

const ASSETS: [(&str, &[u8]); 4] = [
    ("builtin/fjord.png", include_bytes!("../../scenes/fjord.png")),
    ("builtin/pond.asc", include_bytes!("../../scenes/pond.asc")),
    ("builtin/town.png", include_bytes!("../../scenes/town.png")),
    ("builtin/yard.png", include_bytes!("../../scenes/yard.png")),
];

/// The name and a one-line title of every built-in scene; the first is the default.
pub fn list() -> impl ExactSizeIterator<Item = (&'static str, &'static str)> {
    SCENES.iter().map(|Builtin(name, title, _)| (*name, *title))
}

/// The scene's TOML, if there is a scene of this name.
pub fn toml(name: &str) -> Option<&'static str> {
    SCENES.iter().find(|scene| scene.0 == name).map(|scene| scene.2)
}

/// Reads the built-in scene with `overrides` in it.
pub fn load(name: &str, overrides: &[Override]) -> Result<Scene, SceneError> {
    let text = toml(name).ok_or_else(|| SceneError::NoBuiltin { name: name.to_owned() })?;
    Scene::parse(text, &format!("builtin/{name}.toml"), None, overrides)
}

/// The bytes of a built-in asset, by the path that scenes name it with: `builtin/fjord.png`.
pub fn asset(path: &str) -> Option<&'static [u8]> {
    ASSETS.iter().find(|asset| asset.0 == path).map(|asset| asset.1)
}

/// The names of all scenes, for an error.
pub(super) fn names() -> String {
    list().map(|(name, _)| name).collect::<Vec<_>>().join(", ")
}
