// SPDX-License-Identifier: MIT OR Apache-2.0
//! Throughput of paint on the lizard: pairs of a texel and a particle as the brute form tries them, so that rates of all
//! variants compare. Particles are as in the seed's scene, anywhere in a cube of 2 m, of which few are near; or, with
//! `/near`, all on the surface.

use super::{Measured, Suite};
use crate::{
    gpu::{Buffer, Gpu},
    impact::{self, Impact, Stream, Surfaces},
    mesh::{shapes, Mesh},
    paint::{
        cpu::{self, Aim},
        Atlas, Canvas, Coat, Drop, Error as PaintError, Format, Gather, Method, Paint, Position, Splat,
        Taken,
    },
    random,
    study::{
        must_be_within,
        runs::{self, Effort, Timing},
        Result,
    },
};
use glam::{UVec2, Vec3};

/// Its rows. Sizes are sides of the map, with 5000 particles up to 512, else 50000.
pub const SUITE: Suite = Suite {
    sim: "paint",
    variants: &[
        "brute",
        "tiles",
        "tiles/group256",
        "tiles/near",
        "sifted",
        "sifted/floats",
        "sifted/near",
        "splat",
        "place",
    ],
    sizes: &[256, 2048],
    largest_on_cpu: 256,
    label: |side| format!("{side}x{side}x{}", drops_for(side)),
    run,
};

fn drops_for(side: u32) -> u32 {
    if side <= 512 {
        5000
    } else {
        50_000
    }
}

/// The seed's: `sqrt(0.0005)` (m).
const RADIUS_M: f32 = 0.022_36;

/// A lizard, a canvas, and what paints it.
struct Easel {
    atlas: Atlas,
    mesh: Mesh,
    canvas: Canvas,
    places: Buffer,
    triangles: Buffer,
    drops: Vec<Drop>,
    coats: Vec<Coat>,
}

/// A point of the surface.
fn on(mesh: &Mesh, i: u32) -> (Vec3, u32) {
    let [a, b, c, _] = random::bits(3, 1, i, 4);
    let triangle = a % mesh.triangles.len() as u32;
    let [p, q, r] = mesh.triangles[triangle as usize].map(|v| mesh.at_m[v as usize]);
    let (mut s, mut t) = (b as f32 / u32::MAX as f32, c as f32 / u32::MAX as f32);
    if s + t > 1.0 {
        (s, t) = (1.0 - s, 1.0 - t);
    }
    (p + (q - p) * s + (r - p) * t, triangle)
}

impl Easel {
    fn new(gpu: &Gpu, paint: &Paint, side: u32, count: u32, is_near: bool) -> Result<Self> {
        let mesh = shapes::lizard(1.0);
        let atlas = Atlas::new(&[(&mesh, UVec2::splat(side))], 2).map_err(PaintError::from)?;
        let six: Vec<[f32; 6]> = mesh.at_m.iter().map(|p| [p.x, p.y, p.z, 0.0, 0.0, 0.0]).collect();
        let places = gpu.upload("bench.places", &six)?;
        let triangles = gpu.upload("bench.triangles", &mesh.triangles)?;
        let canvas = paint.canvas(&atlas, &places, &triangles)?;
        gpu.once(|rec| canvas.record_place(rec, &[0]))?;
        let drop = |i| {
            let [x, y, z, w] = random::bits(1, 2, i, 5);
            let anywhere = Vec3::new(x as f32, y as f32, z as f32) * (2.0 / u32::MAX as f32) - 1.0;
            Drop { at_m: if is_near { on(&mesh, i).0 } else { anywhere }, source: w % 4 }
        };
        let drops = (0..count).map(drop).collect();
        let mut coats = Vec::new();
        for color in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE] {
            coats.push(Coat::new(color, 0.3, RADIUS_M).map_err(PaintError::from)?);
        }
        Coat::take_turns(&mut coats, &[count; 4]).map_err(PaintError::from)?;
        Ok(Self { atlas, mesh, canvas, places, triangles, drops, coats })
    }

    fn gather(&self, gpu: &Gpu, paint: &Paint) -> Result<Gather> {
        let drops = gpu.upload("bench.drops", &self.drops)?;
        Ok(paint.gather(&self.canvas, &drops, &self.coats)?)
    }

    /// An impact a drop, where it is on the surface, as a step would have left them.
    fn splat(&self, gpu: &Gpu, paint: &Paint) -> Result<(Stream, Splat)> {
        let count = self.drops.len() as u32;
        let mut stream = Stream::new(gpu, count)?;
        let uvs = gpu.upload("bench.uvs", &self.mesh.uv)?;
        let firsts = gpu.upload("bench.firsts", &[0, self.mesh.triangles.len() as u32])?;
        let surfaces =
            Surfaces { places: &self.places, triangles: &self.triangles, uvs: &uvs, first_triangle: &firsts };
        stream.locate_on(&surfaces)?;
        let impact = |i: u32| {
            let (at_m, triangle) = on(&self.mesh, i);
            let source = self.drops[i as usize].source;
            // In no order: 7919 is prime and divides no count.
            let order = (u64::from(i) * 7919 % u64::from(count)) as u32;
            Impact { at_m, order, triangle: triangle + 1, source, ..Impact::default() }
        };
        gpu.upload_to(stream.impacts(), &(0..count).map(impact).collect::<Vec<_>>())?;
        let closed = impact::Count { appended: count, ..stream.counts()? };
        gpu.upload_to(stream.count(), &[closed])?;
        gpu.once(|rec| stream.record_end(rec))?;
        let splat = paint.splat(&self.canvas, &stream, &self.coats)?;
        Ok((stream, splat))
    }

    fn pairs(&self) -> f64 {
        let charts = &self.atlas.charts[0];
        (charts.covered + charts.gutter) as f64 * self.drops.len() as f64
    }
}

