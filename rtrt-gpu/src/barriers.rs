//! Keeps every rounding in place where `NoContraction` is lost.
//!
//! naga drops the decoration, and drivers then reorder and fold: Mesa turns `(x + c) − c` into `x`. What a driver
//! cannot see through is an integer operation with a number that is known at run time only. So the result `r` of
//! every float operation becomes
//!
//! ```text
//! bits_to_float(float_to_bits(r) | zero)
//! ```
//!
//! with `zero` read from a uniform buffer in a bind group of its own.
//!
//! The largest number has no decimal literal that every compiler of WGSL takes: naga prints `3.4028235e38f`, which is
//! more than [`f32::MAX`], and Tint refuses it. So that constant, and what is made of it, is made from bits where a
//! function begins.

use crate::spirv::{BOUND, HEADER, instructions, op, opcode, values};
use std::collections::HashMap;

/// The bind group of the zero; its binding is 0.
pub(crate) const ZERO_GROUP: u32 = 1;

/// Storage class of uniform buffers.
const UNIFORM: u32 = 2;
/// Decorations.
const BLOCK: u32 = 2;
const BINDING: u32 = 33;
const DESCRIPTOR_SET: u32 = 34;
const OFFSET: u32 = 35;

/// The constants of the largest number, and those that are made of them, in order.
fn largest(spirv: &[u32], float: u32) -> Vec<&[u32]> {
    let mut found = Vec::<&[u32]>::new();
    for instruction in instructions(spirv).take_while(|i| opcode(i) != op::FUNCTION) {
        let is_number = opcode(instruction) == op::CONSTANT
            && instruction[1] == float
            && f32::from_bits(instruction[3]).abs() == f32::MAX;
        let is_made_of_one = opcode(instruction) == op::CONSTANT_COMPOSITE
            && instruction[3..].iter().any(|part| found.iter().any(|made| made[2] == *part));
        if is_number || is_made_of_one {
            found.push(instruction);
        }
    }
    found
}

