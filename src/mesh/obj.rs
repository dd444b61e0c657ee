// SPDX-License-Identifier: MIT OR Apache-2.0
//! Wavefront OBJ: positions, texture coordinates, normals and faces of all its objects. Materials are passed over.

use super::{Hold, Mesh, Rig, MOST};
use glam::{vec2, Vec2, Vec3};

pub(super) fn decode(bytes: &[u8]) -> Result<Mesh, String> {
    // A face of n corners becomes n - 2 triangles, so the size of the file bounds them.
    if bytes.len() > 1 << 30 {
        return Err(format!("{} bytes; allowed: {}", bytes.len(), 1 << 30));
    }
    check_indices(bytes)?;
    let options =
        tobj::LoadOptions { triangulate: true, single_index: true, ignore_points: true, ignore_lines: true };
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let (models, _) =
        tobj::load_obj_buf(&mut &bytes[..], &options, no_materials).map_err(|error| error.to_string())?;
    let mut mesh = Mesh {
        name: String::new(),
        at_m: Vec::new(),
        normals: Vec::new(),
        uv: Vec::new(),
        hold: Vec::new(),
        triangles: Vec::new(),
        rig: Rig::still(),
    };
    let threes = |floats: &[f32]| floats.chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>();
    let all = |has: fn(&tobj::Mesh) -> bool| models.iter().all(|model| has(&model.mesh));
    let (has_normals, has_uv) = (all(|m| !m.normals.is_empty()), all(|m| !m.texcoords.is_empty()));
    for model in &models {
        let first = mesh.at_m.len();
        if first + model.mesh.positions.len() / 3 > MOST
            || mesh.triangles.len() + model.mesh.indices.len() / 3 > MOST
        {
            return Err(format!("more than {MOST} vertices or triangles"));
        }
        mesh.at_m.extend(threes(&model.mesh.positions));
        if has_normals {
            mesh.normals.extend(threes(&model.mesh.normals).into_iter().map(Vec3::normalize_or_zero));
        }
        if has_uv {
            // OBJ counts v from below.
            let pairs = model.mesh.texcoords.chunks_exact(2).map(|uv| vec2(uv[0], 1.0 - uv[1]));
            mesh.uv.extend(pairs.collect::<Vec<Vec2>>());
        }
        let corner = |i: u32| i.checked_add(first as u32).ok_or("an index beyond 32 bits");
        for corners in model.mesh.indices.chunks_exact(3) {
            mesh.triangles.push([corner(corners[0])?, corner(corners[1])?, corner(corners[2])?]);
        }
    }
    mesh.hold = vec![Hold::on(0); mesh.at_m.len()];
    Ok(mesh)
}

/// The reader multiplies indices before it looks whether they are there.
fn check_indices(bytes: &[u8]) -> Result<(), String> {
    let words = |line: &[u8]| -> Vec<String> {
        line.split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty())
            .map(|word| String::from_utf8_lossy(word).into_owned())
            .collect()
    };
    let lines = || bytes.split(|&byte| byte == b'\n').enumerate();
    let count =
        |kind: &[u8]| lines().filter(|(_, line)| line.trim_ascii_start().starts_with(kind)).count() as i64;
    let counts = [count(b"v "), count(b"vt "), count(b"vn ")].map(|n| n.max(1));
    for (number, line) in lines() {
        let line = line.trim_ascii_start();
        if !line.starts_with(b"f") {
            continue;
        }
        for word in words(line).iter().skip(1) {
            for (part, count) in word.split('/').zip(counts).filter(|(part, _)| !part.is_empty()) {
                if part.parse::<i64>().is_ok_and(|i| i == 0 || i.unsigned_abs() > count as u64) {
                    return Err(format!(
                        "line {}: index {part}; allowed: 1 to {count}, or -1 to -{count}",
                        number + 1
                    ));
                }
            }
        }
    }
    Ok(())
}
