//! From the module that rust-gpu emits to the committed one.

use anyhow::{Context, Result};
use rspirv::binary::Assemble;
use rspirv::dr::{self, Instruction, Module, Operand};
use rspirv::spirv::{AddressingModel, Capability, Decoration, MemoryModel, Op, Word};

use crate::lint::FLOAT_ARITHMETIC;
use crate::pointers::untangle;

/// The module `raw` without debug information, composites of pointers or the Vulkan memory model, and with
/// every float operation decorated `NoContraction`.
pub fn finish(raw: &[u8]) -> Result<Vec<u8>> {
    let mut module = dr::load_bytes(raw).ok().context("rust-gpu's output is not a SPIR-V module")?;
    strip_debug(&mut module);
    untangle(&mut module);
    use_glsl_memory_model(&mut module);
    decorate(&mut module);
    Ok(module.assemble().into_iter().flat_map(Word::to_le_bytes).collect())
}

/// Names, lines and embedded sources: they would tie the bytes to the folder they were built in.
fn strip_debug(module: &mut Module) {
    module.debug_string_source.clear();
    module.debug_names.clear();
    module.debug_module_processed.clear();
    let is_line = |i: &Instruction| matches!(i.class.opcode, Op::Line | Op::NoLine);
    module.types_global_values.retain(|i| !is_line(i));
    for block in module.functions.iter_mut().flat_map(|f| &mut f.blocks) {
        block.instructions.retain(|i| !is_line(i));
    }
}

/// wgpu does not enable the Vulkan memory model, and nothing here needs it.
fn use_glsl_memory_model(module: &mut Module) {
    let vulkan = [Capability::VulkanMemoryModel, Capability::VulkanMemoryModelDeviceScope];
    module.capabilities.retain(|c| !vulkan.map(Operand::Capability).contains(&c.operands[0]));
    module
        .extensions
        .retain(|e| e.operands != [Operand::LiteralString("SPV_KHR_vulkan_memory_model".into())]);
    let operands =
        vec![Operand::AddressingModel(AddressingModel::Logical), Operand::MemoryModel(MemoryModel::GLSL450)];
    module.memory_model = Some(Instruction::new(Op::MemoryModel, None, None, operands));
}

/// Without `NoContraction` a driver may fuse a multiplication with an addition, or reorder sums.
fn decorate(module: &mut Module) {
    let arithmetic = module.all_inst_iter().filter(|i| FLOAT_ARITHMETIC.contains(&i.class.opcode));
    let decorations: Vec<_> = arithmetic
        .filter_map(|i| i.result_id)
        .map(|id| vec![Operand::IdRef(id), Operand::Decoration(Decoration::NoContraction)])
        .map(|operands| Instruction::new(Op::Decorate, None, None, operands))
        .collect();
    module.annotations.extend(decorations);
}
