// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles for simulations to collide with and to paint: read from glTF and OBJ files, or made; static, moved by keys, or
//! skinned.
//!
//! Every vertex hangs on up to four joints of a [`Rig`]. A static mesh has one joint that never moves, a rigid part one
//! that is a node of the file, a skin many; so there is one way to pose them all, [`cpu::pose`] and `mesh.pose` on the GPU.
//!
//! | kernel      | reads                       | writes                 | CPU twin      |
//! | ----------- | --------------------------- | ---------------------- | ------------- |
//! | `mesh.pose` | vertices at rest, matrices  | places and velocities  | [`cpu::pose`] |
//!
//! Left out: morph targets, materials, sparse accessors, compressed meshes. Files that need them are refused by name.

pub mod cpu;
#[cfg(feature = "tools")]
mod gltf;
mod meshes;
#[cfg(feature = "tools")]
mod obj;
mod posed;
mod rig;
pub mod shapes;
mod speed;
pub mod walls;

pub use meshes::{Body, Meshes, MeshesError, Part};
pub use posed::{Pose, PoseParams, Posed, VERTEX_WORDS};
pub use rig::{Curve, Joint, Node, Rig, Track, Value};
pub use speed::Extent;

use glam::{Vec2, Vec3};

/// Most vertices or triangles of a mesh: what an index of 32 bits times the words of a vertex can reach.
pub const MOST: usize = 1 << 24;
/// Most joints of a mesh.
pub const MOST_JOINTS: usize = 1 << 12;
/// Largest coordinate (m): beyond it an f32 knows no millimetres.
pub const FARTHEST_M: f32 = 1.0e5;

/// Triangles, and what moves them.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// For people.
    pub name: String,
    /// At rest (m).
    pub at_m: Vec<Vec3>,
    /// Unit, or zero where no triangle says which way.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, 0 to 1 and v down; empty if the mesh has none.
    pub uv: Vec<Vec2>,
    /// What each vertex hangs on.
    pub hold: Vec<Hold>,
    /// Corners, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// What moves the joints.
    pub rig: Rig,
}

/// The joints that a vertex hangs on, with weights that sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Joints of the [`Rig`].
    pub joints: [u16; 4],
    /// Shares.
    pub weights: [f32; 4],
}

impl Hold {
    /// The weights as the device has them: the last is what is left to 1.
    pub fn stored(&self) -> [f32; 4] {
        let [a, b, c, _] = self.weights;
        [a, b, c, (1.0 - (a + b + c)).max(0.0)]
    }

    /// All on one joint.
    pub fn on(joint: u16) -> Self {
        Self { joints: [joint, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] }
    }
}

/// A mesh that cannot be used: which, and why.
#[derive(Debug, thiserror::Error)]
#[error("{name}: {what}")]
pub struct MeshError {
    /// The file.
    pub name: String,
    /// What is wrong, and what is allowed.
    pub what: String,
}

impl Mesh {
    /// A mesh that does not move, with normals of its triangles.
    ///
    /// # Errors
    /// What [`Mesh::check`] finds.
    pub fn still(
        name: &str,
        at_m: Vec<Vec3>,
        uv: Vec<Vec2>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, MeshError> {
        let hold = vec![Hold::on(0); at_m.len()];
        let mut mesh =
            Self { name: name.into(), at_m, normals: Vec::new(), uv, hold, triangles, rig: Rig::still() };
        mesh.check()?;
        mesh.find_normals();
        Ok(mesh)
    }

    /// Reads `.glb`, `.gltf` or `.obj`; files that it refers to are looked for beside it, and nowhere else.
    ///
    /// # Errors
    /// What is wrong with the file, by name.
    #[cfg(feature = "tools")]
    pub fn read(path: &std::path::Path) -> Result<Self, MeshError> {
        let fail = |what: String| MeshError { name: path.display().to_string(), what };
        let bytes = std::fs::read(path).map_err(|error| fail(error.to_string()))?;
        let beside = |uri: &str| {
            let is_plain = std::path::Path::new(uri)
                .components()
                .all(|part| matches!(part, std::path::Component::Normal(_)));
            if !is_plain {
                return Err(format!("refers to `{uri}`; allowed are files beside it"));
            }
            let other = path.parent().unwrap_or(std::path::Path::new("")).join(uri);
            std::fs::read(&other).map_err(|error| format!("{}: {error}", other.display()))
        };
        Self::decode(&path.display().to_string(), &bytes, beside)
    }

    /// The same from memory; the ending of `name` says which format.
    ///
    /// # Errors
    /// What is wrong with the file, by name.
    #[cfg(feature = "tools")]
    pub fn decode(
        name: &str,
        bytes: &[u8],
        beside: impl Fn(&str) -> Result<Vec<u8>, String>,
    ) -> Result<Self, MeshError> {
        let fail = |what: String| MeshError { name: name.into(), what };
        let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending).to_lowercase();
        let mut mesh = match ending.as_str() {
            "glb" | "gltf" => gltf::decode(bytes, beside),
            "obj" => obj::decode(bytes),
            _ => Err(format!("its name ends in `.{ending}`; allowed are .glb, .gltf and .obj")),
        }
        .map_err(fail)?;
        mesh.name = name.into();
        mesh.check()?;
        if mesh.normals.is_empty() {
            mesh.find_normals();
        }
        Ok(mesh)
    }

