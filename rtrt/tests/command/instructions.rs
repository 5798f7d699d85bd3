//! A frame does not take more instructions unnoticed: the counts of `instructions.txt`, within 3 %.
//!
//! Counts of another compiler may be 15 % off. Without valgrind or AVX2 nothing is counted, which is said; with
//! `RTRT_REQUIRE_VALGRIND=1` that is an error.

use super::folder::Folder;
use std::process::Command;

const COUNTS: &str = include_str!("instructions.txt");

/// Instructions of the frame, and nothing else, of this scene.
fn counted(scene: &str, folder: &Folder) -> u64 {
    let counts = folder.0.join("counts");
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--demangle=no", "--toggle-collect=_ZN8rtrt_cpu6Memory5frame17h*E"])
        .arg(format!("--callgrind-out-file={}", counts.display()))
        .args([
            env!("CARGO_BIN_EXE_rtrt"),
            "render",
            scene,
            "--size",
            "320x180",
            "--samples",
            "1",
            "--threads",
            "1",
        ])
        .args(["--lanes", "8", "--backend", "cpu", "--quiet", "-o"])
        .arg(folder.0.join("frame.png"))
        // A string instruction that clears or copies memory counts as one for each byte: libc does without.
        .env(
            "GLIBC_TUNABLES",
            "glibc.cpu.x86_rep_stosb_threshold=100000000:glibc.cpu.x86_rep_movsb_threshold=100000000",
        )
        .output()
        .unwrap();
    assert!(output.status.success(), "{scene}: {}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(counts).unwrap();
    let count = text.lines().find_map(|line| line.strip_prefix("summary: ")).unwrap().trim().parse().unwrap();
    assert_ne!(count, 0, "no function of this name: Memory::frame of rtrt-cpu");
    count
}

/// The version that `rustc` prints.
fn compiler() -> String {
    let output = Command::new("rustc").arg("--version").output().unwrap();
    String::from_utf8(output.stdout).unwrap().split(' ').take(2).collect::<Vec<_>>().join(" ")
}

/// Why nothing can be counted here.
fn obstacle() -> Option<&'static str> {
    #[cfg(target_arch = "x86_64")]
    let has_avx2 = is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    let has_avx2 = false;
    if cfg!(debug_assertions) {
        Some("this is a debug build")
    } else if !has_avx2 {
        Some("this processor has no AVX2")
    } else if Command::new("valgrind").arg("--version").output().is_err() {
        Some("valgrind is not installed")
    } else {
        None
    }
}

#[test]
fn a_frame_takes_as_many_instructions_as_are_written_down() {
    if let Some(why) = obstacle() {
        let is_required = std::env::var_os("RTRT_REQUIRE_VALGRIND").is_some_and(|value| value == "1");
        assert!(!is_required, "{why}");
        eprintln!("skipped: {why}");
        return;
    }
    let (head, rows) = COUNTS.split_at(COUNTS.find("demo:").unwrap());
    let share = if head.contains(&format!("{}\n", compiler())) { 0.03 } else { 0.15 };
    let folder = Folder::new("instructions");
    let mut changed = vec![];
    for (scene, wanted) in rows.lines().map(|row| row.split_once(' ').unwrap()) {
        let wanted: u64 = wanted.parse().unwrap();
        let found = counted(scene, &folder);
        eprintln!("{scene} {found}, {wanted} written down");
        if found.abs_diff(wanted) as f64 > share * wanted as f64 {
            changed.push(format!("{scene} {found}, not {wanted}"));
        }
    }
    assert!(
        changed.is_empty(),
        "{}: if it is meant, write it into rtrt/tests/command/instructions.txt, and say why",
        changed.join("; ")
    );
}
