//! Files that nobody meant to write: whatever they hold, the import gives a scene or an error.
//!
//! `RTRT_SEEDS=0..100000 cargo test --release -p rtrt --test mutated` runs those seeds instead of the usual ones. A
//! failure names its seed, and leaves its file.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rtrt::cache::Cache;
use rtrt::import::{Loaded, framing, load, surround};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::layout::Attribute;
use rtrt_core::scene::{Camera, Light, Material, Mesh, Scene, Sequential};
use rtrt_cpu::{Cpu, Options};
use sha2::{Digest, Sha256};
use std::fs;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Seeds if no others are asked for.
const SEEDS: Range<u64> = 0..400;
/// No file may take longer.
const LONGEST: Duration = Duration::from_secs(20);
/// Larger files are no better to start from, and slower.
const LARGEST: u64 = 64 << 10;

fn seeds() -> Range<u64> {
    let Ok(seeds) = std::env::var("RTRT_SEEDS") else { return SEEDS };
    let (first, last) = seeds.split_once("..").expect("RTRT_SEEDS is FIRST..LAST");
    first.parse().expect("a number")..last.parse().expect("a number")
}

/// Numbers that look random.
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d)
    }
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % count.max(1)
    }
    fn of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

/// What numbers in files should not be.
const NUMBERS: [&str; 18] = [
    "0",
    "1",
    "2",
    "3",
    "7",
    "-1",
    "255",
    "65535",
    "65536",
    "4294967295",
    "18446744073709551615",
    "1e39",
    "-1e39",
    "1e-39",
    "0.5",
    "null",
    "5126",
    "\"x\"",
];

/// One to eight small damages; in half of the files only one or two, of numbers, so that what is read first stays
/// whole.
fn damaged(random: &mut Random, mut bytes: Vec<u8>) -> Vec<u8> {
    let (most, first, numbers) = if random.below(2) == 0 { (2, 5, 5) } else { (8, 0, NUMBERS.len()) };
    for _ in 0..1 + random.below(most) {
        if bytes.is_empty() {
            break;
        }
        let (at, length) = (random.below(bytes.len()), 1 + random.below(12));
        let end = (at + length).min(bytes.len());
        match first + random.below(9 - first) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = *random.of(&[0, 1, 0x7f, 0x80, 0xff, b'"', b'{', b'\n', b'/']),
            2 => drop(bytes.drain(at..end)),
            3 => {
                let copied = bytes[at..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, copied);
            }
            4 if random.below(4) == 0 => bytes.truncate(at),
            4 => bytes[at..end].fill(0xff),
            // A number of the text.
            _ => {
                let is_digit = |byte: &u8| byte.is_ascii_digit() || b".-+e".contains(byte);
                let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|i| at + i) else {
                    continue;
                };
                let end = start + bytes[start..].iter().take_while(|byte| is_digit(byte)).count();
                let number = random.of(&NUMBERS[..numbers]).bytes();
                bytes.splice(start..end, number);
            }
        }
    }
    bytes
}

/// A binary glTF file whose lengths fit again, so that what is in it is read.
fn repaired(mut glb: Vec<u8>, json_grew: isize) -> Vec<u8> {
    if glb.len() >= 20 && glb.starts_with(b"glTF") {
        let total = glb.len() as u32;
        glb[8..12].copy_from_slice(&total.to_le_bytes());
        let json = u32::from_le_bytes([glb[12], glb[13], glb[14], glb[15]]);
        let json = (json as isize + json_grew).max(0) as u32;
        glb[12..16].copy_from_slice(&json.to_le_bytes());
    }
    glb
}

/// A file to start from: its ending and its bytes.
type Start = (&'static str, Vec<u8>);

/// Files made here, and those of the test scenes that are small, if they are there.
fn starts() -> Vec<Start> {
    let mut starts: Vec<Start> =
        vec![("gltf", GLTF.replace('\n', "").into_bytes()), ("obj", OBJ.as_bytes().to_vec())];
    // Several of each: they are few beside the test scenes.
    for _ in 0..8 {
        starts.extend([("stl", STL.as_bytes().to_vec()), ("stl", stl()), ("ply", PLY.as_bytes().to_vec())]);
        starts.extend([("ply", ply(false)), ("ply", ply(true))]);
        starts.extend([MESHOPT, DRACO].map(|text| ("gltf", text.replace('\n', "").into_bytes())));
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    if folder.is_dir() {
        collect(&folder, &mut starts);
    } else {
        println!("no test scenes at {}: only the built-in files are damaged", folder.display());
    }
    starts
}

fn collect(folder: &Path, starts: &mut Vec<Start>) {
    let mut paths: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            collect(&path, starts);
            continue;
        }
        let ending = path.extension().and_then(|ending| ending.to_str());
        let known = ["glb", "gltf", "obj", "stl", "ply"].into_iter().find(|known| ending == Some(known));
        if let Some(ending) = known.filter(|_| path.metadata().is_ok_and(|file| file.len() <= LARGEST)) {
            starts.push((ending, fs::read(&path).unwrap()));
        }
    }
}

