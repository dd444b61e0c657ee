// SPDX-License-Identifier: MIT OR Apache-2.0
//! The GPU's clock on the host's time line (VK_KHR_calibrated_timestamps, or its EXT forerunner).
//!
//! The device's counter is read between two readings of the host's clock, several times, and the tightest pair counts:
//! half its width is the uncertainty. That needs no clock in common with the driver, so it is the same on every system.

use super::{device::Gpu, Adapter};
use ash::{ext, khr, vk};
use std::{
    ffi::CStr,
    time::{Duration, Instant},
};

/// Readings, of which the tightest counts: the first may page things in.
const READINGS: usize = 4;

/// How the times of a submission's spans are placed on the host's time line, the most certain first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Placed {
    /// They are the host's: it waited for a fence at both ends of every span.
    #[default]
    Host,
    /// By calibrated timestamps.
    Calibrated {
        /// As far as they may be off (ns).
        within_ns: u64,
    },
    /// The last span ends where the host saw the fence: late by what that took.
    End,
}

impl Placed {
    /// As results name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Host => "host",
            Self::Calibrated { .. } => "calibrated",
            Self::End => "end of submission",
        }
    }
}

/// The extension that the device has for it.
pub(super) fn extension(has: impl Fn(&CStr) -> bool) -> Option<&'static CStr> {
    [khr::calibrated_timestamps::NAME, ext::calibrated_timestamps::NAME].into_iter().find(|name| has(name))
}

/// Its one function, the same in both.
#[derive(Clone, Copy)]
pub(super) struct Calibrated(vk::PFN_vkGetCalibratedTimestampsKHR);

/// What the device's counter was at a moment of the host.
#[derive(Clone, Copy)]
struct Anchor {
    ticks: u64,
    at: Instant,
    within: Duration,
}

impl Calibrated {
    pub fn load(instance: &ash::Instance, device: &ash::Device, adapter: &Adapter) -> Option<Self> {
        let name = adapter.calibration?;
        Some(Self(if name == khr::calibrated_timestamps::NAME {
            khr::calibrated_timestamps::Device::new(instance, device).fp().get_calibrated_timestamps_khr
        } else {
            ext::calibrated_timestamps::Device::new(instance, device).fp().get_calibrated_timestamps_ext
        }))
    }

    fn anchor(self, device: &ash::Device) -> Option<Anchor> {
        let info = vk::CalibratedTimestampInfoKHR::default().time_domain(vk::TimeDomainKHR::DEVICE);
        let read = |_| {
            let (mut ticks, mut deviation) = (0, 0);
            let before = Instant::now();
            // SAFETY: one domain and room for one reading; every device with the extension has the domain DEVICE.
            let code = unsafe { (self.0)(device.handle(), 1, &info, &mut ticks, &mut deviation) };
            let within = before.elapsed() / 2;
            (code == vk::Result::SUCCESS).then_some(Anchor { ticks, at: before + within, within })
        };
        (0..READINGS).filter_map(read).min_by_key(|anchor| anchor.within)
    }
}

/// Where the host was when each pair of `ticks` was taken, between `submitted` and `done`.
pub(super) fn place(
    gpu: &Gpu,
    ticks: &[[u64; 2]],
    (submitted, done): (Instant, Instant),
) -> (Vec<Instant>, Placed) {
    let Some(last) = ticks.last().map(|[_, end]| *end) else { return (Vec::new(), Placed::Host) };
    let bits = gpu.adapter().timestamp_bits.clamp(1, 64);
    let tick_ns = f64::from(gpu.limits().timestamp_period);
    // Only so many bits count, and they wrap: what is more than half a turn ahead is behind.
    let ns =
        |from: u64, to: u64| ((to.wrapping_sub(from) << (64 - bits)) as i64 >> (64 - bits)) as f64 * tick_ns;
    let by = |anchor: Anchor, placed| {
        let begin = |[begin, _]: &[u64; 2]| moved(anchor.at, ns(anchor.ticks, *begin));
        (ticks.iter().map(begin).collect(), placed)
    };
    let anchor = gpu.0.calibrated.and_then(|it| it.anchor(gpu.device())).filter(|anchor| {
        // A driver may count something else there than in its queries.
        let end = moved(anchor.at, ns(anchor.ticks, last));
        submitted <= end + anchor.within && end <= done + anchor.within
    });
    match anchor {
        Some(it) => by(it, Placed::Calibrated { within_ns: it.within.as_nanos() as u64 }),
        None => by(Anchor { ticks: last, at: done, within: Duration::ZERO }, Placed::End),
    }
}

fn moved(at: Instant, ns: f64) -> Instant {
    let by = Duration::from_nanos(ns.abs() as u64);
    if ns < 0.0 {
        at.checked_sub(by).unwrap_or(at)
    } else {
        at + by
    }
}
