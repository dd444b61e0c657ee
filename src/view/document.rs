// SPDX-License-Identifier: MIT OR Apache-2.0
//! The scene as a text that is edited: comments and order stay, and every change goes through the schema as a file does.

use crate::scene::{Given, Override, Parameter, Scene, SceneError, Takes};
use std::{
    io,
    path::{Component, Path, PathBuf},
};
use toml_edit::{Array, DocumentMut, Item, Table, Value};

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The TOML.
    pub text: String,
    /// Stands in errors.
    pub name: String,
    /// The file, if it is one: read again.
    pub file: Option<PathBuf>,
    /// Changes of the command line.
    pub changes: Vec<Override>,
}

/// A scene that is edited.
#[derive(Clone, Debug)]
pub struct Document {
    name: String,
    base_dir: Option<PathBuf>,
    tree: DocumentMut,
}

impl Document {
    /// # Errors
    /// If it is not TOML, or a change does not fit it.
    pub fn new(source: &Source) -> Result<Self, SceneError> {
        // The schema's words for what is wrong are better than the editor's, and come first.
        let base_dir = source.file.as_deref().and_then(|file| file.parent()).map(PathBuf::from);
        Scene::parse(&source.text, &source.name, base_dir.as_deref(), &source.changes)?;
        let wrong = |message: String| SceneError::Shader { file: source.name.clone(), reason: message };
        let tree = source.text.parse::<DocumentMut>().map_err(|error| wrong(error.to_string()))?;
        let mut made = Self { name: source.name.clone(), base_dir, tree };
        for change in &source.changes {
            let (path, value) = change.parts();
            made.set(path, value).map_err(&wrong)?;
        }
        Ok(made)
    }

    /// As a file.
    pub fn text(&self) -> String {
        self.tree.to_string()
    }

    /// What the text means, and every key that it has or could have.
    pub fn read(&self) -> (Result<Scene, SceneError>, Vec<Parameter>) {
        Scene::parse_listing(&self.text(), &self.name, self.base_dir.as_deref())
    }

    /// The same scene as `file`, whose folder is there: files that it names from its old folder it names from the new one.
    ///
    /// # Errors
    /// If one of the folders cannot be found.
    pub fn moved_to(&self, file: &Path) -> io::Result<Self> {
        let folder = |path: &Path| match path.as_os_str().is_empty() {
            true => Path::new(".").canonicalize(),
            false => path.canonicalize(),
        };
        let base_dir = file.parent().unwrap_or(Path::new("")).to_owned();
        let (old, new) = (folder(self.base_dir.as_deref().unwrap_or(Path::new("")))?, folder(&base_dir)?);
        let mut moved =
            Self { name: file.display().to_string(), base_dir: Some(base_dir), tree: self.tree.clone() };
        if old != new {
            for Parameter { path, takes, given } in self.read().1 {
                if let (Takes::File, Some(Given::Text(name))) = (takes, given) {
                    if is_beside(&name) {
                        let name =
                            between(&new, &straight(&old.join(&name))).to_string_lossy().replace('\\', "/");
                        moved.put(&path, name.into()).map_err(io::Error::other)?;
                    }
                }
            }
        }
        Ok(moved)
    }

    /// Gives a key a value, in TOML; a bare word is a string. Tables that are not there are made.
    ///
    /// # Errors
    /// What is wrong, for people.
    pub fn set(&mut self, path: &str, value: &str) -> Result<(), String> {
        let value = value.trim();
        let value: Value = match value.parse() {
            Ok(value) => value,
            Err(_) if !value.contains(['"', '[', ']', '{', '}', ',', '=']) => value.into(),
            Err(error) => return Err(format!("{path}: {error}")),
        };
        self.put(path, value)
    }

    /// Gives a key numbers.
    ///
    /// # Errors
    /// If there is no such place.
    pub fn set_numbers(&mut self, path: &str, numbers: &[f64], is_whole: bool) -> Result<(), String> {
        let one = |x: f64| if is_whole { Value::from(x.round() as i64) } else { Value::from(short(x)) };
        self.put(
            path,
            match numbers {
                [x] => one(*x),
                several => Value::Array(several.iter().map(|&x| one(x)).collect::<Array>()),
            },
        )
    }

