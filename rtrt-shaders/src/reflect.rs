//! What a host must know of a module to run it.

use std::collections::{BTreeSet, HashMap, HashSet};

use rspirv::dr::{self, Function, Instruction, Module, Operand};
use rspirv::spirv::{Decoration, ExecutionMode, Op, StorageClass, Word};

/// One shader of a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryPoint {
    /// The name to create a pipeline with.
    pub name: String,
    /// Invocations per workgroup in x, y and z; none of what draws.
    pub workgroup_size: Option<[u32; 3]>,
    /// The buffers it reaches, by set and binding.
    pub bindings: Vec<Binding>,
}

/// One buffer of an entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Binding {
    /// Descriptor set, wgpu's bind group.
    pub set: u32,
    /// Number within the set.
    pub binding: u32,
    /// How the buffer is bound.
    pub kind: BindingKind,
}

/// How a buffer is bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum BindingKind {
    /// A uniform buffer.
    Uniform,
    /// A storage buffer that shaders only read.
    ReadOnlyStorage,
    /// A storage buffer that shaders may write.
    Storage,
}

/// The entry points of the module `spirv`, in its own order; `None` if it is not a readable module.
///
/// Bindings are those that the entry point's code reaches, through any depth of calls.
pub fn entry_points(spirv: &[u8]) -> Option<Vec<EntryPoint>> {
    let module = dr::load_bytes(spirv).ok()?;
    let buffers = buffers(&module);
    let functions: HashMap<Word, &Function> =
        module.functions.iter().filter_map(|f| Some((f.def.as_ref()?.result_id?, f))).collect();
    let entry = |declared: &Instruction| {
        let [_, Operand::IdRef(main), Operand::LiteralString(name), ..] = declared.operands.as_slice() else {
            return None;
        };
        let reached = reached(*main, &functions);
        Some(EntryPoint {
            name: name.clone(),
            workgroup_size: workgroup_size(&module, *main),
            bindings: buffers
                .iter()
                .filter(|(id, _)| reached.contains(id))
                .map(|(_, binding)| *binding)
                .collect::<BTreeSet<_>>()
                .into_iter()
                .collect(),
        })
    };
    module.entry_points.iter().map(entry).collect()
}

/// Every id named by the function `main` and by what it calls.
fn reached(main: Word, functions: &HashMap<Word, &Function>) -> HashSet<Word> {
    let mut ids = HashSet::from([main]);
    let mut open = vec![main];
    while let Some(id) = open.pop() {
        let Some(function) = functions.get(&id) else { continue };
        let operands = function.all_inst_iter().flat_map(|i| &i.operands);
        open.extend(operands.filter_map(Operand::id_ref_any).filter(|&id| ids.insert(id)));
    }
    ids
}

/// The module's buffers: the id of the variable, and its binding.
fn buffers(module: &Module) -> Vec<(Word, Binding)> {
    let decorated = |id: Word, wanted: Decoration| {
        module.annotations.iter().find_map(|a| match a.operands.as_slice() {
            [Operand::IdRef(target), Operand::Decoration(found), rest @ ..]
                if a.class.opcode == Op::Decorate && *target == id && *found == wanted =>
            {
                Some(rest.first().map_or(0, |number| number.unwrap_literal_bit32()))
            }
            _ => None,
        })
    };
    let buffer = |variable: &Instruction| {
        let id = variable.result_id?;
        let kind = match variable.operands.first()? {
            Operand::StorageClass(StorageClass::Uniform) => BindingKind::Uniform,
            Operand::StorageClass(StorageClass::StorageBuffer)
                if decorated(id, Decoration::NonWritable).is_some() =>
            {
                BindingKind::ReadOnlyStorage
            }
            Operand::StorageClass(StorageClass::StorageBuffer) => BindingKind::Storage,
            _ => return None,
        };
        let (set, binding) = (decorated(id, Decoration::DescriptorSet)?, decorated(id, Decoration::Binding)?);
        Some((id, Binding { set, binding, kind }))
    };
    let variables = module.types_global_values.iter().filter(|i| i.class.opcode == Op::Variable);
    variables.filter_map(buffer).collect()
}

/// The workgroup size of the entry point whose function is `main`.
fn workgroup_size(module: &Module, main: Word) -> Option<[u32; 3]> {
    module.execution_modes.iter().find_map(|mode| match mode.operands.as_slice() {
        [
            Operand::IdRef(id),
            Operand::ExecutionMode(ExecutionMode::LocalSize),
            Operand::LiteralBit32(x),
            Operand::LiteralBit32(y),
            Operand::LiteralBit32(z),
        ] if *id == main => Some([*x, *y, *z]),
        _ => None,
    })
}
