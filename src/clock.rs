// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frames of any length in, steps of one length out. A leapfrog whose step follows the frame rate gains energy, so the
//! step stays and the number of steps varies.

/// Fixed-step clock. Time is kept in whole units of 2^-80 s, of which every frame and step above 10 ns is a multiple:
/// sums are exact, and at any moment `simulated + lost + pending` is the sum of the frames to the last bit.
#[derive(Clone, Debug, PartialEq)]
pub struct FixedStep {
    dt_s: f64,
    dt: i128,
    max_steps_per_frame: u32,
    pending: i128,
    steps: u64,
    lost_steps: u64,
    refused: u64,
}

/// What a frame asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Advance {
    /// Steps to take now.
    pub steps: u32,
    /// Time that will not be simulated: the steps beyond the cap (s).
    pub lost_s: f64,
}

/// Units in a second.
const UNITS: f64 = (1u128 << 80) as f64;
/// Longest frame that is believed (s), about a year: sums stay far from overflow.
const LONGEST_FRAME_S: f64 = 3e7;

fn units(seconds: f64) -> i128 {
    (seconds * UNITS) as i128 // a power of two: exact
}

fn seconds(units: i128) -> f64 {
    units as f64 / UNITS
}

impl FixedStep {
    /// Shortest step (s).
    pub const SHORTEST_S: f64 = 1e-6;
    /// Longest step (s).
    pub const LONGEST_S: f64 = LONGEST_FRAME_S;

    /// Steps of `dt_s` (s). Of a frame longer than `max_steps_per_frame` steps the rest is lost, and reported:
    /// `u32::MAX` loses nothing, however long it takes to catch up.
    ///
    /// # Panics
    /// If `dt_s` is not between 1 us and a year, or no step is allowed.
    pub fn new(dt_s: f64, max_steps_per_frame: u32) -> Self {
        assert!((Self::SHORTEST_S..=LONGEST_FRAME_S).contains(&dt_s), "a step of {dt_s} s");
        assert!(max_steps_per_frame > 0, "no step in any frame");
        let dt = units(dt_s);
        Self { dt_s, dt, max_steps_per_frame, pending: 0, steps: 0, lost_steps: 0, refused: 0 }
    }

    /// A frame of `frame_s` (s) has passed. One that is negative, not finite or longer than a year is counted in
    /// [`FixedStep::refused`] and asks for nothing.
    pub fn advance(&mut self, frame_s: f64) -> Advance {
        if !(0.0..=LONGEST_FRAME_S).contains(&frame_s) {
            self.refused += 1;
            return Advance::default();
        }
        self.pending += units(frame_s);
        // A frame that is a step long but for its rounding takes the step, not the next frame two: a millionth is lent.
        let due = (self.pending + (self.dt >> 20)) / self.dt;
        self.pending -= due * self.dt;
        let due = due as u64; // at most a year of microseconds
        let steps = due.min(u64::from(self.max_steps_per_frame));
        self.steps += steps;
        self.lost_steps += due - steps;
        Advance { steps: steps as u32, lost_s: (due - steps) as f64 * self.dt_s }
    }

    /// The step (s).
    pub fn dt_s(&self) -> f64 {
        self.dt_s
    }

    /// The cap.
    pub fn max_steps_per_frame(&self) -> u32 {
        self.max_steps_per_frame
    }

    /// Steps asked for so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Time simulated so far: a product, not a sum, so it is as good after a day as at the start (s).
    pub fn simulated_s(&self) -> f64 {
        self.steps as f64 * self.dt_s
    }

    /// Time lost to the cap so far (s).
    pub fn lost_s(&self) -> f64 {
        self.lost_steps as f64 * self.dt_s
    }

    /// Time that waits for the next step (s): below zero by up to a millionth of a step where it was lent.
    pub fn pending_s(&self) -> f64 {
        seconds(self.pending)
    }

    /// How far the present is from the last step to the next, 0 to 1, for interpolation.
    pub fn fraction(&self) -> f64 {
        (self.pending_s() / self.dt_s).clamp(0.0, 1.0)
    }

    /// Frames whose time was no time.
    pub fn refused(&self) -> u64 {
        self.refused
    }
}
