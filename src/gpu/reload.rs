// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shaders of this crate that have been compiled anew while it runs. A shader is known by the place of its SPIR-V in the
//! binary, which it has once; pipelines that are built from now on take what replaces it.

use super::Gpu;
use std::{
    borrow::Cow,
    collections::{BTreeMap, BTreeSet},
    sync::{Mutex, MutexGuard, PoisonError},
};

/// By the place of the SPIR-V in the binary.
pub type Replacements = BTreeMap<usize, Vec<u8>>;

/// Included by what is compiled at run time, before what the binary has.
static INCLUDES: Mutex<BTreeMap<String, String>> = Mutex::new(BTreeMap::new());

pub(super) fn include(files: BTreeMap<String, String>) {
    *INCLUDES.lock().unwrap_or_else(PoisonError::into_inner) = files;
}

pub(super) fn included(file: &str) -> Option<String> {
    INCLUDES.lock().unwrap_or_else(PoisonError::into_inner).get(file).cloned()
}

#[derive(Default)]
pub(super) struct Shaders(Mutex<(Replacements, BTreeSet<usize>)>);

impl Shaders {
    fn lock(&self) -> MutexGuard<'_, (Replacements, BTreeSet<usize>)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Gpu {
    /// What a pipeline is built from where `spv` is asked for.
    pub(super) fn current<'s>(&self, spv: &'s [u8]) -> Cow<'s, [u8]> {
        let mut shaders = self.0.shaders.lock();
        let place = spv.as_ptr() as usize;
        shaders.1.insert(place);
        shaders.0.get(&place).map_or(Cow::Borrowed(spv), |new| Cow::Owned(new.clone()))
    }

    /// Whether any pipeline of this device was built from `spv`, which is one of [`shaders::ALL`](crate::shaders::ALL).
    pub fn uses_shader(&self, spv: &'static [u8]) -> bool {
        self.0.shaders.lock().1.contains(&(spv.as_ptr() as usize))
    }

    /// Names of the shaders that [`Gpu::replace_shaders`] has replaced, as `water.book.comp`.
    pub fn edited_shaders(&self) -> Vec<String> {
        let shaders = self.0.shaders.lock();
        let is_replaced = |spv: &[u8]| shaders.0.contains_key(&(spv.as_ptr() as usize));
        let all = crate::shaders::ALL.iter();
        all.filter(|(_, spv)| is_replaced(spv)).map(|(name, _)| (*name).to_owned()).collect()
    }

    /// Pipelines that are built from now on take these, and the shaders of the binary for all others. Returns what was
    /// taken so far, to go back to.
    pub fn replace_shaders(&self, new: Replacements) -> Replacements {
        std::mem::replace(&mut self.0.shaders.lock().0, new)
    }
}
