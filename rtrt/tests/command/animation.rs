//! Frames of an animation.

use crate::folder::{Folder, code, stderr, stdout};
use std::fs;

/// A file with a triangle that a spline of two keyframes moves from the left to the right, and
/// that is turned and has no size at first. Its numbers are in `numbers.bin`.
const MOVES: &str = r#"{
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 2]}],
    "nodes": [{"children": [1]}, {"mesh": 0, "scale": [0, 0, 0]}, {"camera": 0, "translation": [0, 0, 4]}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "animations": [{
        "samplers": [
            {"input": 1, "output": 2, "interpolation": "CUBICSPLINE"},
            {"input": 1, "output": 3},
            {"input": 1, "output": 4, "interpolation": "STEP"}
        ],
        "channels": [
            {"sampler": 0, "target": {"node": 0, "path": "translation"}},
            {"sampler": 1, "target": {"node": 1, "path": "rotation"}},
            {"sampler": 2, "target": {"node": 1, "path": "scale"}}
        ]
    }],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
        {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 2, "type": "SCALAR"},
        {"bufferView": 0, "byteOffset": 44, "componentType": 5126, "count": 6, "type": "VEC3"},
        {"bufferView": 0, "byteOffset": 116, "componentType": 5126, "count": 2, "type": "VEC4"},
        {"bufferView": 0, "byteOffset": 148, "componentType": 5126, "count": 2, "type": "VEC3"}
    ],
    "bufferViews": [{"buffer": 0, "byteLength": 172}],
    "buffers": [{"byteLength": 172, "uri": "numbers.bin"}]
}"#;

/// A folder with the file, and its numbers.
fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    let numbers: [f32; 43] = [
        // Corners, times, a spline with its tangents, rotations, scales.
        -0.5, -0.5, 0.0, 0.5, -0.5, 0.0, 0.0, 0.5, 0.0, //
        0.0, 2.0, //
        0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, //
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.707, 0.707, //
        0.0, 0.0, 0.0, 1.0, 1.0, 1.0,
    ];
    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    fs::write(folder.0.join("numbers.bin"), bytes).unwrap();
    fs::write(folder.0.join("moves.gltf"), MOVES).unwrap();
    folder
}

#[test]
fn frames_play_the_animation() {
    let folder = folder("frames");
    let line = "moves.gltf --size 64x36 --backend cpu --lanes 8 --environment none";
    stdout(&folder.run(&format!("render {line} --frames 3 --fps 1 -o {{frame}}.png --hash")));
    let pixels = |name: &str| image::open(folder.0.join(name)).unwrap().into_rgba8();
    // At 0 seconds it has no size, at 1 a step has not been taken, at 2 it is there.
    let blank = pixels("0000.png");
    assert!(blank.pixels().all(|pixel| pixel == blank.get_pixel(0, 0)));
    assert_eq!(pixels("0001.png"), blank);
    assert_ne!(pixels("0002.png"), blank);
    assert_ne!(pixels("0002.png").get_pixel(44, 18), blank.get_pixel(0, 0));
    // A frame of many is the frame alone, and at rest nothing is to be seen.
    stdout(&folder.run(&format!("render {line} --time 2 -o alone.png")));
    assert_eq!(pixels("alone.png"), pixels("0002.png"));
    let output = folder.run(&format!("render {line} -o rest.png"));
    assert_eq!((stdout(&output).as_str(), pixels("rest.png")), ("", blank));
    let report = stdout(&folder.run(&format!("verify {line} --time 2")));
    assert!(report.lines().all(|line| line.ends_with(": equal") || line.contains("16 lanes")), "{report}");
    for wrong in ["--frames 2 -o out.png", "--frames 0 -o {frame}.png", "--time -1 -o a.png"] {
        assert_eq!(code(&folder.run(&format!("render moves.gltf {wrong}"))), 2, "{wrong}");
    }
}

#[test]
fn objects_fly_and_turn_until_they_rest() {
    let folder = Folder::new("moving");
    let line = "demo:moving --size 64x36 --backend cpu --lanes 8";
    stdout(&folder.run(&format!("render {line} --frames 6 --fps 1 -o {{frame}}.png")));
    stdout(&folder.run(&format!("render {line} -o start.png")));
    stdout(&folder.run(&format!("render {line} --time 2 -o alone.png")));
    let pixels = |name: &str| image::open(folder.0.join(name)).unwrap().into_rgba8();
    assert_eq!(pixels("start.png"), pixels("0000.png"));
    assert_eq!(pixels("alone.png"), pixels("0002.png"));
    assert_ne!(pixels("0003.png"), pixels("0002.png"));
    assert_ne!(pixels("0004.png"), pixels("0003.png"));
    assert_eq!(pixels("0005.png"), pixels("0004.png"));
}

#[test]
fn one_of_several_animations_is_chosen() {
    let folder = folder("animations");
    // The first moves the triangle, the second gives it its size.
    let channels = |number: &str| {
        let line = MOVES.lines().find(|line| line.contains(&format!(r#"{{"sampler": {number}"#))).unwrap();
        line.trim().trim_end_matches(',').to_owned()
    };
    let samplers = MOVES.split(r#""samplers": ["#).nth(1).unwrap().split(']').next().unwrap();
    let animation = |name: &str, channels: String| {
        format!(r#"{{{name}"samplers": [{samplers}], "channels": [{channels}]}}"#)
    };
    let (before, after) = MOVES.split_once(r#""animations": [{"#).unwrap();
    let after = after.split_once("}],").unwrap().1;
    let animations =
        [animation("", channels("0")), animation(r#""name": "grow", "#, channels("2"))].join(",");
    fs::write(folder.0.join("two.gltf"), format!(r#"{before}"animations": [{animations}],{after}"#)).unwrap();
    let line = "two.gltf --size 64x36 --backend cpu --lanes 8 --environment none";
    let pixels = |options: &str| {
        let output = folder.run(&format!("render {line} {options} -o out.png"));
        stdout(&output);
        (image::open(folder.0.join("out.png")).unwrap().into_rgba8(), stderr(&output))
    };
    let (first, said) = pixels("--time 2");
    assert!(said.contains("warning: of 2 animations, the first is played"), "{said}");
    let blank = first.get_pixel(0, 0);
    assert!(first.pixels().all(|pixel| pixel == blank), "without its size it is not seen");
    let (zero, said) = pixels("--time 2 --animation 0");
    assert!(zero == first && !said.contains("warning"), "{said}");
    let (grown, _) = pixels("--time 2 --animation grow");
    assert_eq!((grown.get_pixel(32, 18) == blank, &grown), (false, &pixels("--time 2 --animation 1").0));
    // Both: it is there, and to the right.
    let (both, _) = pixels("--time 2 --animation all");
    assert!(both != grown && both.get_pixel(44, 18) != blank);
    // Without a time it is at its start.
    assert_eq!(pixels("--animation grow").0, pixels("--animation grow --time 0").0);
    for (scene, asked, said) in [
        ("two.gltf", "shrink", r#"there is no animation "shrink"; the scene has 2 animations: 0, 1 "grow""#),
        ("two.gltf", "2", r#"there is no animation "2"; the scene has 2 animations: 0, 1 "grow""#),
        ("scene.obj", "all", r#"there is no animation "all"; the scene has no animations"#),
    ] {
        for command in ["render -o out.png", "verify", "bench"] {
            let output = folder.run(&format!("{command} {scene} --size 8x8 --animation {asked}"));
            assert_eq!(code(&output), 2, "{}", stderr(&output));
            assert!(stderr(&output).contains(said), "{}", stderr(&output));
        }
    }
}
