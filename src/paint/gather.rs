// SPDX-License-Identifier: MIT OR Apache-2.0
//! Paint from particles that are near. Reads `glsl/paint/{brute,tiles,begin,sift,sifted}.comp`.

use super::{Canvas, Coat, Format, GatherParams, Invalid, Paint, Work, BLOCK, MOST_DROPS, TILE};
use crate::{
    gpu::{self, Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Resource},
    shaders,
};

/// How a [`Gather`] finds what is near. All paint the same, to the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Every texel looks at every drop, as the seed does.
    Brute,
    /// Every tile of 8 x 8 texels looks at every drop, its texels at what is near: one dispatch.
    Tiles,
    /// Every block of 8 x 8 tiles looks at every drop, its tiles at what is near: for most numbers the fastest.
    Sifted,
}

/// Which particles take part: `first`, `first + stride` and so on, below `total`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Taken {
    /// Drops there are.
    pub total: u32,
    /// Of them.
    pub first: u32,
    /// From one to the next.
    pub stride: u32,
}

impl Taken {
    /// All of `total`.
    pub fn all(total: u32) -> Self {
        Self { total, first: 0, stride: 1 }
    }

    /// The share of one frame of `frames` (the seed's amortisation, 25 frames for 5000 particles, 200 a frame): in so many
    /// frames each particle takes part once, also where they do not divide.
    ///
    /// # Panics
    /// If there are no frames.
    pub fn share(total: u32, frame: u32, frames: u32) -> Self {
        Self { total, first: frame % frames, stride: frames }
    }

    /// How many.
    pub fn count(&self) -> u32 {
        self.total.saturating_sub(self.first).div_ceil(self.stride)
    }

    /// Which.
    pub fn indices(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.count()).map(|k| self.first + self.stride * k)
    }
}

const DROPS: [&str; 3] = ["Drops", "Homes", "Coats"];

/// The kernels that gather, for particles or for impacts.
pub(super) struct Culling {
    brute: Kernel,
    tiles: Kernel,
    begin: Kernel,
    sift: Kernel,
    sifted: Kernel,
    group: u32,
}

impl Culling {
    pub(super) fn new(gpu: &Gpu, kind: u32, format: Format, group: u32) -> gpu::Result<Self> {
        let kernel = |name, spv, blocks: &[&str], constants: &[u32]| {
            Kernel::new::<GatherParams>(gpu, &KernelInfo { name, spv, blocks, constants })
        };
        let painted = [&DROPS[..], &["WorkToDo", "Positions", "Tiles", "Paint"]].concat();
        let sifted = [&painted[..], &["Masks", "Touched"]].concat();
        let sift = [&DROPS[..], &["Blocks", "WorkToDo", "Flags", "Masks", "Touched"]].concat();
        let constants = [kind, format as u32, group];
        Ok(Self {
            brute: kernel(c"paint.brute", shaders::PAINT_BRUTE_COMP, &painted, &constants)?,
            tiles: kernel(c"paint.tiles", shaders::PAINT_TILES_COMP, &painted, &constants)?,
            begin: kernel(c"paint.begin", shaders::PAINT_BEGIN_COMP, &["Sums", "WorkToDo"], &[kind])?,
            sift: kernel(c"paint.sift", shaders::PAINT_SIFT_COMP, &sift, &[kind])?,
            sifted: kernel(c"paint.sifted", shaders::PAINT_SIFTED_COMP, &sifted, &constants)?,
            group,
        })
    }