/// A folder for one test.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mutated").join(test);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Does something with a file; says which seed it was if that panics or takes too long.
fn guarded<T>(seed: u64, file: &Path, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = catch_unwind(AssertUnwindSafe(work));
    let result = result.unwrap_or_else(|_| panic!("seed {seed} panicked; its file is {}", file.display()));
    let time = start.elapsed();
    assert!(time < LONGEST, "seed {seed} took {time:?}; its file is {}", file.display());
    result
}

/// The smallest picture there is of a scene.
fn draw(scene: &Scene, camera: &Camera) {
    let mut cpu = Cpu::new(Options { lanes: Some(1), threads: Some(1) }).unwrap();
    let request = Request::new(camera, [4, 4]).shadows(Shadows::Hard);
    // Lights and cameras of damaged files may be refused.
    _ = cpu.render(scene, &request, &mut Picture::default());
}

/// Draws it at rest and in motion.
fn use_all(mut loaded: Loaded) {
    draw(&loaded.scene, &loaded.camera);
    let camera = framing(&loaded.scene, 1.0);
    let Some(animation) = loaded.animation.take() else { return draw(&loaded.scene, &camera) };
    for time in [0.3, 1e9] {
        if let Ok(pose) = animation.at(time)
            && pose.apply(&mut loaded.scene).is_ok()
        {
            pose.aim(loaded.scene.lights_mut());
            draw(&loaded.scene, &camera);
        }
    }
}

#[test]
fn damaged_scenes_are_drawn_or_refused_in_one_line() {
    let folder = folder("scenes");
    fs::write(folder.join("a.mtl"), MTL).unwrap();
    // Of those that are refused as they are, few.
    let mut starts = starts();
    let mut number = 0;
    starts.retain(|(ending, bytes)| {
        number += 1;
        let file = folder.join(format!("whole.{ending}"));
        fs::write(&file, bytes).unwrap();
        number % 8 == 0 || load(&file, &Sequential).is_ok()
    });
    let (mut drawn, mut refused) = (0, 0);
    for seed in seeds() {
        let mut random = Random::new(seed);
        let (ending, bytes) = random.of(&starts);
        let before = bytes.len() as isize;
        let mut bytes = damaged(&mut random, bytes.clone());
        if *ending == "glb" && random.below(4) != 0 {
            let grew = bytes.len() as isize - before;
            bytes = repaired(bytes, grew);
        }
        let file = folder.join(format!("damaged.{ending}"));
        fs::write(&file, &bytes).unwrap();
        guarded(seed, &file, || match load(&file, &Sequential) {
            Ok(loaded) => {
                drawn += 1;
                use_all(loaded);
            }
            Err(error) => {
                refused += 1;
                let line = error.to_string();
                assert!(!line.contains('\n') && line.contains(&*file.to_string_lossy()), "{line}");
            }
        });
    }
    println!("{drawn} drawn, {refused} refused, from {} files", starts.len());
    assert!(drawn * 20 > refused && refused * 20 > drawn, "{drawn} drawn, {refused} refused");
}

#[test]
fn damaged_materials_and_textures_are_drawn() {
    let folder = folder("materials");
    fs::write(folder.join("damaged.obj"), OBJ.replace("a.mtl", "damaged.mtl")).unwrap();
    let picture = image::RgbaImage::from_fn(9, 5, |x, y| image::Rgba([x as u8 * 28, y as u8 * 50, 99, 200]));
    let mut pictures = Vec::from([image::ImageFormat::Png, image::ImageFormat::WebP].map(|format| {
        let mut bytes = vec![];
        picture.write_to(&mut std::io::Cursor::new(&mut bytes), format).unwrap();
        bytes
    }));
    // The first bytes say what a file is, whatever its name.
    pictures.extend([ETC1S, UASTC].map(|ktx2| STANDARD.decode(ktx2).unwrap()));
    for seed in seeds() {
        let mut random = Random::new(seed);
        fs::write(folder.join("damaged.mtl"), damaged(&mut random, MTL.as_bytes().to_vec())).unwrap();
        let picture = random.of(&pictures).clone();
        fs::write(folder.join("t.png"), damaged(&mut random, picture)).unwrap();
        let file = folder.join("damaged.obj");
        let loaded = guarded(seed, &file, || load(&file, &Sequential));
        use_all(loaded.unwrap_or_else(|error| panic!("seed {seed}: {error}")));
    }
}

