//! Variables of the environment that choose an adapter.

use crate::folder::{Folder, code, stderr};

fn run(name: &str, value: &str, options: &str) -> (i32, String) {
    let folder = Folder::new(&format!("environment_{name}_{value}"));
    let mut command = folder.command(&format!("render scene.obj --size 8x8 -o out.png {options}"));
    for name in ["WGPU_BACKEND", "WGPU_ADAPTER_NAME", "WGPU_POWER_PREF"] {
        command.env_remove(name);
    }
    let output = command.env(name, value).output().unwrap();
    (code(&output), stderr(&output))
}

#[test]
fn a_name_that_matches_nothing_lists_what_there_is() {
    let (code, said) = run("WGPU_ADAPTER_NAME", "abacus", "--backend gpu");
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("no GPU adapter is called \"abacus\"; there is: "), "{said}");
    // It has nothing to say about processors.
    assert_eq!(run("WGPU_ADAPTER_NAME", "abacus", "--backend cpu").0, 0);
}

#[test]
fn a_backend_that_is_not_here_has_no_adapters() {
    let other = if cfg!(target_os = "linux") { "dx12" } else { "gl" };
    let (code, said) = run("WGPU_BACKEND", other, "--backend gpu");
    assert!(code == 4 && said.contains("no GPU adapter can be used"), "{said}");
    let what_there_is = format!("WGPU_BACKEND={other} leaves out ");
    let is_none_there = run("WGPU_POWER_PREF", "none", "--backend gpu").1.contains("none is there");
    assert_eq!(said.contains(&what_there_is), !is_none_there, "{said}");
    assert_eq!(run("WGPU_BACKEND", other, "").0, 0);
}

#[test]
fn power_is_a_preference_and_no_more() {
    for preference in ["low", "high", "nonsense"] {
        assert_eq!(run("WGPU_POWER_PREF", preference, "").0, 0);
    }
}

#[test]
fn a_software_adapter_is_announced() {
    let (code, said) = run("WGPU_POWER_PREF", "none", "--backend gpu");
    if code == 4 {
        return println!("skipped: {said}");
    }
    assert_eq!(
        said.contains("(software adapter"),
        said.contains("warning: this adapter is software"),
        "{said}"
    );
    let (code, strict) = run("WGPU_POWER_PREF", "none", "--backend gpu --strict");
    assert_eq!(code, if said.contains("warning: this adapter") { 4 } else { 0 }, "{strict}");
}
