// SPDX-License-Identifier: MIT OR Apache-2.0
//! Makes the terrains of the built-in scenes: `cargo run --release --example make_terrain` writes `fjord.png`, `pond.asc`,
//! `town.png` and `yard.png` in `scenes`, the same bits on every machine: integer hashes and f64 with nothing but + - * /
//! and sqrt, which IEEE 754 defines exactly.

use std::{fmt::Write, fs::File, io::BufWriter, path::Path};

/// Samples along a side of the fjord.
pub const FJORD_SIDE: usize = 513;
/// Extent of the fjord (m).
const FJORD_M: f64 = 192.0;
/// Heights of black and white of the fjord (m).
pub const FJORD_HEIGHT_M: [f64; 2] = [-6.0, 14.0];
/// Samples along a side of the pond.
const POND_SIDE: usize = 129;
/// Distance of the pond's samples (m).
const POND_CELL_M: f64 = 0.25;

/// Samples along x and z of the town's valley.
pub const TOWN_SAMPLES: [usize; 2] = [320, 208];
/// Distance of its samples (m).
const TOWN_CELL_M: f64 = 0.3;
/// Heights of its black and white (m).
const TOWN_HEIGHT_M: [f64; 2] = [-2.0, 14.0];
/// Samples along x and z of the yard.
pub const YARD_SAMPLES: [usize; 2] = [240, 160];
/// Distance of its samples (m).
const YARD_CELL_M: f64 = 0.05;
/// Heights of its black and white (m).
const YARD_HEIGHT_M: [f64; 2] = [0.0, 1.0];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let write =
        |name: &str, [width, height]: [usize; 2], grey: Vec<u16>| -> Result<(), Box<dyn std::error::Error>> {
            let file = BufWriter::new(File::create(scenes.join(name))?);
            let mut encoder = png::Encoder::new(file, width as u32, height as u32);
            encoder.set_color(png::ColorType::Grayscale);
            encoder.set_depth(png::BitDepth::Sixteen);
            encoder.set_compression(png::Compression::High);
            encoder.set_filter(png::Filter::Adaptive);
            let bytes: Vec<u8> = grey.into_iter().flat_map(u16::to_be_bytes).collect();
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&bytes)?;
            Ok(writer.finish()?)
        };
    write("fjord.png", [FJORD_SIDE; 2], fjord())?;
    write("town.png", TOWN_SAMPLES, town())?;
    write("yard.png", YARD_SAMPLES, yard())?;
    std::fs::write(scenes.join("pond.asc"), pond())?;
    Ok(())
}

/// Grey values of a height that is given in the middle of every cell of a rectangle round the origin.
fn grey(
    samples: [usize; 2],
    cell_m: f64,
    [black, white]: [f64; 2],
    height: impl Fn(f64, f64) -> f64,
) -> Vec<u16> {
    let at = |i: usize, n: usize| (i as f64 + 0.5 - n as f64 / 2.0) * cell_m;
    let [width, depth] = samples;
    let share = |i: usize| (height(at(i % width, width), at(i / width, depth)) - black) / (white - black);
    // In steps of 1/4096, a few millimetres, so that the file stays small.
    let step = |i: usize| (share(i).clamp(0.0, 1.0) * 4095.0 + 0.5) as u16;
    (0..width * depth).map(|i| step(i) << 4 | step(i) >> 8).collect()
}

/// The valley of `dam_break`: a reservoir's floor in the west, a town that slopes to a small lake in the east, and hills
/// all round.
pub fn town() -> Vec<u16> {
    grey(TOWN_SAMPLES, TOWN_CELL_M, TOWN_HEIGHT_M, |x, z| {
        let wx = x + 3.0 * fbm(x / 17.0, z / 17.0, 4, 41);
        let wz = z + 3.0 * fbm(x / 17.0, z / 17.0, 4, 42);
        let floor = mix(mix(1.7, 2.1, smooth(-30.0, -18.0, x)), 1.1, smooth(-10.0, 32.0, x));
        let lake = mix(floor, -1.4, smooth(1.0, 0.35, length((wx - 39.0) / 9.0, wz / 21.0)));
        let streets = lake + 0.16 * fbm(x / 5.0, z / 5.0, 4, 43);
        // The valley narrows to a gate where the dam is.
        let half = mix(25.0, 17.0, smooth(9.0, 0.0, (x + 18.0).abs()));
        let sides = smooth(0.0, 9.0, wz.abs() - half).max(smooth(0.0, 7.0, (wx - 0.5).abs() - 42.0));
        let hills = 5.5 + 6.5 * ridged(x / 24.0, z / 24.0, 5, 44) + 0.5 * fbm(x / 4.0, z / 4.0, 3, 45);
        mix(streets, streets.max(0.0) + hills, sides)
    })
}

