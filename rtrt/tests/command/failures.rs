//! What goes wrong: exit codes, one line, nothing left behind.

use crate::folder::{Folder, code, stderr};
use std::fs;

#[test]
fn what_is_not_there_is_told_from_what_is() {
    let folder = Folder::new("not_there");
    for (line, said) in [
        ("scene.obj --camera left", r#"there is no camera "left"; the scene has no cameras"#),
        ("demo:glass --camera left", r#"there is no camera "left"; the scene has one camera: 0 "window""#),
        ("scene.obj --hide 7", "there is no object 7; objects of the scene: 0"),
        ("scene.obj --ground --hide 0,2", "there is no object 2; objects of the scene: 0 to 1"),
        ("scene.obj --material 3:alpha=1", "there is no material 3; materials of the scene: 0"),
    ] {
        let output = folder.run(&format!("render {line} -o out.png --size 8x8 --backend cpu --quiet"));
        assert_eq!(code(&output), 2, "{line}");
        assert!(stderr(&output).lines().next().unwrap().ends_with(said), "{line}: {}", stderr(&output));
    }
    assert_eq!(folder.files(), [""; 0]);
}

#[test]
fn wrong_usage_is_exit_code_2_and_no_panic() {
    let folder = Folder::new("usage");
    for wrong in [
        "--size 0x0",
        "--size 99999x99999",
        "--size 16384x16384 --samples 16",
        "--size 64",
        "--samples 3",
        "--lanes 4",
        "--threads 0",
        "--eye nan,0,0",
        "--eye 0,0",
        "--up 0,0,0",
        "--fov-y 0",
        "--fov-y 180",
        "--fov-y -5",
        "--fov-y NaN",
        "--eye 1,2,3 --look-at 1,2,3",
        "--eye 0,5,0 --look-at 0,0,0 --up 0,1,0",
        "--camera 7",
        "--camera -1",
        "--light sun:0,0,0",
        "--light moon:1,2,3",
        "--backend tpu",
        "--no-such-option",
        "--no-shadows --shadows soft",
        "--fov-y 40 --parallel 3",
        "--compare out.png",
        "--time -1",
        "--light-radius -1",
        "--sun-shadows -1",
        "--parallel -1",
        "--fps -1",
        "--tolerance 1",
        "--frames -1",
        "--threads -1",
        "--transparency-depth -1",
        "--samples -1",
        "--lanes -1",
        "--bits -1",
        "--size -1x5",
        "--structure -1",
        "--point-size -1",
        "--point-size 0",
    ] {
        let output = folder.run(&format!("render scene.obj -o out.png --backend cpu --quiet {wrong}"));
        let said = stderr(&output);
        assert_eq!(code(&output), 2, "{wrong}: {said}");
        let [error, hint] = said.lines().collect::<Vec<_>>()[..] else { panic!("{wrong}: {said}") };
        assert!(error.starts_with("error: ") && hint.starts_with("hint: "), "{wrong}: {said}");
        // A number that is refused is not taken for an option.
        assert!(!error.contains("unexpected argument '-1'"), "{wrong}: {said}");
    }
    for wrong in [
        "render",
        "render scene.obj",
        "render scene.obj -o out.jpg",
        "render demo:none -o out.png",
        "render scene.obj --aov out.png",
        "render scene.obj -o out.exr --bits 16",
        "render scene.obj -o out.exr --debug depth",
        "render scene.obj -o out.png --bits 16 --debug depth",
        "render scene.obj --hash --debug depth",
        "render scene.obj --aov out.exr --bits 16",
        "render scene.obj -o out.png --debug colors",
        "render scene.obj -o - --hash",
        "render scene.obj -o - --json",
        "render scene.obj -o out.exr --aov out.exr",
        "render demo:matchbox --aov {scene}.exr --compare matchbox.exr",
        "render scene.obj -o {scnee}.png",
        "render scene.obj --aov {}.exr",
        "",
    ] {
        assert_eq!(code(&folder.run(wrong)), 2, "{wrong}");
    }
    assert_eq!(folder.files(), [""; 0]);
}

#[test]
fn a_command_that_makes_nothing_says_what_it_could_make() {
    let folder = Folder::new("nothing");
    let said = stderr(&folder.run("render scene.obj --size 8x8"));
    assert!(said.starts_with("error: wrong usage: no result is asked for: add -o FILE, --hash"), "{said}");
    let said = stderr(&folder.run("render scene.obj --size 8x8 --hash --debug depth"));
    assert!(said.starts_with("error: wrong usage: --debug and --bits are for a picture"), "{said}");
    for enough in ["--hash", "--json", "--aov out.exr", "--report out.json", "-o out.png --bits 16"] {
        let output = folder.run(&format!("render scene.obj --size 8x8 --backend cpu {enough}"));
        assert_eq!(code(&output), 0, "{enough}: {}", stderr(&output));
    }
}

#[test]
fn extreme_numbers_do_not_panic() {
    let folder = Folder::new("extreme");
    for extreme in [
        "--size 1x1",
        "--size 1x3000",
        "--size 8x8 --eye 1e38,1,1",
        "--size 8x8 --eye 1e-38,0,0 --look-at 0,0,0",
        "--size 8x8 --eye 3e38,3e38,3e38 --look-at -3e38,-3e38,-3e38",
        "--size 8x8 --fov-y 1e-30",
        "--size 8x8 --fov-y 179.999",
        "--size 8x8 --light point:3e38,0,0",
        "--size 8x8 --light point:0,0,0 --light sun:1e-17,0,0",
        "--size 8x8 --light sun:0,-3e38,3e38",
    ] {
        let output = folder.run(&format!("render scene.obj --hash --backend cpu {extreme}"));
        assert!([0, 2].contains(&code(&output)), "{extreme}: {}", stderr(&output));
        assert!(!stderr(&output).contains("panicked"), "{extreme}: {}", stderr(&output));
    }
}

#[test]
fn input_that_cannot_be_read_is_exit_code_3() {
    let folder = Folder::new("input");
    fs::write(folder.0.join("broken.glb"), "glTF but not really").unwrap();
    fs::write(folder.0.join("nan.obj"), "v 0 nan 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    for scene in ["missing.glb", "broken.glb", "nan.obj", "."] {
        for command in ["render -o out.png", "verify", "bench"] {
            let output = folder.run(&format!("{command} {scene} --size 8x8 --backend cpu"));
            assert_eq!(code(&output), 3, "{command} {scene}: {}", stderr(&output));
            let errors = stderr(&output);
            let error = errors.lines().next().unwrap();
            assert!(error.starts_with("error: ") && error.contains(scene), "{error}");
            let more: Vec<_> = errors.lines().skip(1).collect();
            assert!(more.len() == 1 && more[0].starts_with("hint: "), "{errors}");
        }
    }
    for (environment, why) in [("missing.hdr", "No such file"), ("scene.obj", "it is not in the Radiance")] {
        let output = folder.run(&format!("render scene.obj -o out.png --environment {environment}"));
        let said = stderr(&output);
        assert_eq!(code(&output), 3, "{said}");
        let begin = format!("error: environment refused: {environment}: ");
        assert!(said.starts_with(&begin) && (cfg!(windows) || said.contains(why)), "{said}");
        assert!(said.contains("\nhint: "), "{said}");
    }
    assert!(!folder.0.join("out.png").exists());
}

#[test]
fn a_picture_that_cannot_be_written_is_exit_code_1_and_leaves_nothing() {
    let folder = Folder::new("output");
    fs::create_dir(folder.0.join("folder.png")).unwrap();
    for place in [
        "-o missing/out.png",
        "-o folder.png",
        "-o scene.obj/out.png",
        "--aov missing/out.exr",
        "-o out.png --aov scene.obj/out.exr",
    ] {
        let output = folder.run(&format!("render scene.obj {place} --size 8x8 --backend cpu"));
        assert_eq!(code(&output), 1, "{place}: {}", stderr(&output));
        let name = place.split_whitespace().last().unwrap();
        assert!(stderr(&output).contains(name), "{}", stderr(&output));
    }
    assert_eq!(folder.files(), ["folder.png"]);
}

/// A folder in which nobody can make files.
#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_cannot_be_written_to_is_found_before_anything_is_rendered() {
    let folder = Folder::new("unwritable");
    for place in ["-o /proc/out.png", "--aov /proc/out.exr"] {
        let output = folder.run(&format!("render missing.obj {place} --size 8x8"));
        assert_eq!(code(&output), 1, "{place}: {}", stderr(&output));
        assert!(stderr(&output).contains("cannot write the picture: /proc/out"), "{}", stderr(&output));
    }
}

#[test]
fn a_failed_run_leaves_the_picture_that_was_there() {
    let folder = Folder::new("kept");
    fs::write(folder.0.join("out.png"), "before").unwrap();
    for scene in ["missing.obj", "demo:none", "scene.obj --up 0,0,0"] {
        assert_ne!(code(&folder.run(&format!("render {scene} -o out.png --backend cpu"))), 0);
        assert_eq!(fs::read(folder.0.join("out.png")).unwrap(), b"before");
        assert_eq!(folder.files(), ["out.png"]);
    }
}

#[test]
fn a_backend_that_is_not_there_is_exit_code_4() {
    let folder = Folder::new("unavailable");
    for backend in ["--backend gpu --adapter no-such-adapter", "--adapter no-such-adapter"] {
        for command in ["render -o out.png", "verify", "bench"] {
            let output = folder.run(&format!("{command} scene.obj --size 8x8 {backend}"));
            assert_eq!(code(&output), 4, "{command} {backend}: {}", stderr(&output));
            assert!(stderr(&output).contains("no-such-adapter"), "{}", stderr(&output));
        }
    }
    assert_eq!(folder.files(), [""; 0]);
}

#[test]
fn a_scene_with_nothing_to_draw_is_no_blank_picture() {
    let folder = Folder::new("blank");
    let empty = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{}]}"#;
    for (name, text, why) in [
        ("empty.gltf", empty, "it has no surfaces, points or lines"),
        (
            "curve.obj",
            "v 0 0 0\nv 1 0 0\ncurv 0 1 1 2\n",
            "curves, surfaces and faces of fewer than three corners are left out: 1",
        ),
    ] {
        fs::write(folder.0.join(name), text).unwrap();
        let output = folder.run(&format!("render {name} -o out.png --size 8x8 --backend cpu --quiet"));
        let said = stderr(&output);
        assert_eq!(code(&output), 3, "{said}");
        assert!(said.contains(&format!("error: nothing to draw: {name}: {why}")), "{said}");
        assert!(!folder.0.join("out.png").exists());
    }
}
