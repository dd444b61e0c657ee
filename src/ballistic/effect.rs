// SPDX-License-Identifier: MIT OR Apache-2.0
//! An effect: numbers and a GLSL snippet, in one file. The numbers stand in its first comment, `/* effect ... */`, a line
//! each, `key = number` or `key = x y z`, `#` before remarks.

use super::emission::{Emission, Live, Moment};
use glam::{UVec2, Vec2, Vec3, Vec4};
use std::fmt;

/// How an effect's sprites meet what is behind them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// They add light: the order does not matter.
    Add,
    /// Premultiplied over it.
    Over,
}

/// Where particles come from: a path in closed form, so that each is born where the emitter was at its birth, whatever the
/// frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Emitter {
    /// At the start (m).
    pub at_m: Vec3,
    /// (m/s).
    pub velocity_mps: Vec3,
    /// Radius of a level circle round that (m).
    pub circle_m: f32,
    /// Rounds of the circle (1/s).
    pub turns_per_s: f64,
}

/// Numbers of an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Its name: the file's, without folder and extension.
    pub name: String,
    /// Births per second.
    pub rate_per_s: f64,
    /// Particles of each birth.
    pub burst: u32,
    /// (s).
    pub life_s: f64,
    /// (m/s^2).
    pub acceleration_mps2: Vec3,
    /// Rate at which velocity dies away (1/s).
    pub drag_per_s: f32,
    /// Where they come from.
    pub emitter: Emitter,
    /// Streaks are as long as a particle flies in this time (s).
    pub exposure_s: f32,
    /// Factor of all sizes.
    pub size: f32,
    /// How sprites meet what is behind them.
    pub blend: Blend,
    /// Particles end on the ground, or do as the effect says: it needs a heightmap.
    pub has_ground: bool,
}

/// What particles fall on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundGrid {
    /// Extent along x and z, round the origin (m).
    pub size_m: Vec2,
    /// Samples along x and z.
    pub cells: UVec2,
    /// Level of standing water (m).
    pub water_m: f32,
}

impl GroundGrid {
    /// Of a heightmap of one sample.
    pub const FLAT: Self = Self { size_m: Vec2::ONE, cells: UVec2::ONE, water_m: f32::NEG_INFINITY };
}

/// `Effect` in `glsl/ballistic/effect.glsl`: an effect at a moment.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Params {
    /// xyz (m/s^2); w: linear drag (1/s).
    pub acceleration: Vec4,
    /// xyz: where the emitter is now, without its circling; w: radius of the circle (m).
    pub emitter_m: Vec4,
    /// xyz: velocity (m/s); w: where on the circle it is now (turns).
    pub emitter_mps: Vec4,
    /// Of the emitter.
    pub turns_per_s: f32,
    /// 1 / life (1/s).
    pub lives_per_s: f32,
    /// Between births, ten bits of it (s).
    pub interval_s: f32,
    /// The rest of it (s).
    pub interval_low_s: f32,
    /// From the newest birth to now (s).
    pub since_s: f32,
    /// What rounding took from it (s).
    pub since_low_s: f32,
    /// Of the scene.
    pub seed: u32,
    /// Which emitter.
    pub stream: u32,
    /// Serial number of the newest birth, low word.
    pub newest: u32,
    /// Its high word.
    pub newest_high: u32,
    /// Births that live.
    pub births: u32,
    /// Particles in each.
    pub burst: u32,
    /// Extent of the heightmap (m).
    pub ground_size_m: Vec2,
    /// Its samples.
    pub ground_cells: UVec2,
    /// Level of standing water (m).
    pub water_m: f32,
    /// Of streaks (s).
    pub exposure_s: f32,
    /// Factor of all sizes.
    pub size: f32,
    /// Particles that there is room for.
    pub capacity: u32,
}

/// `x` as a float, and what rounding took from it.
pub(super) fn wide(x: f64) -> [f32; 2] {
    let high = x as f32;
    [high, (x - f64::from(high)) as f32]
}

