//! Formats other than plain glTF and OBJ: the same shapes and colors come out of each.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;
use image::codecs::{png::PngEncoder, webp::WebPEncoder};
use image::{ExtendedColorType, ImageEncoder};
use rtrt::debug::{DebugView, show};
use rtrt::import::{self, ImportError, Loaded, load, load_with};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::scene::{Camera, Projection, Sequential};
use rtrt_cpu::{Cpu, Options};
use std::path::{Path, PathBuf};

/// A folder with these files, of one test.
fn folder(test: &str, files: &[(&str, &[u8])]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("formats").join(test);
    std::fs::remove_dir_all(&folder).ok();
    std::fs::create_dir_all(&folder).unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.join(name), bytes).unwrap();
    }
    folder
}

/// The scene in the first of these files.
fn opened(test: &str, files: &[(&str, &[u8])]) -> Result<Loaded, ImportError> {
    load(&folder(test, files).join(files[0].0), &Sequential)
}

/// The scene in the first of these files, without a warning.
fn loaded(test: &str, files: &[(&str, &[u8])]) -> Loaded {
    let loaded = opened(test, files).unwrap_or_else(|error| panic!("{error}"));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded
}

/// A PNG file of these texels.
fn png(width: u32, texels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let height = texels.len() as u32 / width;
    PngEncoder::new(&mut bytes)
        .write_image(texels.as_flattened(), width, height, ExtendedColorType::Rgba8)
        .unwrap();
    bytes
}

/// A WebP file of these texels, without losses.
fn webp(width: u32, texels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let height = texels.len() as u32 / width;
    WebPEncoder::new_lossless(&mut bytes)
        .write_image(texels.as_flattened(), width, height, ExtendedColorType::Rgba8)
        .unwrap();
    bytes
}

/// What the objects of a scene are called.
fn labels(loaded: &Loaded) -> Vec<[&str; 3]> {
    loaded.labels.iter().map(|label| [&*label.node, &*label.mesh, &*label.material]).collect()
}

#[test]
fn files_without_names_have_labels() {
    for (name, mesh) in [("part.stl", "facets"), ("scan.dat", "faces")] {
        let bytes = if mesh == "facets" { stl(true) } else { ply("ascii", true, [255; 3]) };
        let material = if mesh == "facets" { "default" } else { "faces" };
        let loaded = loaded("labels", &[(name, &bytes)]);
        assert_eq!(labels(&loaded), [[&name[..4], mesh, material]]);
    }
    let cloud =
        b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
                  end_header\n0 0 0\n1 1 1\n";
    assert_eq!(labels(&loaded("labels", &[("cloud.ply", cloud)])), [["cloud", "points", "points"]]);
    let lines = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nl 1 2\nf 1 2 3\n";
    let found = opened("labels", &[("both.obj", lines)]).unwrap();
    assert_eq!(labels(&found), [["both", "lines", "red"], ["both", "faces", "red"]]);
    for demo in [
        rtrt::demo::matchbox(&Sequential),
        rtrt::demo::glass(&Sequential),
        rtrt::demo::spheres(&Sequential),
        rtrt::demo::levels(&Sequential),
        rtrt::demo::moving(&Sequential),
    ] {
        let demo = demo.unwrap();
        let names = labels(&demo);
        assert_eq!(names.len(), demo.scene.instances().len());
        assert!(names.iter().flatten().all(|name| !name.is_empty()), "{names:?}");
    }
}

/// A view of x and y within ±1, from +z, 32 pixels wide and high; RGB by row from the top.
fn seen(loaded: &Loaded, view: DebugView) -> Vec<[u8; 3]> {
    let projection = Projection::Orthographic { height: 2.0 };
    let camera = Camera { eye: Vec3::Z * 5.0, look_at: Vec3::ZERO, up: Vec3::Y, projection };
    let request = Request::new(&camera, [32, 32]).samples(1).shadows(Shadows::Off).deferred(true);
    let mut picture = Picture::default();
    let mut cpu = Cpu::new(Options { lanes: Some(1), threads: Some(1) }).unwrap();
    cpu.render(&loaded.scene, &request, &mut picture).unwrap();
    let pixels = show(view, &loaded.scene, &request, &picture).unwrap().unwrap().pixels;
    pixels.iter().map(|pixel| pixel.to_le_bytes()).map(|[r, g, b, _]| [r, g, b]).collect()
}