/// The paint of one record of a variant.
fn once(gpu: &Gpu, paint: &Paint, easel: &Easel, method: Option<Method>) -> Result<Vec<[f32; 4]>> {
    gpu.once(|rec| easel.canvas.record_clear(rec))?;
    match method {
        Some(method) => {
            let gather = easel.gather(gpu, paint)?;
            let taken = Taken::all(easel.drops.len() as u32);
            gpu.once(|rec| gather.record(rec, method, &taken, RADIUS_M))?;
        }
        None => {
            let (_stream, splat) = easel.splat(gpu, paint)?;
            gpu.once(|rec| splat.record(rec))?;
        }
    }
    Ok(easel.canvas.download(gpu)?)
}

/// Part of the painted texels that differ from the f32 twin's: the rims of discs, where a driver rounds otherwise.
fn strays(gpu: &Gpu, paint: &Paint, method: Option<Method>) -> Result<f64> {
    let easel = Easel::new(gpu, paint, 61, 1237, true)?;
    let got = once(gpu, paint, &easel, method)?;
    let (positions, ..) = easel.canvas.download_places(gpu)?;
    let places = cpu::place(&easel.atlas.texels, &easel.mesh.triangles, &easel.mesh.at_m);
    let is_placed =
        |(a, b): (&Position, &Position)| a.triangle == b.triangle && a.at_m.distance(b.at_m) < 1e-5;
    if !positions.iter().zip(&places).all(is_placed) {
        return Ok(1.0);
    }
    let drops: Vec<(Drop, Aim)> = match method {
        Some(_) => {
            let aim = Aim { home: None, mesh: None, reach_sq_m2: RADIUS_M * RADIUS_M };
            easel.drops.iter().map(|drop| (*drop, aim)).collect()
        }
        None => {
            let (stream, _splat) = easel.splat(gpu, paint)?;
            cpu::in_order(&stream.download()?.0, &easel.coats, easel.canvas.maps())
        }
    };
    let mut want = vec![[0f32; 4]; positions.len()];
    cpu::gather(&positions, |_| 0, &drops, &easel.coats, &mut want);
    let is_painted = |texel: &&[f32; 4]| texel[3] > 0.0;
    let painted = want.iter().filter(is_painted).count();
    let is_alike = |(a, b): &(&[f32; 4], &[f32; 4])| {
        let b = cpu::stored(paint.format(), **b);
        (0..4).all(|i| (a[i] - b[i]).abs() <= 1e-3)
    };
    let apart = want.len() - got.iter().zip(&want).filter(is_alike).count();
    Ok(if painted > 100 { apart as f64 / painted as f64 } else { 1.0 })
}

fn run(gpu: &Gpu, variant: &str, side: u32, effort: Effort) -> Result<Measured> {
    let has = |wanted: &str| variant.split('/').any(|option| option == wanted);
    let format = if has("floats") { Format::Floats } else { Format::Halves };
    let paint = Paint::tuned(gpu, format, if has("group256") { 256 } else { 64 })?;
    let method = match variant.split('/').next() {
        Some("brute" | "place") => Some(Method::Brute),
        Some("tiles") => Some(Method::Tiles),
        Some("sifted") => Some(Method::Sifted),
        _ => None,
    };
    must_be_within(variant, strays(gpu, &paint, method)?, 0.001)?;
    let easel = Easel::new(gpu, &paint, side, drops_for(side), has("near"))?;
    if method.is_some_and(|method| method != Method::Brute) && !gpu.adapter().is_software() {
        // At this size too, what brute force paints, to the bit.
        let is_same = once(gpu, &paint, &easel, method)? == once(gpu, &paint, &easel, Some(Method::Brute))?;
        must_be_within(variant, if is_same { 0.0 } else { 1.0 }, 0.0)?;
    }
    let texels = easel.pairs() / easel.drops.len() as f64;
    if variant == "place" {
        let timing = runs::time(gpu, effort, |rec| {
            easel.canvas.record_place(rec, &[0]);
            rec.barrier(Paint::EXIT, Paint::ENTRY);
        })?;
        // Which triangle and where in it; the place.
        return Ok(Measured { timing, items: texels, unit: "texel", bytes_per_item: 12.0 + 16.0 });
    }
    let timing: Timing = match method {
        Some(method) => {
            let gather = easel.gather(gpu, &paint)?;
            let taken = Taken::all(easel.drops.len() as u32);
            runs::time(gpu, effort, |rec| {
                gather.record(rec, method, &taken, RADIUS_M);
                rec.barrier(Paint::EXIT, Paint::ENTRY);
            })?
        }
        None => {
            let (_stream, splat) = easel.splat(gpu, &paint)?;
            runs::time(gpu, effort, |rec| {
                splat.record(rec);
                rec.barrier(Paint::EXIT, Paint::ENTRY);
            })?
        }
    };
    // Places and drops read once, paint read and written once.
    let bytes = texels * (16.0 + 2.0 * format.bytes() as f64) + 16.0 * easel.drops.len() as f64;
    Ok(Measured { timing, items: easel.pairs(), unit: "pair", bytes_per_item: bytes / easel.pairs() })
}