#[test]
fn damaged_panoramas_are_seen_or_refused() {
    let folder = folder("panoramas");
    let mut hdr = b"#?RADIANCE\n# made here\nEXPOSURE=1\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    // Run lengths, as programs write them: 8 of a byte, four times a row.
    hdr.extend((0..4).flat_map(|row| [2, 2, 0, 8, 136, 128 + row, 136, 9, 136, 200, 136, 129]));
    let (file, mut seen) = (folder.join("damaged.hdr"), 0);
    fs::write(&file, &hdr).unwrap();
    surround(&mut Scene::new(), &file, true).unwrap();
    for seed in seeds() {
        let bytes = damaged(&mut Random::new(seed), hdr.clone());
        fs::write(&file, bytes).unwrap();
        guarded(seed, &file, || {
            let mut scene = Scene::new();
            if surround(&mut scene, &file, true).is_ok() {
                seen += 1;
                draw(&scene, &framing(&scene, 1.0));
            }
        });
    }
    println!("{seen} seen");
}

#[test]
fn damaged_trees_are_built_anew_or_lose_no_triangle() {
    let folder = folder("trees");
    let mut random = Random::new(7);
    let positions: Vec<[f32; 3]> =
        (0..180).map(|_| [0; 3].map(|_| random.below(1000) as f32 * 0.002 - 1.0)).collect();
    let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
    let mesh = Mesh::new(positions, vec![attribute; 180], (0..180).collect()).unwrap();
    let cache = Cache::new(&folder).unwrap();
    let picture = |cache: &Cache| {
        let tree = cache.tree(&mesh, &Sequential).unwrap();
        let mut scene = Scene::new();
        let material = scene.add_material(Material::new([0.7; 3]).roughness(0.5)).unwrap();
        let index = scene.add_mesh(&mesh, &tree).unwrap();
        scene.add_instance(index, material, glam::Mat4::IDENTITY).unwrap();
        scene.add_light(Light::sun(glam::Vec3::new(-1.0, -2.0, -3.0)).color(glam::Vec3::ONE));
        let mut cpu = Cpu::new(Options { lanes: Some(1), threads: Some(1) }).unwrap();
        let camera = framing(&scene, 1.0);
        let request = Request::new(&camera, [16, 16]).shadows(Shadows::Hard).layers(1);
        let mut picture = Picture::default();
        cpu.render(&scene, &request, &mut picture).unwrap();
        picture.pixels
    };
    let expected = picture(&cache);
    let file = fs::read_dir(&folder).unwrap().next().unwrap().unwrap().path();
    let whole = fs::read(&file).unwrap();
    for seed in seeds() {
        let mut random = Random::new(seed);
        let mut bytes = damaged(&mut random, whole.clone());
        // Most get sums that fit, as somebody would write who wants to be read.
        if random.below(4) != 0 && bytes.len() > 32 {
            let content = bytes.len() - 32;
            let digest = Sha256::digest(&bytes[..content]);
            bytes[content..].copy_from_slice(&digest);
        }
        fs::write(&file, bytes).unwrap();
        let pixels = guarded(seed, &file, || picture(&cache));
        assert!(pixels == expected, "seed {seed} shows something else");
    }
}

