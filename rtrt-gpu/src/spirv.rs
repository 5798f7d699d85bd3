//! The committed module, entry point by entry point: a driver may compile, or read again for each pipeline, all
//! that a module holds.

use std::collections::HashSet;

/// Words before the first instruction; the fourth is one more than the largest id.
pub(crate) const HEADER: usize = 5;
pub(crate) const BOUND: usize = 3;

/// Opcodes.
pub(crate) mod op {
    pub const UNDEF: u32 = 1;
    pub const NAME: u32 = 5;
    pub const MEMBER_NAME: u32 = 6;
    pub const EXT_INST: u32 = 12;
    pub const ENTRY_POINT: u32 = 15;
    pub const EXECUTION_MODE: u32 = 16;
    pub const TYPE_VOID: u32 = 19;
    pub const TYPE_INT: u32 = 21;
    pub const TYPE_FLOAT: u32 = 22;
    pub const TYPE_STRUCT: u32 = 30;
    pub const TYPE_POINTER: u32 = 32;
    pub const TYPE_FUNCTION: u32 = 33;
    pub const CONSTANT_TRUE: u32 = 41;
    pub const CONSTANT: u32 = 43;
    pub const CONSTANT_COMPOSITE: u32 = 44;
    pub const CONSTANT_NULL: u32 = 46;
    pub const FUNCTION: u32 = 54;
    pub const FUNCTION_END: u32 = 56;
    pub const FUNCTION_CALL: u32 = 57;
    pub const VARIABLE: u32 = 59;
    pub const LOAD: u32 = 61;
    pub const STORE: u32 = 62;
    pub const ACCESS_CHAIN: u32 = 65;
    pub const DECORATE: u32 = 71;
    pub const MEMBER_DECORATE: u32 = 72;
    pub const VECTOR_SHUFFLE: u32 = 79;
    pub const COMPOSITE_CONSTRUCT: u32 = 80;
    pub const COMPOSITE_EXTRACT: u32 = 81;
    pub const COMPOSITE_INSERT: u32 = 82;
    pub const BITCAST: u32 = 124;
    pub const F_NEGATE: u32 = 127;
    pub const F_ADD: u32 = 129;
    pub const F_SUB: u32 = 131;
    pub const F_MUL: u32 = 133;
    pub const BITWISE_OR: u32 = 197;
    pub const CONTROL_BARRIER: u32 = 224;
    pub const ATOMIC_STORE: u32 = 228;
    pub const LOOP_MERGE: u32 = 246;
    pub const LABEL: u32 = 248;
    pub const RETURN_VALUE: u32 = 254;
    pub const UNREACHABLE: u32 = 255;
}

/// The instructions of a module, each with its first word.
pub(crate) fn instructions(spirv: &[u32]) -> impl Iterator<Item = &[u32]> {
    let mut rest = &spirv[HEADER..];
    std::iter::from_fn(move || {
        let length = (*rest.first()? >> 16) as usize;
        let (instruction, after) = rest.split_at_checked(length).filter(|_| length > 0)?;
        rest = after;
        Some(instruction)
    })
}

pub(crate) fn opcode(instruction: &[u32]) -> u32 {
    instruction[0] & 0xffff
}

/// Which words of an instruction of a function are ids of values that it reads, among them constants that are
/// numbers or made of numbers.
pub(crate) fn values(instruction: &[u32]) -> std::ops::Range<usize> {
    let length = instruction.len();
    match opcode(instruction) {
        op::STORE => 1..3,
        op::RETURN_VALUE => 1..2,
        op::LOAD | op::COMPOSITE_EXTRACT => 3..4,
        op::COMPOSITE_INSERT | op::VECTOR_SHUFFLE => 3..5,
        op::EXT_INST => 5..length,
        op::FUNCTION..=op::FUNCTION_END | op::VARIABLE => 0..0,
        op::CONTROL_BARRIER..=op::ATOMIC_STORE | op::LOOP_MERGE..=op::UNREACHABLE => 0..0,
        _ => 3.min(length)..length,
    }
}

