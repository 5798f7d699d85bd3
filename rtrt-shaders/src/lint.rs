//! What a module must not contain, if every device is to compute the same bits from it.

use std::collections::HashSet;

use rspirv::dr::{self, Instruction, Module, Operand};
use rspirv::spirv::{AddressingModel, Capability, Decoration, GlslStd450Op, MemoryModel, Op, Word};

/// The float operations a module may contain. Each is correctly rounded on every Vulkan device, provided that
/// its result is decorated `NoContraction`.
pub const FLOAT_ARITHMETIC: &[Op] = &[Op::FAdd, Op::FSub, Op::FMul, Op::FNegate];

/// The other operations a module may contain: none of them rounds, save conversions between integers and
/// floats, which every device rounds alike.
#[rustfmt::skip] // One a line would be a page.
const EXACT: &[Op] = {
    use Op::*;
    &[
        // Module, types, constants.
        Capability, ExtInstImport, MemoryModel, EntryPoint, ExecutionMode, Decorate, MemberDecorate,
        TypeVoid, TypeBool, TypeInt, TypeFloat, TypeVector, TypeArray, TypeRuntimeArray, TypeStruct,
        TypePointer, TypeFunction, ConstantTrue, ConstantFalse, Constant, ConstantComposite, ConstantNull,
        Undef, Variable,
        // Control flow.
        Function, FunctionParameter, FunctionEnd, FunctionCall, Label, Branch, BranchConditional, Switch,
        Return, ReturnValue, Unreachable, Phi, LoopMerge, SelectionMerge,
        // Memory, composites, integer functions of GLSL.std.450.
        Load, Store, CopyMemory, AccessChain, InBoundsAccessChain, ArrayLength, CompositeConstruct, CompositeExtract,
        CompositeInsert, Select, Bitcast, ExtInst,
        // Integers and booleans.
        IAdd, ISub, IMul, UDiv, SDiv, UMod, SRem, SNegate, ShiftLeftLogical, ShiftRightLogical,
        ShiftRightArithmetic, BitwiseAnd, BitwiseOr, BitwiseXor, Not, BitCount, BitReverse, IEqual, INotEqual,
        ULessThan, ULessThanEqual, UGreaterThan, UGreaterThanEqual, SLessThan, SLessThanEqual, SGreaterThan,
        SGreaterThanEqual, LogicalAnd, LogicalOr, LogicalNot, LogicalEqual, LogicalNotEqual,
        // Floats: comparisons and conversions.
        FOrdEqual, FOrdNotEqual, FOrdLessThan, FOrdLessThanEqual, FOrdGreaterThan, FOrdGreaterThanEqual,
        FUnordEqual, FUnordNotEqual, FUnordLessThan, FUnordLessThanEqual, FUnordGreaterThan,
        FUnordGreaterThanEqual, ConvertFToU, ConvertFToS, ConvertSToF, ConvertUToF,
        // Between invocations.
        ControlBarrier, MemoryBarrier, AtomicLoad, AtomicStore, AtomicExchange, AtomicIAdd, AtomicISub,
        AtomicUMin, AtomicUMax, AtomicSMin, AtomicSMax, AtomicAnd, AtomicOr, AtomicXor,
    ]
};

/// The functions of GLSL.std.450 a module may call: bit scans.
const EXACT_GLSL: &[GlslStd450Op] = &[GlslStd450Op::FindILsb, GlslStd450Op::FindUMsb, GlslStd450Op::FindSMsb];

/// What is wrong with the module `spirv`, one line each; empty if every device and naga may have it.
///
/// - An operation that is neither in [`FLOAT_ARITHMETIC`] nor on the list of exact ones (division, square
///   roots, `fma`, a debug line), or a float operation without `NoContraction`.
/// - A capability besides `Shader`, an extension, or a memory model besides GLSL450: wgpu enables no more.
/// - A constant that is infinite or NaN: naga refuses it.
/// - A pointer inside a composite, or chosen at run time: naga refuses the first, Mesa crashes on the second.
pub fn lint(spirv: &[u8]) -> Vec<String> {
    let module = match dr::load_bytes(spirv) {
        Ok(module) => module,
        Err(error) => return vec![format!("not a SPIR-V module: {error}")],
    };
    let exact = uncontracted(&module);
    let pointers = results(&module, |i| i.class.opcode == Op::TypePointer);
    let floats = results(&module, |i| i.class.opcode == Op::TypeFloat);
    let is_in = |set: &HashSet<Word>, id: Option<Word>| id.is_some_and(|id| set.contains(&id));

    let mut found = Vec::new();
    for instruction in module.all_inst_iter() {
        let op = instruction.class.opcode;
        let mut wrong = |what: &str| found.push(format!("{what}: {}", describe(instruction)));
        if FLOAT_ARITHMETIC.contains(&op) {
            if !is_in(&exact, instruction.result_id) {
                wrong("float operation without NoContraction");
            }
        } else if !EXACT.contains(&op) {
            wrong("operation not on the list");
        }
        let pointer_inside = || instruction.operands.iter().any(|o| is_in(&pointers, o.id_ref_any()));
        match op {
            Op::Capability if instruction.operands != [Operand::Capability(Capability::Shader)] => {
                wrong("capability")
            }
            Op::MemoryModel
                if instruction.operands
                    != [
                        Operand::AddressingModel(AddressingModel::Logical),
                        Operand::MemoryModel(MemoryModel::GLSL450),
                    ] =>
            {
                wrong("memory model")
            }
            Op::ExtInstImport if instruction.operands != [Operand::LiteralString("GLSL.std.450".into())] => {
                wrong("instruction set")
            }
            Op::ExtInst if !is_exact_glsl(instruction) => wrong("function not on the list"),
            Op::TypeStruct | Op::TypeArray if pointer_inside() => wrong("pointer inside a composite"),
            Op::Phi | Op::Select if is_in(&pointers, instruction.result_type) => {
                wrong("pointer chosen at run time")
            }
            Op::Constant if is_in(&floats, instruction.result_type) && !is_finite(instruction) => {
                wrong("constant that is not finite")
            }
            _ => {}
        }
    }
    found
}

/// The ids decorated `NoContraction`.
fn uncontracted(module: &Module) -> HashSet<Word> {
    let target = |a: &Instruction| match a.operands.as_slice() {
        [Operand::IdRef(id), Operand::Decoration(Decoration::NoContraction)] => Some(*id),
        _ => None,
    };
    module.annotations.iter().filter_map(target).collect()
}

/// The results of the module's global instructions that are `wanted`.
fn results(module: &Module, wanted: impl Fn(&Instruction) -> bool) -> HashSet<Word> {
    module.types_global_values.iter().filter(|i| wanted(i)).filter_map(|i| i.result_id).collect()
}

fn is_exact_glsl(call: &Instruction) -> bool {
    let Some(Operand::LiteralExtInstInteger(number)) = call.operands.get(1) else { return false };
    GlslStd450Op::from_u32(*number).is_some_and(|function| EXACT_GLSL.contains(&function))
}

fn is_finite(constant: &Instruction) -> bool {
    matches!(constant.operands[..], [Operand::LiteralBit32(bits)] if f32::from_bits(bits).is_finite())
}

fn describe(instruction: &Instruction) -> String {
    use rspirv::binary::Disassemble;
    instruction.disassemble()
}