/// The base color in the middle of each quarter: upper left, upper right, lower left, lower right.
fn quarters(loaded: &Loaded) -> [[u8; 3]; 4] {
    let pixels = seen(loaded, DebugView::Albedo);
    [8, 24].map(|y| [8, 24].map(|x| pixels[32 * y + x])).as_flattened().try_into().unwrap()
}

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];
const BLUE: [u8; 4] = [0, 0, 255, 255];
const WHITE: [u8; 4] = [255; 4];
/// Red and green above blue and white.
const FOUR: [[u8; 3]; 4] = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255; 3]];

/// [`FOUR`] as a picture, with so many texels a side in each quarter.
fn four(side: usize) -> Vec<[u8; 4]> {
    let row = |a, b| [[a].repeat(side), [b].repeat(side)].concat();
    [row(RED, GREEN).repeat(side), row(BLUE, WHITE).repeat(side)].concat()
}

/// The corners of a square over all of the picture.
const SQUARE: [[f32; 3]; 4] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];

/// The square as STL, binary or as text.
fn stl(binary: bool) -> Vec<u8> {
    let facets = [[0, 1, 2], [0, 2, 3]].map(|facet: [usize; 3]| facet.map(|corner| SQUARE[corner]));
    if binary {
        let number = |c: &f32| c.to_le_bytes();
        let facet = |f: &[[f32; 3]; 3]| {
            [&[0; 12], &*f.as_flattened().iter().flat_map(number).collect::<Vec<_>>(), &[0; 2]].concat()
        };
        return [&[b' '; 80], &2_u32.to_le_bytes()[..], &facets.iter().flat_map(facet).collect::<Vec<_>>()]
            .concat();
    }
    let corner = |[x, y, z]: [f32; 3]| format!("vertex {x} {y} {z}\n");
    let facet = |f: [[f32; 3]; 3]| {
        format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", f.map(corner).concat())
    };
    format!("solid square\n{}endsolid square\n", facets.map(facet).concat()).into_bytes()
}

#[test]
fn stl_as_text_and_binary_shows_a_square() {
    let gray = quarters(&loaded("stl-text", &[("a.stl", &stl(false))]));
    assert!(gray[0] == gray[3] && gray[0][0] > 150, "{gray:?}");
    assert_eq!(quarters(&loaded("stl-binary", &[("a.STL", &stl(true))])), gray);
    // Without an ending the first bytes say what it is.
    assert_eq!(quarters(&loaded("stl-nameless", &[("a", &stl(false))])), gray);
    assert_eq!(quarters(&loaded("stl-binary-nameless", &[("a.scan", &stl(true))])), gray);
    // The first 80 bytes are free.
    let mut converted = stl(true);
    converted[..11].copy_from_slice(b"glTF to STL");
    assert_eq!(quarters(&loaded("stl-converted", &[("a.stl", &converted)])), gray);
}

#[test]
fn stl_facets_with_words_are_drawn_with_a_warning() {
    let mut bytes = stl(true);
    bytes[84 + 48] = 1;
    assert_eq!(
        opened("stl-words", &[("a.stl", &bytes)]).unwrap().warnings,
        ["not drawn: colors of STL facets"]
    );
}

/// The square as PLY: two triangles or, with `polygon`, one face; with numbers of vertices in this encoding and of these
/// types, each corner in a color.
fn ply(format: &str, polygon: bool, color: [u8; 3]) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {format} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nelement face {}\n\
         property list uchar ushort vertex_indices\nend_header\n",
        if polygon { 1 } else { 2 }
    )
    .into_bytes();
    let is_big = format.contains("big");
    let faces: &[&[u16]] = if polygon { &[&[0, 1, 2, 3]] } else { &[&[0, 1, 2], &[0, 2, 3]] };
    if format == "ascii" {
        for [x, y, z] in SQUARE {
            let [r, g, b] = color;
            bytes.extend(format!("{x} {y} {z} {r} {g} {b}\n").bytes());
        }
        for face in faces {
            let corners: Vec<String> = face.iter().map(u16::to_string).collect();
            bytes.extend(format!("{} {}\n", face.len(), corners.join(" ")).bytes());
        }
        return bytes;
    }
    for [x, y, z] in SQUARE {
        for c in [x, y] {
            bytes.extend(if is_big { c.to_be_bytes() } else { c.to_le_bytes() });
        }
        let z = f64::from(z);
        bytes.extend(if is_big { z.to_be_bytes() } else { z.to_le_bytes() });
        bytes.extend(color);
    }
    for face in faces {
        bytes.push(face.len() as u8);
        bytes.extend(face.iter().flat_map(|c| if is_big { c.to_be_bytes() } else { c.to_le_bytes() }));
    }
    bytes
}