/// The module `spirv` with one entry point, and what that one needs; `None` if it has no such entry point.
///
/// Every word of an instruction counts as an id, numbers too: so all that is needed stays, and a little more.
pub(crate) fn entry_point(spirv: &[u32], name: &str) -> Option<Vec<u32>> {
    let is_named = |i: &&[u32]| opcode(i) == op::ENTRY_POINT && text(&i[3..]) == name.as_bytes();
    let entry = instructions(spirv).find(is_named)?;
    let (globals, functions) = parts(spirv);

    let types: HashSet<u32> = globals.iter().filter(|i| is_type(i)).map(|i| i[1]).collect();
    let mut called = HashSet::from([entry[2]]);
    let mut open = vec![entry[2]];
    let mut needed: HashSet<u32> = entry.iter().copied().collect();
    let mut results = HashSet::new();
    while let Some(id) = open.pop() {
        for instruction in functions.iter().filter(|f| f[0][2] == id).flatten() {
            needed.extend(&instruction[1..]);
            if let [_, of, result, ..] = **instruction
                && types.contains(&of)
            {
                results.insert(result);
            }
            if opcode(instruction) == op::FUNCTION_CALL && called.insert(instruction[3]) {
                open.push(instruction[3]);
            }
        }
    }
    // Again as long as a number that counts as an id asks for more.
    let mut count = 0;
    while count < needed.len() {
        count = needed.len();
        for instruction in globals.iter().rev() {
            if declared(instruction).is_some_and(|id| needed.contains(&id)) {
                needed.extend(&instruction[1..]);
            }
        }
    }
    results.extend(globals.iter().filter_map(|i| declared(i)).filter(|id| needed.contains(id)));

    let mut out = spirv[..HEADER].to_vec();
    for instruction in &globals {
        let stays = match opcode(instruction) {
            op::NAME | op::MEMBER_NAME => false,
            op::ENTRY_POINT => instruction[2] == entry[2],
            op::EXECUTION_MODE => instruction[1] == entry[2],
            op::DECORATE | op::MEMBER_DECORATE => results.contains(&instruction[1]),
            _ => declared(instruction).is_none_or(|id| needed.contains(&id)),
        };
        if stays {
            out.extend(*instruction);
        }
    }
    for function in functions.iter().filter(|f| called.contains(&f[0][2])) {
        out.extend(function.iter().copied().flatten());
    }
    Some(out)
}

/// The instructions in front of all functions, and those of each function.
fn parts(spirv: &[u32]) -> (Vec<&[u32]>, Vec<Vec<&[u32]>>) {
    let (mut globals, mut functions) = (Vec::new(), Vec::<Vec<&[u32]>>::new());
    for instruction in instructions(spirv) {
        if opcode(instruction) == op::FUNCTION {
            functions.push(Vec::new());
        }
        functions.last_mut().unwrap_or(&mut globals).push(instruction);
    }
    (globals, functions)
}

fn is_type(instruction: &[u32]) -> bool {
    (op::TYPE_VOID..=op::TYPE_FUNCTION).contains(&opcode(instruction))
}

/// The id that an instruction in front of all functions declares: a type, a constant or a variable.
fn declared(instruction: &[u32]) -> Option<u32> {
    match opcode(instruction) {
        _ if is_type(instruction) => Some(instruction[1]),
        op::UNDEF | op::CONSTANT_TRUE..=op::CONSTANT_NULL | op::VARIABLE => Some(instruction[2]),
        _ => None,
    }
}

/// A literal string, which ends with a zero byte, as bytes.
fn text(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).take_while(|&byte| byte != 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rtrt_shaders::reflect::entry_points;

    #[test]
    fn an_entry_point_alone_is_as_it_is_among_the_others() {
        let spirv = bytemuck::pod_collect_to_vec::<u8, u32>(rtrt_shaders::SPIRV);
        for among in entry_points(rtrt_shaders::SPIRV).unwrap() {
            let name = &among.name;
            let alone = entry_point(&spirv, name).unwrap();
            let [found] = &entry_points(bytemuck::cast_slice(&alone)).unwrap()[..] else {
                panic!("{name} is not alone");
            };
            assert_eq!(found.name, among.name);
            assert_eq!((found.workgroup_size, &found.bindings), (among.workgroup_size, &among.bindings));
            assert!(alone.len() < spirv.len(), "{name}");
        }
        assert_eq!(entry_point(&spirv, "no such entry"), None);
    }
}
