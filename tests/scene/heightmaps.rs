// SPDX-License-Identifier: MIT OR Apache-2.0
//! Heightmaps: grey images and ESRI grids.

use super::{parse, LAKE};
use std::path::Path;
use whitecap::scene::{Heightmap, HeightmapError, Scene, SceneError, TerrainSource};

pub fn png_file(
    width: u32,
    height: u32,
    color: png::ColorType,
    depth: png::BitDepth,
    data: &[u8],
) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    file
}

fn load(name: &str, bytes: &[u8]) -> Result<Heightmap, SceneError> {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join(name), bytes).unwrap();
    let heights = if name.ends_with(".png") { "height_m = [-1, 1]" } else { "" };
    let scene = format!("[terrain]\nheightmap = '{name}'\nsize_m = [4, 2]\n{heights}");
    std::fs::write(dir.path().join("scene.toml"), scene).unwrap();
    let scene = Scene::load(&dir.path().join("scene.toml"), &[]).unwrap();
    scene.terrain_heights().map(|heights| heights.expect("the scene has terrain"))
}

fn load_error(name: &str, bytes: &[u8]) -> HeightmapError {
    match load(name, bytes) {
        Err(SceneError::Heightmap { file, reason }) if file == name => reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn grey_images_of_8_and_16_bits_span_the_heights() {
    use png::{BitDepth::*, ColorType::Grayscale};
    let map = load("a.png", &png_file(3, 2, Grayscale, Eight, &[0, 51, 255, 0, 0, 102])).unwrap();
    assert_eq!((map.columns, map.rows, map.size_m), (3, 2, [4.0, 2.0]));
    assert_eq!(map.height_m, [-1.0, -0.6, 1.0, -1.0, -1.0, -0.2]);
    let map =
        load("a.png", &png_file(2, 2, Grayscale, Sixteen, &[0, 0, 255, 255, 0x33, 0x33, 0, 0])).unwrap();
    assert_eq!(map.height_m, [-1.0, 1.0, -0.6, -1.0]);
    assert!(map.warnings.is_empty());
}

#[test]
fn other_images_are_refused_by_what_they_are() {
    use png::{BitDepth::*, ColorType::*};
    for (color, depth, bytes, message) in [
        (Rgb, Eight, 12, "Rgb of 8 bits; allowed: grey of 8 or 16 bits, without alpha and interlacing"),
        (GrayscaleAlpha, Sixteen, 16, "GrayscaleAlpha of 16 bits; allowed: grey of 8 or 16 bits"),
        (Grayscale, Four, 2, "Grayscale of 4 bits; allowed: grey of 8 or 16 bits"),
    ] {
        let error = load_error("a.png", &png_file(2, 2, color, depth, &vec![0; bytes])).to_string();
        assert!(error.starts_with(message), "{error}");
    }
    let error = load_error("a.png", &png_file(1, 2, Grayscale, Eight, &[0, 0]));
    assert_eq!(error.to_string(), "1 x 2 samples; allowed: 2 x 2 to 16384 x 16384");
}

/// A PNG whose header, with a right checksum, claims another size than its data has.
fn png_claiming(width: u32, height: u32) -> Vec<u8> {
    let mut file = png_file(2, 2, png::ColorType::Grayscale, png::BitDepth::Eight, &[0; 4]);
    file[16..20].copy_from_slice(&width.to_be_bytes());
    file[20..24].copy_from_slice(&height.to_be_bytes());
    let crc = file[12..29].iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    });
    file[29..33].copy_from_slice(&(!crc).to_be_bytes());
    file
}

#[test]
fn broken_images_are_errors() {
    let good = png_file(2, 2, png::ColorType::Grayscale, png::BitDepth::Eight, &[0; 4]);
    assert_eq!(png_claiming(2, 2), good);
    for length in 0..good.len() - 16 {
        assert!(matches!(load_error("a.png", &good[..length]), HeightmapError::Png(_)), "{length} bytes");
    }
    assert!(matches!(load_error("a.png", &png_claiming(u32::MAX, 2)), HeightmapError::Png(_)));
    assert!(matches!(load_error("a.png", &png_claiming(16385, 2)), HeightmapError::Size { .. }));
    assert!(matches!(load_error("a.png", &png_claiming(16384, 16384)), HeightmapError::Png(_)));
    assert!(matches!(load_error("a.png", b"no image"), HeightmapError::Png(_)));
}

#[test]
fn an_esri_grid_is_read_from_the_north_and_brings_its_size() {
    let text =
        "\u{feff}NCOLS 3\r\nnrows 2\r\nxllcorner 5\r\nyllcorner 6\r\ncellsize 2.5\r\n1 2 3\r\n-4 5e-1 6\r\n";
    let map = load("a.asc", text.as_bytes()).unwrap();
    assert_eq!((map.columns, map.rows, map.size_m), (3, 2, [4.0, 2.0]));
    assert_eq!(map.height_m, [1.0, 2.0, 3.0, -4.0, 0.5, 6.0]);

    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("a.asc"), text).unwrap();
    let read = |text: &str| Scene::parse(text, "s.toml", Some(dir.path()), &[]);
    let scene = read("[terrain]\nheightmap = 'a.asc'").unwrap();
    assert_eq!(scene.terrain.as_ref().unwrap().size_m, [7.5, 5.0]);
    assert_eq!(scene.terrain_heights().unwrap().unwrap().size_m, [7.5, 5.0]);
    let error = read("[terrain]\nheightmap = 'b.asc'").unwrap_err().to_string();
    assert!(error.starts_with("s.toml:2:13: terrain.heightmap cannot be used: "), "{error}");
}