#[test]
fn ply_in_every_encoding_shows_its_vertex_colors_which_are_srgb() {
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for polygon in [false, true] {
            for color in [[255, 0, 0], [188, 128, 64], [1, 2, 3], [9, 10, 11]] {
                let bytes = ply(format, polygon, color);
                let shown = quarters(&loaded("ply", &[("a.ply", &bytes)]));
                assert!(shown.iter().all(|at| at[..3] == color), "{format} {shown:?}");
                let nameless = quarters(&loaded("ply-nameless", &[("scan.dat", &bytes)]));
                assert_eq!(nameless, shown);
            }
        }
    }
}

#[test]
fn a_texture_of_ply_stands_upright() {
    let header = |vertex: &str, face: &str| {
        format!(
            "ply\nformat ascii 1.0\ncomment TextureFile my four.png\nelement vertex 4\nproperty float x\n\
             property float y\nproperty float z\n{vertex}element face 1\nproperty list uchar int vertex_indices\n{face}\
             end_header\n"
        )
    };
    let of_vertices = header("property float s\nproperty float t\n", "")
        + "-1 -1 0 0 0\n1 -1 0 1 0\n1 1 0 1 1\n-1 1 0 0 1\n4 0 1 2 3\n";
    let of_corners = header("", "property list uchar float texcoord\n")
        + "-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n";
    for text in [of_vertices, of_corners] {
        let files: [(&str, &[u8]); 2] = [("a.ply", text.as_bytes()), ("my four.png", &png(16, &four(8)))];
        assert_eq!(quarters(&loaded("ply-texture", &files)), FOUR);
        let without = opened("ply-gone", &files[..1]).unwrap();
        assert!(
            without.warnings[0].contains("\"my four.png\" is drawn as a magenta checker"),
            "{:?}",
            without.warnings
        );
    }
}

#[test]
fn files_that_are_cut_are_refused_in_words() {
    let points = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n\
                  end_header\n";
    for (name, bytes, why) in [
        ("points.ply", points.as_bytes(), "it has no vertices"),
        ("cut.ply", &points.as_bytes()[..60], "the header has no end"),
        ("cut.stl", &stl(true)[..100], "2 facets need 184 bytes; the file has 100"),
        ("cut-text.stl", &stl(false)[..71], "the text ends within a facet"),
    ] {
        let error = opened("refused", &[(name, bytes)]).map(drop).expect_err(name);
        let line = error.to_string();
        assert!(line.contains(why) && line.contains(name) && !line.contains('\n'), "{line}");
    }
}

/// The square as OBJ, with the texture `map` of a material `t`.
fn textured_obj(map: &str) -> (Vec<u8>, Vec<u8>) {
    let obj = "mtllib m.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl t\n\
               f 1/1 2/2 3/3 4/4\n";
    (obj.into(), format!("newmtl t\nmap_Kd {map}\n").into_bytes())
}

/// Bytes as a URI.
fn data(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes))
}

