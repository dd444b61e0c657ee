// SPDX-License-Identifier: MIT OR Apache-2.0
//! When and where things fall into a water: a function of scene, seed and step alone, so a run can start anywhere and
//! does not depend on the frame rate.

use crate::{scene::WaterScene, water::Disturbance};
use glam::{vec2, Vec2};

/// What falls into one water.
pub struct Falls {
    scene: WaterScene,
    seed: u64,
    dt_s: f64,
}

impl Falls {
    /// `stream` tells the waters of a scene apart.
    pub fn new(scene: &WaterScene, seed: u64, stream: u64, dt_s: f64) -> Self {
        Self { scene: scene.clone(), seed: mix(seed ^ mix(stream)), dt_s }
    }

    /// What falls during step `step`: from `step dt` up to the next.
    pub fn at_step(&self, step: u64) -> Vec<Disturbance> {
        let mut list = Vec::new();
        let (from_s, to_s) = (step as f64 * self.dt_s, (step + 1) as f64 * self.dt_s);
        let corner = 0.5 * Vec2::from(self.scene.size_m);
        for drop in &self.scene.drops {
            // The first fall that may be due; one more or less is sorted out by its time.
            let guess =
                drop.every_s.map_or(0.0, |every| ((from_s - drop.start_s) / every).floor() - 1.0).max(0.0);
            for n in guess as u32..(guess as u32).saturating_add(u32::MAX) {
                let Some(time_s) = drop.time_s(n).filter(|&time_s| time_s < to_s) else { break };
                if time_s >= from_s {
                    list.push(Disturbance {
                        at_m: Vec2::from(drop.at_m) + corner,
                        radius_m: drop.radius_m,
                        volume_m3: drop.volume_m3,
                        push_m3ps: drop.push_m3ps,
                        ..Disturbance::default()
                    });
                }
            }
        }
        for source in &self.scene.sources {
            // As much of the step as it runs.
            let runs_s = to_s.min(source.end_s.unwrap_or(f64::MAX)) - from_s.max(source.start_s);
            if runs_s > 0.0 {
                list.push(Disturbance {
                    at_m: Vec2::from(source.at_m) + corner,
                    radius_m: source.radius_m,
                    volume_m3: (source.rate_m3ps * runs_s) as f32,
                    ..Disturbance::default()
                });
            }
        }
        if let Some(rain) = self.scene.rain.as_ref().filter(|rain| rain.drops_per_s > 0.0) {
            // Drop n falls at time n / rate: their number in a time is exact, whatever the step.
            let first = (from_s * rain.drops_per_s).ceil() as u64;
            let end = (to_s * rain.drops_per_s).ceil() as u64;
            list.extend((first..end).map(|serial| Disturbance {
                at_m: vec2(self.random(serial, 0), self.random(serial, 1)) * Vec2::from(self.scene.size_m),
                radius_m: rain.radius_m,
                volume_m3: rain.volume_m3,
                push_m3ps: rain.push_m3ps,
                ..Disturbance::default()
            }));
        }
        list
    }

    /// 0 to 1, of (seed, serial, what for).
    fn random(&self, serial: u64, purpose: u64) -> f32 {
        let bits = mix(self.seed ^ mix(2 * serial + purpose));
        (bits >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// Finalizer of SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014).
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
