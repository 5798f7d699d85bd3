//! Backends compared.

use crate::folder::{Folder, code, json, keys, stderr, stdout};
use serde_json::Value;

#[test]
fn verify_finds_all_cpu_variants_equal() {
    let folder = Folder::new("verify");
    let line = "verify scene.obj --size 37x21 --samples 4 --backend cpu";
    let lines = stdout(&folder.run(line));
    assert!(lines.contains("cpu, 8 lanes, 2 threads: equal"), "{lines}");
    assert!(lines.lines().all(|line| line.ends_with(": equal") || line.contains("16 lanes")), "{lines}");

    let report = json(&folder.run(&format!("{line} --json")));
    let expected = ["buffers", "equal", "hash", "reference", "samples", "size", "variants"];
    assert_eq!(keys(&report), expected);
    assert_eq!(report["equal"], true);
    let variants = report["variants"].as_array().unwrap();
    assert_eq!(variants.len(), lines.lines().count());
    for variant in variants {
        assert_eq!(keys(variant), ["detail", "result", "variant"]);
    }
}

#[test]
fn verify_finds_the_gpu_equal_or_says_that_it_is_skipped() {
    let folder = Folder::new("verify_gpu");
    let is_required = std::env::var("RTRT_REQUIRE_GPU").is_ok_and(|value| value == "1");
    let mut command = folder.command("verify demo:matchbox --size 64x36 --json --backend gpu");
    if is_required {
        command.env("RTRT_REQUIRE_GPU", "1");
    }
    let output = command.output().unwrap();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    for variant in report["variants"].as_array().unwrap() {
        println!("{}: {}: {}", variant["variant"], variant["result"], variant["detail"]);
        assert_ne!(variant["result"], "differs", "{variant}");
    }
    let is_compared = report["variants"].as_array().unwrap().iter().any(|v| v["result"] == "equal");
    assert!(is_compared || !is_required, "RTRT_REQUIRE_GPU: {}", stderr(&output));
    if !is_compared {
        eprintln!("SKIPPED: verify on a GPU: {}", report["variants"][0]["detail"]);
    }
    assert_eq!(code(&output), if is_compared { 0 } else { 4 }, "{}", stderr(&output));
}

#[test]
fn a_required_gpu_that_is_not_there_is_exit_code_4() {
    let folder = Folder::new("required");
    let mut command = folder.command("verify scene.obj --size 8x8");
    // Vulkan finds no driver in a file that is not there.
    command.env("RTRT_REQUIRE_GPU", "1").env("VK_DRIVER_FILES", "none").env("VK_ICD_FILENAMES", "none");
    let output = command.output().unwrap();
    if cfg!(target_os = "linux") {
        assert_eq!(code(&output), 4, "{}", stderr(&output));
        assert!(stderr(&output).contains("RTRT_REQUIRE_GPU"), "{}", stderr(&output));
    }
}
