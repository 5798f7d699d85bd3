//! Frames whose closest surfaces are drawn.

use crate::folder::{Folder, code, stderr, stdout};

#[test]
fn the_cpu_draws_nothing() {
    let folder = Folder::new("hybrid-cpu");
    for command in ["render -o out.png", "bench"] {
        let output = folder.run(&format!("{command} scene.obj --size 8x8 --backend cpu --hybrid"));
        assert_eq!(code(&output), 4, "{}", stderr(&output));
        assert!(stderr(&output).contains("hybrid frames are drawn by a GPU"), "{}", stderr(&output));
    }
    assert_eq!(code(&folder.run("verify scene.obj --hybrid")), 2);
    assert_eq!(folder.files(), [""; 0]);
}

#[test]
fn a_gpu_draws_what_it_else_traces() {
    let folder = Folder::new("hybrid-gpu");
    let line = "scene.obj --size 64x36 --backend gpu --hybrid";
    let output = folder.run(&format!("render {line} -o drawn.png --samples 1"));
    if code(&output) == 4 && std::env::var("RTRT_REQUIRE_GPU").as_deref() != Ok("1") {
        return println!("skipped: {}", stderr(&output));
    }
    stdout(&output);
    assert!(stderr(&output).contains("surfaces drawn"), "{}", stderr(&output));
    stdout(&folder.run("render scene.obj --size 64x36 --backend cpu --samples 1 -o traced.png"));
    let [drawn, traced] =
        ["drawn.png", "traced.png"].map(|name| image::open(folder.0.join(name)).unwrap().into_rgba8());
    let different = drawn.pixels().zip(traced.pixels()).filter(|(a, b)| a != b).count();
    assert!(different < 20, "{different} pixels");
    assert!(stdout(&folder.run(&format!("bench {line} --frames 1"))).contains("visibility"));
}
