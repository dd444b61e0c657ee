// SPDX-License-Identifier: MIT OR Apache-2.0
//! The seed's way: the scene drawn into the slices of a volume. Reads `glsl/volume/slices*` and `resolve_slices.comp`.

use super::{kernel, spread, Meshes, VolumeParams, Way};
use crate::{
    cells::Cells,
    gpu::{
        Access, Attachments, Blend, Bound, Depth, Gpu, Image, ImageUse, LayersTarget, Raster, RasterInfo,
        Recorder, Result, Topology,
    },
    shaders,
};

/// What sends a triangle to its slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Router {
    /// The vertex shader: `shaderOutputLayer`.
    Vertex,
    /// A geometry shader.
    Geometry,
}

impl Router {
    /// What the device has, the faster first.
    ///
    /// # Errors
    /// [`Error::Lacks`](crate::gpu::Error::Lacks) if it has neither.
    pub fn of(gpu: &Gpu) -> Result<Self> {
        let has = |what| gpu.require("volume.slices", what).is_ok();
        if !has("shaderOutputLayer") && has("geometryShader") {
            return Ok(Self::Geometry);
        }
        gpu.require("volume.slices", "shaderOutputLayer").map(|()| Self::Vertex)
    }

    fn needs(self) -> &'static str {
        match self {
            Self::Vertex => "shaderOutputLayer",
            Self::Geometry => "geometryShader",
        }
    }
}

/// Voxelisation by layered rendering: all meshes are drawn once for each slice of the grid, clipped to it, and the depth test
/// keeps what is nearest to where particles come from. A cell is marked where a triangle covers the centre of its texel, so
/// what is steep to [`Way`] loses cells. One plane a cell.
pub struct Layered {
    params: VolumeParams,
    draw: Bound,
    resolve: Bound,
    volumes: [Image; 2],
    depth: Image,
}

impl Layered {
    /// What places must be visible to before [`Layered::record`].
    pub const ENTRY: Access = Access::GraphicsRead;
    /// How [`Layered::record`] touched the cells last.
    pub const EXIT: Access = Access::ComputeWrite;

    /// # Errors
    /// [`Error::Lacks`](crate::gpu::Error::Lacks) by the name of the feature that the device has not; its limits; no room.
    pub fn new(gpu: &Gpu, meshes: &Meshes, cells: &Cells, way: Way, router: Router) -> Result<Self> {
        for what in ["graphics queue", "shaderClipDistance", "volumes as layers", router.needs()] {
            gpu.require("volume.slices", what)?;
        }
        let params = VolumeParams { way: way.word(), ..VolumeParams::new(cells.grid(), meshes) };
        let (vertex, geometry) = match router {
            Router::Vertex => (shaders::VOLUME_SLICES_VERT, None),
            Router::Geometry => (shaders::VOLUME_SLICES_WORLD_VERT, Some(shaders::VOLUME_SLICES_GEOM)),
        };
        let info = RasterInfo {
            name: c"volume.slices",
            vertex,
            geometry,
            fragment: shaders::VOLUME_SLICES_FRAG,
            blocks: &["Places", "Triangles"],
            constants: &[],
            topology: Topology::Triangles,
            blend: Blend::Opaque,
            depth: Depth::WriteNearer,
            samples: 1,
        };
        let draw = Raster::onto::<VolumeParams>(gpu, &info, Attachments::Volumes)?
            .bind(&[("Places", meshes.places().into()), ("Triangles", meshes.triangles().into())])?;
        let size = way.turned(cells.grid().cells);
        let volumes = [
            Image::layered(gpu, "volume.plane_image", size, ImageUse::Volume)?,
            Image::layered(gpu, "volume.velocity_image", size, ImageUse::Volume)?,
        ];
        let depth = Image::layered(gpu, "volume.depth_image", size, ImageUse::LayeredDepth)?;
        let blocks = ["PlaneImage", "VelocityImage", "Occupied", "Planes", "Extents"];
        let resolve = kernel(gpu, c"volume.resolve_slices", shaders::VOLUME_RESOLVE_SLICES_COMP, &blocks)?
            .bind(&[
                ("PlaneImage", (&volumes[0]).into()),
                ("VelocityImage", (&volumes[1]).into()),
                ("Occupied", cells.occupied().into()),
                ("Planes", cells.planes().into()),
                ("Extents", cells.extents().into()),
            ])?;
        Ok(Self { params, draw, resolve, volumes, depth })
    }

    /// Fills the cells.
    ///
    /// slices --B-- resolve_slices
    pub fn record(&self, rec: &mut Recorder<'_>) {
        let [first, second] = &self.volumes;
        let target = LayersTarget { volumes: [first, second], depth: &self.depth };
        rec.barrier(Access::ComputeRead, Access::ColorWrite);
        rec.barrier(Access::DepthWrite, Access::DepthWrite);
        rec.span(c"volume.slices", |rec| {
            rec.render_layers(&target, |rec| {
                rec.draw(&self.draw, 3 * self.params.triangles, first.layers(), &self.params);
            });
        });
        rec.barrier(Access::ColorWrite, Access::ComputeReadWrite);
        rec.span(c"volume.resolve_slices", |rec| {
            rec.dispatch(&self.resolve, spread(self.params.grid.count() as u32, 256), &self.params);
        });
    }
}
