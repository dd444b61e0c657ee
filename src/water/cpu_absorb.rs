// SPDX-License-Identifier: MIT OR Apache-2.0
//! CPU twin of `glsl/water/absorb.comp`: see [`cpu`](super::cpu).

use super::{absorb, cpu::Real, Borders, Model, LAND_M};

/// Twin of `glsl/water/absorb.comp`: what follows a step of one of the other twins.
pub fn absorb<T: Real>(model: &Model, borders: &Borders, height_m: &mut [T], velocity_mps: &mut [T]) {
    let keep: Vec<T> = absorb::keep(model, borders.strip).into_iter().map(T::of).collect();
    let [width, height] = model.cells.to_array().map(|n| n as usize);
    let one = T::of(1.0);
    let kept = |from_border: usize, side: bool| match keep.get(from_border) {
        Some(&keep) if side => keep,
        _ => one,
    };
    for y in 0..height {
        for x in 0..width {
            let i = y * width + x;
            let e = (kept(x, borders.west) * kept(width - 1 - x, borders.east))
                * (kept(y, borders.north) * kept(height - 1 - y, borders.south));
            if e == one || height_m[i] == T::of(f64::from(LAND_M)) {
                continue;
            }
            let slower = e * velocity_mps[i];
            height_m[i] = height_m[i] - T::of(model.dt_s) * (velocity_mps[i] - slower);
            velocity_mps[i] = slower;
        }
    }
}