/// The square as glTF, with `more` in the root.
fn textured_gltf(extension: &str, more: &str) -> String {
    let mut bytes: Vec<u8> = SQUARE.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    // `v` points down.
    bytes.extend([0.0_f32, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0].iter().flat_map(|c| c.to_le_bytes()));
    bytes.extend([0, 1, 2, 0, 2, 3]);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["{extension}"],"extensionsRequired":["{extension}"],
        "scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2,"material":0}}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"metallicFactor":0,"baseColorTexture":{{"index":0}}}}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
        {{"bufferView":0,"byteOffset":48,"componentType":5126,"count":4,"type":"VEC2"}},
        {{"bufferView":0,"byteOffset":80,"componentType":5121,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":86}}],"buffers":[{{"byteLength":86,"uri":"{}"}}],{more}}}"#,
        data(&bytes)
    )
}

/// The square as glTF with this image by an extension, and a red one for those who do not know it.
fn extension_gltf(extension: &str, image: &[u8]) -> String {
    let more = format!(
        r#""textures":[{{"source":0,"extensions":{{"{extension}":{{"source":1}}}}}}],
        "images":[{{"uri":"{}"}},{{"uri":"{}"}}]"#,
        data(&png(1, &[RED])),
        data(image)
    );
    textured_gltf(extension, &more)
}

/// 16 × 16 texels of 200, 40, 90, with losses (VP8), written by libwebp.
const LOSSY: &str = "UklGRjIAAABXRUJQVlA4ICYAAABQAQCdASoQABAAAoBCJaAABAAAAP7sJf3///Qk//4mz/+k2fAAAA==";

#[test]
fn webp_is_a_texture_in_each_format() {
    let image = webp(16, &four(8));
    let (obj, mtl) = textured_obj("four.webp");
    let scene = loaded("webp-obj", &[("a.obj", &obj), ("m.mtl", &mtl), ("four.webp", &image)]);
    assert_eq!(quarters(&scene), FOUR);
    let gltf = extension_gltf("EXT_texture_webp", &image);
    assert_eq!(quarters(&loaded("webp-gltf", &[("a.gltf", gltf.as_bytes())])), FOUR);
    let lossy = extension_gltf("EXT_texture_webp", &STANDARD.decode(LOSSY).unwrap());
    let shown = quarters(&loaded("webp-lossy", &[("a.gltf", lossy.as_bytes())]));
    let near = |color: [u8; 3]| color.iter().zip([200, 40, 90]).all(|(a, b)| a.abs_diff(b) < 8);
    assert!(shown.iter().all(|&color| near(color)), "{shown:?}");
    let gone = extension_gltf("EXT_texture_webp", &image[..40]);
    let warnings = opened("webp-cut", &[("a.gltf", gone.as_bytes())]).unwrap().warnings;
    assert!(warnings.len() == 1 && warnings[0].contains("is drawn as a magenta checker"), "{warnings:?}");
    let missing = gltf.replace("\"source\":1", "\"source\":7");
    let error = opened("webp-missing", &[("a.gltf", missing.as_bytes())]).map(drop).unwrap_err();
    assert!(error.to_string().ends_with("textures[0].source is not there"), "{error}");
}

/// Elements as EXT_meshopt_compression has them in mode `ATTRIBUTES`: each difference is a byte.
fn meshopt(elements: &[u8], stride: usize) -> Vec<u8> {
    let mut bytes = vec![0xa0];
    for byte in 0..stride {
        let mut before = 0;
        bytes.push(3);
        bytes.extend((0..16).map(|i| {
            let now = elements.get(i * stride + byte).copied().unwrap_or(before);
            let delta = now.wrapping_sub(std::mem::replace(&mut before, now)) as i8;
            (delta << 1 ^ delta >> 7) as u8
        }));
    }
    bytes.extend([0; 32]);
    bytes
}

/// The square with compressed and quantized numbers: positions of 16 bits, normals of 8 in an octahedron, texture
/// coordinates of 16, triangles. The views are of a buffer without bytes.
fn compressed_gltf() -> String {
    let positions: Vec<u8> = SQUARE
        .iter()
        .flat_map(|p| [p[0], p[1], p[2], 0.0].map(|c| (c * 32767.0) as i16))
        .flat_map(i16::to_le_bytes)
        .collect();
    let normals = [0, 0, 127, 0].repeat(4);
    let uvs: Vec<u8> = [0_u16, !0, !0, !0, !0, 0, 0, 0].iter().flat_map(|c| c.to_le_bytes()).collect();
    // Three new vertices; the edge from the first to the third and a new vertex.
    let triangles = [&[0xe1, 0xf0, 0x00][..], &[0; 16]].concat();
    let parts = [meshopt(&positions, 8), meshopt(&normals, 4), meshopt(&uvs, 4), triangles];
    let (mut views, mut at, mut to) = (Vec::new(), 0, 0);
    for (number, part) in parts.iter().enumerate() {
        let (stride, count) = [(8, 4), (4, 4), (4, 4), (2, 6)][number];
        let (mode, filter) = [
            ("ATTRIBUTES", "NONE"),
            ("ATTRIBUTES", "OCTAHEDRAL"),
            ("ATTRIBUTES", "NONE"),
            ("TRIANGLES", "NONE"),
        ][number];
        let (length, size) = (part.len(), stride * count);
        let step = if number < 3 { format!(r#""byteStride":{stride},"#) } else { String::new() };
        views.push(format!(
            r#"{{"buffer":1,"byteOffset":{to},"byteLength":{size},{step}"extensions":{{"EXT_meshopt_compression":
            {{"buffer":0,"byteOffset":{at},"byteLength":{length},"byteStride":{stride},"count":{count},"mode":"{mode}",
            "filter":"{filter}"}}}}}}"#
        ));
        (at, to) = (at + length, to + size);
    }
    let views = views.join(",");
    let (required, bytes) = (r#"["EXT_meshopt_compression","KHR_mesh_quantization"]"#, parts.concat());
    format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":{required},"extensionsRequired":{required},
        "scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},"indices":3,"material":0}}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"metallicFactor":0,"baseColorTexture":{{"index":0}}}}}}],
        "textures":[{{"source":0}}],"images":[{{"uri":"{}"}}],
        "accessors":[{{"bufferView":0,"componentType":5122,"normalized":true,"count":4,"type":"VEC3"}},
        {{"bufferView":1,"componentType":5120,"normalized":true,"count":4,"type":"VEC3"}},
        {{"bufferView":2,"componentType":5123,"normalized":true,"count":4,"type":"VEC2"}},
        {{"bufferView":3,"componentType":5123,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{views}],"buffers":[{{"byteLength":{},"uri":"{}"}},
        {{"byteLength":{to},"extensions":{{"EXT_meshopt_compression":{{"fallback":true}}}}}}]}}"#,
        data(&png(16, &four(8))),
        bytes.len(),
        data(&bytes)
    )
}

