//! Cameras of files, and many views in one run.

use crate::folder::{Folder, code, stderr, stdout};
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
    assert!(said.contains(r#"there is no camera Mian, the scene has 0 ("Main"), 1 ("Side view")"#), "{said}");
}