/// Two nodes, a skin, a morph target, an animation, a texture that is not there, a light, a camera.
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,2,3]}],
"extensionsUsed":["KHR_lights_punctual","KHR_texture_transform","KHR_materials_transmission"],
"extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","intensity":20,"range":9,"spot":{"outerConeAngle":0.5}}]}},
"nodes":[{"children":[1],"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0.5,0,0,1]},
{"mesh":0,"scale":[1,2,1],"rotation":[0,0,0.7071,0.7071],"weights":[0.5]},
{"camera":0,"translation":[0,0,4],"extensions":{"KHR_lights_punctual":{"light":0}}},{"mesh":0,"skin":0}],
"cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1,"aspectRatio":1.5}}],
"skins":[{"joints":[0,1]}],
"materials":[{"alphaMode":"MASK","alphaCutoff":0.4,"doubleSided":true,"pbrMetallicRoughness":{"baseColorFactor":
[1,0.5,0.2,0.9],"roughnessFactor":0.3,"baseColorTexture":{"index":0,"texCoord":0,"extensions":{"KHR_texture_transform":
{"offset":[0.1,0.2],"rotation":0.3,"scale":[2,3]}}}},"extensions":{"KHR_materials_transmission":{"transmissionFactor":0.5}}}],
"textures":[{"source":0,"sampler":0}],"samplers":[{"wrapS":33071,"wrapT":33648}],
"images":[{"uri":"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1,"JOINTS_0":4,"WEIGHTS_0":5},"indices":2,"material":0,
"targets":[{"POSITION":0}]}]}],
"animations":[{"samplers":[{"input":3,"output":0,"interpolation":"LINEAR"}],
"channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":0,"byteOffset":4,"componentType":5126,"count":3,"type":"VEC2"},
{"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"},
{"bufferView":0,"componentType":5126,"count":3,"type":"SCALAR","sparse":{"count":1,"indices":{"bufferView":1,
"byteOffset":2,"componentType":5121},"values":{"bufferView":0,"byteOffset":12}}},
{"bufferView":1,"componentType":5121,"count":3,"type":"VEC4"},
{"bufferView":0,"componentType":5126,"count":2,"type":"VEC4"}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":12}],
"buffers":[{"byteLength":48,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAECAAAAAAAAAAAA"}]}"#;

/// A triangle whose positions and indices are compressed by EXT_meshopt_compression, in a quarter of an octahedron.
const MESHOPT: &str = r#"{"asset":{"version":"2.0"},"extensionsUsed":["EXT_meshopt_compression"],
"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
"accessors":[{"bufferView":0,"componentType":5120,"count":4,"type":"VEC3"},
{"bufferView":1,"componentType":5125,"count":6,"type":"SCALAR"}],
"bufferViews":[{"buffer":1,"byteLength":16,"byteStride":4,"extensions":{"EXT_meshopt_compression":{"buffer":0,
"byteLength":93,"byteStride":4,"count":4,"mode":"ATTRIBUTES","filter":"OCTAHEDRAL"}}},
{"buffer":1,"byteOffset":16,"byteLength":24,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":93,
"byteLength":21,"byteStride":4,"count":6,"mode":"TRIANGLES"}}}],
"buffers":[{"byteLength":114,"uri":"data:application/octet-stream;base64,oAMA/v3IAAAAAAAAAAAAAAAAAwAA/jUAAAAAAAAAAAAAAAAD/gAAAAAAAAAAAAAAAAAAAAIAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA4fD+8QYAAAAAAAAAAAAAAAAAAAAA"},{"byteLength":40}]}"#;