#[test]
fn compressed_buffer_views_hold_what_was_compressed() {
    let gltf = compressed_gltf();
    let scene = loaded("meshopt", &[("a.gltf", gltf.as_bytes())]);
    assert_eq!(quarters(&scene), FOUR);
    // The normal that is decoded points at the camera.
    assert_eq!(scene.scene.attributes()[0].normal, [0.0, 0.0, 1.0]);
    for (from, to, why) in [
        ("\"filter\":\"OCTAHEDRAL\"", "\"filter\":\"ROUND\"", "it has an unknown filter"),
        ("\"mode\":\"TRIANGLES\"", "\"mode\":\"INDICES\"", "its bytes are no indices of version 1"),
        ("\"count\":6,\"mode\"", "\"count\":600,\"mode\"", "its bytes end too early"),
        ("\"count\":6,\"mode\"", "\"count\":3,\"mode\"", "its bytes go on after the last triangle"),
        ("\"count\":4,\"mode\"", "\"count\":4000000000,\"mode\"", "more bytes are compressed than may be"),
        ("\"byteStride\":2,", "\"byteStride\":3,", "its mode and filter allow no 6 elements of 3 bytes"),
    ] {
        let broken = gltf.replacen(from, to, 1);
        assert_ne!(broken, gltf);
        let error = opened("meshopt-broken", &[("a.gltf", broken.as_bytes())]).map(drop).expect_err(why);
        let line = error.to_string();
        assert!(line.contains("EXT_meshopt_compression: ") && line.ends_with(why), "{line}");
    }
}

/// [`four`] of 8 in KTX 2, as ETC1S with BasisLZ, written by Basis Universal's encoder.
const ETC1S: &str = "q0tUWCAyMLsNChoKAAAAAAEAAAAQAAAAEAAAAAAAAAAAAAAAAQAAAAEAAAABAAAAaAAAACwAAACUAAAAJAAAALgAAAAAAAAAiwAAAAAA\
     AABDAQAAAAAAAAYAAAAAAAAAAAAAAAAAAAAsAAAAAAAAAAIAKACjAQIAAwMAAAgAAAAAAAAAAAA/AAAAAAAAAAAA/////x8AAABLVFh3\
     cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuNTAAAAQAAgArAAAACQAAAC8AAAAAAAAAAAAAAAAAAAAGAAAAAAAAAAAAAAAgwEQAAAAAAADi\
     BAQwEQAAAAAAgCQQACYAAAAAAAAQAoAJAAAAAAAABDA2rKqqqlJVVVUFFMBEAAAAAAAAEoEAmAEAAAAAAEDCCDA3YAAAICAAxhGF0ggf\
     AEwAAAAAAAAggABAhT9ghwY=";