    /// Gives a key a text or a flag.
    ///
    /// # Errors
    /// If there is no such place.
    pub fn put(&mut self, path: &str, mut value: Value) -> Result<(), String> {
        let (table, key) = path.rsplit_once('.').unwrap_or(("", path));
        let mut at: &mut Item = self.tree.as_item_mut();
        let mut so_far = String::new();
        for part in table.split('.').filter(|part| !part.is_empty()) {
            let index = index_of(at, part, &so_far);
            let next = match index {
                Some(index) => at.get_mut(index),
                None => {
                    at.as_table_like_mut().map(|table| table.entry(part).or_insert(Item::Table(Table::new())))
                }
            };
            so_far = if so_far.is_empty() { part.into() } else { format!("{so_far}.{part}") };
            at = next.ok_or_else(|| format!("{path}: there is no {so_far}"))?;
        }
        if let (Ok(index), Some(array)) = (key.parse::<usize>(), at.as_array_mut()) {
            let old = array.get_mut(index).ok_or_else(|| format!("{path}: there is no such item"))?;
            *value.decor_mut() = old.decor().clone();
            *old = value;
            return Ok(());
        }
        let table = at.as_table_like_mut().ok_or_else(|| format!("{path}: {so_far} is no table"))?;
        match table.get_mut(key) {
            Some(Item::Value(old)) => {
                *value.decor_mut() = old.decor().clone(); // its comment
                *old = value;
            }
            Some(_) => return Err(format!("{path}: is a table")),
            None => {
                table.insert(key, Item::Value(value));
            }
        }
        Ok(())
    }

    /// Leaves a key to its default.
    pub fn remove(&mut self, path: &str) {
        let (table, key) = path.rsplit_once('.').unwrap_or(("", path));
        let mut at: &mut Item = self.tree.as_item_mut();
        let mut so_far = String::new();
        for part in table.split('.').filter(|part| !part.is_empty()) {
            let next = match index_of(at, part, &so_far) {
                Some(index) => at.get_mut(index),
                None => at.get_mut(part),
            };
            so_far = if so_far.is_empty() { part.into() } else { format!("{so_far}.{part}") };
            let Some(next) = next else { return };
            at = next;
        }
        if let Some(table) = at.as_table_like_mut() {
            table.remove(key);
        }
    }
}

/// The place of `part` in an array of tables: a number, or a name as overrides have it.
fn index_of(item: &Item, part: &str, path: &str) -> Option<usize> {
    if !item.is_array_of_tables() && !item.is_array() {
        return None;
    }
    part.parse().ok().or_else(|| {
        let default = (path == "water").then_some("water");
        let named = |i: usize| Some(item.get(i)?.get("name").and_then(Item::as_str).or(default)? == part);
        (0..).map_while(|i| item.get(i).map(|_| i)).find(|&i| named(i) == Some(true))
    })
}

/// Whether this is a file below the folder of the scene, not one of the crate's own nor one with a whole path.
fn is_beside(name: &str) -> bool {
    let path = Path::new(name);
    path.is_relative() && path.extension().is_some() && !name.starts_with("builtin/")
}

/// A file by its folder's own path: a way up after a way down is neither.
fn straight(file: &Path) -> PathBuf {
    let folder = file.parent().and_then(|folder| folder.canonicalize().ok());
    folder.zip(file.file_name()).map_or(file.to_owned(), |(folder, name)| folder.join(name))
}

/// The way from a folder to a file; where there is none, as between drives, the whole path.
fn between(folder: &Path, file: &Path) -> PathBuf {
    let shared = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return file.to_owned();
    }
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    up.chain(file.components().skip(shared)).collect()
}

