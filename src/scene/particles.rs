// SPDX-License-Identifier: MIT OR Apache-2.0
//! `[[emitter]]`: what throws particles.

use super::{
    attractors::Attractor,
    colliding::{self, CollidingScene},
    kindled::{self, KindledScene},
    parse::{
        Rule::{AtLeastZero, Finite, Within},
        Table,
    },
    schema::{LENGTH, PLACE},
    splash,
};
use crate::{
    ballistic::{self, Emission},
    particles,
};
use serde::Serialize;

/// Throws particles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EmitterScene {
    /// Name, unique in the scene; default `emitter`.
    pub name: String,
    /// What moves its particles.
    pub throws: Throws,
    /// Where it is at the start (m); `None` is where the effect has it, or the origin.
    pub at_m: Option<[f32; 3]>,
    /// Its own velocity (m/s); particles of a law keep it.
    pub velocity_mps: Option<[f32; 3]>,
    /// Births a second; needed for a law.
    pub rate_per_s: Option<f64>,
    /// Life of a particle (s); needed for a law.
    pub life_s: Option<f64>,
    /// How triangles come about, or that there are none.
    pub draw: Draw,
    /// Whether sprites fade where they meet the scene; only as `quads` or `geometry`.
    pub soft: bool,
    /// A PNG on the sprites, relative to the scene; only as `quads` or `geometry`.
    pub texture: Option<String>,
    /// Light on the ground, linear, at a distance of 1 m; at most one emitter of a scene has it.
    pub light: Option<[f32; 3]>,
}

/// What moves particles.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Throws {
    /// A closed form: nothing is stored.
    Effect(EffectScene),
    /// A pool that is stepped.
    Law(LawScene),
}

/// Changes to the numbers of an effect; `None` is what its file has.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EffectScene {
    /// A built-in name, or a `.glsl` file relative to the scene.
    pub file: String,
    /// Particles of each birth.
    pub burst: Option<u32>,
    /// (m/s²).
    pub acceleration_mps2: Option<[f32; 3]>,
    /// (1/s).
    pub drag_per_s: Option<f32>,
    /// Radius of the circle that the emitter runs (m).
    pub circle_m: Option<f32>,
    /// Rounds of it (1/s).
    pub circle_turns_per_s: Option<f64>,
    /// Length of streaks (s).
    pub exposure_s: Option<f32>,
    /// Factor of all sizes.
    pub size: Option<f32>,
    /// Of births from impacts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kindled: Option<KindledScene>,
    /// Most impacts of a step, 1..=16384, of an effect with a ground; `None` makes none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impacts: Option<u32>,
}

/// A law and its numbers, and how its particles look.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LawScene {
    /// `black_hole`, `drag`, or a `.glsl` file relative to the scene.
    pub file: String,
    /// Of what is thrown (m/s), default 0.
    pub speed_mps: f32,
    /// Eight at a time to the corners of a turned cube, instead of one by one.
    pub corners: bool,
    /// Most particles; `None` is as many as rate and life make.
    pub capacity: Option<u32>,
    /// Step (s); `None` is a picture's time, a sixtieth of a second at the most.
    pub dt_s: Option<f64>,
    /// Of `black_hole`; `None` is chosen by `tolerance`.
    pub integrator: Option<String>,
    /// Of a step, for `integrator`; default 1.
    pub substeps: Option<u32>,
    /// Largest position error in 10 s, of the distance to the hole; default 0.01.
    pub tolerance: f64,
    /// Of `drag` (m/s²), default gravity.
    pub pull_mps2: [f32; 3],
    /// Of `drag` (1/s), default 0.
    pub drag_per_s: f32,
    /// Of a law from a file: the floats of its block `Law`.
    pub numbers: Vec<f32>,
    /// Half width of a sprite (m), default 0.1.
    pub half_m: f32,
    /// Length of streaks (s), default 0: discs.
    pub exposure_s: f32,
    /// Linear light of a sprite near an attractor, or when it is born.
    pub color: [f32; 3],
    /// The same far away, or at its end; default as `color`.
    pub far_color: [f32; 3],
    /// What is far (m), default 100.
    pub far_m: f32,
    /// How much a sprite covers, 0..=1, default 0: it only adds light.
    pub alpha: f32,
    /// How much of the sun balls mirror, 0..=1, default 0.4.
    pub mirrors: f32,
    /// What only `colliding` has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colliding: Option<CollidingScene>,
}

