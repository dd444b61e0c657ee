// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipeline cache, kept in a file between runs. Losing it costs time, never an error.

use super::{adapter::Adapter, error::OrCall, Result};
use ash::vk;
use std::{
    fs,
    path::PathBuf,
    process,
    sync::atomic::{AtomicBool, Ordering},
};

pub(super) struct PipelineCache {
    pub raw: vk::PipelineCache,
    file: Option<PathBuf>,
    device: ash::Device,
    /// Something was compiled since the file was read.
    pub is_stale: AtomicBool,
}

impl PipelineCache {
    /// `folder` is made when the cache is first written.
    pub fn open(device: &ash::Device, adapter: &Adapter, folder: Option<PathBuf>) -> Result<Self> {
        // The driver refuses data of another driver by the UUID in its header; one file a device keeps them apart.
        let file = folder.map(|folder| folder.join(format!("pipelines-{}.bin", adapter.uuid)));
        // Drivers check the header of what they are given, not the rest: a damaged file must not reach them.
        let old = file.as_ref().and_then(|path| fs::read(path).ok()).unwrap_or_default();
        let old = match old.split_first_chunk::<8>() {
            Some((sum, data)) if *sum == checksum(data) => data.to_vec(),
            _ => Vec::new(),
        };
        let create = |data: &[u8]| {
            let info = vk::PipelineCacheCreateInfo::default().initial_data(data);
            unsafe { device.create_pipeline_cache(&info, None) }
        };
        let raw = create(&old).or_else(|_| create(&[])).or_call("vkCreatePipelineCache")?;
        Ok(Self { raw, file, device: device.clone(), is_stale: AtomicBool::new(false) })
    }

    /// Writes beside the file and renames, so that a reader never sees half of it.
    pub fn save(&self, device: &ash::Device) {
        let Some(file) = self.file.as_ref().filter(|_| self.is_stale.swap(false, Ordering::Relaxed)) else {
            return;
        };
        let Ok(data) = (unsafe { device.get_pipeline_cache_data(self.raw) }) else { return };
        let beside = file.with_extension(format!("{}.tmp", process::id()));
        let written = file.parent().is_some_and(|folder| fs::create_dir_all(folder).is_ok())
            && fs::write(&beside, [&checksum(&data)[..], &data].concat()).is_ok()
            && fs::rename(&beside, file).is_ok();
        if !written {
            let _ = fs::remove_file(&beside);
        }
    }
}

/// FNV-1a, 64 bits.
fn checksum(data: &[u8]) -> [u8; 8] {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
    data.iter().fold(0xcbf2_9ce4_8422_2325, step).to_le_bytes()
}

impl Drop for PipelineCache {
    fn drop(&mut self) {
        self.save(&self.device);
        unsafe { self.device.destroy_pipeline_cache(self.raw, None) }
    }
}