/// A square that is compressed by Draco.
const DRACO: &str = r#"{"asset":{"version":"2.0"},"extensionsUsed":["KHR_draco_mesh_compression"],
"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,
"TEXCOORD_0":2,"COLOR_0":3},"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0,
"NORMAL":1,"TEXCOORD_0":2,"COLOR_0":3}}}}]}],"accessors":[{"componentType":5126,"count":4,"type":"VEC3"},
{"componentType":5126,"count":4,"type":"VEC3"},{"componentType":5126,"count":4,"type":"VEC2"},
{"componentType":5121,"normalized":true,"count":4,"type":"VEC4"}],"bufferViews":[{"buffer":0,"byteLength":199}],
"buffers":[{"byteLength":199,"uri":"data:application/octet-stream;base64,
RFJBQ08CAgEBAAAABAIDAgAAAR//ARH/ARH/ARH/AREE/wABAAAAAQAAAgAAAQAJAwAAAgEBCQMAAQMBAwkCAAICAQICBAADAQEBAQADAwEwARAD
ACiCmAAAAAAA/z8AAAAAgL8AAIC/AAAAAAAAAEAOBgMBAQMBAUABAP8DAAD/AQAA/wJEQAoFAQEAAwMBMAEQAwAkgiYAAgAAAAEBIAAAAAD/DwAA
AAAAAAAAAAAAAIA/DAEBAQEDAQFAAQD/AAAA/wAAAA=="}]}"#;

const OBJ: &str = "mtllib a.mtl\no thing\nv -1 0 0 1 0.5 0.2\nv 1 0 0\nv 1 1.5 0.2\nv -1 1 -0.2\nv 0 0.4 0.1\nvt 0 0\n\
                   vt 1 0\nvt 0.5 1\nvn 0 0 1\nvn 0 1 0\ng part\ns 1\nusemtl a\nf 1/1/1 2/2/1 3/3/2 4/1/1 5/2/2\n\
                   usemtl b\nf -5//1 -4//2 -3//1\nf 1 2 \\\n 3\nl 1 2 3\np 1\n";

const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1.5 0\nendloop\nendfacet\n\
                   facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1e0 1 -0.2\nvertex 0 1.5 0\nendloop\nendfacet\nendsolid a\n";

/// Two facets, binary.
fn stl() -> Vec<u8> {
    let numbers: [f32; 12] = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.2, 0.0, 1.0, 0.0];
    let facet = [numbers.map(f32::to_le_bytes).as_flattened(), &[0; 2]].concat();
    [&[b'x'; 80], &2_u32.to_le_bytes()[..], &facet, &facet].concat()
}

const PLY: &str = "ply\nformat ascii 1.0\ncomment TextureFile t.png\nelement vertex 5\nproperty float x\nproperty float y\n\
                   property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n\
                   property float s\nproperty float t\nelement face 2\nproperty list uchar int vertex_indices\n\
                   property list uchar float texcoord\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                   -1 0 0 255 0 9 255 0 0\n1 0 0 7 8 9 255 1 0\n1 1.5 0.2 9 9 9 99 1 1\n-1 1 -0.2 1 2 3 255 0 1\n\
                   0 0.4 0.1 3 2 1 255 0.5 0.5\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n3 0 1 4 6 0 0 1 0 0 1\n7 0 1 2 -1 1 2 3\n";

/// A square with normals, binary.
fn ply(big: bool) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_{}_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\nelement face 2\n\
         property list uchar int vertex_index\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
        if big { "big" } else { "little" }
    )
    .into_bytes();
    for number in [0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0] {
        let number = number as f32;
        bytes.extend(if big { number.to_be_bytes() } else { number.to_le_bytes() });
    }
    for face in [[0, 1, 2], [0, 2, 3]] {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|c: &i32| if big { c.to_be_bytes() } else { c.to_le_bytes() }));
        bytes.extend([200, 100, 50]);
    }
    bytes
}

/// Four colors in KTX 2, as ETC1S.
const ETC1S: &str = "q0tUWCAyMLsNChoKAAAAAAEAAAAQAAAAEAAAAAAAAAAAAAAAAQAAAAEAAAABAAAAaAAAACwAAACUAAAAJAAAALgAAAAAAAAAiwAAAAAA\
     AABDAQAAAAAAAAYAAAAAAAAAAAAAAAAAAAAsAAAAAAAAAAIAKACjAQIAAwMAAAgAAAAAAAAAAAA/AAAAAAAAAAAA/////x8AAABLVFh3\
     cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuNTAAAAQAAgArAAAACQAAAC8AAAAAAAAAAAAAAAAAAAAGAAAAAAAAAAAAAAAgwEQAAAAAAADi\
     BAQwEQAAAAAAgCQQACYAAAAAAAAQAoAJAAAAAAAABDA2rKqqqlJVVVUFFMBEAAAAAAAAEoEAmAEAAAAAAEDCCDA3YAAAICAAxhGF0ggf\
     AEwAAAAAAAAggABAhT9ghwY=";

/// Four colors in KTX 2, as UASTC with Zstandard.
const UASTC: &str = "q0tUWCAyMLsNChoKAAAAAAEAAAAQAAAAEAAAAAAAAAAAAAAAAQAAAAEAAAACAAAAaAAAACwAAACUAAAAJAAAAAAAAAAAAAAAAAAAAAAA\
     AAC4AAAAAAAAADsAAAAAAAAAAAEAAAAAAAAsAAAAAAAAAAIAKACmAQIAAwMAABAAAAAAAAAAAAB/AAAAAAAAAAAA/////x8AAABLVFh3\
     cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuNTAAACi1L/1gAACNAQDo9x8A4B96ABfgH+AfAg8XAOD/HwLgAff///8ffO8HAAUSAIuZAbkD\
     lgJYbCYCBTAC";

const MTL: &str = "newmtl a\nKd 0.8 0.2 0.1\nKs 0.5 0.5 0.5\nNs 40\nmap_Kd -s 2 2 1 -o 0.1 0.2 t.png\nmap_bump -bm 0.5 t.png\n\
                   d 0.7\nnewmtl b\nKd 0.1 0.9 0.1\nKe 0.2 0 0\nTr 0.25\nillum 2\nmap_d t.png\n";