/// How sprites are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Draw {
    /// Two triangles each, vertices pulled by number.
    Quads,
    /// Points that a geometry shader takes apart, where the device has it.
    Geometry,
    /// A compute shader, for sprites of a few pixels.
    Splat,
    /// Balls in the light, with shadows.
    Balls,
}

const NAMES: &str = "1 to 64 of A-Z a-z 0-9 _ -, not digits only";
const LAWS: [&str; 3] = ["black_hole", "drag", "colliding"];

fn is_glsl(file: &str) -> bool {
    file.ends_with(".glsl")
}

pub(super) fn emitters(
    root: &mut Table<'_>,
    attractors: &[Attractor],
    has_ground: bool,
) -> Vec<EmitterScene> {
    let mut emitters: Vec<EmitterScene> = Vec::new();
    for table in root.tables("emitter") {
        let next = emitter(table, &emitters, attractors, has_ground);
        emitters.push(next);
    }
    emitters
}

fn emitter(
    mut table: Table<'_>,
    others: &[EmitterScene],
    attractors: &[Attractor],
    has_ground: bool,
) -> EmitterScene {
    let is_name = |name: &str| {
        (1..=64).contains(&name.len())
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-')
            && !name.chars().all(|c| c.is_ascii_digit())
    };
    let built_in: Vec<&str> = ballistic::Builtin::ALL.iter().map(|it| it.name()).collect();
    let effects = format!("{}, or a .glsl file", built_in.join(", "));
    let laws = format!("{}, or a .glsl file", LAWS.join(", "));
    let name = table.text("name", NAMES, is_name);
    let effect = table.file("effect", &effects, |file| built_in.contains(&file) || is_glsl(file));
    let law = table.file("law", &laws, |file| LAWS.contains(&file) || is_glsl(file));
    let name = name.or(effect.or(law).filter(|file| is_name(file))).unwrap_or("emitter").to_owned();
    if let Some(i) = others.iter().position(|other| other.name == name) {
        table.conflict("name", format!("is {name:?}, as emitter.{i} is called already; names are unique"));
    }
    let throws = match (table.has("effect"), table.has("law")) {
        (true, true) => {
            table.conflict("law", "is given beside effect; an emitter has one of them");
            Throws::Effect(EffectScene::default())
        }
        (false, false) => {
            table.missing("effect", format_args!("{effects}; or law: {laws}"));
            Throws::Effect(EffectScene::default())
        }
        (true, false) => Throws::Effect(self::effect(&mut table, effect.unwrap_or_default())),
        (false, true) => Throws::Law(self::law(&mut table, law.unwrap_or_default(), attractors)),
    };
    let is_law = matches!(throws, Throws::Law(_));
    let [lowest, highest] = Emission::RATES_PER_S;
    let rates = if is_law { Within(0.0, particles::Emitter::MOST_PER_S) } else { Within(lowest, highest) };
    // A clock of 32 bits turns once in 18 hours, and a life is less than half of that.
    let lives = if is_law { Within(1e-3, 30_000.0) } else { Within(1e-3, Emission::LONGEST_S) };
    let is_population =
        matches!(&throws, Throws::Law(law) if law.colliding.as_ref().is_some_and(|it| it.population > 0));
    let (rate_per_s, life_s) = match is_law {
        true if is_population => {
            for key in ["rate_per_s", "life_s"] {
                if table.has(key) {
                    table.conflict(key, "is given beside population, of whom none is born and none ends");
                }
            }
            (Some(0.0), Some(30_000.0))
        }
        true => (Some(table.number("rate_per_s", rates)), Some(table.number("life_s", lives))),
        false => (table.maybe("rate_per_s", rates), table.maybe("life_s", lives)),
    };
    let all = [
        ("quads", Draw::Quads),
        ("geometry", Draw::Geometry),
        ("splat", Draw::Splat),
        ("balls", Draw::Balls),
    ];
    // A closed form has no radius.
    let draws = if is_law { &all[..] } else { &all[..3] };
    let collides = matches!(&throws, Throws::Law(law) if law.colliding.is_some());
    let draw = table.choice("draw", draws).unwrap_or(if collides { Draw::Balls } else { Draw::Quads });
    let is_png = |file: &str| file.ends_with(".png");
    let texture = table.file("texture", "a .png file", is_png).map(str::to_owned);
    let soft = table.choice("soft", &[("yes", true), ("no", false)]).unwrap_or(false);
    if draw == Draw::Splat {
        if texture.is_some() {
            table.conflict("texture", "is for draw \"quads\" or \"geometry\"; a splat is a soft disc");
        }
        if soft {
            table.conflict("soft", "is for draw \"quads\" or \"geometry\"; a splat is too small to fade");
        }
    }
    if draw == Draw::Balls {
        for key in ["texture", "soft"] {
            if table.has(key) {
                table.conflict(key, "is for sprites, and this emitter draws balls");
            }
        }
    }
    let light = table.maybe("light", Within(0.0, 1e6));
    if light.is_some() && others.iter().any(|other| other.light.is_some()) {
        table.conflict("light", "is given by another emitter already; a scene has one lamp");
    }
    let emitter = EmitterScene {
        name,
        throws,
        at_m: table.maybe("at_m", PLACE),
        velocity_mps: table.maybe("velocity_mps", Within(-1e6, 1e6)),
        rate_per_s,
        life_s,
        draw,
        soft,
        texture,
        light,
    };
    if let (Throws::Law(law), true) = (&emitter.throws, table.is_clean()) {
        let most = law.wanted(&emitter);
        if law.capacity.is_none() && most > MOST_PARTICLES {
            let message = format!(
                "is {} and life_s {}: {most} particles at once; allowed: {MOST_PARTICLES}, or a capacity",
                emitter.rate_per_s.unwrap_or(0.0),
                emitter.life_s.unwrap_or(0.0)
            );
            table.blame("rate_per_s", super::ProblemKind::OutOfRange, message);
        }
    }
    if let (Throws::Effect(effect), true) = (&emitter.throws, table.is_clean()) {
        let needs = ballistic::Builtin::named(&effect.file).is_some_and(|it| it.effect().has_ground);
        if needs && !has_ground {
            table.conflict("effect", "ends on the ground: it needs [terrain] or [[water]]");
        }
        if let Some(builtin) = ballistic::Builtin::named(&effect.file).filter(|_| effect.kindled.is_none()) {
            if let Err(what) = emitter.changed(effect, builtin.effect()).check() {
                table.blame("rate_per_s", super::ProblemKind::OutOfRange, what);
            }
        }
    }
    table.finish();
    emitter
}

