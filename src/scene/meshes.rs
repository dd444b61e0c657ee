// SPDX-License-Identifier: MIT OR Apache-2.0
//! `[[mesh]]`: what particles collide with and paint.

use super::{
    motion::{Key, Motion},
    parse::{
        Rule::{self, Within},
        Table,
    },
    schema::{LENGTH, PLACE},
    PlannedBuffer, Scene, SceneError,
};
use crate::mesh::{
    shapes,
    walls::{self, Side},
    Mesh, VERTEX_WORDS,
};
use glam::{vec3, Vec2, Vec3};
use serde::Serialize;
use std::path::Path;

/// A mesh and how it moves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshScene {
    /// Name, unique among meshes; default what it is made of.
    pub name: String,
    /// Where its triangles come from.
    #[serde(flatten)]
    pub source: Source,
    /// Place and turn, one key, or several that move it.
    pub keys: Vec<Key>,
    /// Whether the keys begin again after the last.
    #[serde(rename = "loop")]
    pub loops: bool,
    /// Factor of its size, default 1.
    pub scale: f32,
    /// Linear albedo, each 0..=1, default a light grey.
    pub color: [f32; 3],
    /// How much of the sun is mirrored, 0..=1, default 0.05.
    pub mirrors: f32,
    /// Edge of the tiles of a checkered floor (m); 0, the default, is plain.
    pub tile_m: f32,
    /// Texels along its paint map; 0 takes no paint.
    pub map: u32,
    /// Whether particles meet it, default yes.
    pub solid: bool,
}

/// Where triangles come from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// A `.glb`, `.gltf` or `.obj` file relative to the scene; it moves by its own first animation too.
    File(String),
    /// Made by rule.
    Shape(Shape),
}

/// A mesh made by rule. Lengths in metres, before its scale.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Shape {
    /// A block.
    Box {
        /// Half edges.
        half_m: [f32; 3],
    },
    /// A ball.
    Sphere {
        /// Its radius.
        radius_m: f32,
    },
    /// A ring about the y axis.
    Torus {
        /// From its middle to that of the tube.
        ring_m: f32,
        /// Radius of the tube.
        radius_m: f32,
    },
    /// A rod with round ends along the y axis.
    Capsule {
        /// Between the middles of its ends.
        length_m: f32,
        /// Its radius.
        radius_m: f32,
    },
    /// A lizard that walks on the spot.
    Lizard {
        /// From nose to tail.
        length_m: f32,
    },
    /// Walls seen from inside.
    Room {
        /// Half edges.
        half_m: [f32; 3],
        /// Sides that are left out.
        open: Vec<String>,
    },
    /// An upright plate with holes.
    Stencil {
        /// Width, height and thickness.
        size_m: [f32; 3],
        /// Rows from the top; blanks and dots are holes.
        pattern: Vec<String>,
    },
    /// What turns about the y axis.
    Lathe {
        /// Radius and height of each point of the line, from the top where it is seen from outside.
        profile_m: Vec<[f32; 2]>,
    },
}

/// A mesh as it will run.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshPlan {
    /// As in the scene.
    pub name: String,
    /// Triangles and rig.
    pub mesh: Mesh,
    /// Keys of the scene.
    pub motion: Motion,
    /// Linear albedo.
    pub color: Vec3,
    /// How much of the sun is mirrored.
    pub mirrors: f32,
    /// Edge of the tiles of a checkered floor (m); 0: plain.
    pub tile_m: f32,
    /// Texels along its paint map; 0: none.
    pub map: u32,
    /// Whether particles meet it.
    pub solid: bool,
}

const NAMES: &str = "1 to 64 of A-Z a-z 0-9 _ -, not digits only";
const SHAPES: [&str; 8] = ["box", "sphere", "torus", "capsule", "lizard", "room", "stencil", "lathe"];
/// Most meshes of a scene: each is a draw, and a bind.
const MOST_MESHES: usize = 256;
/// Most holes and bars along a plate, and points of a line.
const MOST_PARTS: usize = 128;
const SHARE: Rule = Within(0.0, 1.0);

fn is_name(name: &str) -> bool {
    (1..=64).contains(&name.len())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-')
        && !name.chars().all(|c| c.is_ascii_digit())
}

