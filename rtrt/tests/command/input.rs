//! Scenes from standard input and pipes, and words for input that is none.

use crate::folder::{Folder, code, stderr, stdout};
use std::fs;
use std::io::Write;
use std::process::{Output, Stdio};

const LINE: &str = "--size 8x8 --backend cpu --hash";

fn piped(folder: &Folder, line: &str, bytes: &[u8]) -> Output {
    let mut command = folder.command(line);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut running = command.spawn().unwrap();
    running.stdin.take().unwrap().write_all(bytes).unwrap();
    running.wait_with_output().unwrap()
}

#[test]
fn a_scene_may_come_from_standard_input() {
    let folder = Folder::new("stdin");
    let hashes = stdout(&folder.run(&format!("render scene.obj {LINE}")));
    let obj = fs::read(folder.0.join("scene.obj")).unwrap();
    assert_eq!(stdout(&piped(&folder, &format!("render - {LINE}"), &obj)), hashes);
    let commented = [b"# made by a program\n\n", &obj[..]].concat();
    assert_eq!(stdout(&piped(&folder, &format!("render - {LINE} -o {{scene}}.png"), &commented)), hashes);
    assert!(folder.0.join("stdin.png").is_file());
    let gltf = br#"{"asset":{"version":"2.0"}}"#;
    let said = stderr(&piped(&folder, &format!("render - {LINE}"), gltf));
    assert!(said.contains("nothing to draw: -: it has no surfaces"), "{said}");
    for (bytes, why) in [(&b""[..], "invalid scene: -: it is empty"), (b"hello", "not a scene: -")] {
        let output = piped(&folder, &format!("render - {LINE}"), bytes);
        assert!(code(&output) == 3 && stderr(&output).contains(why), "{}", stderr(&output));
    }
}

#[test]
#[cfg(unix)]
fn a_scene_may_come_from_a_pipe() {
    let folder = Folder::new("pipe");
    let hashes = stdout(&folder.run(&format!("render scene.obj {LINE}")));
    let line = format!("\"$0\" render <(cat scene.obj) {LINE}");
    let mut bash = std::process::Command::new("bash");
    let output = bash.current_dir(&folder.0).args(["-c", &line, env!("CARGO_BIN_EXE_rtrt")]).output();
    match output {
        Ok(output) => assert_eq!(stdout(&output), hashes),
        Err(error) => println!("skipped: there is no bash: {error}"),
    }
}

#[test]
fn input_that_is_none_is_named_in_our_words() {
    let folder = Folder::new("words");
    for name in ["empty.glb", "empty.gltf", "empty.obj", "empty"] {
        fs::write(folder.0.join(name), "").unwrap();
        let output = folder.run(&format!("render {name} {LINE}"));
        let said = stderr(&output);
        assert!(code(&output) == 3 && said.contains(&format!("{name}: it is empty")), "{said}");
    }
    let said = stderr(&folder.run(&format!("render https://example.org/a.glb {LINE}")));
    assert!(said.contains("hint: fetch it first"), "{said}");
    let png = b"\x89PNG\r\n\x1a\nbut not really";
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 10 +X 20\ncut off";
    for (name, bytes, why) in [
        ("damaged.png", &png[..], "damaged.png: it is damaged ("),
        ("cut.hdr", hdr, "cut.hdr: it ends too early, or is damaged ("),
        ("empty.hdr", b"", "empty.hdr: it is empty"),
    ] {
        fs::write(folder.0.join(name), bytes).unwrap();
        let said = stderr(&folder.run(&format!("render scene.obj {LINE} --environment {name}")));
        assert!(said.contains(why), "{said}");
    }
}

/// Two triangles whose buffer is named by a scheme in capitals.
#[test]
fn data_uris_have_no_case() {
    let folder = Folder::new("capitals");
    let gltf = |scheme: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}],
            "buffers":[{{"byteLength":36,"uri":"{scheme}:application/octet-stream;base64,{}"}}]}}"#,
            // (0, 0, 0), (1, 0, 0), (0, 1, 0)
            "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"
        )
    };
    let hashes = ["data", "DATA"].map(|scheme| {
        let name = format!("{scheme}.gltf");
        fs::write(folder.0.join(&name), gltf(scheme)).unwrap();
        stdout(&folder.run(&format!("render {name} {LINE} --strict")))
    });
    assert_eq!(hashes[0], hashes[1]);
    let url = gltf("https://example.org/");
    fs::write(folder.0.join("url.gltf"), url).unwrap();
    let said = stderr(&folder.run(&format!("render url.gltf {LINE}")));
    assert!(said.contains("is not beside the scene"), "{said}");
}
