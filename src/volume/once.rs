// SPDX-License-Identifier: MIT OR Apache-2.0
//! The scene drawn once, each fragment into the slice that it finds. Reads `glsl/volume/once*` and `resolve_once.comp`.

use super::{kernel, spread, Meshes, VolumeParams, Way};
use crate::{
    cells::Cells,
    gpu::{
        Access, Attachments, Blend, Bound, Buffer, Depth, Gpu, Raster, RasterInfo, Recorder, Residence,
        Result, Topology,
    },
    shaders,
};

/// Voxelisation by one pass of rasterizing: the texels of [`Layered`](super::Layered) without drawing everything once
/// for each slice. Fragments come in any order, so they compete by keys, and a second pass writes the planes of those that
/// won.
pub struct Once {
    params: VolumeParams,
    draw: Bound,
    resolve: Bound,
    keys: Buffer,
    size: [u32; 2],
}

impl Once {
    /// What places must be visible to before [`Once::record`], also as [`Access::GraphicsRead`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Once::record`] touched the cells last.
    pub const EXIT: Access = Access::ComputeWrite;

    /// # Errors
    /// [`Error::Lacks`](crate::gpu::Error::Lacks) by the name of the feature that the device has not; its limits; no room.
    pub fn new(gpu: &Gpu, meshes: &Meshes, cells: &Cells, way: Way) -> Result<Self> {
        for what in ["graphics queue", "fragmentStoresAndAtomics"] {
            gpu.require("volume.once", what)?;
        }
        let params = VolumeParams { way: way.word(), ..VolumeParams::new(cells.grid(), meshes) };
        let keys = Buffer::new(gpu, "volume.once_keys", 4 * cells.grid().count() as u64, Residence::Device)?;
        let info = RasterInfo {
            name: c"volume.once",
            vertex: shaders::VOLUME_ONCE_VERT,
            geometry: None,
            fragment: shaders::VOLUME_ONCE_FRAG,
            blocks: &["Places", "Triangles", "OnceKeys"],
            constants: &[],
            topology: Topology::Triangles,
            blend: Blend::Opaque,
            depth: Depth::Write,
            samples: 1,
        };
        let inputs = [
            ("Places", meshes.places().into()),
            ("Triangles", meshes.triangles().into()),
            ("OnceKeys", (&keys).into()),
        ];
        let draw = Raster::onto::<VolumeParams>(gpu, &info, Attachments::Nothing)?.bind(&inputs)?;
        let blocks = ["Places", "Triangles", "OnceKeys", "Occupied", "Planes", "Extents"];
        let [places, triangles, once] = inputs;
        let resolve =
            kernel(gpu, c"volume.resolve_once", shaders::VOLUME_RESOLVE_ONCE_COMP, &blocks)?.bind(&[
                places,
                triangles,
                once,
                ("Occupied", cells.occupied().into()),
                ("Planes", cells.planes().into()),
                ("Extents", cells.extents().into()),
            ])?;
        let [width, height, _] = way.turned(cells.grid().cells);
        Ok(Self { params, draw, resolve, keys, size: [width, height] })
    }

    /// Fills the cells.
    ///
    /// once --B-- resolve_once
    pub fn record(&self, rec: &mut Recorder<'_>) {
        rec.barrier(Access::ComputeRead, Access::FillWrite);
        rec.span(c"volume.clear", |rec| rec.fill(&self.keys, u32::MAX));
        rec.barrier(Access::FillWrite, Access::FragmentReadWrite);
        rec.span(c"volume.once", |rec| {
            rec.render_nothing(self.size, |rec| {
                rec.draw(&self.draw, 3 * self.params.triangles, 1, &self.params)
            });
        });
        rec.barrier(Access::FragmentReadWrite, Access::ComputeReadWrite);
        rec.span(c"volume.resolve_once", |rec| {
            rec.dispatch(&self.resolve, spread(self.params.grid.count() as u32, 256), &self.params);
        });
    }
}