pub(super) fn meshes(root: &mut Table<'_>) -> Vec<MeshScene> {
    let tables = root.tables("mesh");
    if tables.len() > MOST_MESHES {
        let message = format!("has {} of them; allowed: {MOST_MESHES}", tables.len());
        root.blame("mesh", super::ProblemKind::OutOfRange, message);
    }
    let mut all: Vec<MeshScene> = Vec::new();
    for table in tables {
        let next = mesh(table, &all);
        all.push(next);
    }
    all
}

fn mesh(mut table: Table<'_>, others: &[MeshScene]) -> MeshScene {
    let ends = |file: &str| [".glb", ".gltf", ".obj"].iter().any(|end| file.to_lowercase().ends_with(end));
    let name = table.text("name", NAMES, is_name);
    let file = table.file("file", "a .glb, .gltf or .obj file", ends);
    let shapes = SHAPES.join(", ");
    let kind = table.text("shape", &shapes, |kind| SHAPES.contains(&kind));
    let source = match (table.has("file"), table.has("shape")) {
        (true, true) => {
            table.conflict("shape", "is given beside file; a mesh has one of them");
            Source::File(String::new())
        }
        (false, false) => {
            table.missing("shape", format_args!("{shapes}; or file: a .glb, .gltf or .obj file"));
            Source::File(String::new())
        }
        (true, false) => Source::File(file.unwrap_or_default().to_owned()),
        (false, true) => Source::Shape(shape(&mut table, kind.unwrap_or("box"))),
    };
    let name = name.or(kind).unwrap_or("mesh").to_owned();
    let name = match table.has("name") || !others.iter().any(|other| other.name == name) {
        true => name,
        // Nameless ones are told apart by their number.
        false => format!("{name}-{}", others.len()),
    };
    if let Some(i) = others.iter().position(|other| other.name == name) {
        table.conflict("name", format!("is {name:?}, as mesh.{i} is called already; names are unique"));
    }
    let at_m = table.maybe("at_m", PLACE).unwrap_or([0.0; 3]);
    let turn_deg = table.maybe("turn_deg", TURN).unwrap_or([0.0; 3]);
    let keys = keys(&mut table, at_m, turn_deg);
    let loops = table.flag("loop");
    if loops.is_some() && keys.len() < 2 {
        table.conflict("loop", "needs keys, two or more");
    }
    let paints = table.flag("paints").unwrap_or(false);
    let map = table.maybe("map", Within(16.0, 8192.0));
    if map.is_some() && !paints {
        table.conflict("map", "is for a mesh with paints = true");
    }
    let mesh = MeshScene {
        name,
        source,
        keys,
        loops: loops.unwrap_or(false),
        scale: table.maybe("scale", LENGTH).unwrap_or(1.0),
        color: table.maybe("color", SHARE).unwrap_or([0.7, 0.7, 0.68]),
        mirrors: table.maybe("mirrors", SHARE).unwrap_or(0.05),
        tile_m: table.maybe("tile_m", LENGTH).unwrap_or(0.0),
        map: if paints { map.unwrap_or(256) } else { 0 },
        solid: table.flag("solid").unwrap_or(true),
    };
    table.finish();
    mesh
}

/// Angles of keys (degrees): a thousand turns.
const TURN: Rule = Within(-360_000.0, 360_000.0);

/// One key of the mesh's own place, or those of the scene, which default to it.
fn keys(table: &mut Table<'_>, at_m: [f32; 3], turn_deg: [f32; 3]) -> Vec<Key> {
    let mut keys: Vec<Key> = Vec::new();
    for mut row in table.tables("keys") {
        let last = keys.last().copied().unwrap_or(Key { t_s: 0.0, at_m, turn_deg });
        let key = Key {
            t_s: row.number("t_s", Within(0.0, 1e6)),
            at_m: row.maybe("at_m", PLACE).unwrap_or(last.at_m),
            turn_deg: row.maybe("turn_deg", TURN).unwrap_or(last.turn_deg),
        };
        if keys.last().is_some_and(|last| key.t_s <= last.t_s) {
            row.conflict(
                "t_s",
                format!("is {}, and that of the key before {}; times rise", key.t_s, last.t_s),
            );
        }
        row.finish();
        keys.push(key);
    }
    if keys.is_empty() {
        keys.push(Key { t_s: 0.0, at_m, turn_deg });
    }
    keys
}

