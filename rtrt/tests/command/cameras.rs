//! Cameras of files, and many views in one run.

use crate::folder::{Folder, code, stderr, stdout};
use serde_json::{Value, json};
use std::fs;

const LINE: &str = "--size 16x8 --backend cpu --samples 1";

/// A folder with a square in the plane z = 0, seen by two cameras from +z: `Main` from 2, `Side view` from 4.
fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    let gltf = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1,2]}],
        "nodes":[{"mesh":0,"name":"square"},{"camera":0,"translation":[0,0,2],"name":"Main"},
            {"camera":1,"translation":[0,0,4]}],
        "cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1}},
            {"type":"perspective","name":"Side view","perspective":{"yfov":1,"znear":0.1}}],
        "meshes":[{"name":"quad","primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
        "materials":[{"name":"paint","doubleSided":true}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
            {"bufferView":1,"componentType":5121,"count":6,"type":"SCALAR"}],
        "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":6}],
        "buffers":[{"byteLength":56,"uri":"square.bin"}]}"#;
    let corners: [[f32; 3]; 4] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 0, 2, 3, 0, 0]);
    fs::write(folder.0.join("square.gltf"), gltf).unwrap();
    fs::write(folder.0.join("square.bin"), bytes).unwrap();
    folder
}

#[test]
fn a_camera_is_chosen_by_its_name_or_number() {
    let folder = folder("camera_names");
    let hash = |options: &str| stdout(&folder.run(&format!("render square.gltf {LINE} --hash {options}")));
    let [near, far] = ["--camera 0", "--camera 1"].map(hash);
    assert_ne!(near, far);
    assert_eq!([hash(""), hash("--camera Main")], [near.clone(), near]);
    let mut command = folder.command(&format!("render square.gltf {LINE} --hash --camera"));
    assert_eq!(stdout(&command.arg("Side view").output().unwrap()), far);
    let output = folder.run(&format!("render square.gltf {LINE} --hash --camera Mian"));
    let said = stderr(&output);
    assert_eq!(code(&output), 2);
    assert!(said.contains(r#"no camera "Mian"; the scene has 2 cameras: 0 "Main", 1 "Side view""#), "{said}");
}

#[test]
fn what_is_outside_of_clip_planes_is_not_drawn() {
    let folder = folder("clip_planes");
    // The square is at depth 2 of the first camera, and at 4 of the second one.
    let text = fs::read_to_string(folder.0.join("square.gltf")).unwrap();
    let [near, far] = [r#""znear":3"#, r#""znear":0.1,"zfar":1.5"#].map(|planes| {
        let planes = text.replacen(r#""znear":0.1"#, planes, 1);
        fs::write(folder.0.join("planes.gltf"), &planes).unwrap();
        let line = format!("render planes.gltf {LINE} --background 0,0,0 --hash");
        let hash = |options: &str| pixels(&stdout(&folder.run(&format!("{line} {options}"))));
        let [clipped, moved, other] = ["", "--eye 0,0,2 --look-at 0,0,0", "--camera 1"].map(hash);
        assert!(clipped != moved && clipped != other, "{planes}");
        assert_eq!(hash("--near 0 --far inf"), moved, "the options come first");
        assert_eq!(hash("--camera 1 --near 4.5"), clipped, "an empty picture");
        clipped
    });
    assert_eq!(near, far);
}

/// The hash of each picture's pixels.
fn pixels(hashes: &str) -> Vec<String> {
    let columns = hashes.lines().map(|line| line.split("  ").collect::<Vec<_>>());
    columns.filter(|columns| columns[1] == "pixels").map(|columns| columns[0].to_owned()).collect()
}

fn report(folder: &Folder, name: &str) -> Value {
    serde_json::from_slice(&fs::read(folder.0.join(name)).unwrap()).unwrap()
}

#[test]
fn many_views_are_what_each_is_alone() {
    let folder = folder("many_views");
    let poses = json!({"fov_y": 50, "cameras": [
        {"name": "near", "eye": [0, 0, 2], "look_at": [0, 0, 0]},
        {"name": "aside", "eye": [1.5, 0.5, 2], "look_at": [0.1, 0, 0], "up": [0.2, 1, 0], "size": [12, 20]},
        {"eye": [0, 0, 9], "look_at": [0, 0, 0], "parallel": 3}]});
    fs::write(folder.0.join("poses.json"), poses.to_string()).unwrap();
    let run =
        |options: &str| pixels(&stdout(&folder.run(&format!("render square.gltf {LINE} --hash {options}"))));
    let together = run("--cameras poses.json -o {camera}-{n}.png --report run.json");
    let alone = [
        "--size 16x8 --eye 0,0,2 --look-at 0,0,0 --up 0,1,0 --fov-y 50",
        "--size 12x20 --eye 1.5,0.5,2 --look-at 0.1,0,0 --up 0.2,1,0 --fov-y 50",
        "--size 16x8 --eye 0,0,9 --look-at 0,0,0 --up 0,1,0 --parallel 3",
    ];
    let alone = alone.map(|camera| {
        let line = format!("render square.gltf --backend cpu --samples 1 --hash {camera}");
        pixels(&stdout(&folder.run(&line)))[0].clone()
    });
    assert_eq!(together, alone);
    for name in ["near-0.png", "aside-1.png", "2-2.png"] {
        assert!(folder.0.join(name).is_file(), "{name}");
    }
    // The report names what there is, and is a file of cameras itself.
    let report = report(&folder, "run.json");
    let frames = report["frames"].as_array().unwrap();
    let hashes: Vec<_> = frames.iter().map(|frame| frame["hash"].as_str().unwrap()).collect();
    assert_eq!(hashes, together);
    assert_eq!(frames[0]["file_path"], "near-0.png");
    assert_eq!(frames[0]["transform_matrix"][2], json!([0.0, 0.0, 1.0, 2.0]));
    assert_eq!([&frames[1]["w"], &frames[1]["h"]], [12, 20]);
    assert_eq!(report["scenes"][0]["files"], json!(["square.bin", "square.gltf"]));
    let object = json!({"id": 0, "node": "square", "mesh": "quad", "material": "paint", "material_id": 0});
    assert_eq!(report["scenes"][0]["objects"], json!([object]));
    assert_eq!(run("--cameras run.json"), together);
}

/// A report of a film has the same name of a file for each view, and names that differ.
#[test]
fn a_report_gives_the_same_pictures_again() {
    let folder = folder("again");
    let text = fs::read_to_string(folder.0.join("square.gltf")).unwrap();
    let near = text.replacen(r#""znear":0.1"#, r#""znear":1.9,"zfar":2.3"#, 1);
    fs::write(folder.0.join("near.gltf"), near).unwrap();
    let poses = json!({"near": 1.5, "far": 2.25, "cameras": [
        {"name": "a", "eye": [1, 0.5, 2], "look_at": [0.1, 0, 0]},
        {"name": "b", "eye": [1, 0.5, 2], "look_at": [0.1, 0, 0], "near": 0, "far": 2.125},
        {"name": "c", "eye": [1, 0.5, 2], "look_at": [0.1, 0, 0], "far": 1e60}]});
    fs::write(folder.0.join("poses.json"), poses.to_string()).unwrap();
    let run = |options: &str| {
        pixels(&stdout(&folder.run(&format!("render {options} {LINE} --background 0,0,0 --hash"))))
    };
    let mut different = Vec::new();
    for (options, planes) in [
        ("near.gltf --eye 1,0.5,2 --look-at 0,0,0 --near 2 --far 2.4", json!([2.0, 2.4])),
        ("near.gltf", json!([1.9, 2.3])),
        ("near.gltf --camera all", json!([0.1, null])),
        ("near.gltf --orbit 3", json!([1.9, 2.3])),
        ("near.gltf --cameras poses.json", json!([1.5, null])),
        ("near.gltf --cameras poses.json --near 1.625", json!([1.625, null])),
        ("demo:moving demo:glass --time 0.7 --frames 3 --fps 7 -o {scene}{n}.png", json!([0.0, null])),
    ] {
        let first = run(&format!("{options} --report run.json"));
        let frames = report(&folder, "run.json")["frames"].as_array().unwrap().clone();
        let last = frames.last().unwrap();
        assert_eq!(json!([last["near"], last["far"]]), planes, "{options}");
        let scenes = options.split_whitespace().take_while(|word| !word.starts_with('-'));
        for (number, scene) in scenes.enumerate() {
            // The frames of this scene, as the file of cameras of a run of it.
            let own: Vec<_> = frames.iter().filter(|frame| frame["scene"] == number).cloned().collect();
            let of_scene = |(frame, _): &(&Value, &String)| frame["scene"] == number;
            let expected = frames.iter().zip(&first).filter(of_scene).map(|(_, hash)| hash.clone());
            let expected: Vec<String> = expected.collect();
            fs::write(folder.0.join("own.json"), json!({"frames": own}).to_string()).unwrap();
            assert_eq!(run(&format!("{scene} --cameras own.json")), expected, "{options}");
        }
        different.push(first);
    }
    // The planes count.
    assert!(different[0] != run("near.gltf --eye 1,0.5,2 --look-at 0,0,0"));
    assert!(different[4][0] != different[4][1] && different[4][1] != different[4][2]);
    assert_eq!(different[3][0], different[1][0], "an orbit begins with its camera");
    let output =
        folder.run(&format!("render near.gltf {LINE} --orbit 3 -o - --stream rgba --report run.json"));
    assert_eq!(code(&output), 0);
    let names = report(&folder, "run.json")["frames"].as_array().unwrap().clone();
    let names: Vec<_> = names.iter().map(|frame| frame["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["orbit-0000", "orbit-0001", "orbit-0002"]);
    assert_eq!(run("near.gltf --cameras run.json"), different[3]);
    let wrong = json!({"cameras": [{"eye": [0, 0, 2], "look_at": [0, 0, 0], "near": 3, "far": 2}]});
    fs::write(folder.0.join("wrong.json"), wrong.to_string()).unwrap();
    let output = folder.run(&format!("render near.gltf {LINE} --hash --cameras wrong.json"));
    assert!(code(&output) == 3 && stderr(&output).contains("camera 0 (0): its near and far are 3 and 2"));
    let output = folder.run(&format!("render near.gltf {LINE} --hash --near 3 --far 2"));
    assert!(code(&output) == 2 && stderr(&output).contains("hint: see --near and --far"));
}

/// Each line of hashes says of which picture it is, where there are several.
#[test]
fn hashes_name_their_pictures() {
    let folder = folder("hash_names");
    let named = |options: &str| {
        let lines = stdout(&folder.run(&format!("render {options} {LINE} --hash")));
        let lines: Vec<_> =
            lines.lines().map(|line| line.splitn(3, "  ").map(str::to_owned).collect()).collect();
        let names = lines.iter().map(|line: &Vec<String>| line.get(2).cloned().unwrap_or_default());
        let mut names: Vec<String> = names.collect();
        assert_eq!(lines.iter().filter(|line| line[1] == "pixels").count() * 11, lines.len());
        names.dedup();
        names
    };
    assert_eq!(named("square.gltf"), [""]);
    assert_eq!(named("square.gltf --camera all"), ["Main", "Side view"]);
    assert_eq!(named("square.gltf scene.obj"), ["square.gltf", "scene.obj"]);
    assert_eq!(named("square.gltf --frames 2"), ["frame 0", "frame 1"]);
    let all = ["square.gltf, orbit-0000, frame 0", "square.gltf, orbit-0000, frame 1"];
    assert_eq!(named("square.gltf scene.obj --orbit 2 --frames 2")[..2], all);
}

/// Objects of files without names, and those that options add, are called what they are.
#[test]
fn every_object_has_a_label() {
    let folder = folder("labels");
    let line = "render scene.obj demo:glass --ground --light point:0,3,0:0.2 --show-lights --report run.json";
    stdout(&folder.run(&format!("{line} {LINE}")));
    let report = report(&folder, "run.json");
    let label = |scene: usize, object: usize| {
        let object = &report["scenes"][scene]["objects"][object];
        ["node", "mesh", "material"].map(|key| object[key].as_str().unwrap())
    };
    assert_eq!(label(0, 0), ["scene", "faces", "default"]);
    assert_eq!(label(0, 1), ["ground"; 3]);
    assert_eq!(label(0, 2), ["light 0"; 3]);
    assert_eq!(label(1, 0), ["floor"; 3]);
    assert_eq!(label(1, 2), ["red panes", "red panes", "red glass"]);
}

/// A lens whose principal point is in a corner of the picture: a square of ±1 at a distance of 4 is from
/// cx − fx / 4 to cx + fx / 4, and likewise from above.
#[test]
fn a_point_is_at_its_pixel() {
    let folder = folder("lens");
    let matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]];
    let lens = json!({"fl_x": 40, "fl_y": 24, "cx": 12, "cy": 8, "w": 64, "h": 48});
    let mut file = lens.clone();
    file["frames"] = json!([{"file_path": "./images/0001.png", "transform_matrix": matrix}]);
    fs::write(folder.0.join("transforms.json"), file.to_string()).unwrap();
    let line = "render square.gltf --backend cpu --samples 1 --cameras transforms.json --report run.json";
    stdout(&folder.run(line));
    let frame = &report(&folder, "run.json")["frames"][0];
    let seen = json!([{"id": 0, "pixels": 20 * 12, "box_2d": [2, 2, 22, 14], "box_3d": [[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]}]);
    assert_eq!(frame["seen"], seen);
    assert_eq!(frame["camera"], "images_0001");
    for (key, value) in lens.as_object().unwrap() {
        assert!((frame[key].as_f64().unwrap() - value.as_f64().unwrap()).abs() < 1e-5, "{key}: {frame}");
    }
}

#[test]
fn all_cameras_an_orbit_and_several_scenes() {
    let folder = folder("sets");
    let run = |line: &str| pixels(&stdout(&folder.run(&format!("render {line} {LINE} --hash"))));
    let each = ["--camera 0", "--camera 1"].map(|camera| run(&format!("square.gltf {camera}"))[0].clone());
    assert_eq!(run("square.gltf --camera all -o {camera}.png"), each);
    assert!(folder.0.join("Main.png").is_file() && folder.0.join("Side view.png").is_file());
    let around = run("square.gltf --eye 0,0,3 --look-at 0,0,0 --orbit 4");
    assert_eq!(around[0], run("square.gltf --eye 0,0,3 --look-at 0,0,0")[0]);
    assert!(around.len() == 4 && (1..4).all(|view| !around[..view].contains(&around[view])));
    let scenes = run("square.gltf scene.obj -o {scene}.png");
    assert_eq!(scenes, [each[0].clone(), run("scene.obj")[0].clone()]);
    assert!(folder.0.join("square.png").is_file() && folder.0.join("scene.png").is_file());
    for (line, why) in [
        ("square.gltf scene.obj -o out.png", "two pictures have one name: out.png"),
        ("square.gltf --orbit 2 -o out.png", "every view needs a file of its own"),
        ("square.gltf --camera all --orbit 2", "--orbit goes around one camera"),
        (
            "square.gltf --orbit 2 --frames 2 -o {n}.png",
            "every view needs a file of its own for each frame: add {camera} to the names",
        ),
        ("square.gltf --orbit 0", "invalid value '0' for '--orbit <N>'"),
    ] {
        let output = folder.run(&format!("render {line} {LINE} --hash"));
        assert!(code(&output) == 2 && stderr(&output).contains(why), "{line}: {}", stderr(&output));
    }
    let output = folder.run(&format!("render square.gltf {LINE} --hash --cameras missing.json"));
    assert!(code(&output) == 3 && stderr(&output).contains("cameras refused: missing.json"));
    assert_eq!(code(&folder.run(&format!("verify square.gltf {LINE} --camera all"))), 2);
}

/// All of a scene that is framed is in each view of an orbit.
#[test]
fn an_orbit_around_a_framed_scene_crops_nothing() {
    let folder = Folder::new("orbit");
    stdout(
        &folder.run("render scene.obj --size 60x40 --backend cpu --samples 1 --orbit 8 --report run.json"),
    );
    for frame in report(&folder, "run.json")["frames"].as_array().unwrap() {
        let sides = frame["seen"][0]["box_2d"].as_array().unwrap();
        let [left, top, right, bottom] = [0, 1, 2, 3].map(|i| sides[i].as_u64().unwrap());
        assert!(left > 0 && top > 0 && right < 60 && bottom < 40, "{sides:?}");
    }
}
