// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whatever is broken in a scene or a heightmap: an error, never a panic.

use crate::heightmaps::png_file;
use whitecap::scene::{builtin, Heightmap, Scene, TerrainSource};

/// A deterministic stream of numbers (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 33) as usize % n
    }

    /// Replaces, inserts, deletes or repeats a few bytes.
    fn mutate(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        for _ in 0..=self.below(4) {
            let at = self.below(bytes.len());
            let byte = if self.below(2) == 0 {
                self.below(256) as u8
            } else {
                b"0123456789.-[]{}=\"'e\n#,"[self.below(23)]
            };
            match self.below(4) {
                0 => bytes.insert(at, byte),
                1 if bytes.len() > 1 => drop(bytes.remove(at)),
                2 => {
                    let end = (at + self.below(20)).min(bytes.len());
                    let copy = bytes[at..end].to_vec();
                    let to = self.below(bytes.len());
                    bytes.splice(to..to, copy);
                }
                _ => bytes[at] = byte,
            }
        }
        bytes
    }
}

#[test]
fn no_scene_however_broken_panics() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for (name, _) in builtin::list() {
        let text = builtin::toml(name).unwrap();
        for _ in 0..1500 {
            let broken = random.mutate(text.as_bytes());
            let broken = String::from_utf8_lossy(&broken);
            if let Err(error) = Scene::parse(&broken, "broken.toml", None, &[]) {
                assert!(!error.to_string().is_empty());
            }
            let change = random.mutate(b"water.0.start={shape='hump', height_m=1}");
            if let Ok(change) = String::from_utf8_lossy(&change).parse() {
                let _ = Scene::parse(text, "lake.toml", None, &[change]).map_err(|error| error.to_string());
            }
        }
    }
}

#[test]
fn no_heightmap_however_broken_panics() {
    let mut random = Random(0xd1b5_4a32_d192_ed03);
    let grey: Vec<u8> = (0..128).collect();
    let png = png_file(8, 8, png::ColorType::Grayscale, png::BitDepth::Sixteen, &grey);
    let asc = b"ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 0.5\nNODATA_value -9\n1 2 3 4\n5 -9 7 8\n9 1 2 3\n";
    for (name, bytes) in [("a.png", png.as_slice()), ("a.asc", asc)] {
        let source =
            TerrainSource { heightmap: name.to_owned(), size_m: [4.0, 2.0], height_m: Some([-1.0, 1.0]) };
        for _ in 0..5000 {
            if let Ok(map) = Heightmap::decode(&source, &random.mutate(bytes)) {
                assert_eq!(map.height_m.len(), map.columns as usize * map.rows as usize);
                assert!(map.height_m.iter().all(|height| height.is_finite()));
            }
        }
    }
}