/// [`four`] of 8 in KTX 2, as UASTC with Zstandard, written by Basis Universal's encoder.
const UASTC: &str = "q0tUWCAyMLsNChoKAAAAAAEAAAAQAAAAEAAAAAAAAAAAAAAAAQAAAAEAAAACAAAAaAAAACwAAACUAAAAJAAAAAAAAAAAAAAAAAAAAAAA\
     AAC4AAAAAAAAADsAAAAAAAAAAAEAAAAAAAAsAAAAAAAAAAIAKACmAQIAAwMAABAAAAAAAAAAAAB/AAAAAAAAAAAA/////x8AAABLVFh3\
     cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuNTAAACi1L/1gAACNAQDo9x8A4B96ABfgH+AfAg8XAOD/HwLgAff///8ffO8HAAUSAIuZAbkD\
     lgJYbCYCBTAC";

/// An image in KTX 2 with texels of this Vulkan format.
fn ktx2(format: u32, width: u32, texels: &[u8], channels: u32) -> Vec<u8> {
    let height = texels.len() as u32 / channels / width;
    let mut bytes = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    bytes.extend([format, 1, width, height, 0, 0, 1, 1, 0].iter().flat_map(|n| n.to_le_bytes()));
    bytes.resize(80, 0);
    bytes.extend([104, texels.len() as u64, texels.len() as u64].iter().flat_map(|n| n.to_le_bytes()));
    [&bytes, texels].concat()
}

#[test]
fn ktx2_is_a_texture_whatever_is_in_it() {
    let texels = four(8);
    for (name, image) in [
        ("ktx2-etc1s", STANDARD.decode(ETC1S).unwrap()),
        ("ktx2-uastc", STANDARD.decode(UASTC).unwrap()),
        ("ktx2-plain", ktx2(43, 16, texels.as_flattened(), 4)),
    ] {
        let gltf = extension_gltf("KHR_texture_basisu", &image);
        let shown = quarters(&loaded(name, &[("a.gltf", gltf.as_bytes())]));
        // ETC1S keeps fewer bits of colors.
        let near = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 8);
        assert!(shown.iter().zip(FOUR).all(|(a, b)| near(*a, b)), "{name} {shown:?}");
    }
    for (image, why) in [
        (ktx2(146, 16, texels.as_flattened(), 4), "its texels have the Vulkan format 146"),
        (STANDARD.decode(ETC1S).unwrap()[..200].to_vec(), "the length of its file contradict"),
    ] {
        let gltf = extension_gltf("KHR_texture_basisu", &image);
        let warnings = opened("ktx2-refused", &[("a.gltf", gltf.as_bytes())]).unwrap().warnings;
        assert!(warnings.len() == 1 && warnings[0].contains(why), "{warnings:?}");
    }
}

/// The square with normals, texture coordinates and white, by edge breaking, written by Draco's encoder.
const DRACO: &str = "RFJBQ08CAgEBAAAABAIDAgAAAR//ARH/ARH/ARH/AREE/wABAAAAAQAAAgAAAQAJAwAAAgEBCQMAAQMBAwkCAAICAQICBAADAQEBAQAD\
     AwEwARADACiCmAAAAAAA/z8AAAAAgL8AAIC/AAAAAAAAAEAOBgMBAQMBAUABAP8DAAD/AQAA/wJEQAoFAQEAAwMBMAEQAwAkgiYAAgAA\
     AAEBIAAAAAD/DwAAAAAAAAAAAAAAAIA/DAEBAQEDAQFAAQD/AAAA/wAAAA==";

