//! The committed module matches its sources, and obeys the rules that make devices agree.

use std::collections::BTreeSet;
use std::path::Path;

use rspirv::binary::Assemble;
use rspirv::dr::{self, Instruction, Module, Operand};
use rspirv::spirv::{Decoration, Op};
use rtrt_shaders::SPIRV;
use rtrt_shaders::lint::lint;
use rtrt_shaders::manifest::manifest;
use rtrt_shaders::reflect::{BindingKind, entry_points};

const MANIFEST: &str = include_str!("../rtrt.manifest");
const REBUILD: &str = "run `cargo run --release --manifest-path rtrt-shaders/builder/Cargo.toml`";

#[test]
fn the_committed_module_keeps_the_rules() {
    assert_eq!(lint(SPIRV), [""; 0]);
}

#[test]
fn the_manifest_is_current() {
    assert_eq!(stale(&manifest_now(SPIRV), MANIFEST), BTreeSet::new(), "these changed: {REBUILD}");
}

/// wgpu numbers the bindings of a set anew, from 0, in order; passthrough modules must already be so.
#[test]
fn bindings_are_dense_and_few_enough_for_webgpu() {
    for entry in entry_points(SPIRV).expect("a module") {
        let numbers: Vec<_> = entry.bindings.iter().map(|b| (b.set, b.binding)).collect();
        let dense: Vec<_> = (0..numbers.len() as u32).map(|binding| (0, binding)).collect();
        assert_eq!(numbers, dense, "{}", entry.name);
        let storage = entry.bindings.iter().filter(|b| b.kind != BindingKind::Uniform).count();
        assert!(storage <= 8, "{} binds {storage} storage buffers", entry.name);
        let invocations = entry.workgroup_size.unwrap_or_default().iter().product::<u32>();
        assert!(invocations <= 256, "{}", entry.name);
    }
}

#[test]
fn a_missing_decoration_is_found() {
    let broken = edited(|module| {
        let exact = |a: &Instruction| a.operands[1] == Operand::Decoration(Decoration::NoContraction);
        let first = module.annotations.iter().position(exact).expect("a float operation");
        module.annotations.remove(first);
    });
    assert_found(&broken, "float operation without NoContraction: ");
}

#[test]
fn a_division_is_found_decorated_or_not() {
    let broken = edited(|module| replace_multiplication(module, Op::FDiv));
    assert_found(&broken, "operation not on the list: ");
}

#[test]
fn an_infinite_constant_is_found() {
    let broken = edited(|module| {
        let float = first_multiplication(module).result_type;
        let bits = vec![Operand::LiteralBit32(f32::INFINITY.to_bits())];
        let id = module.header.as_mut().map(|header| {
            header.bound += 1;
            header.bound - 1
        });
        module.types_global_values.push(Instruction::new(Op::Constant, float, id, bits));
    });
    assert_found(&broken, "constant that is not finite: ");
}

#[test]
fn a_changed_module_or_manifest_is_found() {
    let broken = edited(|module| replace_multiplication(module, Op::FAdd));
    assert_eq!(
        stale(&manifest_now(&broken), &manifest_now(SPIRV)),
        BTreeSet::from(["rtrt-shaders/rtrt.spv"])
    );
    let now = manifest_now(SPIRV);
    let (first, rest) = now.split_at(1);
    let changed = if first == "0" { "1" } else { "0" };
    assert_eq!(stale(&now, &format!("{changed}{rest}")), BTreeSet::from(["rtrt-core/Cargo.toml"]));
    assert_eq!(stale(&now, &now[now.find('\n').unwrap() + 1..]), BTreeSet::from(["rtrt-core/Cargo.toml"]));
}

/// The files whose lines are in one of two manifests only.
fn stale<'a>(now: &'a str, committed: &'a str) -> BTreeSet<&'a str> {
    let [now, committed] = [now, committed].map(|text| text.lines().collect::<BTreeSet<_>>());
    now.symmetric_difference(&committed).filter_map(|line| line.split("  ").nth(1)).collect()
}

fn manifest_now(spirv: &[u8]) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the repository");
    manifest(root, spirv).expect("the sources")
}

/// The committed module after `edit`.
fn edited(edit: impl FnOnce(&mut Module)) -> Vec<u8> {
    let mut module = dr::load_bytes(SPIRV).expect("a module");
    edit(&mut module);
    module.assemble().into_iter().flat_map(u32::to_le_bytes).collect()
}

fn first_multiplication(module: &mut Module) -> &mut Instruction {
    let blocks = module.functions.iter_mut().flat_map(|function| &mut function.blocks);
    blocks.flat_map(|b| &mut b.instructions).find(|i| i.class.opcode == Op::FMul).expect("a multiplication")
}

fn replace_multiplication(module: &mut Module, by: Op) {
    let i = first_multiplication(module);
    *i = Instruction::new(by, i.result_type, i.result_id, i.operands.clone());
}

/// Exactly one line, which starts with `wrong`: the edit is what was found, and nothing else.
fn assert_found(spirv: &[u8], wrong: &str) {
    let found = lint(spirv);
    assert!(found.len() == 1 && found[0].starts_with(wrong), "{found:?}");
}
