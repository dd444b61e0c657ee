// SPDX-License-Identifier: MIT OR Apache-2.0
//! What stands in a water, floats through it, or lets its waves out: walls, bodies, borders. Types, keys and plans.

use super::{
    error::ProblemKind,
    parse::{
        Rule,
        Rule::{Finite, Within},
        Table,
    },
    schema::{LENGTH, PLACE},
    WaterScene,
};
use crate::{
    draw::{Built, TerrainGrid},
    water,
};
use glam::{dvec3, uvec2, vec2, DVec3, UVec2, Vec2};
use serde::Serialize;

/// Times of a turn (s).
const PERIOD: Rule = Within(1e-4, 1e7);

/// What a border of a water does with waves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Border {
    /// It is a wall.
    #[default]
    Reflect,
    /// They leave through it.
    Absorb,
}

/// The four borders, all reflecting by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Borders {
    /// At the least x.
    pub west: Border,
    /// At the greatest x.
    pub east: Border,
    /// At the least z.
    pub north: Border,
    /// At the greatest z.
    pub south: Border,
}

/// A wall along the axes, from the ground to above the level: land.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Wall {
    /// One corner, x and z (m), within 1e7.
    pub from_m: [f32; 2],
    /// The corner across (m), within 1e7.
    pub to_m: [f32; 2],
    /// How high it stands above the level (m), 1e-4 to 1e7, default a quarter of the depth.
    pub height_m: f32,
    /// What it looks like, default stone.
    pub look: WallLook,
}

/// What a wall looks like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum WallLook {
    /// A quay, a dam.
    #[default]
    Stone,
    /// A house: plaster and tiles.
    House,
}

/// A body that moves through the water, and is not moved by it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Body {
    /// What it looks like.
    #[serde(flatten)]
    pub shape: BodyShape,
    /// How a box is turned, from +x towards +z (degrees), finite, default 0.
    pub yaw_deg: f64,
    /// Where it is.
    #[serde(flatten)]
    pub path: BodyPath,
}

/// What a body looks like.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "shape", rename_all = "lowercase")]
pub enum BodyShape {
    /// A ball.
    Sphere {
        /// (m), at least a column.
        radius_m: f64,
    },
    /// A box, upright.
    Box {
        /// Half its length, height and width (m), 1e-4 to 1e7.
        half_m: [f64; 3],
    },
}

/// Where a body is at which time.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BodyPath {
    /// Time (s) and place, x, y and z (m), in the order of time; straight between them.
    Path(Vec<[f64; 4]>),
    /// Round a centre; a box turns with its way.
    Circle {
        /// x, y and z (m), within 1e7.
        centre_m: [f64; 3],
        /// (m), 1e-4 to 1e7.
        radius_m: f64,
        /// Time of a turn (s), 1e-4 to 1e7.
        period_s: f64,
        /// Where it starts, from +x towards +z (degrees), default 0.
        start_deg: f64,
    },
    /// To and fro, as the sine of time.
    Swing {
        /// The middle, x, y and z (m), within 1e7.
        at_m: [f64; 3],
        /// From the middle to where it turns (m), within 1e7.
        by_m: [f64; 3],
        /// (s), 1e-4 to 1e7.
        period_s: f64,
    },
}

impl Borders {
    /// Whether waves leave through any.
    pub fn any_absorbs(&self) -> bool {
        [self.west, self.east, self.north, self.south].contains(&Border::Absorb)
    }
}

/// `borders`, one word for all or a table with a word for some.
pub(super) fn borders(table: &mut Table<'_>) -> Borders {
    let words = [("reflect", Border::Reflect), ("absorb", Border::Absorb)];
    if !table.is_table("borders") {
        let [west, east, north, south] = [table.choice("borders", &words).unwrap_or_default(); 4];
        return Borders { west, east, north, south };
    }
    table.table("borders").map_or_else(Borders::default, |mut table| {
        let mut side = |key| table.choice(key, &words).unwrap_or_default();
        let borders =
            Borders { west: side("west"), east: side("east"), north: side("north"), south: side("south") };
        table.finish();
        borders
    })
}

