//! What the command tells of itself.

use crate::folder::{Folder, stdout};

#[test]
fn help_has_examples_that_run() {
    let folder = Folder::new("help");
    assert!(stdout(&folder.run("--help")).contains("rtrt verify scene.glb"));
    let help = stdout(&folder.run("render --help"));
    let examples: Vec<&str> = help.lines().filter_map(|line| line.trim().strip_prefix("rtrt ")).collect();
    assert_eq!(examples.len(), 5);
    let words = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("with at least four digits, and {n} the number alone;"), "{help}");
    for example in examples {
        // On a smaller scene, with the reference that one of them is compared with.
        stdout(&folder.run("render scene.obj --size 8x8 --backend cpu -o yesterday.png"));
        let line = example.replace("scene.glb", "scene.obj").replace("--frames 48", "--frames 2");
        stdout(&folder.run(&format!("{line} --size 8x8 --backend cpu")));
    }
}

#[test]
fn the_version_names_features_and_shaders() {
    let folder = Folder::new("version");
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(stdout(&folder.run("-V")), format!("rtrt {version}\n"));
    let long = stdout(&folder.run("--version"));
    let lines: Vec<&str> = long.lines().collect();
    assert_eq!(lines[0], format!("rtrt {version}"));
    let viewer = if cfg!(feature = "viewer") { ", viewer" } else { "" };
    assert_eq!(lines[1], format!("features: gpu, import, command{viewer}"));
    let shaders = rtrt::hash::of(rtrt_gpu::SHADERS);
    assert_eq!(lines[2], format!("shaders: {shaders}"));
}

#[test]
fn shells_complete_and_there_is_a_manual() {
    let folder = Folder::new("completions");
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = stdout(&folder.run(&format!("completions {shell}")));
        assert!(script.contains("transparency-depth"), "{shell}");
    }
    let manual = stdout(&folder.run("man"));
    for part in [".TH rtrt 1", ".TH rtrt-render 1", ".TH rtrt-verify 1", "\\-\\-transparency\\-depth"] {
        assert!(manual.contains(part), "{part}");
    }
    assert!(manual.contains("{n} the number alone") && !manual.contains("[0m"));
}