/// The module `spirv` with a barrier behind every float operation; `spirv` itself if it has no 32-bit numbers.
pub(crate) fn with_barriers(spirv: &[u32]) -> Vec<u32> {
    let find = |wanted: &[u32]| {
        instructions(spirv).find(|i| i[0] & 0xffff == wanted[0] && i[2..] == wanted[1..]).map(|i| i[1])
    };
    let (Some(float), Some(uint)) = (find(&[op::TYPE_FLOAT, 32]), find(&[op::TYPE_INT, 32, 0])) else {
        return spirv.to_vec();
    };
    let mut ids = spirv[BOUND]..;
    let mut new = || ids.next().unwrap_or(u32::MAX);
    let [block, to_block, to_uint, first, variable] = [(); 5].map(|()| new());

    let largest = largest(spirv, float);
    // The ids of their bits, and, in each function, of what stands for them there.
    let bits: Vec<u32> = largest.iter().map(|_| new()).collect();
    let numbers = || largest.iter().zip(bits.iter().copied()).filter(|(i, _)| opcode(i) == op::CONSTANT);
    let mut stands_for = HashMap::new();

    let mut out = spirv[..HEADER].to_vec();
    let add = |words: &[u32], out: &mut Vec<u32>| {
        out.push((words.len() as u32) << 16 | words[0]);
        out.extend(&words[1..]);
    };
    let (mut declared, mut decorated) = (false, false);
    // The zero of the function, once it is loaded; whether its first label has been passed.
    let (mut zero, mut in_body) = (None, false);
    for instruction in instructions(spirv) {
        let code = opcode(instruction);
        if largest.iter().any(|constant| std::ptr::eq(*constant, instruction)) {
            continue;
        }
        if (op::TYPE_INT - 2..=op::CONSTANT).contains(&code) && !decorated {
            add(&[op::DECORATE, block, BLOCK], &mut out);
            add(&[op::MEMBER_DECORATE, block, 0, OFFSET, 0], &mut out);
            add(&[op::DECORATE, variable, DESCRIPTOR_SET, ZERO_GROUP], &mut out);
            add(&[op::DECORATE, variable, BINDING, 0], &mut out);
            decorated = true;
        }
        if code == op::FUNCTION && !declared {
            add(&[op::TYPE_STRUCT, block, uint], &mut out);
            add(&[op::TYPE_POINTER, to_block, UNIFORM, block], &mut out);
            add(&[op::TYPE_POINTER, to_uint, UNIFORM, uint], &mut out);
            add(&[op::CONSTANT, uint, first, 0], &mut out);
            add(&[op::VARIABLE, to_block, variable, UNIFORM], &mut out);
            for (constant, bits) in numbers() {
                add(&[op::CONSTANT, uint, bits, constant[3]], &mut out);
            }
            declared = true;
        }
        if in_body && zero.is_none() && code != op::VARIABLE {
            let (address, loaded) = (new(), new());
            add(&[op::ACCESS_CHAIN, to_uint, address, variable, first], &mut out);
            add(&[op::LOAD, uint, loaded, address], &mut out);
            zero = Some(loaded);
            for (constant, bits) in numbers() {
                let [barred, made] = [new(), new()];
                add(&[op::BITWISE_OR, uint, barred, bits, loaded], &mut out);
                add(&[op::BITCAST, float, made, barred], &mut out);
                stands_for.insert(constant[2], made);
            }
            for constant in largest.iter().filter(|constant| opcode(constant) == op::CONSTANT_COMPOSITE) {
                let made = new();
                let parts = constant[3..].iter().map(|part| *stands_for.get(part).unwrap_or(part));
                let words = [op::COMPOSITE_CONSTRUCT, constant[1], made].into_iter().chain(parts);
                add(&words.collect::<Vec<_>>(), &mut out);
                stands_for.insert(constant[2], made);
            }
        }
        in_body |= code == op::LABEL;
        if code == op::FUNCTION_END {
            (zero, in_body) = (None, false);
        }
        let is_float = matches!(code, op::F_NEGATE | op::F_ADD | op::F_SUB | op::F_MUL);
        let start = out.len();
        out.extend(instruction);
        if in_body {
            for word in &mut out[start..][values(instruction)] {
                *word = *stands_for.get(word).unwrap_or(word);
            }
        }
        if let (true, Some(zero)) = (is_float && instruction[1] == float, zero) {
            // The operation gets a new id; its users read the value behind the barrier.
            let [plain, bits, barred] = [(); 3].map(|()| new());
            let at = out.len() - instruction.len() + 2;
            let result = std::mem::replace(&mut out[at], plain);
            add(&[op::BITCAST, uint, bits, plain], &mut out);
            add(&[op::BITWISE_OR, uint, barred, bits, zero], &mut out);
            add(&[op::BITCAST, float, result, barred], &mut out);
        }
    }
    out[BOUND] = new();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_float_operation_passes_a_barrier() {
        let spirv = bytemuck::pod_collect_to_vec::<u8, u32>(rtrt_shaders::SPIRV);
        let count =
            |words: &[u32], opcode: u32| instructions(words).filter(|i| i[0] & 0xffff == opcode).count();
        let floats = [op::F_NEGATE, op::F_ADD, op::F_SUB, op::F_MUL];
        let operations: usize = floats.iter().map(|&opcode| count(&spirv, opcode)).sum();
        let barred = with_barriers(&spirv);
        assert!(operations > 1000);
        // And the largest number has one in each function.
        let numbers = count(&spirv, op::FUNCTION);
        assert_eq!(count(&barred, op::BITCAST), count(&spirv, op::BITCAST) + 2 * operations + numbers);
        assert_eq!(floats.iter().map(|&opcode| count(&barred, opcode)).sum::<usize>(), operations);
        // A barred result is never an operand's own: all ids are distinct.
        let mut results: Vec<u32> =
            instructions(&barred).filter(|i| i[0] & 0xffff == op::BITCAST).map(|i| i[2]).collect();
        results.sort_unstable();
        assert!(results.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn the_largest_number_is_no_constant() {
        let spirv = bytemuck::pod_collect_to_vec::<u8, u32>(rtrt_shaders::SPIRV);
        let float = instructions(&spirv).find(|i| opcode(i) == op::TYPE_FLOAT).unwrap()[1];
        // The number itself, and the hit that is none.
        let gone: Vec<u32> = largest(&spirv, float).iter().map(|constant| constant[2]).collect();
        assert_eq!(gone.len(), 2);
        let uses = |words: &[u32]| {
            instructions(words)
                .map(|i| i[values(i)].iter().filter(|word| gone.contains(word)).count())
                .sum::<usize>()
        };
        assert!(uses(&spirv) > 20);
        let barred = with_barriers(&spirv);
        assert_eq!((largest(&barred, float).len(), uses(&barred)), (0, 0));
    }
}
