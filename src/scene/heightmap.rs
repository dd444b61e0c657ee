// SPDX-License-Identifier: MIT OR Apache-2.0
//! Terrain heights from grey PNG files and ESRI ASCII grids, which may be broken or hostile.

use std::{
    fs::File,
    io::{Cursor, Read},
    path::Path,
};

use super::{
    asc::{self, AscHeader},
    builtin, SceneError, TerrainSource,
};

/// Most samples along a side of a heightmap.
const MAX_SIDE: u32 = 16384;
/// Most bytes in a heightmap's file.
const MAX_BYTES: u64 = 1 << 30;
/// More than the header of an `.asc` file has (bytes).
const ASC_HEADER_BYTES: u64 = 4096;

/// A grid of terrain heights, centred on x = z = 0.
///
/// Every sample is the height in the middle of its cell, `size_m / (columns, rows)` in size.
#[derive(Clone, Debug, PartialEq)]
pub struct Heightmap {
    /// Samples along x, 2..=16384.
    pub columns: u32,
    /// Samples along z, 2..=16384.
    pub rows: u32,
    /// Heights (m), finite, row by row; row 0 is at -z and column 0 at -x.
    pub height_m: Vec<f32>,
    /// Extent along x and z (m), more than 0.
    pub size_m: [f32; 2],
    /// What was mended while loading, a line each for people.
    pub warnings: Vec<String>,
}

/// Why a heightmap cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum HeightmapError {
    /// The file cannot be read.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// The path leads to a folder or a device.
    #[error("not a file")]
    NotAFile,
    /// The file is too large.
    #[error("larger than 1 GiB")]
    TooManyBytes,
    /// The name ends neither in `.png` nor in `.asc`, or no built-in asset has it.
    #[error("no such heightmap; allowed: .png and .asc files and built-in assets")]
    UnknownName,
    /// The grid is too small or too large.
    #[error("{columns} x {rows} samples; allowed: 2 x 2 to 16384 x 16384")]
    Size {
        /// Columns that the file claims.
        columns: u64,
        /// Rows that the file claims.
        rows: u64,
    },
    /// The PNG file is not plain grey.
    #[error("{given}; allowed: grey of 8 or 16 bits, without alpha and interlacing")]
    PngKind {
        /// What it is.
        given: String,
    },
    /// The PNG file is broken.
    #[error("{0}")]
    Png(#[from] png::DecodingError),
    /// A line of the ESRI ASCII grid is wrong.
    #[error("line {line}: {message}")]
    Asc {
        /// Line, counted from 1.
        line: usize,
        /// What is wrong with it.
        message: String,
    },
    /// The ESRI ASCII grid ends early.
    #[error("{given} heights of {columns} x {rows}; the file is cut short")]
    AscTooShort {
        /// Heights in the file.
        given: usize,
        /// Columns in the header.
        columns: u32,
        /// Rows in the header.
        rows: u32,
    },
    /// No sample has a height.
    #[error("all {count} heights are NODATA")]
    AllNoData {
        /// Samples in the file.
        count: usize,
    },
}

/// What a heightmap's file is, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Png,
    Asc,
}

impl Format {
    pub(super) fn of(name: &str) -> Option<Self> {
        let extension = Path::new(name).extension()?;
        match () {
            () if extension.eq_ignore_ascii_case("png") => Some(Self::Png),
            () if extension.eq_ignore_ascii_case("asc") => Some(Self::Asc),
            () => None,
        }
    }
}

impl Heightmap {
    /// Makes the heightmap that `source` describes of its file's `bytes`.
    pub fn decode(source: &TerrainSource, bytes: &[u8]) -> Result<Self, HeightmapError> {
        if bytes.len() as u64 > MAX_BYTES {
            return Err(HeightmapError::TooManyBytes);
        }
        match Format::of(&source.heightmap).ok_or(HeightmapError::UnknownName)? {
            Format::Png => from_png(bytes, source.size_m, source.height_m.unwrap_or([0.0, 1.0])),
            Format::Asc => asc::decode(bytes, source.size_m),
        }
    }