/// The yard of `puddles`: trodden ground with hollows and two ruts.
pub fn yard() -> Vec<u16> {
    grey(YARD_SAMPLES, YARD_CELL_M, YARD_HEIGHT_M, |x, z| {
        let wx = x + 0.4 * fbm(x / 2.0, z / 2.0, 3, 51);
        let wz = z + 0.4 * fbm(x / 2.0, z / 2.0, 3, 52);
        let ground = 0.45 + 0.34 * fbm(wx / 3.4, wz / 3.4, 2, 53) + 0.035 * fbm(x / 0.7, z / 0.7, 4, 54);
        let across = wz - 0.9 - 0.22 * wx;
        let rut = |at: f64| 0.11 * smooth(0.34, 0.08, (across - at).abs());
        let bank = 0.35 * smooth(0.7, 1.05, (x.abs() / 6.0).max(z.abs() / 4.0));
        // A few stones lie about.
        let pebbles = 0.3 * stones(1.3 * x, 1.3 * z) * smooth(0.0, 0.35, fbm(x / 1.9, z / 1.9, 2, 55));
        ground + bank - rut(-0.75) - rut(0.75) + pebbles
    })
}

/// The grey values of the fjord: a lake without outlet, about 150 m × 110 m, among mountains.
pub fn fjord() -> Vec<u16> {
    /// Rocky islands: x, z, radius, height (m).
    const ISLANDS: [[f64; 4]; 6] = [
        [-16.0, 6.0, 10.0, 3.4],
        [-27.0, 12.0, 6.0, 2.0],
        [17.0, -11.0, 8.5, 2.8],
        [26.0, 13.0, 5.5, 1.7],
        [3.0, 21.0, 4.0, 1.3],
        [-8.0, -19.0, 5.0, 1.9],
    ];
    let mut land = Grid::new(FJORD_SIDE, FJORD_M / FJORD_SIDE as f64, |x, z| {
        // The warp bends the shore and the ridges, so that nothing shows the axes of the noise.
        let wx = x + 44.0 * fbm(x / 62.0, z / 62.0, 5, 1);
        let wz = z + 44.0 * fbm(x / 62.0, z / 62.0, 5, 2);
        let radius = length(wx / 66.0, wz / 50.0);
        let beyond = radius - 1.0;
        let bed = -4.6 + 0.7 * fbm(x / 16.0, z / 16.0, 4, 3);
        let slope = 1.2 + 14.5 * smooth(0.0, 0.8, beyond);
        let ridges = ridged(wx / 60.0, wz / 60.0, 7, 4);
        let mountains = slope * (0.1 + 1.1 * ridges) + 0.5 * fbm(x / 7.0, z / 7.0, 4, 5);
        let mut height = mix(bed, mountains - 1.0, smooth(-0.4, 0.16, beyond));
        for [cx, cz, size, top] in ISLANDS {
            let (dx, dz) =
                (x - cx + 2.4 * fbm(x / 7.0, z / 7.0, 3, 6), z - cz + 2.4 * fbm(x / 7.0, z / 7.0, 3, 7));
            let crag = ridged(x / 6.5, z / 6.5, 4, 8);
            let dome = 1.0 - length(dx, dz) / size;
            let rock = bed + (top * (0.15 + 1.5 * crag) - bed) * smooth(-0.75, 0.8, dome);
            height = smooth_max(height, rock, 0.5);
        }
        height
    });
    land.erode_by_rain(90_000, 11);
    land.erode_by_gravity(12, 1.05);
    land.flatten_beach(0.9);
    // Nowhere does the lake reach the border.
    let side = FJORD_SIDE;
    let [black, white] = FJORD_HEIGHT_M;
    let grey = |(i, height): (usize, &f64)| {
        let (column, row) = (i % side, i / side);
        let border = column.min(row).min(side - 1 - column).min(side - 1 - row);
        let dam = 2.0 - 0.25 * border as f64;
        let share = (height.max(dam) - black) / (white - black);
        (share.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16
    };
    land.height.iter().enumerate().map(grey).collect()
}

/// The pond as an ESRI ASCII grid: round, shallow, with stones along the shore and two islands.
pub fn pond() -> String {
    let mut land = Grid::new(POND_SIDE, POND_CELL_M, |x, z| {
        let wx = x + 1.4 * fbm(x / 6.0, z / 6.0, 3, 21);
        let wz = z + 1.4 * fbm(x / 6.0, z / 6.0, 3, 22);
        let beyond = length(wx, wz) - 10.5;
        let bowl = mix(-1.0, 1.3, smooth(-6.0, 6.5, beyond)) + 0.12 * fbm(x / 3.0, z / 3.0, 4, 23);
        let islands = [[-2.0, -3.2, 2.4, 1.75], [4.2, -0.4, 1.5, 1.4]]
            .map(|[cx, cz, size, top]| top * smooth(-0.5, 1.0, 1.0 - length(wx - cx, wz - cz) / size));
        let ground = bowl + islands[0].max(islands[1]);
        // Stones lie where the waves have washed the soil away.
        let shore = 1.0 - smooth(0.3, 1.0, (ground - 0.05).abs() / 0.75);
        ground + shore * stones(x, z)
    });
    land.erode_by_gravity(2, 1.4);
    let mut text = format!(
        "ncols {POND_SIDE}\nnrows {POND_SIDE}\nxllcorner 0\nyllcorner 0\ncellsize {POND_CELL_M}\nNODATA_value -9999\n"
    );
    for row in land.height.chunks(POND_SIDE) {
        // Centimetres as integers, so that the text is the same whatever formats it.
        let words = row.iter().map(|height| (height * 100.0 + 1000.5) as i64 - 1000);
        for (i, cm) in words.enumerate() {
            let sign = if cm < 0 { "-" } else { "" };
            let space = if i > 0 { " " } else { "" };
            write!(text, "{space}{sign}{}.{:02}", cm.abs() / 100, cm.abs() % 100)
                .expect("a String takes any text");
        }
        text.push('\n');
    }
    text
}

/// Half-buried round stones, at most one in a cell of 0.9 m.
fn stones(x: f64, z: f64) -> f64 {
    const CELL_M: f64 = 0.9;
    let (column, row) = ((x / CELL_M).floor() as i64, (z / CELL_M).floor() as i64);
    let mut height = 0.0_f64;
    for (i, j) in (-1..=1).flat_map(|j| (-1..=1).map(move |i| (column + i, row + j))) {
        let random = |salt| unit(hash(i, j, salt));
        let radius = 0.2 + 0.35 * random(31) * random(32);
        let (cx, cz) = ((i as f64 + random(33)) * CELL_M, (j as f64 + random(34)) * CELL_M);
        let inside = 1.0 - length(x - cx, z - cz) / radius;
        if random(35) < 0.75 && inside > 0.0 {
            height = height.max(0.75 * radius * (1.0 - (1.0 - inside) * (1.0 - inside)).sqrt());
        }
    }
    height
}

/// Heights of square cells (m).
struct Grid {
    side: usize,
    cell_m: f64,
    height: Vec<f64>,
}

impl Grid {
    /// Takes `height(x, z)` in the middle of every cell; the origin is the grid's middle (m).
    fn new(side: usize, cell_m: f64, height: impl Fn(f64, f64) -> f64) -> Self {
        let at = |i: usize| (i as f64 + 0.5 - side as f64 / 2.0) * cell_m;
        let height = (0..side * side).map(|i| height(at(i % side), at(i / side))).collect();
        Self { side, cell_m, height }
    }

    /// Height (m) and gradient at a point, in cells, not in the last row or column.
    fn sample(&self, x: f64, y: f64) -> (f64, f64, f64) {
        let (i, fx, fy) = (y as usize * self.side + x as usize, x.fract(), y.fract());
        let [a, b] = [self.height[i], self.height[i + 1]];
        let [c, d] = [self.height[i + self.side], self.height[i + self.side + 1]];
        (mix(mix(a, b, fx), mix(c, d, fx), fy), mix(b - a, d - c, fy), mix(c - a, d - b, fx))
    }

    /// Adds to the four cells round a point, shared as [`Grid::sample`] weighs them.
    fn add(&mut self, x: f64, y: f64, amount: f64) {
        let (i, fx, fy) = (y as usize * self.side + x as usize, x.fract(), y.fract());
        self.height[i] += amount * (1.0 - fx) * (1.0 - fy);
        self.height[i + 1] += amount * fx * (1.0 - fy);
        self.height[i + self.side] += amount * (1.0 - fx) * fy;
        self.height[i + self.side + 1] += amount * fx * fy;
    }

    /// Hydraulic erosion: drops run downhill, carry soil while they are fast and leave it where they slow down.
    fn erode_by_rain(&mut self, drops: i64, seed: u32) {
        const INERTIA: f64 = 0.25;
        let most = (self.side - 2) as f64;
        for drop in 0..drops {
            let mut x = unit(hash(drop, 0, seed)) * most;
            let mut y = unit(hash(drop, 1, seed)) * most;
            let (mut dx, mut dy, mut speed, mut water, mut soil) = (0.0, 0.0, 0.6_f64, 1.0, 0.0_f64);
            for _ in 0..70 {
                let (height, gx, gy) = self.sample(x, y);
                // Soil that reaches the lake sinks out of sight.
                if height < -0.3 {
                    break;
                }
                (dx, dy) = (mix(-gx, dx, INERTIA), mix(-gy, dy, INERTIA));
                let norm = length(dx, dy);
                if norm < 1e-9 {
                    break;
                }
                (dx, dy) = (dx / norm, dy / norm);
                let (to_x, to_y) = (x + dx, y + dy);
                if !(0.0..most).contains(&to_x) || !(0.0..most).contains(&to_y) {
                    break;
                }
                let fall = height - self.sample(to_x, to_y).0;
                let capacity = (fall * speed * water * 2.2).max(0.004);
                let moved = if fall < 0.0 {
                    -soil.min(-fall)
                } else if soil > capacity {
                    (capacity - soil) * 0.25
                } else {
                    ((capacity - soil) * 0.12).min(fall)
                };
                self.add(x, y, -moved);
                soil += moved;
                speed = (speed * speed + fall * 2.0).max(0.01).sqrt().min(3.0);
                water *= 0.975;
                (x, y) = (to_x, to_y);
            }
        }
    }

    /// Thermal erosion: what is steeper than `talus` (m/m) slides to the lower neighbour.
    fn erode_by_gravity(&mut self, rounds: usize, talus: f64) {
        let most = talus * self.cell_m;
        for _ in 0..rounds {
            let before = self.height.clone();
            let mut slide = |a: usize, b: usize| {
                let difference = before[a] - before[b];
                let excess = (difference.abs() - most).max(0.0) * 0.2;
                let moved = if difference < 0.0 { -excess } else { excess };
                self.height[a] -= moved;
                self.height[b] += moved;
            };
            for i in 0..before.len() {
                if (i + 1) % self.side != 0 {
                    slide(i, i + 1);
                }
                if i + self.side < before.len() {
                    slide(i, i + self.side);
                }
            }
        }
    }

    /// Makes the ground gentler where it is within `reach` (m) of the water's level.
    fn flatten_beach(&mut self, reach: f64) {
        for height in &mut self.height {
            let share = (height.abs() / reach).min(1.0);
            *height *= 0.45 + 0.55 * share * share * (3.0 - 2.0 * share);
        }
    }
}

fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// 0 at `from`, 1 at `to`, which may be less.
fn smooth(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The larger of both, rounded off where they differ by less than `width`.
fn smooth_max(a: f64, b: f64, width: f64) -> f64 {
    let t = (width - (a - b).abs()).max(0.0) / width;
    a.max(b) + t * t * width * 0.25
}

fn hash(x: i64, y: i64, seed: u32) -> u32 {
    let mix = |h: u32| {
        let h = (h ^ h >> 16).wrapping_mul(0x7feb_352d);
        let h = (h ^ h >> 15).wrapping_mul(0x846c_a68b);
        h ^ h >> 16
    };
    mix(mix(mix(seed.wrapping_add(0x9e37_79b9)) ^ x as u32) ^ y as u32)
}

/// A hash as a number from 0 to 1.
fn unit(hash: u32) -> f64 {
    f64::from(hash) / f64::from(u32::MAX)
}

/// Gradient noise, about -1 to 1.
fn noise(x: f64, y: f64, seed: u32) -> f64 {
    let (x0, y0) = (x.floor(), y.floor());
    let corner = |i: f64, j: f64| {
        let h = hash((x0 + i) as i64, (y0 + j) as i64, seed);
        let (gx, gy) = (f64::from(h & 0xffff) / 32767.5 - 1.0, f64::from(h >> 16) / 32767.5 - 1.0);
        gx * (x - x0 - i) + gy * (y - y0 - j)
    };
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (u, v) = (fade(x - x0), fade(y - y0));
    mix(mix(corner(0.0, 0.0), corner(1.0, 0.0), u), mix(corner(0.0, 1.0), corner(1.0, 1.0), u), v) * 1.5
}

/// Octaves of `octave(noise, sum so far)`, each turned, finer by 2 and weaker by 2 than the one before.
fn octaves(x: f64, y: f64, count: u32, seed: u32, octave: impl Fn(f64, f64) -> f64) -> f64 {
    let (mut x, mut y, mut weight, mut sum) = (x, y, 0.5, 0.0);
    for i in 0..count {
        sum += weight * octave(noise(x, y, seed.wrapping_add(i * 101)), sum);
        weight *= 0.5;
        // A turn by the angle of a 3-4-5 triangle keeps the lattices of the octaves from lining up.
        (x, y) = (2.0 * (0.8 * x - 0.6 * y), 2.0 * (0.6 * x + 0.8 * y));
    }
    sum
}

fn fbm(x: f64, y: f64, count: u32, seed: u32) -> f64 {
    octaves(x, y, count, seed, |noise, _| noise)
}

/// Sharp crests with rough flanks and smooth valleys, about 0 to 1.
fn ridged(x: f64, y: f64, count: u32, seed: u32) -> f64 {
    octaves(x, y, count, seed, |noise, sum| {
        let crest = 1.0 - noise.abs().min(1.0);
        crest * crest * (0.35 + sum).min(1.0)
    }) * 1.6
}
