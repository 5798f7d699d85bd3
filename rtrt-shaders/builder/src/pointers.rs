//! Takes structs of slices apart.
//!
//! A struct of slices becomes a composite of pointers, or a variable that holds pointers where a closure
//! captures it. Such a value is built field by field, never changed, and read field by field. naga refuses its
//! type. Here every read is replaced by what was put in; then nothing uses the struct, and it is dropped. What
//! does change (a struct of slices that a loop carries) stays, and the lint refuses it.

use std::collections::{HashMap, HashSet};

use rspirv::dr::{Function, Instruction, Module, Operand};
use rspirv::spirv::{Op, StorageClass, Word};

/// Removes structs of pointers, where their fields are set once.
pub fn untangle(module: &mut Module) {
    let globals = Globals::new(module);
    // A closure is a composite that holds the address of what it captures: first it goes, then the captured.
    module.functions.iter_mut().for_each(|f| forward_composites(f, &globals));
    remove_dead(module);
    module.functions.iter_mut().for_each(|f| forward_variables(f, &globals));
    module.functions.iter_mut().for_each(|f| forward_composites(f, &globals));
    remove_dead(module);
}

/// What the passes ask about types and constants.
struct Globals {
    /// Structs and arrays.
    aggregates: HashSet<Word>,
    /// Types of pointers to variables of a function that hold pointers, at any depth.
    to_pointers: HashSet<Word>,
    /// Integer constants.
    integers: HashMap<Word, u32>,
}

impl Globals {
    fn new(module: &Module) -> Self {
        let (mut aggregates, mut to_pointers) = (HashSet::new(), HashSet::new());
        let mut integers = HashMap::new();
        let mut holds_pointers = HashSet::new();
        for i in &module.types_global_values {
            let Some(result) = i.result_id else { continue };
            match (i.class.opcode, i.operands.as_slice()) {
                (Op::TypePointer, [Operand::StorageClass(class), Operand::IdRef(pointee)]) => {
                    if *class == StorageClass::Function && holds_pointers.contains(pointee) {
                        to_pointers.insert(result);
                    }
                    holds_pointers.insert(result);
                }
                (Op::TypeStruct | Op::TypeArray, members) => {
                    aggregates.insert(result);
                    if members.iter().any(|member| holds_pointers.contains(&id(member))) {
                        holds_pointers.insert(result);
                    }
                }
                (Op::Constant, [Operand::LiteralBit32(value)]) => {
                    integers.insert(result, *value);
                }
                _ => {}
            }
        }
        Self { aggregates, to_pointers, integers }
    }
}

/// A variable, and the path to a part of it.
type Place = (Word, Vec<u32>);

/// Replaces loads from variables of pointers by what was stored, where each part is stored once.
///
/// The one store comes before every load on every path, or the load would be of something undefined; so what
/// it stores may be named wherever it is loaded. spirv-val checks that.
fn forward_variables(function: &mut Function, globals: &Globals) {
    let mut places: HashMap<Word, Place> = HashMap::new();
    let mut stores: HashMap<Place, Word> = HashMap::new();
    let mut given_up: HashSet<Word> = HashSet::new();
    for i in function.blocks.iter().flat_map(|b| &b.instructions) {
        let base =
            i.operands.first().and_then(Operand::id_ref_any).and_then(|base| places.get(&base)).cloned();
        match (i.class.opcode, base) {
            (Op::Variable, _) if globals.to_pointers.contains(&i.result_type.unwrap()) => {
                places.insert(i.result_id.unwrap(), (i.result_id.unwrap(), Vec::new()));
            }
            (Op::AccessChain | Op::InBoundsAccessChain, Some((variable, mut path))) => {
                let steps: Option<Vec<_>> =
                    i.operands[1..].iter().map(|o| globals.integers.get(&id(o)).copied()).collect();
                if let Some(steps) = steps {
                    path.extend(steps);
                } else {
                    given_up.insert(variable);
                }
                places.insert(i.result_id.unwrap(), (variable, path));
            }
            (Op::Load, Some(_)) => {}
            (Op::Store, Some(place)) => {
                let variable = place.0;
                if stores.insert(place, id(&i.operands[1])).is_some() {
                    given_up.insert(variable);
                }
            }
            _ => {
                let used = i.operands.iter().filter_map(|o| places.get(&o.id_ref_any()?));
                given_up.extend(used.map(|(variable, _)| *variable));
            }
        }
    }

    let mut same = HashMap::new();
    for block in &mut function.blocks {
        block.instructions.retain_mut(|i| {
            let place = i.operands.first().and_then(Operand::id_ref_any).and_then(|base| places.get(&base));
            let Some((variable, path)) = place.filter(|(variable, _)| !given_up.contains(variable)) else {
                return true;
            };
            if i.class.opcode != Op::Load {
                return i.class.opcode != Op::Store;
            }
            // Stored whole, or as a part of something larger.
            let stored = (0..=path.len()).rev().find_map(|length| {
                Some((*stores.get(&(*variable, path[..length].to_vec()))?, &path[length..]))
            });
            match stored {
                Some((value, [])) => {
                    same.insert(i.result_id.unwrap(), value);
                    return false;
                }
                Some((value, rest)) => *i = extract(i, value, rest),
                None => {}
            }
            true
        });
    }
    rename(function, &same);
}

