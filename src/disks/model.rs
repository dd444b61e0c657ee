// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::check::{hold, Invalid};
use glam::{DVec3, UVec3};
use std::fmt;

/// Disks in a rectangle, or spheres in a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "tools", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Space {
    /// Disks: z is 0 everywhere.
    Flat,
    /// Spheres.
    Solid,
}

/// What is at the faces of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "tools", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Borders {
    /// Planes that mirror.
    Walls,
    /// The opposite face.
    Periodic,
}

/// What disks do that touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "tools", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Response {
    /// As the tutorial: elastic if it is the only contact of both, else the velocity is reversed.
    Seed,
    /// Impulses in the order of nine (27) colours of cells, without times of impact.
    GaussSeidel,
    /// Each disk offers itself to its earliest contact, and pairs that agree collide.
    Matching {
        /// How often, 1 or more.
        rounds: u32,
        /// Whether they collide where they met, and not where the step left them.
        rewinds: bool,
    },
    /// Extended position based dynamics: out of every overlap, and velocities from where that led (Müller et al.,
    /// "Detailed Rigid Body Simulation with Extended Position Based Dynamics", 2020).
    Xpbd {
        /// With its velocity pass, at a restitution of 1; without it, collisions are inelastic.
        bounces: bool,
    },
}

/// A disk or a sphere. Its mass is `radius^2` or `radius^3`: all are of one stuff.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    /// Centre, from the lowest corner of the box (m).
    pub at_m: DVec3,
    /// (m/s).
    pub velocity_mps: DVec3,
    /// (m).
    pub radius_m: f64,
}

/// A point that pushes disks away, or draws them in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stir {
    /// (m).
    pub at_m: DVec3,
    /// How far it reaches, falling off to nothing (m).
    pub radius_m: f64,
    /// At its middle, away from it; negative: towards it (m/s^2).
    pub push_mps2: f64,
}

/// A box of disks and how it is stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Disks or spheres.
    pub space: Space,
    /// The box, from the origin (m); z is not used in [`Space::Flat`].
    pub size_m: DVec3,
    /// Its faces.
    pub borders: Borders,
    /// (m/s^2).
    pub gravity_mps2: DVec3,
    /// What contacts do.
    pub response: Response,
    /// A step (s).
    pub dt_s: f64,
}

/// The cells that disks are sorted into, and which disks are too large for them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Along x, y and z; z is 1 in [`Space::Flat`].
    pub cells: UVec3,
    /// How many disks are wider than two cells: they come first, are in no cell, and are tried against every other.
    pub large: u32,
    /// Radius of the largest of the others (m).
    pub small_m: f64,
}

impl Stir {
    /// # Panics
    /// If one of the numbers is none.
    pub(super) fn assert_finite(&self) {
        let numbers = [self.at_m.x, self.at_m.y, self.at_m.z, self.radius_m, self.push_mps2];
        assert!(numbers.iter().all(|x| (*x as f32).is_finite()), "{self:?} is of finite numbers");
    }
}

impl Response {
    /// Whether contacts are settled in colours of cells, by passes that write both disks.
    pub fn is_colored(self) -> bool {
        matches!(self, Self::GaussSeidel | Self::Xpbd { .. })
    }
}

impl Space {
    /// 2 or 3.
    pub fn dimensions(self) -> u32 {
        match self {
            Self::Flat => 2,
            Self::Solid => 3,
        }
    }

    /// Of a disk of this radius, in units of its stuff.
    pub fn mass(self, radius_m: f64) -> f64 {
        radius_m.powi(self.dimensions() as i32)
    }

    /// Area or volume of a disk (m^2, m^3).
    pub fn measure(self, radius_m: f64) -> f64 {
        use std::f64::consts::PI;
        match self {
            Self::Flat => PI * radius_m.powi(2),
            Self::Solid => 4.0 / 3.0 * PI * radius_m.powi(3),
        }
    }
}

impl Grid {
    /// Most disks that are larger than a cell: each of the others looks at all of them.
    pub const MOST_LARGE: usize = 64;
    /// Most cells.
    pub const MOST_CELLS: f64 = 67_108_864.0;