fn effect(table: &mut Table<'_>, file: &str) -> EffectScene {
    splash::check_effect(table, file);
    EffectScene {
        file: file.to_owned(),
        burst: table.maybe("burst", Within(1.0, 65536.0)),
        acceleration_mps2: table.maybe("acceleration_mps2", Within(-1e6, 1e6)),
        drag_per_s: table.maybe("drag_per_s", Within(0.0, 1e3)),
        circle_m: table.maybe("circle_m", Within(0.0, 1e6)),
        circle_turns_per_s: table.maybe("circle_turns_per_s", Within(-1e3, 1e3)),
        exposure_s: table.maybe("exposure_s", Within(0.0, 10.0)),
        size: table.maybe("size", Within(1e-6, 1e6)),
        kindled: kindled::kindled(table),
        impacts: splash::impacts(table),
    }
}

/// Most particles of a pool: 7 GB of them, twice.
pub(super) const MOST_PARTICLES: u64 = 1 << 28;

fn law(table: &mut Table<'_>, file: &str, attractors: &[Attractor]) -> LawScene {
    let [is_hole, is_drag, is_colliding] = LAWS.map(|law| law == file);
    let color = table.maybe("color", Within(0.0, 1e6)).unwrap_or([0.1, 0.1, 0.1]);
    let mut law = LawScene {
        file: file.to_owned(),
        speed_mps: table.maybe("speed_mps", Within(-1e6, 1e6)).unwrap_or(0.0),
        corners: table.choice("thrown", &[("singly", false), ("corners", true)]).unwrap_or(false),
        capacity: table.maybe("capacity", Within(1.0, MOST_PARTICLES as f64)),
        dt_s: table.maybe("dt_s", Within(1e-4, 1.0)),
        integrator: None,
        substeps: None,
        tolerance: 0.01,
        pull_mps2: [0.0, -9.81, 0.0],
        drag_per_s: 0.0,
        numbers: Vec::new(),
        half_m: table.maybe("half_m", LENGTH).unwrap_or(0.1),
        exposure_s: table.maybe("exposure_s", Within(0.0, 10.0)).unwrap_or(0.0),
        color,
        far_color: table.maybe("far_color", Within(0.0, 1e6)).unwrap_or(color),
        far_m: table.maybe("far_m", LENGTH).unwrap_or(100.0),
        alpha: table.maybe("alpha", Within(0.0, 1.0)).unwrap_or(0.0),
        mirrors: table.maybe("mirrors", Within(0.0, 1.0)).unwrap_or(0.4),
        colliding: None,
    };
    if is_colliding {
        if law.dt_s.is_some() {
            table.conflict("dt_s", "is that of [volume] for all that collides");
        }
        let colliding = colliding::colliding(table, &law);
        if !table.has("half_m") {
            law.half_m = colliding.radius_m;
        }
        law.colliding = Some(colliding);
    } else if is_hole {
        let named = particles::black_hole::Integrator::ALL.map(|it| (it.name(), it.name()));
        law.integrator = table.choice("integrator", &named).map(str::to_owned);
        law.substeps = table.maybe("substeps", Within(1.0, 1024.0));
        if law.substeps.is_some() && law.integrator.is_none() {
            table.conflict("substeps", "needs integrator; without one, tolerance chooses both");
        }
        if let Some(tolerance) = table.maybe("tolerance", Within(1e-5, 1.0)) {
            law.tolerance = tolerance;
            if law.integrator.is_some() {
                table.conflict("tolerance", "is given beside integrator; one of them decides");
            }
        }
        if attractors.is_empty() {
            table.conflict("law", "is \"black_hole\", and the scene has no [[attractor]]");
        }
    } else if is_drag {
        law.pull_mps2 = table.maybe("pull_mps2", Within(-1e6, 1e6)).unwrap_or(law.pull_mps2);
        law.drag_per_s = table.maybe("drag_per_s", AtLeastZero).unwrap_or(0.0);
    } else {
        law.numbers = table.list("numbers", Finite).unwrap_or_default();
    }
    law
}

