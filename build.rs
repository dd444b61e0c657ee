// SPDX-License-Identifier: MIT OR Apache-2.0
//! Compiles `glsl/<module>/<pass>.<stage>` with warnings as errors, and writes `$OUT_DIR/shaders.rs`: the SPIR-V as
//! constants (`WATER_BOOK_COMP`), a list of all of them, the include files for the run-time compiler, and hashes of all
//! files, for those who read them again.

use std::{env, fmt::Write, fs, path::Path};

#[allow(dead_code)] // the crate uses the rest
#[path = "src/gpu/glsl.rs"]
mod glsl;

fn main() {
    println!("cargo:rerun-if-changed=glsl");
    println!("cargo:rerun-if-changed=src/gpu/glsl.rs");
    let out = env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    let compiler = glsl::Compiler::new(|include| fs::read_to_string(Path::new("glsl").join(include)).ok())
        .unwrap_or_else(|error| panic!("{error}"));

    let (mut code, mut all, mut includes) = (String::new(), String::new(), String::new());
    let mut hashes = String::new();
    for (module, file, path) in sources() {
        let source = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
        writeln!(hashes, "    (\"{module}/{file}\", {}),", glsl::hash(&source)).expect("a String");
        let (stem, kind) = file.rsplit_once('.').expect("a file name with an extension");
        let Some(stage) = glsl::Stage::of_extension(kind) else {
            let absolute = fs::canonicalize(&path).expect("a file just listed");
            writeln!(includes, "    (\"{module}/{file}\", include_str!({absolute:?})),").expect("a String");
            continue;
        };
        let mut words = compiler.compile(&source, &path, stage).unwrap_or_else(|e| panic!("\n{e}\n"));
        if env::var("PROFILE").as_deref() == Ok("release") {
            words = without_source(&words);
        }
        let spv = format!("{out}/{module}.{stem}.{kind}.spv");
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        fs::write(&spv, &bytes).unwrap_or_else(|e| panic!("{spv}: {e}"));
        let name = format!("{module}_{stem}_{kind}").to_uppercase();
        // A static has one place in the binary; the bytes of a constant are copied into each unit that names it.
        let count = bytes.len();
        writeln!(code, "static {name}_BYTES: [u8; {count}] = *include_bytes!({spv:?});").expect("a String");
        writeln!(code, "/// `glsl/{module}/{file}`.\npub const {name}: &[u8] = &{name}_BYTES;")
            .expect("a String");
        writeln!(all, "    (\"{module}.{stem}.{kind}\", {name}),").expect("a String");
    }
    writeln!(
        code,
        "/// Every shader: `module.pass.stage` and SPIR-V.\npub const ALL: &[(&str, &[u8])] = &[\n{all}];"
    )
    .expect("a String");
    writeln!(
        code,
        "/// Files that shaders include: path below `glsl/` and text.\npub const INCLUDES: &[(&str, &str)] = &[\n{includes}];"
    )
    .expect("a String");
    writeln!(
        code,
        "/// Every file of `glsl/`, by its path below it: [`hash`](crate::gpu::glsl::hash) of its text.\npub const HASHES: &[(&str, u64)] = &[\n{hashes}];"
    )
    .expect("a String");
    fs::write(format!("{out}/shaders.rs"), code).expect("OUT_DIR is writable");
}

/// The module without the text of its source and the lines that point into it, a third of its size; names stay, as
/// reflection needs them.
fn without_source(words: &[u32]) -> Vec<u32> {
    const SOURCE_CONTINUED: u32 = 2;
    const SOURCE: u32 = 3;
    const STRING: u32 = 7;
    const LINE: u32 = 8;
    const NO_LINE: u32 = 317;
    let (header, mut rest) = words.split_at(5);
    let mut out = header.to_vec();
    while let Some(first) = rest.first() {
        let (one, after) = rest.split_at((first >> 16) as usize);
        if !matches!(first & 0xffff, SOURCE_CONTINUED | SOURCE | STRING | LINE | NO_LINE) {
            out.extend(one);
        }
        rest = after;
    }
    out
}

/// Module, file name and path of everything under `glsl/`, sorted, so that builds are reproducible.
fn sources() -> Vec<(String, String, String)> {
    let list = |dir: &Path| -> Vec<_> {
        let entries = fs::read_dir(dir).unwrap_or_else(|e| panic!("{}: {e}", dir.display()));
        let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
        paths.sort();
        paths
    };
    let name = |path: &Path| path.file_name().expect("a listed file").to_string_lossy().into_owned();
    let mut found = Vec::new();
    for dir in list(Path::new("glsl")).into_iter().filter(|path| path.is_dir()) {
        for path in list(&dir) {
            found.push((name(&dir), name(&path), path.to_string_lossy().into_owned()));
        }
    }
    found
}
