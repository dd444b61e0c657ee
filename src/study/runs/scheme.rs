// SPDX-License-Identifier: MIT OR Apache-2.0
//! Water kernels by the names that results have for them.

use crate::{
    gpu::Gpu,
    water::{FusedTuning, Invalid, Model, Tuning, Walls},
};
use glam::UVec2;

/// A water kernel and its options, as results name them: `book`, or `waves/w0.25` with `/land` or `/coast` if it looks for
/// land, everywhere or in a few places, and
/// `/fused` if it takes several steps a dispatch and `/f16` if it stores halves, or `waves/fourth`, with `/land` too, or
/// `pipes` with the options of `waves/w0.25` but `/f16`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// The kernel is `water.book`, else `water.waves` or `water.fourth`.
    pub is_book: bool,
    /// The kernel is `water.fourth`.
    pub is_fourth: bool,
    /// Weight of a diagonal pipe.
    pub diagonal: f64,
    /// The kernel is built to look for land.
    pub has_land: bool,
    /// The kernel is `water.fused` or `water.pipes_fused`.
    pub is_fused: bool,
    /// The kernel is `water.pipes` or `water.pipes_fused`.
    pub is_pipes: bool,
    /// The kernel is `water.waves_f16` or `water.fused_f16`.
    pub is_f16: bool,
}

impl Scheme {
    /// The scheme that a variant names; options that are no part of a scheme are passed over.
    ///
    /// # Panics
    /// If it names none: variants are written in tables of this crate.
    pub fn named(variant: &str) -> Self {
        let kernel = variant.split('/').next().unwrap_or_default();
        let has = |wanted: &str| variant.split('/').any(|option| option == wanted);
        let (is_book, is_pipes, is_fourth) = (kernel == "book", kernel == "pipes", has("fourth"));
        let weight = variant.split('/').find_map(|option| option.strip_prefix('w')?.parse().ok());
        let weight = weight.or(is_book.then_some(1.0)).or(is_fourth.then_some(0.25));
        let diagonal = weight.unwrap_or_else(|| panic!("`{variant}` names no scheme"));
        let (has_land, is_fused, is_f16) = (has("land") || has("coast"), has("fused"), has("f16"));
        Self { is_book, is_fourth, diagonal, has_land, is_fused, is_pipes, is_f16 }
    }

    /// Read once and written once by a dispatch, for each column.
    pub fn bytes_a_column(self) -> f64 {
        match (self.is_book, self.is_pipes, self.diagonal > 0.0) {
            (false, false, _) if self.is_f16 => 8.0,
            (false, false, _) => 16.0,
            (false, true, false) => 24.0,
            _ => 40.0,
        }
    }

    /// Courant number of the longest stable step of `model`.
    pub fn courant_limit(self, model: &Model) -> f64 {
        if self.is_fourth {
            model.fourth_order_limit()
        } else {
            model.courant_limit()
        }
    }

    /// # Errors
    /// The first parameter of `model` that the scheme does not take.
    pub fn check(self, model: &Model) -> std::result::Result<(), Invalid> {
        if self.is_fourth {
            model.check_fourth_order()
        } else {
            model.check()
        }
    }

    /// `model` with the stencil and the walls of the scheme.
    pub fn model(self, model: Model) -> Model {
        let walls = if self.is_book { Walls::Dropped } else { Walls::Folded };
        Model { diagonal: self.diagonal, walls, ..model }
    }
}

/// The constants of the book at 60 frames a second, in cells and seconds: `sqrt(0.3 * 60)` cells a second, and 0.9995 of
/// the flow kept a frame.
pub fn book_constants(cells: UVec2) -> Model {
    Model {
        cells,
        cell_m: 1.0,
        speed_mps: 18f64.sqrt(),
        damping_per_s: -60.0 * 0.9995f64.ln(),
        diagonal: 1.0,
        walls: Walls::Dropped,
        dt_s: 1.0 / 60.0,
    }
}

/// How each kernel cuts up the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tunings {
    /// Of `water.waves`, `water.fourth` and `water.pipes`.
    pub waves: Tuning,
    /// Of `water.fused`.
    pub fused: FusedTuning,
    /// Of `water.pipes_fused`.
    pub pipes: FusedTuning,
    /// Of `wet` and `shallow`; `None` is what each likes.
    pub depth: Option<Tuning>,
}

impl Tunings {
    /// What the device likes.
    pub fn for_grid(gpu: &Gpu, cells: UVec2) -> Self {
        Self {
            waves: Tuning::for_grid(gpu, cells),
            fused: FusedTuning::for_grid(gpu, cells),
            pipes: FusedTuning::for_pipes(gpu, cells),
            depth: None,
        }
    }

    /// Steps that a dispatch takes.
    pub fn steps(&self, scheme: Scheme) -> u32 {
        match (scheme.is_fused, scheme.is_pipes) {
            (false, _) => 1,
            (true, false) => self.fused.steps,
            (true, true) => self.pipes.steps,
        }
    }
}