#[test]
fn samples_without_data_are_filled_from_the_nearest_and_counted() {
    let header = "ncols 4\nnrows 2\ncellsize 1\n";
    let map = load("a.asc", format!("{header}-9999 1 -9999 -9999\n-9999 -9999 -9999 2").as_bytes()).unwrap();
    assert_eq!(map.height_m, [1.0, 1.0, 1.0, 2.0, 1.0, 1.0, 2.0, 2.0]);
    assert_eq!(map.warnings, ["6 of 8 heights are NODATA; each was given that of a nearest neighbour"]);
    let map = load("a.asc", format!("{header}nodata_value nan\nnan 1 2 3 4 5 6 7").as_bytes()).unwrap();
    assert_eq!((map.height_m[0], map.warnings.len()), (1.0, 1));
    let error = load_error("a.asc", format!("{header}nodata_value 0\n0 0 0 0 0 0 0 0").as_bytes());
    assert_eq!(error.to_string(), "all 8 heights are NODATA");
}

#[test]
fn broken_grids_are_errors_with_their_line() {
    for (text, message) in [
        ("", "line 1: the header ends without ncols"),
        ("ncols 2\nnrows 2\n1 2 3 4", "line 3: the header ends without cellsize"),
        ("ncols 2\nnrows x\ncellsize 1\n", "line 2: nrows has no number"),
        ("ncols 2\nnrows\n", "line 2: nrows has no number"),
        ("ncols 2.5\nnrows 2\ncellsize 1\n", "0 x 2 samples; allowed: 2 x 2 to 16384 x 16384"),
        ("ncols 99999\nnrows 1e300\ncellsize 1\n", "99999 x 18446744073709551615 samples; allowed: 2"),
        ("ncols 2\nnrows 2\ncellsize 0\n", "line 4: cellsize is 0; allowed: finite, more than 0"),
        ("ncols 2\nnrows 2\ncellsize 1\n1 2\n3", "3 heights of 2 x 2; the file is cut short"),
        ("ncols 2\nnrows 2\ncellsize 1\n1 2\n3 4 5", "line 5: more than 2 x 2 heights"),
        ("ncols 2\nnrows 2\ncellsize 1\n1 two\n3 4", "line 4: \"two\" is not a number"),
        ("ncols 2\nnrows 2\ncellsize 1\n1 inf\n3 4", "line 4: \"inf\" is not a finite height"),
        ("ncols 2\nnrows 2\ncellsize 1\n1 1e39\n3 4", "line 4: \"1e39\" is not a finite height"),
        ("ncols 16384\nnrows 16384\ncellsize 1\n1", "1 heights of 16384 x 16384; the file is cut short"),
    ] {
        let error = load_error("a.asc", text.as_bytes()).to_string();
        assert!(error.starts_with(message), "{text}\n{error}");
    }
    let error = load_error("a.asc", b"ncols 2\nnrows 2\ncellsize 1\n1 \xff\n").to_string();
    assert_eq!(error, "line 4: not a text");
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = Scene::load(Path::new("nowhere/lake.toml"), &[]).unwrap_err().to_string();
    assert!(error.starts_with("nowhere/lake.toml: "), "{error}");
    let scene = parse("[terrain]\nheightmap = 'none.png'\nsize_m = [1, 1]\nheight_m = [0, 1]").unwrap();
    let error = scene.terrain_heights().unwrap_err().to_string();
    assert!(error.starts_with("none.png: "), "{error}");
    let scene = Scene { base_dir: Some(std::env::temp_dir()), ..scene };
    let folder = Scene {
        terrain: scene.terrain.map(|t| TerrainSource { heightmap: ".".into(), ..t }),
        ..parse(LAKE).unwrap()
    };
    assert_eq!(folder.terrain_heights().unwrap_err().to_string(), ".: not a file");
}

#[test]
fn heights_between_samples_are_linear_and_constant_outside() {
    let map = Heightmap {
        columns: 2,
        rows: 2,
        height_m: vec![0.0, 1.0, 2.0, 3.0],
        size_m: [4.0, 8.0],
        warnings: Vec::new(),
    };
    for (x, z, height) in [
        (-1.0, -2.0, 0.0),
        (1.0, -2.0, 1.0),
        (-1.0, 2.0, 2.0),
        (0.0, 0.0, 1.5),
        (9.0, 9.0, 3.0),
        (-9.0, 0.0, 1.0),
    ] {
        assert_eq!(map.height_at(x, z), height, "at {x}, {z}");
    }
}
