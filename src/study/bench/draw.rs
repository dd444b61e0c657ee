// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rates at which sprites are drawn, over a picture of 1920 x 1080: what the passes of sprites take, and nothing else.
//! Where they are is a hash of their number (`glsl/draw/cloud.glsl`), so no memory is read for it.

use super::{Measured, Suite};
use crate::{
    draw::{
        sprites::{Path, SplatSprites, Splats, Sprites, SpritesInfo, Texture},
        Camera, Layers, Stage, View,
    },
    gpu::{Gpu, Recorder},
    shaders,
    study::{must_be_within, runs, Result},
};
use glam::{uvec2, vec3, UVec2, Vec3};

/// Its rows: discs of 2 to 4 pixels across, and `drops` below one pixel. `quads` and `geometry` draw with the samples that
/// pictures have, 4 where there are so many; `1x` with one.
pub const SUITE: Suite = Suite {
    sim: "particles",
    variants: &[
        "draw/quads",
        "draw/quads/1x",
        "draw/geometry",
        "draw/splat",
        "draw/splat/packed",
        "draw/quads/drops",
        "draw/splat/drops",
        "draw/splat/packed/drops",
    ],
    sizes: &[1 << 20, 10 << 20],
    largest_on_cpu: 1 << 18,
    label: |size| format!("{size}"),
    run: |gpu, variant, size, effort| {
        let has = |option: &str| variant.split('/').any(|it| it == option);
        // Splats against quads and quads against splats, which share no pass: by a splat, the middle of the pixel counts,
        // and not four samples of it.
        let small = uvec2(192, 108);
        let push = Push::new(20_000, small.y, has("drops"));
        let other = if has("splat") { "draw/quads" } else { "draw/splat" };
        let want = Cloud::new(gpu, other, small, push)?.picture(gpu)?;
        let got = Cloud::new(gpu, variant, small, push)?.picture(gpu)?;
        must_be_within(variant, apart(&got, &want), LARGEST)?;
        let size_px = uvec2(1920, 1080);
        let mut cloud = Cloud::new(gpu, variant, size_px, Push::new(size, size_px.y, has("drops")))?;
        cloud.picture(gpu)?;
        let timing = runs::time(gpu, effort, |rec| cloud.record(rec))?;
        Ok(Measured { timing, items: f64::from(size), unit: "sprite", bytes_per_item: 0.0 })
    },
};

/// Mean difference of two pictures that both drew it right, of the mean of one: measured 0.021 (splats against four
/// samples), 0.055 for drops, which have one pixel where quads light four more weakly.
const LARGEST: f64 = 0.1;

fn apart(got: &[u8], want: &[u8]) -> f64 {
    // Means of 12 x 12 pixels: what a drop lights is one of them.
    let blocks = |rgba: &[u8]| {
        let mut sums = vec![0.0; 16 * 9 * 3];
        for (i, byte) in rgba.iter().enumerate().filter(|(i, _)| i % 4 < 3) {
            let (x, y) = (i / 4 % 192, i / 4 / 192);
            sums[(y / 12 * 16 + x / 12) * 3 + i % 4] += f64::from(*byte);
        }
        sums
    };
    let (got, want) = (blocks(got), blocks(want));
    let difference: f64 = got.iter().zip(&want).map(|(a, b)| (a - b).abs()).sum();
    // Two black pictures are no number apart.
    difference / want.iter().sum::<f64>()
}

/// Push constants of `glsl/draw/cloud.glsl`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Push {
    count: u32,
    half_m: f32,
    along_m: f32,
    light: f32,
}

const EYE_M: Vec3 = vec3(0.0, 0.0, 30.0);
const FOV_RAD: f32 = 0.8;

impl Push {
    fn new(count: u32, rows: u32, has_drops: bool) -> Self {
        // At the near end of the cloud, 25 m from the eye.
        let pixel_m = 2.0 * (0.5 * FOV_RAD).tan() * 25.0 / rows as f32;
        let half_m = if has_drops { 0.15 } else { 2.0 } * pixel_m;
        let (along_m, light) = if has_drops { (0.3 * pixel_m, 20.0) } else { (0.0, 1.0) };
        Self { count, half_m, along_m, light }
    }
}