pub(super) fn wall(mut table: Table<'_>, depth_m: f64) -> Wall {
    let wall = Wall {
        from_m: table.number("from_m", PLACE),
        to_m: table.number("to_m", PLACE),
        height_m: table.maybe("height_m", LENGTH).unwrap_or(0.25 * depth_m as f32),
        look: table
            .choice("look", &[("stone", WallLook::Stone), ("house", WallLook::House)])
            .unwrap_or_default(),
    };
    if (0..2).any(|axis| wall.from_m[axis] == wall.to_m[axis]) {
        table.conflict("to_m", "is in line with from_m; a wall has two corners across");
    }
    table.finish();
    wall
}

pub(super) fn body(mut table: Table<'_>, column_m: f64) -> Body {
    let shape = table.choice("shape", &[("sphere", 0), ("box", 1)]);
    if !table.has("shape") {
        table.missing("shape", format_args!("\"sphere\" or \"box\""));
    }
    let yaw_deg = table.maybe("yaw_deg", Finite).unwrap_or(0.0);
    let shape = match shape {
        Some(1) => BodyShape::Box { half_m: table.number("half_m", LENGTH) },
        Some(_) => {
            let radius_m = table.number("radius_m", LENGTH);
            if radius_m > 0.0 && radius_m < column_m {
                let message = format!("is {radius_m}; allowed: at least a column, {column_m} m");
                table.blame("radius_m", ProblemKind::OutOfRange, message);
            }
            BodyShape::Sphere { radius_m }
        }
        None => {
            return Body { shape: BodyShape::Sphere { radius_m: 1.0 }, yaw_deg, path: BodyPath::Path(vec![]) }
        }
    };
    let ways = ["path", "circle", "swing"].map(|key| table.has(key));
    let path = match ways {
        [true, false, false] => {
            let keys: Vec<[f64; 4]> = table.list("path", PLACE).unwrap_or_default();
            if keys.windows(2).any(|pair| pair[0][0] >= pair[1][0]) {
                table.conflict("path", "goes back in time; each key is later than the one before it");
            }
            BodyPath::Path(keys)
        }
        [false, true, false] => table.table("circle").map_or(BodyPath::Path(vec![]), |mut table| {
            let circle = BodyPath::Circle {
                centre_m: table.number("centre_m", PLACE),
                radius_m: table.number("radius_m", LENGTH),
                period_s: table.number("period_s", PERIOD),
                start_deg: table.maybe("start_deg", Finite).unwrap_or(0.0),
            };
            table.finish();
            circle
        }),
        [false, false, true] => table.table("swing").map_or(BodyPath::Path(vec![]), |mut table| {
            let swing = BodyPath::Swing {
                at_m: table.number("at_m", PLACE),
                by_m: table.number("by_m", PLACE),
                period_s: table.number("period_s", PERIOD),
            };
            table.finish();
            swing
        }),
        [false, false, false] => {
            table.missing("path", format_args!("path, circle or swing, where the body is at which time"));
            BodyPath::Path(vec![])
        }
        _ => {
            table.conflict("path", "or circle or swing: a body has one way");
            BodyPath::Path(vec![])
        }
    };
    table.finish();
    Body { shape, yaw_deg, path }
}

/// What depends on the grid.
pub(super) fn check(table: &Table<'_>, water: &WaterScene) {
    if water.bodies.len() > water::bodies::MOST as usize {
        let (count, most) = (water.bodies.len(), water::bodies::MOST);
        table.blame("body", ProblemKind::OutOfRange, format!("has {count} bodies; allowed: {most}"));
    }
    let Some(width_m) = water.absorb_width_m else { return };
    if !water.borders.any_absorbs() {
        table.conflict("absorb_width_m", "needs borders that absorb");
    }
    let [least, most] = [2.0 * water.column_m(), 0.5 * f64::from(water.size_m[0].min(water.size_m[1]))];
    if !(least..=most).contains(&width_m) {
        let message =
            format!("is {width_m}; allowed: {least} to {most}, two columns to half the water's shorter side");
        table.blame("absorb_width_m", ProblemKind::OutOfRange, message);
    }
}

impl WaterScene {
    /// Edge of a column (m).
    pub fn column_m(&self) -> f64 {
        f64::from(self.size_m[0]) / f64::from(self.cells[0])
    }

    /// The borders that absorb, if any does.
    pub(super) fn absorbing(&self) -> Option<water::Borders> {
        let [x, z] = self.cells;
        let strip = match self.absorb_width_m {
            Some(width_m) => (width_m / self.column_m()).round() as u32,
            None => water::Borders::STRIP.min(x.min(z) / 4),
        };
        let absorbs = |border| border == Border::Absorb;
        self.borders.any_absorbs().then_some(water::Borders {
            west: absorbs(self.borders.west),
            east: absorbs(self.borders.east),
            north: absorbs(self.borders.north),
            south: absorbs(self.borders.south),
            strip: strip.max(1),
        })
    }

