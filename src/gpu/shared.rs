// SPDX-License-Identifier: MIT OR Apache-2.0
//! How much shared memory a kernel declares, read from its SPIR-V with its specialization constants set.
//!
//! Sizes are those of scalars one after the other: workgroup memory has no layout of its own, and drivers pack it so.
//! What a module computes from its specialization constants is computed here too, as far as sizes of arrays need it.

use std::collections::BTreeMap;

/// Opcodes, by their numbers in the SPIR-V specification, 3.52.
mod op {
    pub const TYPE_INT: u32 = 21;
    pub const TYPE_FLOAT: u32 = 22;
    pub const TYPE_VECTOR: u32 = 23;
    pub const TYPE_MATRIX: u32 = 24;
    pub const TYPE_ARRAY: u32 = 28;
    pub const TYPE_STRUCT: u32 = 30;
    pub const TYPE_POINTER: u32 = 32;
    pub const CONSTANT: u32 = 43;
    pub const SPEC_CONSTANT_TRUE: u32 = 48;
    pub const SPEC_CONSTANT_FALSE: u32 = 49;
    pub const SPEC_CONSTANT: u32 = 50;
    pub const SPEC_CONSTANT_OP: u32 = 52;
    pub const VARIABLE: u32 = 59;
    pub const DECORATE: u32 = 71;
}
const SPEC_ID: u32 = 1;
const WORKGROUP: u32 = 4;

/// What a workgroup of the kernel `spv` shares (bytes), its specialization constants set to `constants` by `constant_id`;
/// `None` if a size is not known.
pub(super) fn shared_bytes(spv: &[u8], constants: &[u32]) -> Option<u64> {
    let words: Vec<u32> = bytemuck::allocation::pod_collect_to_vec(spv);
    let mut module = Module { constants, ..Module::default() };
    let mut rest = words.get(5..)?;
    while let Some(&first) = rest.first() {
        let (one, after) =
            rest.split_at_checked((first >> 16) as usize).filter(|(one, _)| !one.is_empty())?;
        module.read(first & 0xffff, &one[1..]);
        rest = after;
    }
    module.shared
}

/// What was read so far, by id: everything is declared before it is used.
struct Module<'a> {
    constants: &'a [u32],
    /// `constant_id` of a constant.
    specs: BTreeMap<u32, usize>,
    values: BTreeMap<u32, u32>,
    /// Sizes of types; of a pointer to shared memory, of what it points to.
    bytes: BTreeMap<u32, u64>,
    shared: Option<u64>,
}

impl Default for Module<'_> {
    fn default() -> Self {
        let (specs, values, bytes) = Default::default();
        Self { constants: &[], specs, values, bytes, shared: Some(0) }
    }
}

impl Module<'_> {
    fn read(&mut self, code: u32, operands: &[u32]) {
        let size = |id: &u32| self.bytes.get(id).copied();
        let value = |id: &u32| self.values.get(id).copied();
        let set = |id: &u32, default: u32| {
            let spec = self.specs.get(id).and_then(|&spec| self.constants.get(spec));
            Some(spec.copied().unwrap_or(default))
        };
        let (id, found) = match (code, operands) {
            (op::DECORATE, [id, SPEC_ID, spec]) => {
                self.specs.insert(*id, *spec as usize);
                return;
            }
            (op::VARIABLE, [pointer, _, WORKGROUP, ..]) => {
                self.shared = self.shared.zip(size(pointer)).map(|(sum, one)| sum + one);
                return;
            }
            (op::CONSTANT, [_, id, value, ..]) => (id, Found::Value(Some(*value))),
            (op::SPEC_CONSTANT, [_, id, default, ..]) => (id, Found::Value(set(id, *default))),
            (op::SPEC_CONSTANT_TRUE, [_, id]) => (id, Found::Value(set(id, 1))),
            (op::SPEC_CONSTANT_FALSE, [_, id]) => (id, Found::Value(set(id, 0))),
            (op::SPEC_CONSTANT_OP, [_, id, operation, of @ ..]) => {
                let of: Option<Vec<u32>> = of.iter().map(value).collect();
                (id, Found::Value(of.and_then(|of| compute(*operation, &of))))
            }
            (op::TYPE_INT | op::TYPE_FLOAT, [id, bits, ..]) => (id, Found::Size(Some(u64::from(bits / 8)))),
            (op::TYPE_VECTOR | op::TYPE_MATRIX, [id, of, count]) => {
                (id, Found::Size(size(of).map(|one| one * u64::from(*count))))
            }
            (op::TYPE_ARRAY, [id, of, length]) => {
                let both = size(of).zip(value(length));
                (id, Found::Size(both.map(|(one, length)| one * u64::from(length))))
            }
            (op::TYPE_STRUCT, [id, members @ ..]) => (id, Found::Size(members.iter().map(size).sum())),
            (op::TYPE_POINTER, [id, WORKGROUP, of]) => (id, Found::Size(size(of))),
            _ => return,
        };
        match found {
            Found::Value(Some(value)) => _ = self.values.insert(*id, value),
            Found::Size(Some(size)) => _ = self.bytes.insert(*id, size),
            Found::Value(None) | Found::Size(None) => {}
        }
    }
}

enum Found {
    Value(Option<u32>),
    Size(Option<u64>),
}

/// What sizes are made of, in words of 32 bits.
fn compute(operation: u32, operands: &[u32]) -> Option<u32> {
    let yes_or_no = |is: bool| Some(u32::from(is));
    match (operation, operands) {
        (128, [a, b]) => Some(a.wrapping_add(*b)),
        (130, [a, b]) => Some(a.wrapping_sub(*b)),
        (132, [a, b]) => Some(a.wrapping_mul(*b)),
        (134, [a, b]) => a.checked_div(*b),
        (137, [a, b]) => a.checked_rem(*b),
        (135, [a, b]) => (*a as i32).checked_div(*b as i32).map(|it| it as u32),
        (194, [a, b]) => a.checked_shr(*b),
        (196, [a, b]) => a.checked_shl(*b),
        (197, [a, b]) => Some(a | b),
        (199, [a, b]) => Some(a & b),
        (124, [a]) => Some(*a), // OpBitcast
        (166, [a, b]) => yes_or_no(*a != 0 || *b != 0),
        (167, [a, b]) => yes_or_no(*a != 0 && *b != 0),
        (168, [a]) => yes_or_no(*a == 0),
        (169, [is, a, b]) => Some(if *is != 0 { *a } else { *b }),
        (170, [a, b]) => yes_or_no(a == b),
        (171, [a, b]) => yes_or_no(a != b),
        (172, [a, b]) => yes_or_no(a > b),
        (173, [a, b]) => yes_or_no(*a as i32 > *b as i32),
        (174, [a, b]) => yes_or_no(a >= b),
        (175, [a, b]) => yes_or_no(*a as i32 >= *b as i32),
        (176, [a, b]) => yes_or_no(a < b),
        (177, [a, b]) => yes_or_no((*a as i32) < *b as i32),
        (178, [a, b]) => yes_or_no(a <= b),
        (179, [a, b]) => yes_or_no(*a as i32 <= *b as i32),
        _ => None,
    }
}
