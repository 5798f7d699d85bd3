//! Pictures compared with files.

use crate::folder::{Folder, code, stderr, stdout};
use std::fs;

const LINE: &str = "render scene.obj --size 20x10 --backend cpu";

#[test]
fn the_same_picture_is_equal_and_another_is_exit_code_5() {
    let folder = Folder::new("compare");
    stdout(&folder.run(&format!("{LINE} -o reference.png")));
    stdout(&folder.run(&format!("{LINE} --compare reference.png")));
    // A step of red more in one pixel.
    let mut picture = image::open(folder.0.join("reference.png")).unwrap().into_rgba8();
    picture.get_pixel_mut(7, 3).0[0] += 1;
    let [is, _, _, _] = picture.get_pixel(7, 3).0;
    picture.save(folder.0.join("other.png")).unwrap();
    let output = folder.run(&format!("{LINE} --compare other.png"));
    assert_eq!(code(&output), 5);
    let said = stderr(&output);
    assert!(said.contains("error: pictures differ: other.png: 1 pixels, the first at 7,3: is ["), "{said}");
    assert!(said.contains(&format!("is [{}, ", is - 1)) && said.contains("hint: --tolerance"), "{said}");
    assert!(said.contains("difference: other.difference.png and other.difference.json"), "{said}");
    let shown = image::open(folder.0.join("other.difference.png")).unwrap().into_rgba8();
    let is_red = |at: [u32; 2]| shown.get_pixel(at[0], at[1]).0[0] > 200;
    assert!(is_red([7, 3]) && !is_red([6, 3]) && !is_red([7, 4]));
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.0.join("other.difference.json")).unwrap()).unwrap();
    assert_eq!([&report["pixels"], &report["most"]], [1, 1]);
    assert_eq!(report["bounds"], serde_json::json!([7, 3, 8, 4]));
    assert!(report["picture"].is_null() && report["hash"] != report["expected_hash"]);
    stdout(&folder.run(&format!("{LINE} --compare other.png --tolerance 1")));
    // Beside the picture, if there is one.
    assert_eq!(code(&folder.run(&format!("{LINE} --compare other.png -o mine.png"))), 5);
    assert!(folder.0.join("mine.png").is_file() && folder.0.join("mine.difference.json").is_file());
    let output =
        folder.run("render scene.obj --size 21x10 --backend cpu --compare other.png --tolerance 255");
    assert_eq!(code(&output), 5);
    assert!(stderr(&output).contains("it has 20 x 10 pixels, the frame 21 x 10"), "{}", stderr(&output));
}

#[test]
fn a_reference_that_cannot_be_read_is_exit_code_3() {
    let folder = Folder::new("reference");
    fs::write(folder.0.join("broken.png"), "PNG, but not really").unwrap();
    for reference in ["missing.png", "broken.png"] {
        let output = folder.run(&format!("{LINE} --compare {reference}"));
        assert_eq!(code(&output), 3, "{}", stderr(&output));
        assert!(stderr(&output).contains(&format!("error: cannot read the picture: {reference}: ")));
    }
    assert_eq!(code(&folder.run(&format!("{LINE} -o out.png --tolerance 1"))), 2);
}
