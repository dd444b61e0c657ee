// SPDX-License-Identifier: MIT OR Apache-2.0
//! glTF 2.0 (Khronos, 2021): triangles of the scene's nodes, skins, and the first animation. The crate `gltf` reads the
//! JSON; numbers are read here, with every offset checked, since its own readers trust the file.

use super::{Curve, Hold, Joint, Mesh, Node, Rig, Track, Value, MOST, MOST_JOINTS};
use base64::Engine;
use glam::{Mat4, Quat, Vec2, Vec3};
use gltf::{
    accessor::{DataType, Dimensions},
    animation::{Interpolation, Property},
    buffer::Source,
    mesh::Mode,
    Accessor, Document, Semantic,
};

/// Most nodes: a tree that is walked on the CPU for each pose.
const MOST_NODES: usize = 1 << 16;
/// Most keys of all tracks.
const MOST_KEYS: usize = 1 << 22;

pub(super) fn decode(bytes: &[u8], beside: impl Fn(&str) -> Result<Vec<u8>, String>) -> Result<Mesh, String> {
    if bytes.starts_with(b"glTF") {
        let length =
            bytes.get(8..12).map_or(0, |word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
        if !(12..=bytes.len() as u64).contains(&u64::from(length)) {
            return Err(format!("its header says {length} bytes; there are {}", bytes.len()));
        }
    }
    let gltf::Gltf { document, blob } =
        gltf::Gltf::from_slice_without_validation(bytes).map_err(|error| error.to_string())?;
    let json = document.into_json();
    valid(&json)?;
    let document = Document::from_json(json).map_err(|error| error.to_string())?;
    if let Some(extension) = document.extensions_required().next() {
        return Err(format!("it requires the extension `{extension}`, which is not read"));
    }
    let file = File { buffers: buffers(&document, blob, beside)? };
    let order = node_order(&document)?;
    let mut mesh = Mesh {
        name: String::new(),
        at_m: Vec::new(),
        normals: Vec::new(),
        uv: Vec::new(),
        hold: Vec::new(),
        triangles: Vec::new(),
        rig: rig(&document, &file, &order)?,
    };
    let (mut has_normals, mut has_uv) = (true, true);
    for (node, _) in &order.list {
        let node = document.nodes().nth(*node).ok_or("a node that is not there")?;
        let Some(shape) = node.mesh() else { continue };
        let first_joint = mesh.rig.joints.len();
        let joints = match node.skin() {
            Some(skin) => {
                let inverse =
                    skin.inverse_bind_matrices().map(|it| file.floats(&it, Dimensions::Mat4)).transpose()?;
                let count = skin.joints().count();
                if inverse.as_ref().is_some_and(|floats| floats.len() < 16 * count) {
                    return Err(format!("skin {}: fewer matrices than its {count} joints", skin.index()));
                }
                for (k, joint) in skin.joints().enumerate() {
                    let node = order.place(joint.index())?;
                    let matrix =
                        inverse.as_ref().map(|floats| Mat4::from_cols_slice(&floats[16 * k..16 * k + 16]));
                    mesh.rig.joints.push(Joint { node, node_from_rest: matrix.unwrap_or(Mat4::IDENTITY) });
                }
                count
            }
            None => {
                let node = order.place(node.index())?;
                mesh.rig.joints.push(Joint { node, node_from_rest: Mat4::IDENTITY });
                1
            }
        };
        if mesh.rig.joints.len() > MOST_JOINTS {
            return Err(format!("more than {MOST_JOINTS} joints"));
        }
        for primitive in shape.primitives() {
            if primitive.mode() != Mode::Triangles {
                return Err(format!(
                    "mesh {}: its primitives are {:?}; allowed: Triangles",
                    shape.index(),
                    primitive.mode()
                ));
            }
            if primitive.morph_targets().next().is_some() {
                return Err(format!("mesh {}: it has morph targets, which are not read", shape.index()));
            }
            let first = mesh.at_m.len();
            let at = primitive.get(&Semantic::Positions).ok_or("a primitive without POSITION")?;
            mesh.at_m.extend(file.floats(&at, Dimensions::Vec3)?.chunks_exact(3).map(Vec3::from_slice));
            let count = mesh.at_m.len() - first;
            let of_size = |floats: Vec<f32>, each: usize, what: &str| {
                (floats.len() == each * count)
                    .then_some(floats)
                    .ok_or(format!("{what} and POSITION differ in number"))
            };
            match primitive.get(&Semantic::Normals) {
                Some(normals) => {
                    let floats = of_size(file.floats(&normals, Dimensions::Vec3)?, 3, "NORMAL")?;
                    mesh.normals
                        .extend(floats.chunks_exact(3).map(|n| Vec3::from_slice(n).normalize_or_zero()));
                }
                None => has_normals = false,
            }
            match primitive.get(&Semantic::TexCoords(0)) {
                Some(uv) => {
                    let floats = of_size(file.floats(&uv, Dimensions::Vec2)?, 2, "TEXCOORD_0")?;
                    mesh.uv.extend(floats.chunks_exact(2).map(Vec2::from_slice));
                }
                None => has_uv = false,
            }
            match (node.skin(), primitive.get(&Semantic::Joints(0)), primitive.get(&Semantic::Weights(0))) {
                (Some(_), Some(on), Some(weights)) => {
                    let on = file.integers(&on, Dimensions::Vec4)?;
                    let weights = of_size(file.floats(&weights, Dimensions::Vec4)?, 4, "WEIGHTS_0")?;
                    if on.len() != 4 * count {
                        return Err("JOINTS_0 and POSITION differ in number".into());
                    }
                    for (on, weights) in on.chunks_exact(4).zip(weights.chunks_exact(4)) {
                        mesh.hold.push(hold(on, weights, first_joint, joints)?);
                    }
                }
                (Some(_), ..) => return Err("a skinned primitive without JOINTS_0 and WEIGHTS_0".into()),
                (None, ..) => mesh.hold.resize(mesh.at_m.len(), Hold::on(first_joint as u16)),
            }
            let corners: Vec<u32> = match primitive.indices() {
                Some(indices) => file.integers(&indices, Dimensions::Scalar)?,
                None => (0..count as u32).collect(),
            };
            if !corners.len().is_multiple_of(3) || corners.iter().any(|&corner| corner as usize >= count) {
                return Err(format!("{} corners of {count} vertices: no triangles", corners.len()));
            }
            let corner = |i: u32| i + first as u32;
            mesh.triangles
                .extend(corners.chunks_exact(3).map(|c| [corner(c[0]), corner(c[1]), corner(c[2])]));
            if mesh.at_m.len() > MOST || mesh.triangles.len() > MOST {
                return Err(format!("more than {MOST} vertices or triangles"));
            }
        }
    }
    if !has_normals {
        mesh.normals.clear();
    }
    if !has_uv {
        mesh.uv.clear();
    }
    if mesh.rig.joints.is_empty() {
        return Err("no node of its scene has a mesh".into());
    }
    Ok(mesh)
}

/// What `gltf` takes for valid, and then panics at.
fn valid(json: &gltf::json::Root) -> Result<(), String> {
    use gltf::json::validation::Checked;
    for (i, animation) in json.animations.iter().enumerate() {
        let targets =
            animation.channels.iter().all(|channel| matches!(channel.target.path, Checked::Valid(_)));
        let curves =
            animation.samplers.iter().all(|sampler| matches!(sampler.interpolation, Checked::Valid(_)));
        let channels = animation.channels.iter().all(|channel| {
            channel.sampler.value() < animation.samplers.len()
                && channel.target.node.value() < json.nodes.len()
        });
        let accessors = json.accessors.len();
        let samplers = animation
            .samplers
            .iter()
            .all(|sampler| sampler.input.value() < accessors && sampler.output.value() < accessors);
        if !(targets && curves && channels && samplers) {
            return Err(format!(
                "animation {i}: a path, an interpolation, a sampler, a node or an accessor that is none"
            ));
        }
    }
    for (i, accessor) in json.accessors.iter().enumerate() {
        let is_valid = matches!(accessor.component_type, Checked::Valid(_))
            && matches!(accessor.type_, Checked::Valid(_));
        if !is_valid {
            return Err(format!("accessor {i}: a type that is none"));
        }
    }
    for (i, mesh) in json.meshes.iter().enumerate() {
        let named = |primitive: &gltf::json::mesh::Primitive| {
            matches!(primitive.mode, Checked::Valid(_))
                && primitive.attributes.iter().all(|(semantic, accessor)| {
                    matches!(semantic, Checked::Valid(_)) && accessor.value() < json.accessors.len()
                })
        };
        if !mesh.primitives.iter().all(named) {
            return Err(format!("mesh {i}: a mode, an attribute or an accessor that is none"));
        }
    }
    Ok(())
}

fn hold(on: &[u32], weights: &[f32], first: usize, joints: usize) -> Result<Hold, String> {
    let sum: f32 = weights.iter().sum();
    if !(weights.iter().all(|w| *w >= 0.0) && sum > 0.0 && sum.is_finite()) {
        return Err(format!("weights {weights:?}; allowed: 0 or more, not all 0"));
    }
    let joint = |k: usize| -> Result<u16, String> {
        if weights[k] == 0.0 {
            return Ok(first as u16);
        }
        match on[k] as usize {
            joint if joint < joints => Ok((first + joint) as u16),
            joint => Err(format!("a weight of joint {joint}; the skin has {joints}")),
        }
    };
    let weights = [0, 1, 2, 3].map(|k| weights[k] / sum);
    Ok(Hold { joints: [joint(0)?, joint(1)?, joint(2)?, joint(3)?], weights })
}

/// Nodes of the scene, parents first: index in the file and place of the parent.
struct Order {
    list: Vec<(usize, Option<usize>)>,
    places: Vec<Option<usize>>,
}

impl Order {
    fn place(&self, node: usize) -> Result<usize, String> {
        self.places.get(node).copied().flatten().ok_or(format!("node {node} is used, but not in the scene"))
    }
}

fn node_order(document: &Document) -> Result<Order, String> {
    let nodes: Vec<_> = document.nodes().collect();
    if nodes.len() > MOST_NODES {
        return Err(format!("{} nodes; allowed: {MOST_NODES}", nodes.len()));
    }
    let scene = document.default_scene().or_else(|| document.scenes().next()).ok_or("it has no scene")?;
    let mut order = Order { list: Vec::new(), places: vec![None; nodes.len()] };
    let mut waiting: Vec<(usize, Option<usize>)> = scene.nodes().map(|node| (node.index(), None)).collect();
    waiting.reverse();
    while let Some((node, parent)) = waiting.pop() {
        if order.places[node].is_some() {
            return Err(format!("node {node} has two parents, or is its own"));
        }
        order.places[node] = Some(order.list.len());
        let place = order.list.len();
        order.list.push((node, parent));
        waiting.extend(nodes[node].children().map(|child| (child.index(), Some(place))));
    }
    Ok(order)
}

fn rig(document: &Document, file: &File, order: &Order) -> Result<Rig, String> {
    let nodes: Vec<_> = document.nodes().collect();
    let mut rig = Rig { nodes: Vec::new(), joints: Vec::new(), tracks: Vec::new(), period_s: 0.0 };
    for (node, parent) in &order.list {
        let (move_m, turn, scale) = nodes[*node].transform().decomposed();
        let turn = Quat::from_array(turn);
        let turn =
            if turn.is_finite() && turn.length_squared() > 1e-12 { turn.normalize() } else { Quat::IDENTITY };
        rig.nodes.push(Node { parent: *parent, move_m: move_m.into(), turn, scale: scale.into() });
    }
    let Some(animation) = document.animations().next() else { return Ok(rig) };
    let mut keys = 0;
    for channel in animation.channels() {
        let target = channel.target();
        // A node outside the scene may be moved; nobody sees it.
        let Ok(node) = order.place(target.node().index()) else { continue };
        let sampler = channel.sampler();
        let time_s = file.floats(&sampler.input(), Dimensions::Scalar)?;
        let threes = |floats: Vec<f32>| floats.chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>();
        let value = match target.property() {
            Property::Translation => Value::Move(threes(file.floats(&sampler.output(), Dimensions::Vec3)?)),
            Property::Scale => Value::Scale(threes(file.floats(&sampler.output(), Dimensions::Vec3)?)),
            Property::Rotation => {
                let floats = file.floats(&sampler.output(), Dimensions::Vec4)?;
                Value::Turn(floats.chunks_exact(4).map(Quat::from_slice).collect())
            }
            Property::MorphTargetWeights => {
                return Err("it animates morph targets, which are not read".into())
            }
        };
        let curve = match sampler.interpolation() {
            Interpolation::Step => Curve::Step,
            Interpolation::Linear => Curve::Linear,
            Interpolation::CubicSpline => Curve::Cubic,
        };
        keys += time_s.len();
        if keys > MOST_KEYS {
            return Err(format!("more than {MOST_KEYS} keys"));
        }
        rig.period_s = time_s.last().map_or(rig.period_s, |&end| rig.period_s.max(end));
        rig.tracks.push(Track { node, time_s, value, curve });
    }
    Ok(rig)
}

struct File {
    buffers: Vec<Vec<u8>>,
}

fn buffers(
    document: &Document,
    mut blob: Option<Vec<u8>>,
    beside: impl Fn(&str) -> Result<Vec<u8>, String>,
) -> Result<Vec<Vec<u8>>, String> {
    let read = |buffer: gltf::Buffer<'_>| -> Result<Vec<u8>, String> {
        match buffer.source() {
            Source::Bin => blob.take().ok_or("it has no binary part".into()),
            Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => {
                    let (_, text) = data.split_once("base64,").ok_or("a data URI that is not base64")?;
                    let engine = base64::engine::general_purpose::STANDARD;
                    engine.decode(text).map_err(|error| format!("a data URI: {error}"))
                }
                None => beside(uri),
            },
        }
    };
    document.buffers().map(read).collect()
}

