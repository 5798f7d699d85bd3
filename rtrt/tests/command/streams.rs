//! Pictures that go to other programs: streams, films, arrays.

use crate::folder::{Folder, code, stderr, stdout};
use std::fs;

const LINE: &str = "render scene.obj --size 8x6 --backend cpu --samples 1";

#[test]
fn frames_follow_one_another_on_standard_output() {
    let folder = Folder::new("streams");
    stdout(&folder.run(&format!("{LINE} --orbit 3 -o {{n}}.png")));
    let files: Vec<Vec<u8>> = (0..3).map(|n| fs::read(folder.0.join(format!("{n}.png"))).unwrap()).collect();
    let stream = |options: &str| {
        let output = folder.run(&format!("{LINE} --orbit 3 -o - {options}"));
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        output.stdout
    };
    assert_eq!(stream(""), files.concat());
    let pixels = |file: &Vec<u8>| image::load_from_memory(file).unwrap().into_rgba8().into_raw();
    assert_eq!(stream("--stream rgba"), files.iter().flat_map(pixels).collect::<Vec<u8>>());
    assert_eq!(code(&folder.run(&format!("{LINE} -o out.png --stream rgba"))), 2);
    assert_eq!(code(&folder.run(&format!("{LINE} -o - --stream rgba --bits 16"))), 2);
}

/// A stand-in for ffmpeg writes its arguments, and then what it is given.
#[test]
#[cfg(unix)]
fn a_film_is_made_by_ffmpeg() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new("film");
    let tools = folder.0.join("tools");
    fs::create_dir(&tools).unwrap();
    let run = |options: &str| {
        let mut command = folder.command(&format!("{LINE} --orbit 2 -o out.mp4 {options}"));
        command.env("PATH", &tools).output().unwrap()
    };
    let output = run("");
    assert_eq!(code(&output), 1);
    assert!(
        stderr(&output).contains("cannot make the film: out.mp4: ffmpeg does not start"),
        "{}",
        stderr(&output)
    );
    let ffmpeg = |script: &str| {
        fs::write(tools.join("ffmpeg"), script).unwrap();
        fs::set_permissions(tools.join("ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
    };
    ffmpeg("#!/bin/sh\nfor last; do :; done\necho \"$@\" > args\n/bin/cat > \"$last\"\n");
    stdout(&run("--fps 12"));
    assert_eq!(fs::read(folder.0.join("out.mp4")).unwrap().len(), 2 * 8 * 6 * 4);
    let args = fs::read_to_string(folder.0.join("args")).unwrap();
    assert!(
        args.contains("-video_size 8x6 -framerate 12 -i -") && args.contains("-colorspace bt709"),
        "{args}"
    );
    ffmpeg("#!/bin/sh\necho no such codec >&2\nexit 3\n");
    let output = run("");
    assert!(code(&output) == 1 && stderr(&output).contains("no such codec"), "{}", stderr(&output));
    let left = folder.files().into_iter().filter(|name| name.contains("part")).count();
    assert_eq!(left, 0);
}

/// The members of an archive whose members are stored as they are.
fn members(bytes: &[u8]) -> Vec<(String, &[u8])> {
    let mut all = Vec::new();
    let mut at = 0;
    while bytes[at..].starts_with(b"PK\x03\x04") {
        let word = |place: usize| u32::from_le_bytes(bytes[at + place..][..4].try_into().unwrap()) as usize;
        let (size, name) = (word(22), word(26) & 0xffff);
        let start = at + 30 + name;
        all.push((String::from_utf8(bytes[at + 30..start].to_vec()).unwrap(), &bytes[start..][..size]));
        at = start + size;
    }
    all
}

#[test]
fn arrays_hold_what_layers_do() {
    let folder = Folder::new("arrays");
    stdout(&folder.run(&format!("{LINE} --aov all.npz -o color.npy")));
    stdout(&folder.run(&format!("{LINE} --aov all.exr")));
    let bytes = fs::read(folder.0.join("all.npz")).unwrap();
    let members = members(&bytes);
    let names: Vec<_> = members.iter().map(|(name, _)| name.trim_end_matches(".npy")).collect();
    let expected = [
        "color",
        "depth",
        "normal",
        "albedo",
        "object",
        "material",
        "triangle",
        "source",
        "barycentrics",
        "uv",
        "position",
        "shadow",
    ];
    assert_eq!(names, expected);
    assert_eq!(members[0].1, fs::read(folder.0.join("color.npy")).unwrap());
    let image = exr::prelude::read_all_flat_layers_from_file(folder.0.join("all.exr")).unwrap();
    let depth =
        image.layer_data.iter().find(|l| l.attributes.layer_name.as_ref().unwrap().eq("depth")).unwrap();
    let exr::prelude::FlatSamples::F32(depth) = &depth.channel_data.list[0].sample_data else { panic!() };
    let numbers: Vec<u8> = depth.iter().flat_map(|number| number.to_le_bytes()).collect();
    assert!(members[1].1.ends_with(&numbers));
    assert!(String::from_utf8_lossy(members[1].1).contains("'shape': (6, 8), }"));
    // The same arrays are the same file.
    stdout(&folder.run(&format!("{LINE} --aov again.npz")));
    assert_eq!(fs::read(folder.0.join("again.npz")).unwrap(), bytes);
}

#[test]
fn motion_is_a_layer_of_several_frames() {
    let folder = Folder::new("motion");
    stdout(&folder.run("render demo:moving --size 24x16 --samples 1 --backend cpu --frames 2 --aov {n}.exr"));
    let most = [0, 1].map(|n| {
        let path = folder.0.join(format!("{n}.exr"));
        let image = exr::prelude::read_all_flat_layers_from_file(path).unwrap();
        let named = |l: &&exr::image::Layer<_>| l.attributes.layer_name.as_ref().unwrap().eq("motion");
        let layer = image.layer_data.iter().find(named).unwrap();
        let most = |channel: &exr::image::AnyChannel<exr::prelude::FlatSamples>| {
            channel.sample_data.values_as_f32().map(f32::abs).fold(0.0, f32::max)
        };
        layer.channel_data.list.iter().map(most).fold(0.0, f32::max)
    });
    assert!(most[0] == 0.0 && most[1] > 0.01, "{most:?}");
}