/// Builds what the rows draw with, and the sprites of a list, which tests draw.
pub(in crate::study) fn build(gpu: &Gpu) -> Result<()> {
    if !gpu.has_graphics() {
        return Ok(());
    }
    let size = uvec2(64, 64);
    let mut variants = vec!["draw/quads", "draw/quads/1x", "draw/splat"];
    variants.extend(gpu.has_geometry_shader().then_some("draw/geometry"));
    variants.extend(gpu.has_wide_atomics().then_some("draw/splat/packed"));
    for variant in variants {
        Cloud::new(gpu, variant, size, Push::new(1, size.y, false))?;
    }
    let mut stage = Stage::new(gpu, size, None)?;
    stage.copy_depth(gpu)?;
    let list = gpu.upload("draw.list", &[0f32; 16])?;
    let texture = Texture::new(gpu, [1, 1], &[255; 4])?;
    let resources: &[_] = &[("List", (&list).into())];
    let quads = Path::Quads { vertex: shaders::DRAW_LIST_VERT };
    let mut paths = vec![quads];
    paths.extend(gpu.has_geometry_shader().then_some(Path::Geometry { geometry: shaders::DRAW_LIST_GEOM }));
    for path in paths {
        for (texture, soft) in [(None, false), (None, true), (Some(&texture), false), (Some(&texture), true)]
        {
            let info = SpritesInfo { name: c"draw.list", path, resources, texture, soft, constants: &[] };
            Sprites::new::<()>(gpu, &stage, &info)?;
        }
    }
    let kernel = (c"draw.list_splat", shaders::DRAW_LIST_SPLAT_COMP);
    SplatSprites::new::<()>(gpu, &stage, &Splats::new(gpu, &stage)?, kernel, resources)?;
    Ok(())
}

enum Way {
    Sprites(Sprites),
    Splat(SplatSprites, Splats),
}

struct Cloud {
    stage: Stage,
    way: Way,
    push: Push,
}

impl Cloud {
    fn new(gpu: &Gpu, variant: &str, size: UVec2, push: Push) -> Result<Self> {
        let has = |option: &str| variant.split('/').any(|it| it == option);
        let samples = if has("1x") { 1 } else { gpu.samples() };
        let mut stage = Stage::with_samples(gpu, size, None, samples)?;
        stage.clear = [0.0, 0.0, 0.0, 1.0];
        stage.copy_depth(gpu)?;
        let camera = Camera { eye_m: EYE_M, target_m: Vec3::ZERO, fov_rad: FOV_RAD };
        stage.set_view(&View::new(&camera, size, 0.0, Vec3::Y, 1.0));
        let way = if has("splat") {
            let (splats, kernel) = if has("packed") {
                let kernel = (c"draw.cloud_packed", shaders::DRAW_CLOUD_PACKED_COMP);
                (Splats::packed(gpu, &stage)?, kernel)
            } else {
                (Splats::new(gpu, &stage)?, (c"draw.cloud_splat", shaders::DRAW_CLOUD_SPLAT_COMP))
            };
            Way::Splat(SplatSprites::new::<Push>(gpu, &stage, &splats, kernel, &[])?, splats)
        } else {
            let path = if has("geometry") {
                Path::Geometry { geometry: shaders::DRAW_CLOUD_GEOM }
            } else {
                Path::Quads { vertex: shaders::DRAW_CLOUD_VERT }
            };
            let info = SpritesInfo {
                name: c"draw.cloud",
                path,
                resources: &[],
                texture: None,
                soft: false,
                constants: &[],
            };
            Way::Sprites(Sprites::new::<Push>(gpu, &stage, &info)?)
        };
        Ok(Self { stage, way, push })
    }

    fn record(&mut self, rec: &mut Recorder<'_>) {
        let (stage, push) = (&self.stage, &self.push);
        match &self.way {
            Way::Sprites(sprites) => {
                let mut draw = |rec: &mut Recorder<'_>| sprites.record(rec, push.count, push);
                stage.record_over(rec, Some(&mut draw), None);
            }
            Way::Splat(sprites, splats) => {
                let mut splat = |rec: &mut Recorder<'_>| {
                    sprites.record(rec, push.count, push);
                    splats.record_over(rec);
                };
                stage.record_over(rec, None, Some(&mut splat));
            }
        }
    }

    fn picture(&mut self, gpu: &Gpu) -> Result<Vec<u8>> {
        let mut nothing = |_: &mut Recorder<'_>| {};
        let (way, push) = (&self.way, &self.push);
        let mut draw = |rec: &mut Recorder<'_>| match way {
            Way::Sprites(sprites) => sprites.record(rec, push.count, push),
            Way::Splat(sprites, splats) => {
                sprites.record(rec, push.count, push);
                splats.record_over(rec);
            }
        };
        let layers = match way {
            Way::Sprites(_) => Layers { opaque: &mut nothing, sprites: Some(&mut draw), splats: None },
            Way::Splat(..) => Layers { opaque: &mut nothing, sprites: None, splats: Some(&mut draw) },
        };
        gpu.once(|rec| self.stage.record_layers(rec, layers))?;
        Ok(self.stage.read())
    }
}