fn shape(table: &mut Table<'_>, kind: &str) -> Shape {
    match kind {
        "sphere" => Shape::Sphere { radius_m: table.number("radius_m", LENGTH) },
        "torus" => {
            let (ring_m, radius_m) = (table.number("ring_m", LENGTH), table.number("radius_m", LENGTH));
            if table.is_clean() && radius_m >= ring_m {
                table.conflict(
                    "radius_m",
                    format!("is {radius_m}; the tube is thinner than ring_m, {ring_m}"),
                );
            }
            Shape::Torus { ring_m, radius_m }
        }
        "capsule" => Shape::Capsule {
            length_m: table.number("length_m", LENGTH),
            radius_m: table.number("radius_m", LENGTH),
        },
        "lizard" => Shape::Lizard { length_m: table.maybe("length_m", LENGTH).unwrap_or(1.0) },
        "room" => {
            let half_m = table.number("half_m", LENGTH);
            let names = Side::ALL.map(|(name, _)| name);
            let open =
                table.texts("open", &names.join(", "), |word| names.contains(&word)).unwrap_or_default();
            if names.iter().all(|name| open.iter().any(|word| word == name)) {
                table.conflict("open", "leaves no wall");
            }
            Shape::Room { half_m, open }
        }
        "stencil" => {
            let size_m = table.number("size_m", LENGTH);
            let is_row = |row: &str| (1..=MOST_PARTS).contains(&row.chars().count());
            let allowed = format!("rows of 1 to {MOST_PARTS} characters; blanks and dots are holes");
            let pattern = table.texts("pattern", &allowed, is_row).unwrap_or_else(|| {
                table.missing("pattern", format_args!("{allowed}"));
                Vec::new()
            });
            let wide = pattern.first().map_or(0, |row| row.chars().count());
            if pattern.iter().any(|row| row.chars().count() != wide) {
                table.conflict("pattern", "has rows that differ in length");
            } else if pattern.len() > MOST_PARTS {
                table.conflict("pattern", format!("has {} rows; allowed: {MOST_PARTS}", pattern.len()));
            } else if table.is_clean() && pattern.iter().all(|row| row.chars().all(|c| c == ' ' || c == '.'))
            {
                table.conflict("pattern", "leaves nothing of the plate");
            }
            Shape::Stencil { size_m, pattern }
        }
        "lathe" => {
            let profile_m: Vec<[f32; 2]> = table.list("profile_m", PLACE).unwrap_or_else(|| {
                table.missing("profile_m", format_args!("radius and height of two points or more"));
                Vec::new()
            });
            if table.is_clean() {
                let is_outside = |at: &[f32; 2]| at[0] >= 0.0;
                if !(2..=MOST_PARTS).contains(&profile_m.len()) || !profile_m.iter().all(is_outside) {
                    let message = format!(
                        "has {} points; allowed: 2 to {MOST_PARTS}, radius 0 or more",
                        profile_m.len()
                    );
                    table.conflict("profile_m", message);
                }
                if profile_m.windows(2).any(|ends| ends[0] == ends[1] || ends[0][0] + ends[1][0] <= 1e-4) {
                    table.conflict(
                        "profile_m",
                        "has a part without a surface: two points alike, or both on the axis",
                    );
                }
            }
            Shape::Lathe { profile_m }
        }
        _ => Shape::Box { half_m: table.number("half_m", LENGTH) },
    }
}

/// Squares round what is round.
const AROUND: u32 = 48;