/// The same, in the order of its triangles.
const DRACO_SEQUENTIAL: &str = "RFJBQ08CAgEAAAACBAEAAQIAAgMBBAAJAwAAAQkDAAEDCQIAAgICBAADAgMCAQABAQADAwEwARADADSCiAQAAAAA/z8AAAADAQAKAwEw\
     GwEQAwAcggD+A/8DAAD/AQAAAAEBAAMDASABIAMAIISGAgAAAAD/DwAAAAEBAQEBAUABAP8AAAD/AAAAAACAvwAAgL8AAAAAAAAAQA4K\
     AAAAAAAAAAAAAIA/DA==";

/// The square as glTF, compressed by Draco.
fn draco_gltf(bytes: &[u8]) -> String {
    let (length, required) = (bytes.len(), r#"["KHR_draco_mesh_compression"]"#);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":{required},"extensionsRequired":{required},
        "scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2,"COLOR_0":3}},"indices":4,
        "material":0,"extensions":{{"KHR_draco_mesh_compression":{{"bufferView":0,
        "attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2,"COLOR_0":3}}}}}}}}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"metallicFactor":0,"baseColorTexture":{{"index":0}}}}}}],
        "textures":[{{"source":0}}],"images":[{{"uri":"{}"}}],
        "accessors":[{{"componentType":5126,"count":4,"type":"VEC3"}},{{"componentType":5126,"count":4,"type":"VEC3"}},
        {{"componentType":5126,"count":4,"type":"VEC2"}},{{"componentType":5121,"normalized":true,"count":4,"type":"VEC4"}},
        {{"componentType":5123,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{length}}}],"buffers":[{{"byteLength":{length},"uri":"{}"}}]}}"#,
        data(&png(16, &four(8))),
        data(bytes)
    )
}

#[test]
fn draco_meshes_are_drawn() {
    for (name, bytes) in [("draco", DRACO), ("draco-sequential", DRACO_SEQUENTIAL)] {
        let bytes = STANDARD.decode(bytes).unwrap();
        let scene = loaded(name, &[("a.gltf", draco_gltf(&bytes).as_bytes())]);
        assert_eq!(quarters(&scene), FOUR, "{name}");
        assert_eq!(scene.scene.drawn_triangles(), 2);
        for normal in scene.scene.attributes().iter().map(|attribute| attribute.normal) {
            assert!(normal[2] > 0.999, "{name} {normal:?}");
        }
        let cut = draco_gltf(&bytes[..bytes.len() / 2]);
        let line = opened("draco-cut", &[("a.gltf", cut.as_bytes())]).map(drop).unwrap_err().to_string();
        assert!(line.contains("KHR_draco_mesh_compression: ") && !line.contains('\n'), "{line}");
    }
    let gltf = draco_gltf(&STANDARD.decode(DRACO).unwrap());
    for (from, to, why) in [
        (r#""NORMAL":1,"TEXCOORD_0":2,"COLOR_0":3}}"#, r#""NORMAL":9}}"#, "NORMAL is not in it"),
        (r#""bufferView":0,"#, r#""bufferView":-1,"#, "it has no buffer view"),
        (r#"4,"type":"VEC2""#, r#"4,"type":"VEC3""#, "TEXCOORD_0 has 3 components"),
    ] {
        let broken = gltf.replacen(from, to, 1);
        assert_ne!(broken, gltf);
        let error = opened("draco-broken", &[("a.gltf", broken.as_bytes())]).map(drop).expect_err(why);
        assert!(error.to_string().ends_with(&format!("KHR_draco_mesh_compression: {why}")), "{error}");
    }
}

/// The scene in the first of these files, with points and lines of this diameter.
fn with_diameter(test: &str, files: &[(&str, &[u8])], diameter: f32) -> Loaded {
    let options = import::Options { point_size: Some(diameter), ..import::Options::default() };
    let loaded = load_with(&folder(test, files).join(files[0].0), &Sequential, &options).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded
}

/// The middles of the quarters in the order of [`FOUR`], each with its color.
const MIDDLES: [([f32; 3], [u8; 3]); 4] = [
    ([-0.5, 0.5, 0.0], [255, 0, 0]),
    ([0.5, 0.5, 0.0], [0, 255, 0]),
    ([-0.5, -0.5, 0.0], [0, 0, 255]),
    ([0.5, -0.5, 0.0], [255; 3]),
];

/// A point in the middle of each quarter as glTF, all `scale` times as near to the middle of the picture; the node
/// enlarges them again.
fn points_gltf(mode: u32, scale: f32) -> String {
    let mut bytes: Vec<u8> =
        MIDDLES.iter().flat_map(|(at, _)| at.map(|c| c * scale)).flat_map(f32::to_le_bytes).collect();
    bytes.extend(MIDDLES.iter().flat_map(|(_, [r, g, b])| [*r, *g, *b, 255]));
    let (grown, half) = (1.0 / scale, 0.5 * scale);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0,"scale":[{grown},{grown},{grown}]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"COLOR_0":1}},"mode":{mode}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[-{half},-{half},0],
        "max":[{half},{half},0]}},{{"bufferView":0,"byteOffset":48,"componentType":5121,"normalized":true,"count":4,
        "type":"VEC4"}}],"bufferViews":[{{"buffer":0,"byteLength":64}}],"buffers":[{{"byteLength":64,"uri":"{}"}}]}}"#,
        data(&bytes)
    )
}