impl LawScene {
    /// Particles that live at once.
    pub(super) fn wanted(&self, emitter: &EmitterScene) -> u64 {
        if let Some(colliding) = self.colliding.as_ref().filter(|it| it.population > 0) {
            return colliding.population.into();
        }
        let most = emitter.rate_per_s.unwrap_or(0.0) * emitter.life_s.unwrap_or(0.0);
        // A burst, and the births of a step, may be there before the oldest have gone.
        most.ceil() as u64 + 64 + (emitter.rate_per_s.unwrap_or(0.0) / 15.0) as u64
    }
}

impl EmitterScene {
    /// What its law has, if that is `colliding`.
    pub fn colliding(&self) -> Option<&CollidingScene> {
        match &self.throws {
            Throws::Law(law) => law.colliding.as_ref(),
            Throws::Effect(_) => None,
        }
    }

    /// Which impacts throw its particles, if impacts do.
    pub fn kindled(&self) -> Option<&KindledScene> {
        match &self.throws {
            Throws::Effect(effect) => effect.kindled.as_ref(),
            Throws::Law(_) => None,
        }
    }

    /// `effect` with the numbers that the scene gives.
    pub(super) fn changed(&self, scene: &EffectScene, mut effect: ballistic::Effect) -> ballistic::Effect {
        fn set<T: Copy>(to: &mut T, from: Option<T>) {
            if let Some(from) = from {
                *to = from;
            }
        }
        set(&mut effect.rate_per_s, self.rate_per_s);
        set(&mut effect.life_s, self.life_s);
        set(&mut effect.emitter.at_m, self.at_m.map(Into::into));
        set(&mut effect.emitter.velocity_mps, self.velocity_mps.map(Into::into));
        set(&mut effect.emitter.circle_m, scene.circle_m);
        set(&mut effect.emitter.turns_per_s, scene.circle_turns_per_s);
        set(&mut effect.burst, scene.burst);
        set(&mut effect.acceleration_mps2, scene.acceleration_mps2.map(Into::into));
        set(&mut effect.drag_per_s, scene.drag_per_s);
        set(&mut effect.exposure_s, scene.exposure_s);
        set(&mut effect.size, scene.size);
        effect
    }
}