    /// The bodies, in the world's coordinates.
    pub(super) fn fleet(&self) -> Vec<water::Body> {
        let body = |body: &Body| water::Body {
            shape: match body.shape {
                BodyShape::Sphere { radius_m } => water::bodies::Shape::Sphere(radius_m),
                BodyShape::Box { half_m } => water::bodies::Shape::Box(DVec3::from(half_m)),
            },
            path: match &body.path {
                BodyPath::Path(keys) => {
                    water::bodies::Path::Keys(keys.iter().map(|&[t, x, y, z]| (t, dvec3(x, y, z))).collect())
                }
                &BodyPath::Circle { centre_m, radius_m, period_s, start_deg } => {
                    water::bodies::Path::Circle {
                        centre_m: DVec3::from(centre_m),
                        radius_m,
                        period_s,
                        start_rad: start_deg.to_radians(),
                    }
                }
                &BodyPath::Swing { at_m, by_m, period_s } => {
                    water::bodies::Path::Swing { at_m: at_m.into(), by_m: by_m.into(), period_s }
                }
            },
            yaw_rad: body.yaw_deg.to_radians(),
        };
        self.bodies.iter().map(body).collect()
    }

    /// The columns under each wall, from and up to: those between its rounded edges, at least one each way.
    pub(super) fn walled_columns(&self) -> impl Iterator<Item = [UVec2; 2]> + '_ {
        let cells = UVec2::from(self.cells).as_vec2();
        self.barriers.iter().map(move |wall| {
            let (lo, hi) = wall.corners();
            let column = |at: Vec2| ((at / Vec2::from(self.size_m) + 0.5) * cells).round();
            let from = column(lo).clamp(Vec2::ZERO, cells);
            let to = column(hi).max(from + 1.0).clamp(Vec2::ZERO, cells);
            [from.as_uvec2(), to.as_uvec2()]
        })
    }

    /// Makes the columns under walls land.
    pub(super) fn build_walls(&self, height_m: &mut [f32]) {
        for [from, to] in self.walled_columns() {
            let (from, to) = (from.as_usizevec2(), to.as_usizevec2());
            for row in height_m.chunks_exact_mut(self.cells[0] as usize).take(to.y).skip(from.y) {
                row[from.x..to.x].fill(water::LAND_M);
            }
        }
    }
}

impl Wall {
    fn corners(&self) -> (Vec2, Vec2) {
        let (from, to) = (Vec2::from(self.from_m), Vec2::from(self.to_m));
        (from.min(to), from.max(to))
    }
}

/// Samples of a bed that has walls on it, along one side at most.
const MOST_SAMPLES: f32 = 2048.0;

/// Raises the ground to the walls of all waters; a bed of four samples is made finer first, as fine as the finest columns.
pub(super) fn raise_walls(waters: &[WaterScene], ground: &mut TerrainGrid) {
    if waters.iter().all(|water| water.barriers.is_empty()) {
        return;
    }
    if ground.cells == UVec2::splat(2) {
        let column_m = waters.iter().map(WaterScene::column_m).fold(f64::MAX, f64::min) as f32;
        ground.cells =
            (ground.size_m / column_m).round().clamp(Vec2::splat(2.0), Vec2::splat(MOST_SAMPLES)).as_uvec2();
        ground.height_m = vec![ground.height_m[0]; ground.cells.as_usizevec2().element_product()];
    }
    ground.built = vec![Built::Ground; ground.height_m.len()];
    for (water, wall) in waters.iter().flat_map(|water| water.barriers.iter().map(move |wall| (water, wall)))
    {
        let (lo, hi) = wall.corners();
        for (i, height) in ground.height_m.iter_mut().enumerate() {
            let c = uvec2(i as u32 % ground.cells.x, i as u32 / ground.cells.x).as_vec2();
            let at = ((c + vec2(0.5, 0.5)) / ground.cells.as_vec2() - 0.5) * ground.size_m;
            if at.cmpge(lo).all() && at.cmplt(hi).all() {
                *height = height.max(water.level_m + wall.height_m);
                ground.built[i] = match wall.look {
                    WallLook::Stone => Built::Stone,
                    WallLook::House => Built::House,
                };
            }
        }
    }
}