    /// About one cell a disk, no cell narrower than a disk, but for a few that are wider than two cells. Of more than
    /// [`Grid::MOST_LARGE`] such disks the smaller ones make all cells as wide as they are.
    pub fn of(model: &Model, radii_m: impl Iterator<Item = f64>) -> Self {
        let mut radii_m: Vec<f64> = radii_m.collect();
        let count = radii_m.len();
        // The largest last; there are rarely more than a few that matter.
        let most = Self::MOST_LARGE.min(count.saturating_sub(1));
        if most > 0 {
            radii_m.select_nth_unstable_by(count - most - 1, f64::total_cmp);
            radii_m[count - most - 1..].sort_by(f64::total_cmp);
        }
        let even = model.even_edge(count as f64);
        let wide = (0..most).take_while(|i| radii_m[count - 1 - i] > even).count();
        let small_m = radii_m.get(count.wrapping_sub(1 + wide)).copied().unwrap_or(0.0);
        // Those that are as large as the first that cells have to hold gain nothing by being in none.
        let large = (0..wide).take_while(|i| radii_m[count - 1 - i] > small_m).count();
        // A hair wider than a disk: positions are rounded.
        let edge = even.max(2.0 * small_m * (1.0 + 1e-5)).max(model.even_edge(Self::MOST_CELLS));
        let along = |size: f64| (size / edge).floor().clamp(1.0, 1e6) as u32;
        let [x, y, z] = model.size_m.to_array().map(along).map(|n| {
            // Colours of cells must close where the box does.
            if model.response.is_colored() && model.borders == Borders::Periodic && n > 3 {
                n - n % 3
            } else {
                n
            }
        });
        let z = if model.space == Space::Flat { 1 } else { z };
        Self { cells: UVec3::new(x, y, z), large: large as u32, small_m }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.cells.as_usizevec3().element_product()
    }
}

fn smallest_m(disks: &[Disk]) -> f64 {
    disks.iter().map(|disk| disk.radius_m).fold(f64::INFINITY, f64::min)
}

impl Model {
    /// Collisions a disk and step beyond which [`Response::Matching`] is cut into substeps, by its rounds: measured in
    /// docs/disks.md.
    pub fn most_collisions(&self) -> f64 {
        match self.response {
            Response::Matching { rounds, .. } => 0.1 * f64::from(rounds),
            _ => f64::INFINITY,
        }
    }

    /// Area or volume of the box (m^2, m^3).
    pub fn measure(&self) -> f64 {
        match self.space {
            Space::Flat => self.size_m.x * self.size_m.y,
            Space::Solid => self.size_m.element_product(),
        }
    }

    /// Edge of `count` cells that fill the box, of which there is one across what is narrower.
    fn even_edge(&self, count: f64) -> f64 {
        let mut sizes = self.size_m.to_array()[..self.space.dimensions() as usize].to_vec();
        loop {
            let edge = (sizes.iter().product::<f64>() / count.max(1.0)).powf(1.0 / sizes.len() as f64);
            let before = sizes.len();
            sizes.retain(|size| *size > edge);
            if sizes.len() == before || sizes.is_empty() {
                return edge;
            }
        }
    }

    /// Share of the box that is disk.
    pub fn packing(&self, disks: &[Disk]) -> f64 {
        disks.iter().map(|disk| self.space.measure(disk.radius_m)).sum::<f64>() / self.measure()
    }

    /// Mass-weighted root mean square speed (m/s) and mean radius (m).
    fn means(&self, disks: &[Disk]) -> (f64, f64) {
        let (mut energy, mut mass, mut radius) = (0.0, 0.0, 0.0);
        for disk in disks {
            let m = self.space.mass(disk.radius_m);
            energy += m * disk.velocity_mps.length_squared();
            mass += m;
            radius += disk.radius_m;
        }
        ((energy / mass.max(f64::MIN_POSITIVE)).sqrt(), radius / disks.len().max(1) as f64)
    }

    /// How often a disk collides in a step, in the mean (Enskog, with the pressure of [`super::oracle::pressure`]).
    pub fn collisions_a_step(&self, disks: &[Disk]) -> f64 {
        let (speed, radius) = self.means(disks);
        let excess = super::oracle::pressure(self.space, self.packing(disks).min(0.7)) - 1.0;
        // Twice as many ends as collisions; in units of v dt / r: 0.798 (Z - 1) flat, 0.977 (Z - 1) / 1.06 solid.
        let shape = match self.space {
            Space::Flat => (2.0 / std::f64::consts::PI).sqrt(),
            Space::Solid => (3.0 / std::f64::consts::PI).sqrt(),
        };
        shape * excess * speed * self.dt_s / radius.max(f64::MIN_POSITIVE)
    }

    /// Speed that hardly any disk exceeds (m/s): the fastest there is, three times the thermal speed of the lightest, and
    /// what a fall through the box adds.
    pub fn fastest_mps(&self, disks: &[Disk]) -> f64 {
        let energy: f64 = disks
            .iter()
            .map(|disk| self.space.mass(disk.radius_m) * disk.velocity_mps.length_squared())
            .sum::<f64>()
            / disks.len().max(1) as f64;
        let lightest = disks.iter().map(|disk| self.space.mass(disk.radius_m)).fold(f64::INFINITY, f64::min);
        let fastest = disks.iter().map(|disk| disk.velocity_mps.length()).fold(0.0, f64::max);
        let thermal = if disks.len() > 2 { 3.0 * (energy / lightest).sqrt() } else { 0.0 };
        let fall = 2.0 * self.gravity_mps2.abs().dot(self.size_m);
        (fastest.max(thermal).powi(2) + fall).sqrt()
    }