#[test]
fn points_are_drawn_in_their_colors_and_the_size_that_is_asked_for() {
    let cloud = MIDDLES.map(|([x, y, z], [r, g, b])| format!("{x} {y} {z} {r} {g} {b}\n")).concat();
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n{cloud}"
    );
    let obj = MIDDLES.map(|([x, y, z], c)| {
        let [r, g, b] = c.map(|c| f32::from(c) / 255.0);
        format!("v {x} {y} {z} {r} {g} {b}\n")
    });
    let obj = obj.concat() + "p 1 2 3 -1\n";
    for (name, text) in [
        ("points.gltf", points_gltf(0, 1.0)),
        ("scaled.gltf", points_gltf(0, 0.125)),
        ("cloud.ply", ply),
        ("points.obj", obj),
    ] {
        let files: [(&str, &[u8]); 1] = [(name, text.as_bytes())];
        let scene = with_diameter("points", &files, 0.5);
        assert_eq!(quarters(&scene), FOUR, "{name}");
        assert_eq!(scene.scene.drawn_triangles(), 4 * 8, "{name}");
        // 4 pixels to the right of the middle is the corner of an octahedron of that size; 6 are beyond it.
        let lit = |scene: &Loaded, x: usize| seen(scene, DebugView::Albedo)[32 * 8 + x] == [255, 0, 0];
        assert_eq!([lit(&scene, 10), lit(&scene, 14)], [true, false], "{name}");
        assert!(lit(&with_diameter("points-large", &files, 0.9), 13), "{name}");
        // By default they are a small part of the whole.
        let scene = loaded("points-default", &files);
        let (low, high) = scene.scene.extent().unwrap();
        let expected = 1.0 + 2.0_f32.sqrt() / 250.0;
        assert!((high.x - low.x - expected).abs() < 1e-5, "{name} {}", high.x - low.x);
    }
}

#[test]
fn lines_are_drawn_in_each_mode() {
    // The four points in their order: the upper two, the lower two; a Z through all of them; back to the start.
    for (mode, lines) in [(1, 2), (3, 3), (2, 4)] {
        let text = points_gltf(mode, 0.5);
        let scene = with_diameter("lines", &[("a.gltf", text.as_bytes())], 0.25);
        assert_eq!(scene.scene.drawn_triangles(), lines * 12, "mode {mode}");
        let pixels = seen(&scene, DebugView::Albedo);
        // On the upper line halfway: red and green. On the diagonal of the Z; on the way back.
        let is_drawn = |x: usize, y: usize| pixels[32 * y + x] != pixels[0];
        assert!(is_drawn(16, 8), "mode {mode}");
        assert_eq!([is_drawn(15, 16), is_drawn(20, 20)], [mode != 1, mode == 2], "mode {mode}");
    }
    let obj = b"v -0.5 0.5 0\nv 0.5 0.5 0\nv 0 0 0\nvt 0 0\nl 1/1 2/1\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
               element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n-0.5 0.5 0\n0.5 0.5 0\n0 1\n";
    for (name, bytes) in [("a.obj", &obj[..]), ("a.ply", ply.as_bytes())] {
        let scene = with_diameter("lines-others", &[(name, bytes)], 0.25);
        let pixels = seen(&scene, DebugView::Albedo);
        assert!(scene.scene.drawn_triangles() == 12 && pixels[32 * 8 + 16] != pixels[0], "{name}");
    }
}
