//! Files that ask for more than there may be: an error or a warning, before memory or the stack is used up.

use rtrt::import::{ImportError, Loaded, load};
use rtrt_core::scene::{Image, Sequential};
use std::path::Path;
use std::time::{Duration, Instant};

/// A file written for one test.
fn written(name: &str, text: &[u8]) -> Result<Loaded, ImportError> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("limits");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    let start = Instant::now();
    let loaded = load(&path, &Sequential);
    assert!(start.elapsed() < Duration::from_secs(20), "{name} took {:?}", start.elapsed());
    loaded
}

/// A glTF file with one triangle, and `nodes` for nodes.
fn gltf(nodes: &str) -> Vec<u8> {
    let bytes = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{nodes}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],
        "buffers":[{{"byteLength":36,"uri":"data:application/octet-stream;base64,{bytes}"}}]}}"#
    )
    .into_bytes()
}

#[test]
fn a_long_chain_of_nodes_takes_no_stack() {
    let last = 100_000;
    let chain: String = (1..=last).map(|child| format!(r#"{{"children":[{child}]}},"#)).collect();
    let loaded = written("chain.gltf", &gltf(&format!(r#"{chain}{{"mesh":0}}"#))).unwrap();
    assert_eq!(loaded.scene.drawn_triangles(), 1);
}

#[test]
fn json_within_json_takes_no_stack() {
    for (open, close) in [("[", "]"), (r#"{"a":"#, "}")] {
        let deep = format!("{}0{}", open.repeat(1_000_000), close.repeat(1_000_000));
        let extras = format!(r#"{{"mesh":0,"extras":{deep}}}"#);
        for nodes in [&extras, &deep] {
            // What is not read is either passed over or refused.
            if let Err(error) = written("deep.gltf", &gltf(nodes)) {
                assert!(matches!(error, ImportError::Invalid { .. }), "{error}");
            }
        }
    }
}

#[test]
fn a_picture_that_claims_too_much_is_a_placeholder_with_a_reason() {
    // The header of a PNG file of that size, and nothing behind it.
    let side = Image::MAX_SIDE + 1;
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    png.extend([side, side].map(u32::to_be_bytes).as_flattened());
    png.extend([8, 6, 0, 0, 0]);
    let sum = crc(&png[12..]);
    png.extend(sum.to_be_bytes());
    let obj = b"mtllib vast.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
    for (name, bytes) in [("vast.png", &png[..]), ("vast.mtl", b"newmtl a\nmap_Kd vast.png\n")] {
        written(name, bytes).unwrap_err();
    }
    let loaded = written("vast.obj", obj).unwrap();
    assert!(
        loaded.warnings[0].contains("\"vast.png\" is drawn as a magenta checker"),
        "{:?}",
        loaded.warnings
    );
    assert!(loaded.scene.texels().len() < 10_000);
}

/// The sum at the end of a part of a PNG file.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| sum >> 1 ^ if sum & 1 == 1 { 0xedb8_8320 } else { 0 })
    })
}

#[test]
fn more_objects_than_may_be_are_refused_with_the_number() {
    // Instances whose matrices are all the same: an accessor without a buffer is of zeros, so they are given
    // by a sparse one of few bytes. What would be millions of objects is refused before they are placed.
    let nodes = r#"{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":1}}}}"#;
    let text = String::from_utf8(gltf(nodes)).unwrap();
    let many = r#"{"componentType":5126,"type":"VEC3","count":900000000}]"#;
    let text = text.replacen("\"count\":3}]", &format!("\"count\":3}},{many}"), 1);
    let error = written("many.gltf", text.as_bytes()).unwrap_err();
    assert!(matches!(error, ImportError::Invalid { .. } | ImportError::Limit { .. }), "{error}");
}