    /// For the drops of a buffer, at most `most` of which take part.
    pub(super) fn bind(
        &self,
        gpu: &Gpu,
        canvas: &Canvas,
        input: &Input<'_>,
        most: u32,
    ) -> Result<Culled, super::Error> {
        if most > MOST_DROPS {
            let allowed = format!("up to {MOST_DROPS}");
            return Err(Invalid { key: "drops", value: most.to_string(), allowed }.into());
        }
        let (blocks, words) = (canvas.block_count(), 8 * most.div_ceil(256).max(1));
        let device = |name, words: u64| Buffer::new(gpu, name, 4 * words, Residence::Device);
        let flags = device("paint.flags", u64::from(blocks))?;
        let masks = device("paint.masks", u64::from(blocks) * u64::from(words))?;
        let touched = device("paint.touched", u64::from(blocks))?;
        let work = gpu.upload("paint.work", &[Work::default()])?;
        let drops: [(&str, Resource<'_>); 3] =
            [("Drops", input.drops.into()), ("Homes", input.homes.into()), ("Coats", input.coats.into())];
        let painted: Vec<(&str, Resource<'_>)> = drops
            .into_iter()
            .chain([
                ("WorkToDo", (&work).into()),
                ("Positions", (&canvas.positions).into()),
                ("Tiles", (&canvas.tiles).into()),
                ("Paint", (&canvas.paint).into()),
            ])
            .collect();
        let masked = [("Masks", (&masks).into()), ("Touched", (&touched).into())];
        let sift: [(&str, Resource<'_>); 3] =
            [("Blocks", (&canvas.blocks).into()), ("WorkToDo", (&work).into()), ("Flags", (&flags).into())];
        Ok(Culled {
            brute: self.brute.bind(&painted)?,
            tiles: self.tiles.bind(&painted)?,
            begin: self.begin.bind(&[("Sums", input.sums.into()), ("WorkToDo", (&work).into())])?,
            sift: self.sift.bind(&drops.into_iter().chain(sift).chain(masked).collect::<Vec<_>>())?,
            sifted: self.sifted.bind(&painted.iter().copied().chain(masked).collect::<Vec<_>>())?,
            flags,
            masks,
            work,
            blocks,
            words,
            coats: (input.coats.bytes() / size_of::<Coat>() as u64) as u32,
            group: self.group,
        })
    }
}

/// What a [`Culled`] reads.
pub(super) struct Input<'a> {
    pub drops: &'a Buffer,
    pub homes: &'a Buffer,
    pub coats: &'a Buffer,
    pub sums: &'a Buffer,
}

/// Drops, a canvas, and the masks between them.
pub(super) struct Culled {
    brute: Bound,
    tiles: Bound,
    begin: Bound,
    sift: Bound,
    sifted: Bound,
    flags: Buffer,
    pub(super) masks: Buffer,
    pub(super) work: Buffer,
    blocks: u32,
    pub(super) words: u32,
    pub(super) coats: u32,
    group: u32,
}

impl Culled {
    pub(super) fn params(&self, taken: &Taken, reach_sq_m2: f32, total_at: u32) -> GatherParams {
        let Taken { total, first, stride } = *taken;
        let (blocks, words, coats) = (self.blocks, self.words, self.coats);
        GatherParams { total, first, stride, blocks, words, coats, reach_sq_m2, total_at }
    }

    /// brute, or tiles, or begin --B-- sift --B-- sifted. `brute` and `tiles` of impacts have a begin before them.
    pub(super) fn record(&self, rec: &mut Recorder<'_>, method: Method, p: &GatherParams, is_counted: bool) {
        let both = Access::ComputeReadWrite;
        if is_counted || method == Method::Sifted {
            rec.barrier(Access::IndirectRead, Access::ComputeWrite);
            rec.barrier(both, Access::FillWrite);
            rec.fill(&self.flags, 0);
            rec.span(c"paint.begin", |rec| rec.dispatch(&self.begin, [1, 1, 1], p));
            rec.barrier(Access::FillWrite, both);
            rec.barrier(both, both);
            rec.barrier(Access::ComputeWrite, Access::IndirectRead);
        }
        match method {
            Method::Brute => {
                let groups = (self.blocks * BLOCK as u32).div_ceil(self.group);
                let threads = super::spread(groups, self.group);
                rec.span(c"paint.brute", |rec| rec.dispatch(&self.brute, threads, p));
            }
            Method::Tiles => {
                let threads = super::spread(self.blocks * (BLOCK / TILE) as u32, self.group);
                rec.span(c"paint.tiles", |rec| rec.dispatch(&self.tiles, threads, p));
            }
            Method::Sifted => {
                rec.span(c"paint.sift", |rec| rec.dispatch_indirect(&self.sift, &self.work, Work::SIFT, p));
                rec.barrier(both, both);
                rec.barrier(Access::ComputeWrite, Access::IndirectRead);
                rec.span(c"paint.sifted", |rec| {
                    rec.dispatch_indirect(&self.sifted, &self.work, Work::TILES, p);
                });
            }
        }
    }
}

impl Paint {
    /// From `drops`, [`super::Drop`]s, on `canvas`, a coat of `coats` each.
    ///
    /// # Errors
    /// More than 65535 coats or none, more than [`MOST_DROPS`] drops, or if the device has no room for a bit for each pair of a block and a drop.
    pub fn gather(&self, canvas: &Canvas, drops: &Buffer, coats: &[Coat]) -> Result<Gather, super::Error> {
        let coats = upload_coats(&self.gpu, coats)?;
        let most = (drops.bytes() / size_of::<super::Drop>() as u64) as u32;
        let input = Input { drops, homes: drops, coats: &coats, sums: drops };
        Ok(Gather { culled: self.particles.bind(&self.gpu, canvas, &input, most)?, most })
    }
}

pub(super) fn upload_coats(gpu: &Gpu, coats: &[Coat]) -> Result<Buffer, super::Error> {
    if coats.is_empty() || coats.len() >= 1 << 16 {
        let allowed = "1 to 65535".to_string();
        return Err(Invalid { key: "coats", value: coats.len().to_string(), allowed }.into());
    }
    Ok(gpu.upload("paint.coats", coats)?)
}

/// Paint from the particles of one buffer on one canvas.
pub struct Gather {
    culled: Culled,
    most: u32,
}

impl Gather {
    /// Records the coats of those that are nearer than `radius_m` to a texel, in the order of the buffer. Submits nothing,
    /// waits for nothing, allocates nothing.
    ///
    /// # Panics
    /// If fewer drops are in the buffer, or the stride is 0.
    pub fn record(&self, rec: &mut Recorder<'_>, method: Method, taken: &Taken, radius_m: f32) {
        assert!(taken.total <= self.most, "{} of {} drops", taken.total, self.most);
        assert!(taken.stride > 0, "a stride of 0");
        self.culled.record(rec, method, &self.culled.params(taken, radius_m * radius_m, 0), false);
    }

    /// Bits of blocks and drops after [`Method::Sifted`]: `words` of each block.
    pub fn masks(&self) -> (&Buffer, u32) {
        (&self.culled.masks, self.culled.words)
    }
}
