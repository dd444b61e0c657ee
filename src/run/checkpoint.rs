// SPDX-License-Identifier: MIT OR Apache-2.0
//! The state of a run in a file: what has been simulated can be gone on with, bit for bit, after the process is gone.
//!
//! Layout, little-endian: `WCAPCHK1`, hash of what the scene simulates, number of the picture, number of waters, for each
//! its number of floats and the floats; last an FNV-1a hash of all before it.

use super::atomic::{failed, write_atomic, FileError};
use crate::scene::Scene;
use std::{fs, path::Path};

/// What a run can go on from.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// Hash of what the scene simulates; how it is looked at may change.
    pub scene: u64,
    /// The last picture that was made, from 0.
    pub picture: u32,
    /// Of every water: heights and velocities, or columns; then of every pool of particles, of every box of disks and of
    /// the paint, words as they are.
    pub states: Vec<Vec<f32>>,
}

/// Why a file is no checkpoint of this run.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// It cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// It is damaged, or something else.
    #[error("{path}: not a checkpoint, or a damaged one: {why}")]
    Damaged {
        /// The file.
        path: String,
        /// What does not fit.
        why: &'static str,
    },
    /// There is nothing left to do.
    #[error(
        "{path}: its {pictures} pictures are all that the scene asks for; more need a larger output.frames"
    )]
    Complete {
        /// The file.
        path: String,
        /// Made so far.
        pictures: u32,
    },
    /// It is of another scene.
    #[error("{path}: of another scene: waters, emitters, terrain, seed, fps and steps must be the same (pictures and camera may differ)")]
    OtherScene {
        /// The file.
        path: String,
    },
}

const MAGIC: &[u8; 8] = b"WCAPCHK1";

/// FNV-1a, 64 bits.
pub(super) fn fnv(bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// Hash of everything in `scene` that the state depends on.
pub fn scene_hash(scene: &Scene) -> u64 {
    let thrown = (&scene.emitters, &scene.attractors);
    let room = (&scene.meshes, &scene.volume, &scene.paint);
    let simulated = (scene.seed, scene.output.fps, &scene.terrain, &scene.water, thrown, &scene.disks, room);
    fnv(serde_json::to_vec(&simulated).expect("a scene is plain data"))
}

impl Checkpoint {
    /// Writes the whole file or leaves the old one.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(self.scene.to_le_bytes());
        bytes.extend(self.picture.to_le_bytes());
        bytes.extend((self.states.len() as u32).to_le_bytes());
        for state in &self.states {
            bytes.extend((state.len() as u64).to_le_bytes());
            bytes.extend(state.iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes.extend(fnv(bytes.iter().copied()).to_le_bytes());
        write_atomic(path, |file| file.write_all(&bytes))
    }

    /// Reads a checkpoint of `scene`.
    ///
    /// # Errors
    /// [`CheckpointError`] says what is wrong with the file.
    pub fn read(path: &Path, scene: &Scene) -> Result<Self, CheckpointError> {
        let name = || path.display().to_string();
        let bytes = fs::read(path).map_err(failed(path, "read the checkpoint"))?;
        let damaged = |why| CheckpointError::Damaged { path: name(), why };
        let (body, sum) = bytes.split_last_chunk::<8>().ok_or_else(|| damaged("it is too short"))?;
        if !body.starts_with(MAGIC) {
            return Err(damaged("it begins with something else"));
        }
        if fnv(body.iter().copied()) != u64::from_le_bytes(*sum) {
            return Err(damaged("its checksum does not fit"));
        }
        let found = Self::parse(&body[MAGIC.len()..]).ok_or_else(|| damaged("its parts do not add up"))?;
        if found.scene != scene_hash(scene)
            || found.states.len()
                != scene.water.len() + scene.pools() + scene.disks.len() + usize::from(scene.paint.is_some())
        {
            return Err(CheckpointError::OtherScene { path: name() });
        }
        Ok(found)
    }

    fn parse(mut rest: &[u8]) -> Option<Self> {
        let scene = u64::from_le_bytes(take(&mut rest)?);
        let picture = u32::from_le_bytes(take(&mut rest)?);
        let count = u32::from_le_bytes(take(&mut rest)?);
        let mut states = Vec::new();
        for _ in 0..count {
            let floats = usize::try_from(u64::from_le_bytes(take(&mut rest)?)).ok()?;
            let (now, later) = rest.split_at_checked(floats.checked_mul(4)?)?;
            states.push(bytemuck::allocation::pod_collect_to_vec(now));
            rest = later;
        }
        rest.is_empty().then_some(Self { scene, picture, states })
    }
}

fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (now, later) = rest.split_first_chunk::<N>()?;
    *rest = later;
    Some(*now)
}