impl Effect {
    /// The clock of its births. [`Effect::check`] must hold.
    ///
    /// # Panics
    /// If rate or life are out of range.
    pub fn emission(&self) -> Emission {
        Emission::new(self.rate_per_s, self.life_s).expect("rate and life are checked")
    }

    /// Most particles that live at one moment.
    pub fn most_particles(&self) -> u64 {
        self.emission().most() * u64::from(self.burst)
    }

    /// The effect at a moment, as shaders see it, of the emitter `stream` of a scene of this `seed`.
    pub fn params(&self, now: Moment, seed: u32, stream: u32, ground: &GroundGrid, capacity: u32) -> Params {
        let emission = self.emission();
        let Live { newest, births } = emission.live(now);
        let interval = emission.interval_s();
        let interval_s = f32::from_bits((interval as f32).to_bits() & 0xffff_c000);
        let interval_low_s = (interval - f64::from(interval_s)) as f32;
        let [since_s, since_low_s] = wide(emission.age_s(now, newest));
        let t = now.as_s();
        let at_m = self.emitter.at_m.as_dvec3() + self.emitter.velocity_mps.as_dvec3() * t;
        let turns = (self.emitter.turns_per_s * t).rem_euclid(1.0);
        Params {
            acceleration: self.acceleration_mps2.extend(self.drag_per_s),
            emitter_m: at_m.as_vec3().extend(self.emitter.circle_m),
            emitter_mps: self.emitter.velocity_mps.extend(turns as f32),
            turns_per_s: self.emitter.turns_per_s as f32,
            lives_per_s: (1.0 / self.life_s) as f32,
            interval_s,
            interval_low_s,
            since_s,
            since_low_s,
            seed,
            stream,
            newest: newest as u32,
            newest_high: (newest >> 32) as u32,
            births: births as u32,
            burst: self.burst,
            ground_size_m: ground.size_m,
            ground_cells: ground.cells,
            water_m: ground.water_m,
            exposure_s: self.exposure_s,
            size: self.size,
            capacity,
        }
    }

    /// The same of an effect that impacts throw, from a ring of `slots`: of an emitter there is nothing in it, and what lives
    /// the ring says.
    pub fn kindled_params(&self, seed: u32, stream: u32, ground: &GroundGrid, slots: u32) -> Params {
        let still = Self { emitter: Emitter::default(), ..self.clone() };
        let params = still.params(Moment::default(), seed, stream, ground, slots);
        Params { newest: 0, births: 0, ..params }
    }

    /// Reads the numbers of an effect file; `file` is how errors name it.
    ///
    /// # Errors
    /// [`BadEffect`], which says where.
    pub fn parse(file: &str, text: &str) -> Result<Self, BadEffect> {
        let bad = |line: usize, what: String| BadEffect {
            file: file.into(),
            line,
            what,
            excerpt: text.lines().nth(line - 1).unwrap_or_default().into(),
        };
        let stem = file.rsplit(['/', '\\']).next().unwrap_or(file);
        let mut effect = Self {
            name: stem.split('.').next().unwrap_or(stem).into(),
            rate_per_s: f64::NAN,
            burst: 1,
            life_s: f64::NAN,
            acceleration_mps2: Vec3::ZERO,
            drag_per_s: 0.0,
            emitter: Emitter::default(),
            exposure_s: 1.0 / 60.0,
            size: 1.0,
            blend: Blend::Add,
            has_ground: false,
        };
        let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
        let Some((begin, _)) = lines.by_ref().find(|(_, line)| line.starts_with("/* effect")) else {
            return Err(bad(1, "no comment that begins with `/* effect`: it holds the numbers".into()));
        };
        let mut seen: Vec<&str> = Vec::new();
        let mut is_closed = false;
        for (number, line) in lines {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line == "*/" {
                is_closed = true;
                break;
            }
            if line.is_empty() {
                continue;
            }
            let Some((key, value)) = line.split_once('=') else {
                return Err(bad(
                    number,
                    format!("`{line}` is not `key = value`, nor the end of the comment, `*/`"),
                ));
            };
            let (key, value) = (key.trim(), value.trim());
            if seen.contains(&key) {
                return Err(bad(number, format!("`{key}` is given twice")));
            }
            effect.set(key, value).map_err(|what| bad(number, what))?;
            seen.push(key);
        }
        if !is_closed {
            return Err(bad(begin, "the comment `/* effect` has no line `*/`".into()));
        }
        if let Some(key) = ["rate_per_s", "life_s"].iter().find(|key| !seen.contains(*key)) {
            return Err(bad(begin, format!("`{key}` is missing")));
        }
        effect.check().map_err(|what| bad(begin, what))?;
        Ok(effect)
    }

    fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        const KEYS: &str =
            "rate_per_s, burst, life_s, acceleration_mps2, drag_per_s, emitter_m, emitter_mps, \
                            circle_m, circle_turns_per_s, exposure_s, size, blend, ground";
        let numbers: Vec<f64> = value.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let words = value.split_whitespace().count();
        let number = |allowed: [f64; 2]| match numbers[..] {
            [x] if words == 1 && (allowed[0]..=allowed[1]).contains(&x) => Ok(x),
            _ => Err(format!("`{key}` = {value}: a number from {} to {} is allowed", allowed[0], allowed[1])),
        };
        let vector = || match numbers[..] {
            [x, y, z] if words == 3 && numbers.iter().all(|x| x.abs() <= 1e6) => {
                Ok(Vec3::new(x as f32, y as f32, z as f32))
            }
            _ => Err(format!("`{key}` = {value}: three numbers up to a million are allowed")),
        };
        match key {
            "rate_per_s" => self.rate_per_s = number(Emission::RATES_PER_S)?,
            "burst" => {
                let count = number([1.0, 65536.0])?;
                if count.fract() != 0.0 {
                    return Err(format!("`burst` = {value}: a whole number is allowed"));
                }
                self.burst = count as u32;
            }
            "life_s" => self.life_s = number([1e-3, Emission::LONGEST_S])?,
            "acceleration_mps2" => self.acceleration_mps2 = vector()?,
            "drag_per_s" => self.drag_per_s = number([0.0, 1e3])? as f32,
            "emitter_m" => self.emitter.at_m = vector()?,
            "emitter_mps" => self.emitter.velocity_mps = vector()?,
            "circle_m" => self.emitter.circle_m = number([0.0, 1e6])? as f32,
            "circle_turns_per_s" => self.emitter.turns_per_s = number([-1e3, 1e3])?,
            "exposure_s" => self.exposure_s = number([0.0, 10.0])? as f32,
            "size" => self.size = number([1e-6, 1e6])? as f32,
            "blend" => {
                self.blend = match value {
                    "add" => Blend::Add,
                    "over" => Blend::Over,
                    _ => return Err(format!("`blend` = {value}: `add` and `over` are allowed")),
                }
            }
            "ground" => self.has_ground = number([0.0, 1.0])? != 0.0,
            _ => return Err(format!("no key `{key}`; there are {KEYS}")),
        }
        Ok(())
    }

    /// Whether it can run.
    ///
    /// # Errors
    /// What cannot, and what is allowed.
    pub fn check(&self) -> Result<(), String> {
        let Some(emission) = Emission::new(self.rate_per_s, self.life_s) else {
            let [lowest, highest] = Emission::RATES_PER_S;
            return Err(format!(
                "rate_per_s = {}, life_s = {}: rates from {lowest:e} to {highest} and lives up to {} s are allowed",
                self.rate_per_s,
                self.life_s,
                Emission::LONGEST_S
            ));
        };
        let most = u128::from(emission.most()) * u128::from(self.burst);
        if most > 1 << 30 {
            return Err(format!(
                "{most} particles live at once: rate x burst x life up to {} is allowed",
                1 << 30
            ));
        }
        Ok(())
    }
}

/// An effect file that cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub struct BadEffect {
    /// Its name.
    pub file: String,
    /// From 1.
    pub line: usize,
    /// What is wrong, and what is allowed.
    pub what: String,
    /// The line.
    pub excerpt: String,
}

impl fmt::Display for BadEffect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}\n{:5} | {}", self.file, self.line, self.what, self.line, self.excerpt)
    }
}

impl std::error::Error for BadEffect {}
