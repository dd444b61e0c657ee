// SPDX-License-Identifier: MIT OR Apache-2.0
//! The passes of a step, flat and solid: their shaders, what they bind, and the constants that they are built with.

use super::{Response, Space};
use crate::shaders;
use std::ffi::CStr;

/// A kernel of disks and its twin for spheres.
pub struct Pass {
    pub names: [&'static CStr; 2],
    pub spv: [&'static [u8]; 2],
    pub blocks: &'static [&'static str],
    /// What follows the workgroup, by constant number from 1.
    constants: &'static [Constant],
}

#[derive(Clone, Copy)]
enum Constant {
    Periodic,
    HasLarge,
    Response,
    Rewinds,
    Measures,
}

use Constant::{HasLarge, Measures, Periodic, Rewinds};

/// What pipelines of one box have in common.
pub struct Constants {
    pub group: u32,
    pub periodic: bool,
    pub has_large: bool,
    pub measures: bool,
    pub response: Response,
}

impl Constants {
    /// Those of a pass, in their order.
    pub fn of(&self, pass: &Pass) -> Vec<u32> {
        let one = |constant: &Constant| match constant {
            Constant::Periodic => u32::from(self.periodic),
            Constant::HasLarge => u32::from(self.has_large),
            Constant::Measures => u32::from(self.measures),
            Constant::Rewinds => u32::from(matches!(self.response, Response::Matching { rewinds: true, .. })),
            // What `disks.travel` finishes of the step before.
            Constant::Response => match self.response {
                Response::Seed => 0,
                Response::GaussSeidel | Response::Xpbd { .. } => 1,
                Response::Matching { .. } => 2,
            },
        };
        std::iter::once(self.group).chain(pass.constants.iter().map(one)).collect()
    }
}

/// The passes that let contacts respond, in the order of [`super::Sorted`]'s kernels.
pub fn responding(space: Space, response: Response) -> &'static [&'static Pass] {
    match response {
        Response::Seed if space == Space::Flat => &[&CONTACTS],
        Response::Seed => &[&CONTACTS_SOLID],
        Response::GaussSeidel => &[&SWEEP],
        Response::Matching { .. } => &[&PROPOSE, &COLLIDE],
        Response::Xpbd { bounces } => match (space, bounces) {
            (Space::Flat, false) => &[&XPBD_PART, &XPBD_DERIVE],
            (Space::Flat, true) => &[&XPBD_PART, &XPBD_DERIVE, &XPBD_BOUNCE],
            (Space::Solid, false) => &[&XPBD_PART_SOLID, &XPBD_DERIVE],
            (Space::Solid, true) => &[&XPBD_PART_SOLID, &XPBD_DERIVE, &XPBD_BOUNCE],
        },
    }
}

pub const TRAVEL: Pass = Pass {
    names: [c"disks.travel", c"disks.travel_solid"],
    spv: [shaders::DISKS_TRAVEL_COMP, shaders::DISKS_TRAVEL_SOLID_COMP],
    blocks: &[
        "Place",
        "Motion",
        "Start",
        "Partner",
        "Wake",
        "NewPlace",
        "NewMotion",
        "Key",
        "Count",
        "Impulse",
    ],
    constants: &[Periodic, HasLarge, Constant::Response, Measures],
};

pub const SLOT: Pass = Pass {
    names: [c"disks.slot", c"disks.slot_solid"],
    spv: [shaders::DISKS_SLOT_COMP, shaders::DISKS_SLOT_SOLID_COMP],
    blocks: &["Key", "Start", "Slot"],
    constants: &[],
};

pub const GATHER: Pass = Pass {
    names: [c"disks.gather", c"disks.gather_solid"],
    spv: [shaders::DISKS_GATHER_COMP, shaders::DISKS_GATHER_SOLID_COMP],
    blocks: &["Slot", "Start", "NewPlace", "NewMotion", "Place", "Motion"],
    constants: &[],
};

const CONTACTS: Pass = Pass {
    names: [c"disks.contacts", c"disks.contacts_solid"],
    spv: [shaders::DISKS_CONTACTS_COMP, shaders::DISKS_CONTACTS_SOLID_COMP],
    blocks: &["Place", "Start", "Partner", "Hit"],
    constants: &[Periodic, HasLarge],
};

/// The ids of spheres are in their motion.
const CONTACTS_SOLID: Pass = Pass { blocks: &["Place", "Start", "Partner", "Hit", "Motion"], ..CONTACTS };

const PROPOSE: Pass = Pass {
    names: [c"disks.propose", c"disks.propose_solid"],
    spv: [shaders::DISKS_PROPOSE_COMP, shaders::DISKS_PROPOSE_SOLID_COMP],
    blocks: &["Place", "Motion", "Start", "Partner", "Wake"],
    constants: &[Periodic, HasLarge, Rewinds],
};

const COLLIDE: Pass = Pass {
    names: [c"disks.collide", c"disks.collide_solid"],
    spv: [shaders::DISKS_COLLIDE_COMP, shaders::DISKS_COLLIDE_SOLID_COMP],
    blocks: &["Place", "Motion", "Start", "Partner", "Wake", "Hit", "Impulse"],
    constants: &[Periodic, HasLarge, Rewinds, Measures],
};

const SWEEP: Pass = Pass {
    names: [c"disks.sweep", c"disks.sweep_solid"],
    spv: [shaders::DISKS_SWEEP_COMP, shaders::DISKS_SWEEP_SOLID_COMP],
    blocks: &["Place", "Motion", "Start", "Hit", "Impulse"],
    constants: &[Periodic, HasLarge, Measures],
};

const XPBD_PART: Pass = Pass {
    names: [c"disks.xpbd_part", c"disks.xpbd_part_solid"],
    spv: [shaders::DISKS_XPBD_PART_COMP, shaders::DISKS_XPBD_PART_SOLID_COMP],
    blocks: &["Place", "Start", "Hit", "Impulse"],
    constants: &[Periodic, HasLarge, Measures],
};

const XPBD_PART_SOLID: Pass = Pass { blocks: &["Place", "Start", "Hit", "Impulse", "Motion"], ..XPBD_PART };

const XPBD_DERIVE: Pass = Pass {
    names: [c"disks.xpbd_derive", c"disks.xpbd_derive_solid"],
    spv: [shaders::DISKS_XPBD_DERIVE_COMP, shaders::DISKS_XPBD_DERIVE_SOLID_COMP],
    blocks: &["Place", "NewPlace", "Motion", "NewMotion"],
    constants: &[Periodic],
};

const XPBD_BOUNCE: Pass = Pass {
    names: [c"disks.xpbd_bounce", c"disks.xpbd_bounce_solid"],
    spv: [shaders::DISKS_XPBD_BOUNCE_COMP, shaders::DISKS_XPBD_BOUNCE_SOLID_COMP],
    blocks: &["NewPlace", "NewMotion", "Start", "Motion", "Impulse"],
    constants: &[Periodic, HasLarge, Measures],
};
