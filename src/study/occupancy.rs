// SPDX-License-Identifier: MIT OR Apache-2.0
//! How many workgroups of a kernel a multiprocessor holds at once, estimated from what they need.
//!
//! With `w` warps of 32 invocations a workgroup, `r` registers an invocation and `s` bytes of shared memory a workgroup, on
//! NVIDIA's compute capability 9.0 (CUDA C++ Programming Guide, "Features and Technical Specifications"; the rounding is
//! that of the CUDA occupancy calculator):
//!
//! ```text
//! by warps      floor(64 / w), and 32 at most
//! by registers  a warp takes 32 r, rounded up to 256; each of four parts has 16384:
//!               floor(4 floor(16384 / warp) / w)
//! by shared     a group takes s + 1024, rounded up to 128; a multiprocessor has 233472: floor(233472 / group)
//! occupancy     the least of these, times w, of 64
//! ```
//!
//! It says how much is there to hide latency with, and no more: a kernel that is bound by memory is as fast at half of it,
//! if half has enough loads in flight.

/// What one multiprocessor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Multiprocessor {
    /// Whose, for people.
    pub name: &'static str,
    warps: u64,
    groups: u64,
    /// Of each part.
    registers: u64,
    parts: u64,
    register_unit: u64,
    shared_bytes: u64,
    shared_unit: u64,
    /// What the driver takes of each workgroup's.
    shared_reserved_bytes: u64,
}

/// Invocations of a warp.
const WARP: u64 = 32;

const COMPUTE_9_0: Multiprocessor = Multiprocessor {
    name: "NVIDIA compute capability 9.0",
    warps: 64,
    groups: 32,
    registers: 16_384,
    parts: 4,
    register_unit: 256,
    shared_bytes: 228 << 10,
    shared_unit: 128,
    shared_reserved_bytes: 1 << 10,
};

/// What a kernel needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// Invocations of a workgroup.
    pub invocations: u64,
    /// Registers of an invocation.
    pub registers: u64,
    /// Shared memory of a workgroup (bytes).
    pub shared_bytes: u64,
}

/// How full a multiprocessor can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occupancy {
    /// Workgroups on it at once.
    pub groups: u64,
    /// Their warps.
    pub warps: u64,
    /// Of all that there could be.
    pub share: f64,
    /// What there is no more of: `warps`, `groups`, `registers` or `shared`.
    pub limit: &'static str,
}

impl Multiprocessor {
    /// That of a device by its name, if it is known here: Vulkan does not tell.
    pub fn of(device: &str) -> Option<Self> {
        let words = |it: char| !it.is_ascii_alphanumeric();
        let is_known =
            device.split(words).any(|word| ["H100", "H200", "H800", "H20", "GH200"].contains(&word));
        (device.contains("NVIDIA") && is_known).then_some(COMPUTE_9_0)
    }

    /// `None` if not even one workgroup fits.
    pub fn occupancy(&self, needs: Needs) -> Option<Occupancy> {
        let warps = needs.invocations.div_ceil(WARP).max(1);
        let warp = (WARP * needs.registers).next_multiple_of(self.register_unit).max(self.register_unit);
        let group = (needs.shared_bytes + self.shared_reserved_bytes).next_multiple_of(self.shared_unit);
        // Of two limits that are alike, the first is named.
        let limits = [
            ("warps", self.warps / warps),
            ("groups", self.groups),
            ("registers", self.parts * (self.registers / warp) / warps),
            ("shared", self.shared_bytes / group),
        ];
        let (limit, groups) = limits.into_iter().min_by_key(|(_, groups)| *groups)?;
        let share = (groups * warps) as f64 / self.warps as f64;
        (groups > 0).then_some(Occupancy { groups, warps: groups * warps, share, limit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(invocations: u64, registers: u64, shared_bytes: u64) -> Occupancy {
        let needs = Needs { invocations, registers, shared_bytes };
        COMPUTE_9_0.occupancy(needs).expect("one workgroup fits")
    }

    /// By hand, from the formula of the module.
    #[test]
    fn occupancy_is_that_of_the_formula() {
        assert_eq!(of(256, 32, 0), Occupancy { groups: 8, warps: 64, share: 1.0, limit: "warps" });
        // 33 registers are 1056 a warp, rounded to 1280: 12 warps in each part, 48 in all.
        assert_eq!(of(256, 33, 0), Occupancy { groups: 6, warps: 48, share: 0.75, limit: "registers" });
        // 255 registers: 8192 a warp, 2 in each part.
        assert_eq!(of(64, 255, 0), Occupancy { groups: 4, warps: 8, share: 0.125, limit: "registers" });
        // 48 KiB and 1 KiB: 233472 / 50176 = 4.65.
        assert_eq!(of(128, 32, 48 << 10), Occupancy { groups: 4, warps: 16, share: 0.25, limit: "shared" });
        assert_eq!(of(32, 16, 0), Occupancy { groups: 32, warps: 32, share: 0.5, limit: "groups" });
        // A part of a warp takes a whole one.
        assert_eq!(of(33, 32, 0).warps, 64);
        let too_much = Needs { invocations: 1024, registers: 128, shared_bytes: 0 };
        assert_eq!(COMPUTE_9_0.occupancy(too_much), None, "2 x 4 warps of 32 that one group has");
    }

    #[test]
    fn only_devices_that_are_known_are_estimated() {
        for name in ["NVIDIA H100 80GB HBM3", "NVIDIA H200", "NVIDIA GH200 480GB"] {
            assert_eq!(Multiprocessor::of(name), Some(COMPUTE_9_0), "{name}");
        }
        for name in ["NVIDIA A100-SXM4-80GB", "llvmpipe (LLVM 15.0.6, 256 bits)", "NVIDIA GeForce GTX 1080"] {
            assert_eq!(Multiprocessor::of(name), None, "{name}");
        }
    }
}