impl Shape {
    /// Its triangles.
    pub fn mesh(&self) -> Mesh {
        match self {
            Self::Box { half_m } => shapes::cuboid((*half_m).into()),
            Self::Sphere { radius_m } => shapes::sphere(*radius_m, AROUND),
            Self::Torus { ring_m, radius_m } => shapes::torus(*ring_m, *radius_m, AROUND),
            Self::Capsule { length_m, radius_m } => {
                let end = 0.5 * length_m * Vec3::Y;
                shapes::capsule(end, -end, *radius_m, AROUND / 2)
            }
            Self::Lizard { length_m } => shapes::lizard(*length_m),
            Self::Room { half_m, open } => {
                let is_open = |name: &&str| open.iter().any(|word| word == name);
                let open = Side::ALL.into_iter().filter(|(name, _)| is_open(name)).map(|(_, side)| side);
                walls::room((*half_m).into(), &open.collect::<Vec<_>>())
            }
            Self::Stencil { size_m, pattern } => {
                let rows: Vec<&str> = pattern.iter().map(String::as_str).collect();
                walls::stencil((*size_m).into(), &rows)
            }
            Self::Lathe { profile_m } => {
                let line: Vec<Vec2> = profile_m.iter().map(|at| Vec2::from(*at)).collect();
                walls::lathe(&line, AROUND)
            }
        }
    }
}

impl MeshPlan {
    /// Whether it moves, by keys of the scene or of its file.
    pub fn moves(&self) -> bool {
        self.motion.moves() || self.mesh.rig.moves()
    }

    /// No vertex goes a longer way in a step of `dt_s` than this by `dt_s` (m/s), by keys of the scene and its own.
    pub fn fastest_mps(&self, dt_s: f64) -> f32 {
        if !self.moves() {
            return 0.0;
        }
        let own = self.mesh.extent(dt_s);
        let far_m = self.motion.keys.iter().map(|key| Vec3::from(key.at_m).length()).fold(0.0, f32::max)
            + self.motion.scale * own.reach_m;
        // A velocity is a difference of rounded places.
        let rounding_mps = 16.0 * f32::EPSILON * far_m / dt_s as f32;
        self.motion.fastest_mps(own.reach_m) + self.motion.scale * own.speed_mps + rounding_mps
    }

    /// A box round it at `time_s` (m).
    pub fn bounds_m(&self, time_s: f64) -> (Vec3, Vec3) {
        let (low, high) = self.mesh.bounds_m();
        let world = self.motion.at(time_s);
        (0..8).fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), corner| {
            let pick = |k: u32, axis: usize| if corner >> k & 1 == 0 { low[axis] } else { high[axis] };
            let at = world.transform_point3(vec3(pick(0, 0), pick(1, 1), pick(2, 2)));
            (lo.min(at), hi.max(at))
        })
    }

    pub(super) fn list_buffers(&self, list: &mut Vec<PlannedBuffer>) {
        let because = format!("mesh.{}", self.name);
        let mut add = |name: &str, bytes: usize| {
            list.push(PlannedBuffer { name: name.into(), bytes: bytes as u64, because: because.clone() });
        };
        let (vertices, triangles) = (self.mesh.at_m.len(), self.mesh.triangles.len());
        add("mesh.rest", 4 * VERTEX_WORDS * vertices);
        add("mesh.triangles", 12 * triangles);
        add("mesh.places", 24 * vertices);
        add("mesh.matrices", 3 * 48 * self.mesh.rig.joints.len());
    }
}

impl Scene {
    pub(super) fn plan_meshes(&self) -> Result<Vec<MeshPlan>, SceneError> {
        let plan = |it: &MeshScene| {
            let mesh = match &it.source {
                Source::File(file) => {
                    let path = self.base_dir.as_deref().unwrap_or(Path::new("")).join(file);
                    Mesh::read(&path)
                        .map_err(|error| SceneError::Shader { file: file.clone(), reason: error.what })?
                }
                Source::Shape(shape) => shape.mesh(),
            };
            if it.map > 0 && mesh.uv.is_empty() {
                let reason = "has no texture coordinates, so it cannot be painted".into();
                return Err(SceneError::Shader { file: format!("mesh.{}", it.name), reason });
            }
            Ok(MeshPlan {
                name: it.name.clone(),
                mesh,
                motion: Motion { keys: it.keys.clone(), loops: it.loops, scale: it.scale },
                color: it.color.into(),
                mirrors: it.mirrors,
                tile_m: it.tile_m,
                map: it.map,
                solid: it.solid,
            })
        };
        self.meshes.iter().map(plan).collect()
    }
}
