// SPDX-License-Identifier: MIT OR Apache-2.0
//! What SPIR-V says of itself: blocks, push constants, specialization constants, workgroup size, and the byte offset of
//! every struct member. Names come from OpName and OpMemberName, so modules are compiled with debug information.

use ash::vk;
use spirq::{
    prelude::{AccessType, ConstantValue, DescriptorType, ReflectConfig, Type, Variable},
    spirv::ExecutionMode,
};
use std::collections::{BTreeMap, BTreeSet};

/// A member of a struct that crosses to the host.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// Name in GLSL.
    pub name: String,
    /// From the start of the struct (bytes).
    pub offset: usize,
}

/// A struct that crosses to the host.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Struct {
    /// In declaration order.
    pub members: Vec<Member>,
    /// End of the last member (bytes); a runtime array counts 0.
    pub bytes: usize,
}

/// A binding of set 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Name of the block, or of the image.
    pub name: String,
    /// Storage or uniform buffer, or storage image.
    pub kind: vk::DescriptorType,
    /// How the shader touches it.
    pub access: &'static str,
    /// Of one element of its runtime array, 0 if it ends in none (bytes).
    pub stride: usize,
}

/// Interface of one shader, or of the stages of one pipeline.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Interface {
    /// By binding number.
    pub blocks: BTreeMap<u32, Block>,
    /// 0 without push constants (bytes).
    pub push_bytes: usize,
    /// Every `constant_id`, with its name.
    pub constants: BTreeMap<u32, String>,
    /// By name: the structs inside blocks and push constants.
    pub structs: BTreeMap<String, Struct>,
    /// Workgroup size of a compute shader, once constants are set.
    pub local_size: Option<[u32; 3]>,
}

/// Reads the interface of a module that a compiler has made (damaged ones are not looked for) and whose specialization constants are set to `constants`, by `constant_id`.
///
/// # Errors
/// What is wrong, if `spv` is not a module with one entry point, or uses what this crate does not bind.
pub fn reflect(spv: &[u8], constants: &[u32]) -> Result<Interface, String> {
    if spv.len() < 20 || !spv.len().is_multiple_of(4) {
        return Err("not SPIR-V".into());
    }
    let words = without_logic(&bytemuck::allocation::pod_collect_to_vec::<u8, u32>(spv));
    // Everything declared counts, also what the optimizer left without a use: the host must bind it.
    let mut config = ReflectConfig::new();
    config.spv(words).ref_all_rscs(true);
    let mut entries = config.reflect().map_err(|e| format!("not SPIR-V: {e}"))?;
    let entry = entries.pop().filter(|_| entries.is_empty()).ok_or("not a module with one entry point")?;

    let mut out = Interface::default();
    for variable in &entry.vars {
        match variable {
            Variable::Descriptor { name, desc_bind, desc_ty, ty, .. } => {
                let (set, binding) = (desc_bind.set(), desc_bind.bind());
                if set != 0 {
                    return Err(format!("binding {binding} is in set {set}, only set 0 is used"));
                }
                let (kind, access) = match desc_ty {
                    DescriptorType::StorageBuffer(access) => (vk::DescriptorType::STORAGE_BUFFER, access),
                    DescriptorType::UniformBuffer() => {
                        (vk::DescriptorType::UNIFORM_BUFFER, &AccessType::ReadOnly)
                    }
                    DescriptorType::StorageImage(access) => (vk::DescriptorType::STORAGE_IMAGE, access),
                    other => {
                        return Err(format!("binding {binding} is {other:?}, not a buffer or storage image"))
                    }
                };
                let block = match ty {
                    Type::Struct(it) => it.name.as_deref(),
                    _ => name.as_deref(),
                };
                let name = block.unwrap_or_default().to_string();
                collect(ty, &mut out.structs);
                let access = access_name(access);
                out.blocks.insert(binding, Block { name, kind, access, stride: stride(ty) });
            }
            Variable::PushConstant { ty, .. } => {
                collect(ty, &mut out.structs);
                out.push_bytes = ty.nbyte().ok_or("push constants without a size")?;
            }
            Variable::SpecConstant { name, spec_id, .. } => {
                out.constants.insert(*spec_id, name.clone().unwrap_or_default());
            }
            Variable::Input { .. } | Variable::Output { .. } => {}
        }
    }
    for mode in &entry.exec_modes {
        if matches!(mode.exec_mode, ExecutionMode::LocalSize | ExecutionMode::LocalSizeId) {
            let mut size = [1; 3];
            for (axis, operand) in size.iter_mut().zip(&mode.operands) {
                // A size that is a specialization constant: what the host sets it to, never the default by accident.
                *axis = match operand.spec_id {
                    Some(id) => {
                        out.constants.entry(id).or_insert_with(|| "local_size".into());
                        *constants.get(id as usize).ok_or_else(|| format!("constant_id {id} is not set"))?
                    }
                    None => number(&operand.value).ok_or("a workgroup size that is not a number")?,
                };
            }
            out.local_size = Some(size);
        }
    }
    Ok(out)
}

