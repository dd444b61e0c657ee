// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shaders from the files that they were compiled from: what is edited is measured, or seen in the window, without a
//! build. Only those whose text is not the binary's, that of their includes among it, are compiled.
//!
//! What a scene compiles itself, effects and laws of its own, sees what [`super::include`] was given, else the includes of the
//! binary; in the window the latter.

use super::{
    glsl::{self, Compiler, Stage},
    reload::Replacements,
};
use crate::shaders;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// A folder of GLSL.
pub struct Files(PathBuf);

/// What was compiled.
pub struct Compiled {
    /// For [`Gpu::replace_shaders`](super::Gpu::replace_shaders).
    pub replacements: Replacements,
    /// Names of the shaders.
    pub names: Vec<String>,
    /// Files that they include and that differ, by their paths below the folder: for [`super::include`].
    pub includes: BTreeMap<String, String>,
}

/// Path below the folder and text of every file.
fn texts(dir: &Path) -> Result<BTreeMap<String, String>, String> {
    let list = |dir: &Path| -> Result<Vec<PathBuf>, String> {
        let entries = fs::read_dir(dir).map_err(|error| format!("{}: {error}", dir.display()))?;
        Ok(entries.flatten().map(|entry| entry.path()).collect())
    };
    // Editors leave files of their own beside these.
    let is_glsl = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str());
        path.is_file() && ending.is_some_and(|it| matches!(it, "comp" | "vert" | "frag" | "geom" | "glsl"))
    };
    let mut all = BTreeMap::new();
    for module in list(dir)?.into_iter().filter(|path| path.is_dir()) {
        for path in list(&module)?.into_iter().filter(is_glsl) {
            let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            let name = path.strip_prefix(dir).unwrap_or(&path).to_string_lossy().replace('\\', "/");
            all.insert(name, text);
        }
    }
    Ok(all)
}

/// Whether `file` or anything that it includes is in `changed`.
fn is_touched(
    file: &str,
    texts: &BTreeMap<String, String>,
    changed: &BTreeSet<&String>,
    seen: &mut BTreeSet<String>,
) -> bool {
    if !seen.insert(file.to_owned()) {
        return false;
    }
    let Some((name, text)) = texts.get_key_value(file) else { return false };
    let mut includes =
        text.lines().filter_map(|line| line.trim().strip_prefix("#include \"")?.split('"').next());
    changed.contains(name) || includes.any(|include| is_touched(include, texts, changed, seen))
}

impl Files {
    /// Those in `dir`, which may come later.
    pub fn new(dir: &Path) -> Self {
        Self(dir.to_owned())
    }

    /// The folder.
    pub fn dir(&self) -> &Path {
        &self.0
    }

    /// Compiles those of [`shaders::ALL`] that are wanted and are not what the binary has; `None` if there is no such folder.
    ///
    /// # Errors
    /// The compiler's words, with file, line and excerpt.
    pub fn compile(&self, is_wanted: impl Fn(&'static [u8]) -> bool) -> Result<Option<Compiled>, String> {
        let Self(dir) = self;
        if !dir.is_dir() {
            return Ok(None);
        }
        let now = texts(dir)?;
        if !shaders::HASHES.iter().any(|(name, _)| now.contains_key(*name)) {
            return Err(format!(
                "{}: none of this crate's shaders is below it, as water/waves.comp",
                dir.display()
            ));
        }
        let binary: BTreeMap<&str, u64> = shaders::HASHES.iter().copied().collect();
        let is_other =
            |(name, text): &(&String, &String)| binary.get(name.as_str()) != Some(&glsl::hash(text));
        let changed: BTreeSet<_> = now.iter().filter(is_other).map(|(name, _)| name).collect();
        let includes = now.clone();
        let compiler =
            Compiler::new(move |name| includes.get(name).cloned()).map_err(|error| error.to_string())?;
        let others = changed.iter().filter(|name| name.ends_with(".glsl"));
        let others = others.map(|name| ((*name).clone(), now[*name].clone())).collect();
        let mut compiled =
            Compiled { replacements: Replacements::new(), names: Vec::new(), includes: others };
        for (name, spv) in shaders::ALL.iter().filter(|(_, spv)| is_wanted(spv)) {
            let [module, pass, kind] = name.splitn(3, '.').collect::<Vec<_>>()[..] else { continue };
            let (file, stage) = (format!("{module}/{pass}.{kind}"), Stage::of_extension(kind));
            let (Some(text), Some(stage)) = (now.get(&file), stage) else { continue };
            if !is_touched(&file, &now, &changed, &mut BTreeSet::new()) {
                continue;
            }
            let shown = dir.join(&file).to_string_lossy().into_owned();
            let words = compiler.compile(text, &shown, stage).map_err(|error| error.to_string())?;
            let bytes = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            compiled.replacements.insert(spv.as_ptr() as usize, bytes);
            compiled.names.push((*name).to_owned());
        }
        Ok(Some(compiled))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_of_this_crate_is_what_the_binary_has() {
        let files = texts(Path::new("glsl")).expect("the folder");
        assert_eq!(files.len(), shaders::HASHES.len());
        for (name, hash) in shaders::HASHES {
            assert_eq!(glsl::hash(&files[*name]), *hash, "{name}");
        }
    }

    #[test]
    fn a_shader_is_touched_through_its_includes() {
        let files = [
            ("a/x.comp", "#include \"a/y.glsl\"\n"),
            ("a/y.glsl", "#include \"b/z.glsl\""),
            ("b/z.glsl", ""),
        ];
        let texts: BTreeMap<_, _> =
            files.iter().map(|(name, text)| (name.to_string(), text.to_string())).collect();
        let (z, other) = ("b/z.glsl".to_owned(), "b/w.glsl".to_owned());
        let touched = |file: &str, changed: &String| {
            is_touched(file, &texts, &BTreeSet::from([changed]), &mut BTreeSet::new())
        };
        assert!(touched("a/x.comp", &z) && touched("b/z.glsl", &z));
        assert!(!touched("a/x.comp", &other) && !touched("a/missing.comp", &z));
    }
}