    /// # Errors
    /// The first thing that is out of range: sizes that differ, a corner that is no vertex, a number that is not finite.
    pub fn check(&self) -> Result<(), MeshError> {
        let fail = |what: String| Err(MeshError { name: self.name.clone(), what });
        let vertices = self.at_m.len();
        for (what, count, most) in [
            ("vertices", vertices, MOST),
            ("triangles", self.triangles.len(), MOST),
            ("joints", self.rig.joints.len(), MOST_JOINTS),
        ] {
            if count == 0 || count > most {
                return fail(format!("{count} {what}; allowed: 1 to {most}"));
            }
        }
        let sizes = [("normals", self.normals.len()), ("texture coordinates", self.uv.len())];
        for (what, count) in sizes {
            if count != 0 && count != vertices {
                return fail(format!("{count} {what} for {vertices} vertices"));
            }
        }
        if self.hold.len() != vertices {
            return fail(format!("{} joint weights for {vertices} vertices", self.hold.len()));
        }
        if let Some(i) =
            self.at_m.iter().position(|at| !at.is_finite() || at.abs().max_element() > FARTHEST_M)
        {
            return fail(format!("vertex {i} is at {}; allowed: within {FARTHEST_M} m", self.at_m[i]));
        }
        let numbers =
            self.normals.iter().map(|n| n.is_finite()).chain(self.uv.iter().map(|uv| uv.is_finite()));
        if let Some(i) = numbers.into_iter().position(|is_finite| !is_finite) {
            return fail(format!("vertex {}: a normal or texture coordinate is not finite", i % vertices));
        }
        if let Some(i) =
            self.triangles.iter().position(|corners| corners.iter().any(|&c| c as usize >= vertices))
        {
            return fail(format!(
                "triangle {i} is of {:?}; there are {vertices} vertices",
                self.triangles[i]
            ));
        }
        let joints = self.rig.joints.len();
        let holds = |hold: &Hold| {
            let sum: f32 = hold.weights.iter().sum();
            hold.weights.iter().all(|w| *w >= 0.0)
                && (sum - 1.0).abs() < 1e-3
                && hold.joints.iter().all(|&joint| usize::from(joint) < joints)
        };
        if let Some(i) = self.hold.iter().position(|hold| !holds(hold)) {
            return fail(format!(
                "vertex {i}: {:?}; weights sum to 1 and there are {joints} joints",
                self.hold[i]
            ));
        }
        self.rig.check().or_else(fail)?;
        // Far out, or where numbers overflow: what it is between its keys included.
        let reach_m = self.extent(1.0).reach_m;
        let most_m = 2.0 * FARTHEST_M;
        if reach_m > most_m {
            return fail(format!(
                "its joints take it {reach_m} m from its origin; allowed: within {most_m} m"
            ));
        }
        Ok(())
    }

    /// Normals from triangles, weighted by area.
    pub fn find_normals(&mut self) {
        let mut sums = vec![Vec3::ZERO; self.at_m.len()];
        for corners in &self.triangles {
            let [a, b, c] = corners.map(|i| self.at_m[i as usize]);
            let normal = (b - a).cross(c - a);
            corners.iter().for_each(|&i| sums[i as usize] += normal);
        }
        self.normals = sums.into_iter().map(Vec3::normalize_or_zero).collect();
    }

    /// Smallest box of the mesh at rest (m).
    pub fn bounds_m(&self) -> (Vec3, Vec3) {
        self.at_m.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), at| (lo.min(*at), hi.max(*at)))
    }

    /// `self` and `other` as one mesh, each with its own rig's joints.
    pub fn with(mut self, other: &Self) -> Self {
        let (vertices, joints) = (self.at_m.len() as u32, self.rig.joints.len() as u16);
        if self.uv.is_empty() != other.uv.is_empty() {
            self.uv.resize(self.at_m.len(), Vec2::ZERO);
        }
        self.at_m.extend(&other.at_m);
        self.normals.extend(&other.normals);
        self.uv.extend(&other.uv);
        self.uv.resize(if self.uv.is_empty() { 0 } else { self.at_m.len() }, Vec2::ZERO);
        self.hold
            .extend(other.hold.iter().map(|hold| Hold { joints: hold.joints.map(|j| j + joints), ..*hold }));
        self.triangles.extend(other.triangles.iter().map(|corners| corners.map(|c| c + vertices)));
        self.rig.append(&other.rig);
        self
    }
}
