// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hard cases of water.

mod accuracy;
mod depth;
mod input;
mod stability;
mod time;

pub use depth::CASES as DEPTH_CASES;

pub(in crate::study) use accuracy::{from_twin, ROUNDING};

use super::Case;

const BOTH: &[&str] = &["book", "waves/w0.25"];
const STENCILS: &[&str] = &["waves/w0", "waves/w0.25", "waves/w1"];

/// The table.
pub const CASES: &[Case] = &[
    Case {
        id: "W1",
        title: "a flat lake keeps its water for 1e5 steps, and stays flat to 2 ulp",
        variants: BOTH,
        unit: "of the volume",
        limit: 1e-6,
        run: stability::flat_lake,
    },
    Case {
        id: "W2",
        title: "a wave has one period at 20, 60, 144 and 1000 frames a second",
        variants: BOTH,
        unit: "spread of the periods / mean",
        limit: 1e-3,
        run: time::one_period,
    },
    Case {
        id: "W3",
        title: "a wave has one half-life at 30, 144 and 1000 frames a second",
        variants: BOTH,
        unit: "spread of the half-lives / mean",
        limit: 5e-3,
        run: time::one_half_life,
    },
    Case {
        id: "W4",
        title: "noise does not grow at 0.99 of the longest step, and 1.01 is refused",
        variants: &["book", "waves/w0", "waves/w0.25", "waves/w1"],
        unit: "growth per step",
        limit: 1.0,
        run: stability::longest_step,
    },
    Case {
        id: "W5",
        title: "the averaged flow of equation 12.5 blows up in a twin, the new flow does not",
        variants: &["book"],
        unit: "rms of the start after 3600 steps",
        limit: 1.0,
        run: stability::averaged_flow,
    },
    Case {
        id: "W6",
        title: "a hitch of 0.5 s that is caught up leaves no trace",
        variants: BOTH,
        unit: "difference / highest wave",
        limit: 1e-5,
        run: time::hitch_caught_up,
    },
    Case {
        id: "W6",
        title: "of a hitch of 0.5 s, what 8 steps do not catch up is reported",
        variants: &["book/cap8", "waves/w0.25/cap8"],
        unit: "s lost and not reported",
        limit: 1e-12,
        run: time::hitch_capped,
    },
    Case {
        id: "W7",
        title: "frames of 50 to 150 % leave the energy alone, to 1e-6 in 1e4 steps",
        variants: &["waves/w0.25", "waves/w1"],
        unit: "of the energy per step",
        limit: 1e-10,
        run: time::jitter,
    },
    Case {
        id: "W11",
        title: "waves of 8 cells run as fast along the diagonal as along the axis",
        variants: &["waves/w0.25"],
        unit: "speed at 45 degrees / speed at 0, less 1",
        limit: 1e-3,
        run: accuracy::isotropy,
    },
    Case {
        id: "W12",
        title: "a wave along a wall is of second order in its frequency, 16 to 128 cells",
        variants: STENCILS,
        unit: "distance of the order from 2",
        limit: 0.1,
        run: accuracy::order_along_wall,
    },
    Case {
        id: "W12",
        title: "a wave along a wall keeps its shape, 16 to 128 cells",
        variants: STENCILS,
        unit: "residual / amplitude",
        limit: 1e-5,
        run: accuracy::shape_along_wall,
    },
    Case {
        id: "W13",
        title: "a checkerboard does not grow",
        variants: &["book", "waves/w0", "waves/w0.25", "waves/w1"],
        unit: "largest amplitude / the start's",
        limit: 1.0,
        run: stability::checkerboard,
    },
    Case {
        id: "W16",
        title: "grids of 1 x 1, 1 x N, 2 x 2, 17 x 33, 255 x 257 and 1000 x 3 are their f64 twin",
        variants: &[
            "book",
            "waves/w0.25",
            "waves/w1",
            "waves/w0.25/land",
            "waves/fourth",
            "waves/fourth/land",
            "waves/fused/w0.25",
            "waves/fused/w0.25/land",
            "pipes/w0.25/land",
            "pipes/fused/w0",
            "pipes/fused/w0.25",
        ],
        unit: "difference / highest column",
        limit: ROUNDING,
        run: accuracy::odd_grids,
    },
    Case {
        id: "W17",
        title: "NaN, infinity and 1e30 are refused and counted, and change nothing",
        variants: BOTH,
        unit: "columns changed",
        limit: 0.0,
        run: input::absurd_sources,
    },
];