/// As short as an f32 can be told by: what is dragged has no more digits.
fn short(x: f64) -> f64 {
    let few = x as f32;
    if f64::from(few) == x || (f64::from(few) - x).abs() <= 1e-7 * x.abs() {
        few.to_string().parse().unwrap_or(x)
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    fn pond() -> Document {
        let text = builtin::toml("pond").expect("a built-in scene").to_owned();
        let changes = vec!["water.pond.depth_m=0.7".parse().expect("a change")];
        Document::new(&Source { text, name: "pond".into(), file: None, changes }).expect("a scene")
    }

    #[test]
    fn a_change_keeps_comments_and_goes_through_the_schema() {
        let mut document = pond();
        assert!(document.text().contains("depth_m = 0.7"));
        document.set_numbers("water.0.cells", &[128.0, 128.0], true).expect("a key");
        let text = document.text();
        assert!(text.contains("cells = [128, 128]               # of 12.5 cm"), "{text}");
        assert_eq!(document.read().0.expect("a scene").water[0].cells, [128, 128]);
        document.set("water.0.gravity_mps2", "-1").expect("a place");
        let error = document.read().0.expect_err("out of range").to_string();
        assert!(error.contains("gravity_mps2 is -1") && error.contains("allowed"), "{error}");
        document.remove("water.0.gravity_mps2");
        assert!(document.read().0.is_ok());
    }

    #[test]
    fn a_scene_that_moves_takes_the_way_to_its_files_with_it() {
        let folders = tempfile::tempdir().expect("a folder");
        let (from, to) = (folders.path().join("scenes"), folders.path().join("out/today"));
        std::fs::create_dir_all(&from).expect("a folder");
        std::fs::create_dir_all(&to).expect("a folder");
        let asset = builtin::asset("builtin/pond.asc").expect("a built-in asset");
        std::fs::write(from.join("pond.asc"), asset).expect("a file");
        let absolute = from.join("pond.asc").to_string_lossy().replace('\\', "/");
        for (named, then) in [
            ("pond.asc", "../../scenes/pond.asc"),
            ("builtin/pond.asc", "builtin/pond.asc"),
            (&absolute, &absolute),
        ] {
            let text = builtin::toml("pond").expect("a built-in scene").replace("builtin/pond.asc", named);
            let file = Some(from.join("pond.toml"));
            let source = Source { text, name: "pond.toml".into(), file, changes: Vec::new() };
            let document = Document::new(&source).expect("a scene");
            let moved = document.moved_to(&to.join("b.toml")).expect("two folders");
            assert!(moved.text().contains(&format!("heightmap = \"{then}\"   # says")), "{}", moved.text());
            let terrain =
                |it: &Document| it.read().0.expect("a scene").terrain_heights().expect("its terrain");
            assert_eq!(terrain(&moved), terrain(&document));
            let back = moved.moved_to(&from.join("c.toml")).expect("two folders");
            assert_eq!(back.text(), document.text());
            let up = moved.moved_to(&folders.path().join("d.toml")).expect("two folders");
            assert!(!up.text().contains("../"), "{}", up.text());
        }
    }

    #[test]
    fn tables_that_are_not_there_are_made() {
        let mut document = pond();
        document.set("sun.elevation_deg", "12").expect("a new table");
        assert_eq!(document.read().0.expect("a scene").sun.elevation_deg, 12.0);
        document.set("water.0.drop.1.radius_m", "0.33").expect("an item");
        assert_eq!(document.read().0.expect("a scene").water[0].drops[1].radius_m, 0.33);
        assert!(document.set("water.7.depth_m", "1").is_err());
    }

    #[test]
    fn every_key_is_listed_with_range_unit_and_value() {
        let (_, parameters) = pond().read();
        let find = |path: &str| parameters.iter().find(|it| it.path == path).expect(path);
        use crate::scene::{Given, Takes};
        let depth = find("water.0.depth_m");
        assert_eq!(depth.unit(), "m");
        assert_eq!(depth.given, Some(Given::Numbers(vec![0.7])));
        assert!(matches!(depth.takes, Takes::Numbers { count: 1, is_whole: false, .. }));
        assert_eq!(find("water.0.drop.0.volume_m3").unit(), "m³");
        assert!(
            matches!(&find("water.0.model").takes, Takes::OneOf(names) if names.contains(&"waves".into()))
        );
        assert_eq!(find("sun.azimuth_deg").given, None);
    }
}