impl File {
    /// The elements of an accessor, each as its bytes.
    fn elements<'a>(
        &'a self,
        accessor: &Accessor<'_>,
        wanted: Dimensions,
    ) -> Result<impl Iterator<Item = &'a [u8]>, String> {
        let name = accessor.index();
        if accessor.dimensions() != wanted {
            return Err(format!("accessor {name} is {:?}, {wanted:?} expected", accessor.dimensions()));
        }
        if accessor.sparse().is_some() {
            return Err(format!("accessor {name} is sparse, which is not read"));
        }
        if accessor.count() == 0 || accessor.count() > 4 * MOST {
            return Err(format!(
                "accessor {name} has {} elements; allowed: 1 to {}",
                accessor.count(),
                4 * MOST
            ));
        }
        let view = accessor.view().ok_or(format!("accessor {name} has no data"))?;
        let buffer = self.buffers.get(view.buffer().index()).ok_or("a buffer that is not there")?;
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size).max(1);
        let bytes = view.offset().checked_add(view.length()).and_then(|end| buffer.get(view.offset()..end));
        let end = stride.checked_mul(accessor.count() - 1).and_then(|last| last.checked_add(size));
        let end = end.and_then(|end| end.checked_add(accessor.offset()));
        let bytes = bytes.zip(end).and_then(|(bytes, end)| bytes.get(accessor.offset()..end));
        let bytes =
            bytes.ok_or(format!("accessor {name} reaches beyond its buffer of {} bytes", buffer.len()))?;
        Ok((0..accessor.count()).map(move |i| &bytes[i * stride..i * stride + size]))
    }

    /// Floats, or integers as the parts of 1 that they stand for.
    fn floats(&self, accessor: &Accessor<'_>, wanted: Dimensions) -> Result<Vec<f32>, String> {
        let (kind, name) = (accessor.data_type(), accessor.index());
        if kind != DataType::F32 && !accessor.normalized() {
            return Err(format!("accessor {name} holds {kind:?}; allowed: floats, or normalized integers"));
        }
        let parts = self.elements(accessor, wanted)?.flat_map(|element| element.chunks_exact(kind.size()));
        Ok(parts.map(|bytes| part(bytes, kind)).collect())
    }

    fn integers(&self, accessor: &Accessor<'_>, wanted: Dimensions) -> Result<Vec<u32>, String> {
        let kind = accessor.data_type();
        if !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32) || accessor.normalized() {
            return Err(format!("accessor {} holds {kind:?}; allowed: unsigned integers", accessor.index()));
        }
        let parts = self.elements(accessor, wanted)?.flat_map(|element| element.chunks_exact(kind.size()));
        Ok(parts.map(|bytes| bytes.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte))).collect())
    }
}

fn part(bytes: &[u8], kind: DataType) -> f32 {
    let short = || [bytes[0], bytes[1]];
    match kind {
        DataType::I8 => (f32::from(bytes[0] as i8) / 127.0).max(-1.0),
        DataType::U8 => f32::from(bytes[0]) / 255.0,
        DataType::I16 => (f32::from(i16::from_le_bytes(short())) / 32767.0).max(-1.0),
        DataType::U16 => f32::from(u16::from_le_bytes(short())) / 65535.0,
        DataType::U32 => f32::NAN, // glTF has no normalized words: refused as not finite
        DataType::F32 => f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}