/// Makes every extraction name the value it extracts, where a chain of insertions built the composite.
fn forward_composites(function: &mut Function, globals: &Globals) {
    let definitions: HashMap<Word, Instruction> = function
        .all_inst_iter()
        .filter(|i| match i.class.opcode {
            Op::CompositeInsert | Op::CompositeExtract => true,
            Op::CompositeConstruct => globals.aggregates.contains(&i.result_type.unwrap()),
            _ => false,
        })
        .map(|i| (i.result_id.unwrap(), i.clone()))
        .collect();
    let mut same = HashMap::new();
    for i in function.blocks.iter_mut().flat_map(|b| &mut b.instructions) {
        if i.class.opcode == Op::CompositeExtract {
            let (source, path) = resolve(i, &definitions);
            if path.is_empty() {
                same.insert(i.result_id.unwrap(), source);
            } else {
                *i = extract(i, source, &path);
            }
        }
    }
    rename(function, &same);
}

/// Where the value of an OpCompositeExtract comes from: an id, and the path within it.
fn resolve(extract: &Instruction, definitions: &HashMap<Word, Instruction>) -> (Word, Vec<u32>) {
    let (mut source, mut path) = (id(&extract.operands[0]), literals(&extract.operands[1..]));
    while let (Some(definition), false) = (definitions.get(&source), path.is_empty()) {
        let operands = &definition.operands;
        match definition.class.opcode {
            Op::CompositeInsert => {
                let inserted = literals(&operands[2..]);
                if path.starts_with(&inserted) {
                    source = id(&operands[0]);
                    path.drain(..inserted.len());
                } else if inserted.starts_with(&path) {
                    break; // The insertion changed a part of what is extracted.
                } else {
                    source = id(&operands[1]);
                }
            }
            Op::CompositeExtract => {
                source = id(&operands[0]);
                path.splice(0..0, literals(&operands[1..]));
            }
            _ => source = id(&operands[path.remove(0) as usize]),
        }
    }
    (source, path)
}

/// `i`, but as the part of `source` at `path`.
fn extract(i: &Instruction, source: Word, path: &[u32]) -> Instruction {
    let path = path.iter().copied().map(Operand::LiteralBit32);
    let operands = [Operand::IdRef(source)].into_iter().chain(path).collect();
    Instruction::new(Op::CompositeExtract, i.result_type, i.result_id, operands)
}

/// Names, in place of every id that is a key of `same`, its value.
fn rename(function: &mut Function, same: &HashMap<Word, Word>) {
    let instructions = function.blocks.iter_mut().flat_map(|b| &mut b.instructions);
    for id in instructions.flat_map(|i| &mut i.operands).filter_map(Operand::id_ref_any_mut) {
        while let Some(source) = same.get(id) {
            *id = *source;
        }
    }
}

/// Drops variables, chains, composites, constants and types that nothing uses, and what decorated them.
fn remove_dead(module: &mut Module) {
    use Op::{
        AccessChain, CompositeConstruct, CompositeExtract, CompositeInsert, InBoundsAccessChain, Undef,
    };
    let pure = [
        AccessChain,
        InBoundsAccessChain,
        CompositeConstruct,
        CompositeExtract,
        CompositeInsert,
        Undef,
        Op::Variable,
    ];
    loop {
        let used: HashSet<Word> = (module.entry_points.iter())
            .chain(&module.types_global_values)
            .chain(module.functions.iter().flat_map(|f| f.all_inst_iter()))
            .flat_map(|i| i.operands.iter().filter_map(Operand::id_ref_any).chain(i.result_type))
            .collect();
        let mut dead = HashSet::new();
        let mut keep = |i: &Instruction, removable: bool| {
            let unused = i.result_id.filter(|id| removable && !used.contains(id));
            dead.extend(unused);
            unused.is_none()
        };
        module.types_global_values.retain(|i| keep(i, i.class.opcode != Op::Variable));
        for block in module.functions.iter_mut().flat_map(|f| &mut f.blocks) {
            block.instructions.retain(|i| keep(i, pure.contains(&i.class.opcode)));
        }
        if dead.is_empty() {
            return;
        }
        module.annotations.retain(|a| !dead.contains(&id(&a.operands[0])));
    }
}

fn id(operand: &Operand) -> Word {
    operand.id_ref_any().expect("an id")
}

fn literals(operands: &[Operand]) -> Vec<u32> {
    operands.iter().map(Operand::unwrap_literal_bit32).collect()
}
