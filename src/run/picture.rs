// SPDX-License-Identifier: MIT OR Apache-2.0
//! Still pictures: PNG files, downscaling in linear light, contact sheets.

use std::fs::File;
use std::io::{self, BufReader, Write};
use std::path::Path;
use std::sync::LazyLock;

use super::atomic::{failed, write_atomic, Result};

/// Between and around the tiles of a contact sheet (pixels).
const MARGIN: u32 = 4;
/// Behind the tiles of a contact sheet (sRGB).
const BACKGROUND: [u8; 3] = [18, 20, 23];

/// An opaque picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Columns (pixels).
    pub width: u32,
    /// Rows (pixels).
    pub height: u32,
    /// Rows from the top, 4 bytes a pixel: 8-bit sRGB and an alpha that is not looked at.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// A picture of one colour (8-bit sRGB).
    pub fn filled(width: u32, height: u32, [r, g, b]: [u8; 3]) -> Self {
        Self { width, height, rgba: [r, g, b, 255].repeat(width as usize * height as usize) }
    }

    /// Writes an 8-bit RGB PNG, whole or not at all.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        write_atomic(path, |file| self.encode(file).map_err(io::Error::from))
    }

    fn encode(&self, to: &mut dyn Write) -> std::result::Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(to, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb())?;
        writer.finish()
    }

    /// Reads a PNG of any kind; 16-bit samples are cut to 8 bits and transparency is dropped. Of an
    /// animation, the first frame.
    pub fn read_png(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(failed(path, "open it"))?;
        Self::decode(BufReader::new(file)).map_err(|e| failed(path, "read it as a PNG")(e.into()))
    }

    fn decode(from: BufReader<File>) -> std::result::Result<Self, png::DecodingError> {
        let mut decoder = png::Decoder::new(from);
        decoder.set_transformations(png::Transformations::normalize_to_color8());
        let mut reader = decoder.read_info()?;
        let size = reader.output_buffer_size().ok_or(png::DecodingError::LimitsExceeded)?;
        let mut bytes = vec![0; size];
        let frame = reader.next_frame(&mut bytes)?;
        bytes.truncate(frame.buffer_size());
        let samples = frame.color_type.samples();
        let (green, blue) = if samples < 3 { (0, 0) } else { (1, 2) };
        let rgba = bytes.chunks_exact(samples).flat_map(|p| [p[0], p[green], p[blue], 255]).collect();
        Ok(Self { width: frame.width, height: frame.height, rgba })
    }

    /// The pixels without their alpha.
    pub fn rgb(&self) -> Vec<u8> {
        self.rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect()
    }

    /// The picture at a smaller width, its aspect kept: each pixel is the mean light of the area it covers. A
    /// picture that is no wider than that is returned as it is.
    pub fn downscale(&self, width: u32) -> Self {
        let width = width.max(1);
        if width >= self.width {
            return self.clone();
        }
        let height =
            (f64::from(self.height) * f64::from(width) / f64::from(self.width)).round().max(1.0) as u32;
        let columns = coverage(self.width, width);
        let mut light = vec![[0.0f32; 3]; self.width as usize];
        let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
        for band in coverage(self.height, height) {
            light.fill([0.0; 3]);
            let rows = self.rgba.chunks_exact(4 * self.width as usize).skip(band.start);
            for (row, weight) in rows.zip(&band.weights) {
                for (sum, pixel) in light.iter_mut().zip(row.chunks_exact(4)) {
                    (0..3).for_each(|c| sum[c] += weight * LINEAR[usize::from(pixel[c])]);
                }
            }
            for span in &columns {
                let covered = || light[span.start..].iter().zip(&span.weights);
                let mean = |c: usize| encoded(covered().map(|(sum, weight)| weight * sum[c]).sum());
                rgba.extend([mean(0), mean(1), mean(2), 255]);
            }
        }
        Self { width, height, rgba }
    }
}

/// Pictures in rows of `columns`, each at most `tile_width` wide, on a dark ground with thin margins.
pub fn contact_sheet(pictures: &[Picture], columns: u32, tile_width: u32) -> Picture {
    let tiles: Vec<Picture> = pictures.iter().map(|p| p.downscale(tile_width)).collect();
    let columns = columns.clamp(1, tiles.len().max(1) as u32);
    let rows = (tiles.len() as u32).div_ceil(columns);
    let cell_width = tiles.iter().map(|t| t.width).max().unwrap_or(0) + MARGIN;
    let cell_height = tiles.iter().map(|t| t.height).max().unwrap_or(0) + MARGIN;
    let mut sheet = Picture::filled(columns * cell_width + MARGIN, rows * cell_height + MARGIN, BACKGROUND);
    for (index, tile) in (0u32..).zip(&tiles) {
        // A tile that is smaller than its cell stands in the middle of it.
        let left = MARGIN + index % columns * cell_width + (cell_width - MARGIN - tile.width) / 2;
        let top = MARGIN + index / columns * cell_height + (cell_height - MARGIN - tile.height) / 2;
        for (y, row) in (top..).zip(tile.rgba.chunks_exact(4 * tile.width.max(1) as usize)) {
            let at = 4 * (y as usize * sheet.width as usize + left as usize);
            sheet.rgba[at..at + row.len()].copy_from_slice(row);
        }
    }
    sheet
}

/// The source pixels that one target pixel covers along one axis, and the share of each; the shares add up to
/// 1.
struct Span {
    start: usize,
    weights: Vec<f32>,
}

fn coverage(source: u32, target: u32) -> Vec<Span> {
    let (source, target) = (u64::from(source), u64::from(target));
    (0..target)
        .map(|t| {
            // In units of 1 / target source pixels everything is a whole number.
            let (from, to) = (t * source, (t + 1) * source);
            let covered = |s: u64| to.min((s + 1) * target) - from.max(s * target);
            let pixels = from / target..to.div_ceil(target);
            let weights = pixels.clone().map(|s| covered(s) as f32 / source as f32).collect();
            Span { start: pixels.start as usize, weights }
        })
        .collect()
}

/// Linear light of each 8-bit sRGB value.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let s = i as f32 / 255.0;
        if s <= 0.04045 {
            s / 12.92
        } else {
            ((s + 0.055) / 1.055).powf(2.4)
        }
    })
});

/// Linear light to 8-bit sRGB, rounded to the nearest.
fn encoded(linear: f32) -> u8 {
    let s = if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (s * 255.0).round() as u8
}
