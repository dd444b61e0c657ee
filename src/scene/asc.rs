// SPDX-License-Identifier: MIT OR Apache-2.0
//! ESRI ASCII grids: a few `key value` lines, then the heights row by row from the north.

use super::{
    heightmap::{check_size, Heightmap},
    HeightmapError,
};

/// What the lines before the heights say.
pub(super) struct AscHeader {
    columns: u32,
    rows: u32,
    cell_m: f64,
    no_data: f64,
}

/// A line and its number, counted from 1.
type Line<'a> = (usize, &'a str);

pub(super) fn numbered_lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    (1..).zip(text.trim_start_matches('\u{feff}').lines())
}

/// As much of a word as an error shows.
fn start(word: &str) -> String {
    word.chars().take(40).collect()
}

fn asc_error(line: usize, message: impl Into<String>) -> HeightmapError {
    HeightmapError::Asc { line, message: message.into() }
}

impl AscHeader {
    /// Reads the lines that start with a key of the header and leaves the others.
    pub(super) fn read<'a>(
        lines: &mut std::iter::Peekable<impl Iterator<Item = Line<'a>>>,
    ) -> Result<Self, HeightmapError> {
        const KEYS: [&str; 8] = [
            "ncols",
            "nrows",
            "cellsize",
            "nodata_value",
            "xllcorner",
            "yllcorner",
            "xllcenter",
            "yllcenter",
        ];
        let mut values: [Option<f64>; KEYS.len()] = Default::default();
        let key = |line: &str| {
            let first = line.split_whitespace().next()?;
            KEYS.iter().position(|key| key.eq_ignore_ascii_case(first))
        };
        let mut end = 1;
        while let Some((number, line)) =
            lines.next_if(|(_, line)| line.trim().is_empty() || key(line).is_some())
        {
            end = number + 1;
            let Some(key) = key(line) else { continue };
            let value = line.split_whitespace().nth(1).and_then(|word| word.parse().ok());
            values[key] =
                Some(value.ok_or_else(|| asc_error(number, format!("{} has no number", KEYS[key])))?);
        }
        let need = |key: usize| {
            values[key].ok_or_else(|| asc_error(end, format!("the header ends without {}", KEYS[key])))
        };
        let (columns, rows, cell_m) = (need(0)?, need(1)?, need(2)?);
        // A number that is not whole is not a count; `as` saturates and turns NaN into 0.
        let count = |x: f64| if x.fract() == 0.0 { x as u64 } else { 0 };
        let (columns, rows) = check_size(count(columns), count(rows))?;
        if !(cell_m.is_finite() && cell_m > 0.0) {
            return Err(asc_error(end, format!("cellsize is {cell_m}; allowed: finite, more than 0")));
        }
        Ok(Self { columns, rows, cell_m, no_data: values[3].unwrap_or(-9999.0) })
    }

    /// Extent along x and z (m).
    pub(super) fn size_m(&self) -> Result<[f32; 2], HeightmapError> {
        let size_m = [self.columns, self.rows].map(|count| (f64::from(count) * self.cell_m) as f32);
        if size_m.iter().all(|size| size.is_finite() && *size > 0.0) {
            Ok(size_m)
        } else {
            Err(asc_error(1, format!("cellsize {} makes a grid of {size_m:?} m", self.cell_m)))
        }
    }
}

pub(super) fn decode(bytes: &[u8], size_m: [f32; 2]) -> Result<Heightmap, HeightmapError> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|byte| **byte == b'\n').count();
        asc_error(line, "not a text")
    })?;
    let mut lines = numbered_lines(text).peekable();
    let header = AscHeader::read(&mut lines)?;
    let (columns, rows) = (header.columns, header.rows);
    let count = columns as usize * rows as usize;
    // Grows with what is read. A sample without data is NaN until it is filled; no other sample is.
    let mut height_m: Vec<f32> = Vec::new();
    for (number, line) in lines {
        for word in line.split_whitespace() {
            let height: f64 =
                word.parse().map_err(|_| asc_error(number, format!("{:?} is not a number", start(word))))?;
            let is_no_data = height == header.no_data || (height.is_nan() && header.no_data.is_nan());
            let height = if is_no_data { f32::NAN } else { height as f32 };
            if !is_no_data && !height.is_finite() {
                return Err(asc_error(number, format!("{:?} is not a finite height", start(word))));
            }
            if height_m.len() == count {
                return Err(asc_error(number, format!("more than {columns} x {rows} heights")));
            }
            height_m.push(height);
        }
    }
    if height_m.len() < count {
        return Err(HeightmapError::AscTooShort { given: height_m.len(), columns, rows });
    }
    let filled = fill_no_data(&mut height_m, columns as usize)?;
    let warnings = match filled {
        0 => Vec::new(),
        _ => vec![format!(
            "{filled} of {count} heights are NODATA; each was given that of a nearest neighbour"
        )],
    };
    Ok(Heightmap { columns, rows, height_m, size_m, warnings })
}

/// Gives every NaN the height of a nearest sample, counted in steps along rows and columns.
fn fill_no_data(height_m: &mut [f32], columns: usize) -> Result<usize, HeightmapError> {
    let missing = height_m.iter().filter(|height| height.is_nan()).count();
    if missing == height_m.len() {
        return Err(HeightmapError::AllNoData { count: missing });
    }
    let mut front: Vec<usize> =
        (0..height_m.len()).filter(|&i| missing > 0 && !height_m[i].is_nan()).collect();
    while !front.is_empty() {
        let mut next = Vec::new();
        for i in front {
            let column = i % columns;
            let left = (column > 0).then(|| i - 1);
            let right = (column + 1 < columns).then(|| i + 1);
            for neighbour in [i.checked_sub(columns), left, right, Some(i + columns)].into_iter().flatten() {
                if height_m.get(neighbour).is_some_and(|height| height.is_nan()) {
                    height_m[neighbour] = height_m[i];
                    next.push(neighbour);
                }
            }
        }
        front = next;
    }
    Ok(missing)
}