    /// The height at (x, z) (m), linear between samples and constant beyond the outermost.
    pub fn height_at(&self, x: f32, z: f32) -> f32 {
        let axis = |at: f32, size: f32, count: u32| {
            let position = ((at / size + 0.5) * count as f32 - 0.5).clamp(0.0, (count - 1) as f32);
            let before = (position as u32).min(count - 2);
            (before as usize, position - before as f32)
        };
        let (column, right) = axis(x, self.size_m[0], self.columns);
        let (row, down) = axis(z, self.size_m[1], self.rows);
        let stride = self.columns as usize;
        let at = |row: usize| {
            let left = self.height_m[row * stride + column];
            left + right * (self.height_m[row * stride + column + 1] - left)
        };
        let (near, far) = (at(row), at(row + 1));
        near + down * (far - near)
    }
}

pub(super) fn load(source: &TerrainSource, base_dir: Option<&Path>) -> Result<Heightmap, SceneError> {
    let bytes = read(&source.heightmap, base_dir, MAX_BYTES + 1);
    bytes
        .and_then(|bytes| Heightmap::decode(source, &bytes))
        .map_err(|reason| SceneError::Heightmap { file: source.heightmap.clone(), reason })
}

/// Columns and rows times the cell size of an `.asc` file (m).
pub(super) fn asc_size_m(name: &str, base_dir: Option<&Path>) -> Result<[f32; 2], HeightmapError> {
    let bytes = read(name, base_dir, ASC_HEADER_BYTES)?;
    let text = String::from_utf8_lossy(&bytes);
    let header = AscHeader::read(&mut asc::numbered_lines(&text).peekable())?;
    header.size_m()
}

/// The first `limit` bytes of a file or of a built-in asset.
fn read(name: &str, base_dir: Option<&Path>, limit: u64) -> Result<Vec<u8>, HeightmapError> {
    let mut bytes = Vec::new();
    if name.starts_with("builtin/") {
        builtin::asset(name).ok_or(HeightmapError::UnknownName)?.take(limit).read_to_end(&mut bytes)?;
        return Ok(bytes);
    }
    let path = base_dir.map_or_else(|| name.into(), |dir| dir.join(name));
    // Asked before opening, for opening a pipe waits.
    if !std::fs::metadata(&path)?.is_file() {
        return Err(HeightmapError::NotAFile);
    }
    File::open(path)?.take(limit).read_to_end(&mut bytes)?;
    Ok(bytes)
}

pub(super) fn check_size(columns: u64, rows: u64) -> Result<(u32, u32), HeightmapError> {
    let side = |count: u64| u32::try_from(count).ok().filter(|side| (2..=MAX_SIDE).contains(side));
    side(columns).zip(side(rows)).ok_or(HeightmapError::Size { columns, rows })
}

fn from_png(bytes: &[u8], size_m: [f32; 2], height_m: [f32; 2]) -> Result<Heightmap, HeightmapError> {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info()?;
    let info = reader.info();
    let (columns, rows) = check_size(info.width.into(), info.height.into())?;
    let bytes_per_sample = match (info.color_type, info.bit_depth, info.interlaced) {
        (png::ColorType::Grayscale, png::BitDepth::Eight, false) => 1,
        (png::ColorType::Grayscale, png::BitDepth::Sixteen, false) => 2,
        (color, depth, interlaced) => {
            let interlaced = if interlaced { ", interlaced" } else { "" };
            let given = format!("{color:?} of {} bits{interlaced}", depth as u8);
            return Err(HeightmapError::PngKind { given });
        }
    };
    let [black, white] = height_m.map(f64::from);
    let most = if bytes_per_sample == 1 { 255.0 } else { 65535.0 };
    // Grows with what is decoded: a header alone makes no allocation larger than a row.
    let mut height_m = Vec::new();
    while let Some(row) = reader.next_row()? {
        let samples = row.data().chunks_exact(bytes_per_sample);
        height_m.extend(samples.map(|sample| {
            let value = sample.iter().fold(0, |value, byte| value << 8 | u32::from(*byte));
            (black + (white - black) * f64::from(value) / most) as f32
        }));
    }
    Ok(Heightmap { columns, rows, height_m, size_m, warnings: Vec::new() })
}
