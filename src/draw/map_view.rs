// SPDX-License-Identifier: MIT OR Apache-2.0
//! Debug views of the maps of painted meshes, flat, one beside the other: `glsl/draw/map_*`.

use super::Stage;
use crate::{
    gpu::{Access, Blend, Bound, Buffer, Depth, Gpu, Raster, RasterInfo, Recorder, Result, Topology},
    shaders,
};
use glam::{vec2, UVec2, Vec2, Vec3, Vec4};

/// Push constants: `MapViewParams` in `glsl/draw/map_view.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct MapViewParams {
    /// Of the positions that are black (m).
    pub low_m: Vec4,
    /// Of those that are white (m).
    pub high_m: Vec4,
    /// Where it lies in the picture, from its upper left corner on: corner and size (pixels).
    pub corner: Vec4,
    /// Where the map is: `Map` in `glsl/paint/map.glsl`.
    pub map: [u32; 4],
}

/// Which maps.
#[derive(Clone, Copy)]
pub enum Maps<'a> {
    /// `Position` a texel.
    Positions(&'a Buffer),
    /// Paint, and how a texel of it is stored (`glsl/paint/texel.glsl`).
    Paint(&'a Buffer, u32),
}

/// A pipeline for all maps in one buffer.
pub struct MapViews {
    bound: Bound,
    params: Vec<MapViewParams>,
}

impl MapViews {
    /// What the maps must be visible to before [`MapViews::record`].
    pub const ENTRY: Access = Access::GraphicsRead;

    /// `list`: width, height and where it is, of each map. Positions go from black at `low_m` to white at `high_m`.
    ///
    /// # Errors
    /// If the device cannot draw.
    pub fn new(
        gpu: &Gpu,
        stage: &Stage,
        maps: Maps<'_>,
        list: &[[u32; 4]],
        (low_m, high_m): (Vec3, Vec3),
    ) -> Result<Self> {
        let (name, fragment, block, buffer, constants) = match maps {
            Maps::Positions(buffer) => {
                (c"draw.map_position", shaders::DRAW_MAP_POSITION_FRAG, "Positions", buffer, vec![])
            }
            Maps::Paint(buffer, format) => {
                (c"draw.map_paint", shaders::DRAW_MAP_PAINT_FRAG, "Paint", buffer, vec![format])
            }
        };
        let info = RasterInfo {
            name,
            vertex: shaders::DRAW_MAP_VIEW_VERT,
            geometry: None,
            fragment,
            blocks: &["Views", block],
            constants: &constants,
            topology: Topology::Triangles,
            blend: Blend::Opaque,
            depth: Depth::Write,
            samples: stage.samples(),
        };
        let bound = Raster::new::<MapViewParams>(gpu, &info)?
            .bind(&[("Views", stage.views().into()), (block, buffer.into())])?;
        let place = |i: usize, map: [u32; 4]| {
            let (corner, size) = rectangle(i, list.len(), stage.size(), UVec2::new(map[0], map[1]));
            MapViewParams {
                low_m: low_m.extend(0.0),
                high_m: high_m.extend(0.0),
                corner: Vec4::new(corner.x, corner.y, size.x, size.y),
                map,
            }
        };
        let params = list.iter().enumerate().map(|(i, map)| place(i, *map)).collect();
        Ok(Self { bound, params })
    }

    /// Draws all maps, inside [`Stage::record`].
    pub fn record(&self, rec: &mut Recorder<'_>) {
        self.params.iter().for_each(|params| rec.draw(&self.bound, 6, 1, params));
    }
}

/// Corner and size of the `i`-th of `count` maps in a picture (pixels): in rows, as large as fits, its sides in proportion.
fn rectangle(i: usize, count: usize, picture: UVec2, map: UVec2) -> (Vec2, Vec2) {
    let columns = (1..=count)
        .max_by_key(|columns| {
            (picture.x as usize / columns).min(picture.y as usize / count.div_ceil(*columns))
        })
        .unwrap_or(1);
    let rows = count.div_ceil(columns);
    let room = picture.as_vec2() / vec2(columns as f32, rows as f32);
    let scale = ((room - 8.0) / map.as_vec2()).min_element().max(1.0 / map.max_element() as f32);
    let size = map.as_vec2() * scale;
    let middle = room * (vec2((i % columns) as f32, (i / columns) as f32) + 0.5);
    (middle - 0.5 * size, size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_lie_side_by_side_within_the_picture() {
        for (count, picture) in
            [(1, UVec2::new(960, 540)), (3, UVec2::new(960, 540)), (7, UVec2::new(64, 300))]
        {
            let all: Vec<_> =
                (0..count).map(|i| rectangle(i, count, picture, UVec2::new(256, 128))).collect();
            for (i, (corner, size)) in all.iter().enumerate() {
                assert!(
                    corner.min_element() >= 0.0 && (corner + size).cmple(picture.as_vec2()).all(),
                    "{i} {all:?}"
                );
                assert!((size.x - 2.0 * size.y).abs() < 1e-3);
                for (other, wide) in &all[i + 1..] {
                    assert!(
                        (corner + size).cmple(*other).any() || (other + wide).cmple(*corner).any(),
                        "{i} {all:?}"
                    );
                }
            }
        }
    }
}