impl Interface {
    /// The interface of a pipeline of several stages.
    ///
    /// # Errors
    /// If two stages mean different things by one binding or by the push constants.
    pub fn merge(mut self, other: Self) -> Result<Self, String> {
        for (binding, block) in other.blocks {
            let here = self.blocks.entry(binding).or_insert_with(|| block.clone());
            if (&here.name, here.kind) != (&block.name, block.kind) {
                return Err(format!(
                    "binding {binding} is `{}` in one stage, `{}` in another",
                    here.name, block.name
                ));
            }
        }
        if self.push_bytes != 0 && other.push_bytes != 0 && self.push_bytes != other.push_bytes {
            return Err(format!(
                "push constants: {} bytes in one stage, {} in another",
                self.push_bytes, other.push_bytes
            ));
        }
        self.push_bytes = self.push_bytes.max(other.push_bytes);
        self.constants.extend(other.constants);
        self.structs.extend(other.structs);
        Ok(self)
    }
}

/// The module without what its specialization constants are compared and chosen by: spirq knows only their arithmetic, and
/// of their values only sizes of workgroups and arrays matter here.
fn without_logic(words: &[u32]) -> Vec<u32> {
    const SPEC_CONSTANT_OP: u32 = 52;
    const CONSTANT_NULL: u32 = 46;
    // OpIAdd to OpVectorTimesScalar, without the latter; OpIEqual and OpINotEqual.
    let is_known = |op: u32| (126..=141).contains(&op) || matches!(op, 170 | 171);
    let (header, mut rest) = words.split_at(words.len().min(5));
    let (mut out, mut left_out) = (header.to_vec(), BTreeSet::new());
    while let Some(&first) = rest.first() {
        let length = ((first >> 16) as usize).clamp(1, rest.len());
        let (one, after) = rest.split_at(length);
        match one {
            [_, ty, id, op, operands @ ..]
                if first & 0xffff == SPEC_CONSTANT_OP
                    && (!is_known(*op) || operands.iter().any(|it| left_out.contains(it))) =>
            {
                left_out.insert(*id);
                out.extend([3 << 16 | CONSTANT_NULL, *ty, *id]);
            }
            _ => out.extend(one),
        }
        rest = after;
    }
    out
}

fn number(value: &ConstantValue) -> Option<u32> {
    Some(u32::from_le_bytes(value.to_typeless()?.get(..4)?.try_into().ok()?))
}

fn access_name(access: &AccessType) -> &'static str {
    match access {
        AccessType::ReadOnly => "reads",
        AccessType::WriteOnly => "writes",
        AccessType::ReadWrite => "reads, writes",
    }
}

/// Bytes from one element of a trailing runtime array to the next.
fn stride(ty: &Type) -> usize {
    match ty {
        Type::Struct(it) => match it.members.last().map(|last| &last.ty) {
            Some(Type::Array(array)) if array.nelement.is_none() => array.stride.unwrap_or(0),
            _ => 0,
        },
        _ => 0,
    }
}

/// Adds `ty` and the structs inside it.
fn collect(ty: &Type, structs: &mut BTreeMap<String, Struct>) {
    match ty {
        Type::Struct(it) => {
            let member = |m: &spirq::ty::StructMember| Member {
                name: m.name.clone().unwrap_or_default(),
                offset: m.offset.unwrap_or_default(),
            };
            let bytes = it.members.last().map_or(0, |m| m.offset.unwrap_or(0) + m.ty.nbyte().unwrap_or(0));
            let described = Struct { members: it.members.iter().map(member).collect(), bytes };
            structs.insert(it.name.clone().unwrap_or_default(), described);
            it.members.iter().for_each(|m| collect(&m.ty, structs));
        }
        Type::Array(it) => collect(&it.element_ty, structs),
        _ => {}
    }
}
