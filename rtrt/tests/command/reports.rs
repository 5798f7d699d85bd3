//! What is printed: hashes, JSON, what there is.

use crate::folder::{Folder, json, keys, stdout};

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
        "bvh_build_ms",
        "camera",
        "cx",
        "cy",
        "drawn_triangles",
        "exposure",
        "eye",
        "far",
        "fl_x",
        "fl_y",
        "fov_y",
        "frame",
        "frame_ms",
        "h",
        "hash",
        "lanes",
        "load_ms",
        "look_at",
        "near",
        "objects",
        "output",
        "parallel",
        "peak_rss_bytes",
        "samples",
        "scene",
        "scene_bytes",
        "size",
        "stages_ms",
        "threads",
        "time",
        "total_ms",
        "transform_matrix",
        "triangles",
        "up",
        "w",
    ];
    assert_eq!(keys(&report), expected);
    assert_eq!([&report["scene"], &report["camera"], &report["backend"]], ["scene.obj", "camera", "cpu"]);
    let demo = json(&folder.run("render demo:glass --json --size 16x9 --backend cpu --samples 1"));
    assert_eq!(demo["camera"], "window");
    assert_eq!(report["size"], serde_json::json!([64, 36]));
    assert_eq!([&report["lanes"], &report["threads"], &report["samples"]], [8, 2, 4]);
    assert_eq!(report["triangles"], 3);
    assert!(report["buffers"].is_null() && report["output"].is_null());
    let number = |key: &str| report[key].as_f64().unwrap();
    assert!(number("total_ms") > number("load_ms") + number("frame_ms"));
    assert!(number("scene_bytes") > 0.0);
    assert!(cfg!(not(target_os = "linux")) || number("peak_rss_bytes") > number("scene_bytes"));
}

#[test]
fn bench_prints_the_documented_keys() {
    let folder = Folder::new("bench_json");
    let line = "demo:matchbox --size 64x36 --samples 1 --backend cpu --lanes 1";
    let report = json(&folder.run(&format!("bench --json --frames 3 {line}")));
    let expected = [
        "adapter",
        "backend",
        "bvh_build_ms",
        "drawn_triangles",
        "frame_ms",
        "hash",
        "host_ms",
        "lanes",
        "load_ms",
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
        "traced_rays_per_second",
        "triangles",
    ];
    assert_eq!(keys(&report), expected);
    let stages = report["stages_ms"].as_object().unwrap();
    assert_eq!(stages.len(), rtrt_core::schedule::Stage::COUNT);
    for (name, times) in stages {
        let [median, min] = ["median", "min"].map(|key| times[key].as_f64().unwrap());
        assert!(0.0 <= min && min <= median, "{name}");
    }
    let number = |key: &str| report[key].as_f64().unwrap();
    let median = |stage: &str| stages[stage]["median"].as_f64().unwrap();
    let seconds = (median("prepare") + median("bin") + median("visibility")) * 1e-3;
    let rays = number("primary_rays_per_second") * seconds;
    assert!((rays - 64.0 * 36.0).abs() < 1e-3, "{rays}");
    assert!(report["host_ms"].is_null());
    assert!(number("frame_ms") > 0.0 && number("scene_bytes") > number("source_bytes"));
    let rendered = json(&folder.run(&format!("render --json {line}")));
    assert_eq!(report["hash"], rendered["hash"]);
}

#[test]
fn doctor_says_what_auto_would_choose() {
    let folder = Folder::new("doctor");
    let lines = stdout(&folder.run("doctor"));
    assert!(lines.contains("cpu, scalar, 1 lane"), "{lines}");
    assert!(lines.lines().last().unwrap().starts_with("auto chooses "), "{lines}");
    let report = json(&folder.run("doctor --json"));
    let expected = ["adapters", "auto", "cpu", "defaults", "left_out", "shaders", "version"];
    assert_eq!(keys(&report), expected);
    assert_eq!(report["cpu"][0]["lanes"], 1);
    assert!(lines.contains(report["auto"]["why"].as_str().unwrap()));
    for adapter in report["adapters"].as_array().unwrap() {
        assert!(lines.contains(adapter["name"].as_str().unwrap()), "{lines}");
    }
}
