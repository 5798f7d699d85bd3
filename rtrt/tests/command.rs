//! The `rtrt` command as a shell sees it: exit codes, output, files.

use rtrt_core::backend::{Picture, Request, Shadows};
use rtrt_core::grid::Grid;
use rtrt_core::layout::NONE;
use rtrt_core::scene::ObjectIndex;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of the test's own, with a scene in it: `scene.obj`, a triangle on a floor.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
        fs::remove_dir_all(&path).ok();
        fs::create_dir_all(&path).unwrap();
        let scene = "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nv -1 0.5 0\nv 1 0.5 0\nv 0 2 0\n\
                     f 4 3 2 1\nf 5 6 7\n";
        fs::write(path.join("scene.obj"), scene).unwrap();
        Self(path)
    }

    /// Runs the command here. `line` is split at white space.
    fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rtrt"));
        command.current_dir(&self.0).args(line.split_whitespace()).env_remove("RTRT_REQUIRE_GPU");
        command
    }

    /// What lies in the folder, but for the scene.
    fn files(&self) -> Vec<String> {
        let names = fs::read_dir(&self.0).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name != "scene.obj").collect()
    }
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("ended by a signal")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// What a run printed, which must have ended well.
fn stdout(output: &Output) -> String {
    assert_eq!(code(output), 0, "{}", stderr(output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn json(output: &Output) -> Value {
    serde_json::from_str(&stdout(output)).unwrap()
}

fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<_> = value.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

#[test]
fn renders_a_file_and_the_demo_to_png() {
    let folder = Folder::new("renders");
    for scene in ["scene.obj", "demo:matchbox", "demo:glass"] {
        let output =
            folder.run(&format!("render {scene} -o out.png --size 64x36 --backend cpu --eye -1,2,3"));
        assert_eq!(stdout(&output), "");
        assert_eq!(stderr(&output).lines().filter(|line| line.starts_with("backend: cpu, ")).count(), 1);
        let picture = image::open(folder.0.join("out.png")).unwrap().into_rgba8();
        assert_eq!(picture.dimensions(), (64, 36));
        let first = *picture.get_pixel(0, 0);
        assert!(picture.pixels().any(|&pixel| pixel != first), "{scene} is blank");
        assert_eq!(folder.files(), ["out.png"]);
    }
}

/// The samples of a channel of a layer.
fn channel(image: &exr::image::FlatImage, layer: &str, name: &str) -> Vec<u32> {
    let layer =
        image.layer_data.iter().find(|l| l.attributes.layer_name.as_ref().unwrap().eq(layer)).unwrap();
    let channel = layer.channel_data.list.iter().find(|channel| channel.name.eq(name)).unwrap();
    match &channel.sample_data {
        exr::prelude::FlatSamples::F32(samples) => samples.iter().map(|sample| sample.to_bits()).collect(),
        exr::prelude::FlatSamples::U32(samples) => samples.clone(),
        exr::prelude::FlatSamples::F16(_) => panic!("half precision"),
    }
}

#[test]
fn layers_are_the_deferred_buffers() {
    let folder = Folder::new("layers");
    // Renders what the command does.
    let loaded = rtrt::import::load(&folder.0.join("scene.obj"), &rtrt_core::scene::Sequential).unwrap();
    let camera = rtrt::import::framing(&loaded.scene, 37.0 / 21.0);
    let mut scene = loaded.scene;
    rtrt::import::light_by_default(&mut scene, &camera);
    let mut backend = rtrt_cpu::Cpu::new(rtrt_cpu::Options { lanes: Some(1), threads: Some(1) }).unwrap();
    for samples in [1, 4] {
        let line = "render scene.obj --size 37x21 --aov all.exr -o color.exr --backend cpu";
        stdout(&folder.run(&format!("{line} --samples {samples}")));
        assert_eq!(folder.files().len(), 2);
        let [all, color] = ["all.exr", "color.exr"]
            .map(|name| exr::prelude::read_all_flat_layers_from_file(folder.0.join(name)).unwrap());
        let request = Request {
            camera: &camera,
            size: [37, 21],
            samples,
            shadows: Shadows::Soft,
            layers: rtrt_core::backend::LAYERS,
            deferred: true,
        };
        let mut picture = Picture::default();
        rtrt_core::backend::Backend::render(&mut backend, &scene, &request, &mut picture).unwrap();
        let deferred = picture.deferred.unwrap();
        let grid = Grid { width: 37, height: 21, side: samples.isqrt() };
        assert_eq!(all.layer_data.len(), 9);
        let get = |layer, names: &[&str]| -> Vec<Vec<u32>> {
            names.iter().map(|name| channel(&all, layer, name)).collect()
        };
        let (depth, normal) = (get("depth", &["Z"]), get("normal", &["X", "Y", "Z"]));
        let (object, triangle) = (get("object", &["id"]), get("triangle", &["id", "source"]));
        let (weights, uv) = (get("barycentrics", &["U", "V"]), get("uv", &["U", "V"]));
        let (colors, shadow) = (get("color", &["R", "G", "B", "A"]), get("shadow", &["Y"]));
        let albedo = get("albedo", &["R", "G", "B"]);
        let mut hits = 0;
        for pixel in 0..37 * 21 {
            let [x, y] = grid.pixel(pixel);
            let rays: Vec<usize> = (0..samples)
                .map(|n| [x * grid.side + n % grid.side, y * grid.side + n / grid.side])
                .map(|place| grid.index(place).0 as usize)
                .collect();
            let (hit, surface) = (&deferred.hits[rays[0]], &deferred.surfaces[rays[0]]);
            let at = |layer: &[Vec<u32>]| layer.iter().map(|c| c[pixel as usize]).collect::<Vec<_>>();
            let floats = |layer: &[Vec<u32>]| at(layer).into_iter().map(f32::from_bits).collect::<Vec<_>>();
            let is_hit = hit.object != NONE;
            assert_eq!(floats(&depth), [if is_hit { hit.t } else { f32::INFINITY }]);
            assert_eq!((floats(&normal), floats(&uv)), (surface.normal.to_vec(), surface.uv.to_vec()));
            assert_eq!((at(&object), at(&triangle)[0]), (vec![hit.object], hit.triangle));
            let source = scene.source_triangle(ObjectIndex(hit.object), hit.triangle);
            assert_eq!(at(&triangle)[1], source.unwrap_or(NONE));
            assert_eq!(floats(&weights), [hit.u, hit.v]);
            let mean = |value: &dyn Fn(usize) -> f32| {
                rays.iter().fold(0.0, |sum, &ray| sum + value(ray)) / samples as f32
            };
            for (i, color) in floats(&colors).into_iter().enumerate() {
                assert_eq!(color, mean(&|ray| deferred.colors[ray][i]));
            }
            assert_eq!(floats(&shadow), [mean(&|ray| deferred.masks[ray].count_ones() as f32) / 2.0]);
            // The file has no materials: everything is of one color.
            assert!(is_hit || samples > 1 || floats(&albedo) == [0.0; 3]);
            hits += usize::from(is_hit);
        }
        assert!(hits > 50 && hits < 37 * 21, "{hits}");
        assert_eq!(color.layer_data.len(), 1);
        for (name, expected) in ["R", "G", "B", "A"].iter().zip(&colors) {
            assert_eq!(channel(&color, "color", name), *expected);
        }
    }
}

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

#[test]
fn frames_play_the_animation() {
    let folder = Folder::new("frames");
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
    let line = "moves.gltf --size 64x36 --backend cpu --lanes 8";
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
    for wrong in
        ["--frames 2 -o out.png", "--frames 2 -o -", "--frames 0 -o {frame}.png", "--time -1 -o a.png"]
    {
        assert_eq!(code(&folder.run(&format!("render moves.gltf {wrong}"))), 2, "{wrong}");
    }
}

#[test]
fn a_cache_changes_nothing_but_the_time() {
    let folder = Folder::new("cache");
    // A wavy field of 2,312 triangles.
    let side = 35;
    let corner = |i: u32| format!("v {} {} {}\n", i % side, f64::from(i * i % 7) * 0.2, i / side);
    let quad = |i: u32| format!("f {} {} {} {}\n", i, i + 1, i + side + 1, i + side);
    let quads = (1..side * (side - 1)).filter(|i| i % side != 0).map(quad);
    fs::write(folder.0.join("field.obj"), (0..side * side).map(corner).chain(quads).collect::<String>())
        .unwrap();
    let run = || stdout(&folder.run("render field.obj --hash --size 37x21 --backend cpu --cache trees"));
    let first = run();
    let files =
        || fs::read_dir(folder.0.join("trees")).unwrap().map(|e| e.unwrap().path()).collect::<Vec<_>>();
    let [file] = &files()[..] else { panic!("{:?}", files()) };
    let whole = fs::read(file).unwrap();
    assert_eq!(run(), first);
    for bad in [&whole[..40], b"not a tree"] {
        fs::write(file, bad).unwrap();
        assert_eq!((run(), files().len()), (first.clone(), 1));
        assert_eq!(fs::read(file).unwrap(), whole);
    }
    // A cache that cannot be there is a warning.
    let output = folder.run("render scene.obj -o out.png --size 8x8 --backend cpu --cache scene.obj");
    assert_eq!(code(&output), 0);
    assert!(stderr(&output).contains("warning: no cache at scene.obj"), "{}", stderr(&output));
    // Small trees are not kept.
    stdout(&folder.run("render scene.obj -o out.png --size 8x8 --backend cpu --cache few"));
    assert_eq!(fs::read_dir(folder.0.join("few")).unwrap().count(), 0);
}

#[test]
fn a_png_of_16_bits_rounds_to_that_of_8() {
    let folder = Folder::new("bits");
    let line = "render scene.obj --size 37x21 --backend cpu";
    stdout(&folder.run(&format!("{line} -o 8.png")));
    stdout(&folder.run(&format!("{line} -o 16.png --bits 16")));
    let [narrow, wide] = ["8.png", "16.png"].map(|name| image::open(folder.0.join(name)).unwrap());
    assert_eq!(wide.color(), image::ColorType::Rgba16);
    for (narrow, wide) in narrow.into_rgba8().iter().zip(wide.into_rgba16().iter()) {
        assert!((f64::from(*narrow) - f64::from(*wide) / 257.0).abs() <= 0.51);
    }
    // The same picture goes to standard output, and nothing else does.
    let output = folder.run(&format!("{line} -o -"));
    assert_eq!(code(&output), 0);
    assert_eq!(output.stdout, fs::read(folder.0.join("8.png")).unwrap());
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
    ] {
        let output = folder.run(&format!("render scene.obj -o out.png --backend cpu {wrong}"));
        assert_eq!(code(&output), 2, "{wrong}: {}", stderr(&output));
        assert!(stderr(&output).contains("error: "), "{wrong}: {}", stderr(&output));
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
        "render scene.obj -o out.png --debug colors",
        "render scene.obj -o - --hash",
        "render scene.obj -o - --json",
        "",
    ] {
        assert_eq!(code(&folder.run(wrong)), 2, "{wrong}");
    }
    assert_eq!(folder.files(), [""; 0]);
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
            let [error] = errors.lines().collect::<Vec<_>>()[..] else { panic!("not one line: {errors}") };
            assert!(error.starts_with("error: ") && error.contains(scene), "{error}");
        }
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
fn lanes_and_threads_do_not_change_a_hash() {
    let folder = Folder::new("hash");
    let hashes = |options: &str| {
        let line = format!("render demo:matchbox --hash --size 64x36 --samples 1 --backend cpu {options}");
        stdout(&folder.run(&line))
    };
    let scalar = hashes("--lanes 1 --threads 1");
    let names: Vec<_> = scalar.lines().map(|line| line.split("  ").last().unwrap()).collect();
    let buffers = [
        "pixels",
        "colors",
        "hits",
        "layers",
        "left",
        "lists",
        "lit",
        "masks",
        "penumbras",
        "surfaces",
        "tints",
    ];
    assert_eq!(names, buffers);
    for options in ["--lanes 8 --threads 1", "--lanes 1 --threads 2", "--lanes 8 --threads 2", ""] {
        assert_eq!(hashes(options), scalar, "{options}");
    }
    assert_ne!(hashes("--eye -1,2,3"), scalar);
    assert_ne!(hashes("--no-shadows"), scalar);
}

#[test]
fn lights_with_a_radius_cast_the_shadows_that_are_asked_for() {
    let folder = Folder::new("radius");
    let hashes = |options: &str| {
        let line = format!("render demo:matchbox --hash --size 64x36 --samples 4 --backend cpu {options}");
        stdout(&folder.run(&line))
    };
    let ways = ["off", "hard", "soft", "area", "jitter"];
    let wide = ways.map(|how| hashes(&format!("--light-radius 0.3 --shadows {how}")));
    assert!((1..ways.len()).all(|at| !wide[..at].contains(&wide[at])), "two ways are the same");
    assert_eq!(hashes("--light-radius 0.3"), wide[2]);
    assert_eq!(hashes("--no-shadows --light-radius 0.3"), wide[0]);
    // Without a radius all shadows are hard.
    let hard = ways[1..].iter().map(|how| hashes(&format!("--shadows {how}")));
    assert!(hard.into_iter().all(|hashes| hashes == wide[1]));
    let one = hashes("--light point:0,3,0:0.3");
    assert_eq!(hashes("--light point:0,3,0 --light-radius 0.3"), one);
    assert_ne!(hashes("--light point:0,3,0"), one);
    assert_ne!(hashes("--light sun:1,3,1:2"), hashes("--light sun:1,3,1"));
}

#[test]
fn render_prints_the_documented_keys() {
    let folder = Folder::new("render_json");
    let report =
        json(&folder.run("render scene.obj --json --size 64x36 --backend cpu --lanes 8 --threads 2"));
    let expected = [
        "adapter",
        "backend",
        "buffers",
        "drawn_triangles",
        "frame_ms",
        "hash",
        "lanes",
        "objects",
        "output",
        "samples",
        "size",
        "stages_ms",
        "threads",
        "tree_build_ms",
        "triangles",
    ];
    assert_eq!(keys(&report), expected);
    assert_eq!(report["backend"], "cpu");
    assert_eq!(report["size"], serde_json::json!([64, 36]));
    assert_eq!([&report["lanes"], &report["threads"], &report["samples"]], [8, 2, 4]);
    assert_eq!(report["triangles"], 3);
    assert!(report["buffers"].is_null() && report["output"].is_null());
}

#[test]
fn bench_prints_the_documented_keys() {
    let folder = Folder::new("bench_json");
    let line = "demo:matchbox --size 64x36 --samples 1 --backend cpu --lanes 1";
    let report = json(&folder.run(&format!("bench --json --frames 3 {line}")));
    let expected = [
        "adapter",
        "backend",
        "drawn_triangles",
        "frame_ms",
        "hash",
        "lanes",
        "objects",
        "peak_rss_bytes",
        "primary_and_shadow_rays_per_second",
        "primary_rays_per_second",
        "samples",
        "scene_bytes",
        "size",
        "source_bytes",
        "stages_ms",
        "threads",
        "tree_build_ms",
        "triangles",
    ];
    assert_eq!(keys(&report), expected);
    let stages = report["stages_ms"].as_object().unwrap();
    assert_eq!(stages.len(), rtrt_core::backend::STAGES.len());
    for (name, times) in stages {
        let [median, min] = ["median", "min"].map(|key| times[key].as_f64().unwrap());
        assert!(0.0 <= min && min <= median, "{name}");
    }
    let number = |key: &str| report[key].as_f64().unwrap();
    let median = |stage: &str| stages[stage]["median"].as_f64().unwrap();
    let seconds = (median("prepare") + median("bin") + median("visibility")) * 1e-3;
    let rays = number("primary_rays_per_second") * seconds;
    assert!((rays - 64.0 * 36.0).abs() < 1e-3, "{rays}");
    assert!(number("frame_ms") > 0.0 && number("scene_bytes") > number("source_bytes"));
    let rendered = json(&folder.run(&format!("render --json {line}")));
    assert_eq!(report["hash"], rendered["hash"]);
}

#[test]
fn verify_finds_all_cpu_variants_equal() {
    let folder = Folder::new("verify");
    let line = "verify scene.obj --size 37x21 --samples 4 --backend cpu";
    let lines = stdout(&folder.run(line));
    assert!(lines.contains("cpu, 8 lanes, 2 threads: equal"), "{lines}");
    assert!(lines.lines().all(|line| line.ends_with(": equal") || line.contains("16 lanes")), "{lines}");

    let report = json(&folder.run(&format!("{line} --json")));
    let expected = ["buffers", "equal", "hash", "reference", "samples", "size", "variants"];
    assert_eq!(keys(&report), expected);
    assert_eq!(report["equal"], true);
    let variants = report["variants"].as_array().unwrap();
    assert_eq!(variants.len(), lines.lines().count());
    for variant in variants {
        assert_eq!(keys(variant), ["detail", "result", "variant"]);
    }
}

#[test]
fn verify_finds_the_gpu_equal_or_says_that_it_is_skipped() {
    let folder = Folder::new("verify_gpu");
    let is_required = std::env::var("RTRT_REQUIRE_GPU").is_ok_and(|value| value == "1");
    let mut command = folder.command("verify demo:matchbox --size 64x36 --json --backend gpu");
    if is_required {
        command.env("RTRT_REQUIRE_GPU", "1");
    }
    let output = command.output().unwrap();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    for variant in report["variants"].as_array().unwrap() {
        println!("{}: {}: {}", variant["variant"], variant["result"], variant["detail"]);
        assert_ne!(variant["result"], "differs", "{variant}");
    }
    let is_compared = report["variants"].as_array().unwrap().iter().any(|v| v["result"] == "equal");
    assert!(is_compared || !is_required, "RTRT_REQUIRE_GPU: {}", stderr(&output));
    if !is_compared {
        eprintln!("SKIPPED: verify on a GPU: {}", report["variants"][0]["detail"]);
    }
    assert_eq!(code(&output), if is_compared { 0 } else { 4 }, "{}", stderr(&output));
}

#[test]
fn a_required_gpu_that_is_not_there_is_exit_code_4() {
    let folder = Folder::new("required");
    let mut command = folder.command("verify scene.obj --size 8x8");
    // Vulkan finds no driver in a file that is not there.
    command.env("RTRT_REQUIRE_GPU", "1").env("VK_DRIVER_FILES", "none").env("VK_ICD_FILENAMES", "none");
    let output = command.output().unwrap();
    if cfg!(target_os = "linux") {
        assert_eq!(code(&output), 4, "{}", stderr(&output));
        assert!(stderr(&output).contains("RTRT_REQUIRE_GPU"), "{}", stderr(&output));
    }
}

#[test]
fn doctor_says_what_auto_would_choose() {
    let lines = stdout(&Folder::new("doctor").run("doctor"));
    assert!(lines.contains("cpu, scalar, 1 lane"), "{lines}");
    assert!(lines.lines().last().unwrap().starts_with("auto chooses "), "{lines}");
}