    /// To which speed stirring may bring a disk: beyond it, two in one step come nearer by more than four radii of the
    /// smallest (m/s).
    pub fn stirred_mps(&self, disks: &[Disk]) -> f64 {
        2.0 * smallest_m(disks) / self.dt_s
    }

    /// Into how many substeps a step is cut: in one, two disks come nearer by at most four radii of the smallest, so that no
    /// head-on collision is jumped over, and a disk collides [`Model::most_collisions`] times at most in the mean.
    pub fn substeps(&self, disks: &[Disk]) -> u32 {
        let jumps = match self.response {
            Response::Seed => 0.0, // as the tutorial: it has no limit, and misses what is fast
            _ => 2.0 * self.fastest_mps(disks) * self.dt_s / (4.0 * smallest_m(disks)),
        };
        let crowd = self.collisions_a_step(disks) / self.most_collisions();
        jumps.max(crowd).ceil().clamp(1.0, 1e9) as u32
    }

    /// The model of one of `substeps`.
    pub fn cut(self, substeps: u32) -> Self {
        Self { dt_s: self.dt_s / f64::from(substeps), ..self }
    }

    /// Refuses what has no meaning, before anything runs.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn check(&self, disks: &[Disk]) -> Result<(), Invalid> {
        let dimensions = self.space.dimensions() as usize;
        let size = &self.size_m.to_array()[..dimensions];
        let is_box = size.iter().all(|s| (1e-6..=1e6).contains(s));
        hold(is_box, "size_m", self.size_m, "1e-6 to 1e6 along each axis")?;
        hold(self.dt_s > 0.0 && self.dt_s <= 1e3, "dt_s", self.dt_s, "more than 0, at most 1000 s")?;
        let is_flat = self.space == Space::Flat;
        let pull = self.gravity_mps2;
        let is_pull = pull.is_finite() && pull.abs().max_element() < 1e9 && !(is_flat && pull.z != 0.0);
        let flat = if is_flat { ", and 0 along z of a flat box" } else { "" };
        hold(is_pull, "gravity_mps2", pull, format!("below 1e9 along each axis{flat}"))?;
        if let Response::Matching { rounds, .. } = self.response {
            hold((1..=64).contains(&rounds), "rounds", rounds, "1 to 64")?;
        }
        hold((1..=1 << 26).contains(&disks.len()), "disks", disks.len(), "1 to 2^26")?;
        let narrowest = size.iter().copied().fold(f64::INFINITY, f64::min);
        // Of a place in f32 the box is seven digits.
        let least = size.iter().copied().fold(0.0, f64::max) / 1e7;
        let widest = match self.borders {
            Borders::Walls => 0.5 * narrowest,
            Borders::Periodic => 0.25 * narrowest, // nearer than half a box, a disk has one image only
        };
        for (i, disk) in disks.iter().enumerate() {
            let bad = |key, value: &dyn fmt::Display, allowed: &str| {
                hold(false, key, format!("{value} of disk {i}"), allowed) // a text for each would take seconds
            };
            if !(disk.radius_m >= least && disk.radius_m <= widest) {
                let allowed = format!("{least:e} to {widest} m in this box");
                return bad("radius_m", &disk.radius_m, &allowed);
            }
            let at = &disk.at_m.to_array()[..dimensions];
            if !at.iter().zip(size).all(|(x, s)| (0.0..=*s).contains(x)) {
                return bad("at_m", &disk.at_m, "in the box");
            }
            let velocity = disk.velocity_mps;
            if !(velocity.is_finite() && velocity.abs().max_element() < 1e9) {
                return bad("velocity_mps", &velocity, "below 1e9 along each axis");
            }
            if is_flat && (disk.at_m.z != 0.0 || velocity.z != 0.0) {
                return bad("z", &format!("{} m, {} m/s", disk.at_m.z, velocity.z), "0 in a flat box");
            }
        }
        Ok(())
    }

    /// From one point to another, the short way round.
    pub fn way(&self, from: DVec3, to: DVec3) -> DVec3 {
        let d = to - from;
        match self.borders {
            Borders::Walls => d,
            Borders::Periodic => {
                let mut turns = (d / self.size_m).round();
                if self.space == Space::Flat {
                    turns.z = 0.0;
                }
                d - self.size_m * turns
            }
        }
    }
}
