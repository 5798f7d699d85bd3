//! Environments from the six pictures of a cube.

use crate::folder::{Folder, code, stderr, stdout};
use image::{Rgb, RgbImage, imageops};

/// Rows and columns of a picture.
const SIDE: u32 = 16;
/// The names of the pictures, where they are seen, and what is then up.
const FACES: [(&str, [i32; 3], [i32; 3]); 6] = [
    ("px", [1, 0, 0], [0, 1, 0]),
    ("nx", [-1, 0, 0], [0, 1, 0]),
    ("py", [0, 1, 0], [0, 0, 1]),
    ("ny", [0, -1, 0], [0, 0, -1]),
    ("pz", [0, 0, -1], [0, 1, 0]),
    ("nz", [0, 0, 1], [0, 1, 0]),
];

/// The color of a quarter of a picture: left or right, above or below.
fn color(face: u32, right: bool, below: bool) -> [u8; 3] {
    [40 * face as u8, 80 + 100 * u8::from(right), 60 + 150 * u8::from(below)]
}

fn face(number: u32) -> RgbImage {
    RgbImage::from_fn(SIDE, SIDE, |x, y| Rgb(color(number, x >= SIDE / 2, y >= SIDE / 2)))
}

/// The pictures in one.
fn together(columns: u32, rows: u32, places: [[u32; 2]; 6]) -> RgbImage {
    let mut all = RgbImage::new(columns * SIDE, rows * SIDE);
    for (number, [x, y]) in (0..).zip(places) {
        let face = if rows == 4 && number == 5 { imageops::rotate180(&face(5)) } else { face(number) };
        imageops::replace(&mut all, &face, i64::from(x * SIDE), i64::from(y * SIDE));
    }
    all
}

fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    std::fs::create_dir(folder.0.join("cube")).unwrap();
    for (number, (name, ..)) in (0..).zip(FACES) {
        face(number).save(folder.0.join(format!("cube/{name}.png"))).unwrap();
    }
    folder
}

/// What is seen in a direction, far above the scene.
fn seen(folder: &Folder, direction: [i32; 3], up: [i32; 3], environment: &str) -> RgbImage {
    let [x, y, z] = direction;
    let [u, v, w] = up;
    stdout(&folder.run(&format!(
        "render scene.obj -o out.png --backend cpu --size 8x8 --samples 1 --fov-y 60 --eye 0,900,0 \
         --look-at {x},{},{z} --up {u},{v},{w} --tone-map none --environment {environment}",
        y + 900
    )));
    image::open(folder.0.join("out.png")).unwrap().into_rgb8()
}

#[test]
fn each_picture_is_seen_where_it_should_be_and_not_mirrored() {
    let folder = folder("cube_sides");
    for (number, (name, direction, up)) in (0..).zip(FACES) {
        let picture = seen(&folder, direction, up, "cube");
        for (right, below) in [(false, false), (true, false), (false, true), (true, true)] {
            let at = |far: bool| if far { 6 } else { 1 };
            let found = picture.get_pixel(at(right), at(below)).0;
            let wanted = color(number, right, below);
            let is_near = found.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) <= 2);
            assert!(is_near, "{name}, right {right}, below {below}: {found:?} {wanted:?}");
        }
    }
}

#[test]
fn strips_and_crosses_are_the_same_cube() {
    let folder = folder("cube_shapes");
    let hash = |environment: &str| {
        let line = "render scene.obj --size 16x16 --samples 1 --backend cpu --hash --environment";
        stdout(&folder.run(&format!("{line} {environment}")))
    };
    let row = [0, 1, 2, 3, 4, 5];
    let shapes = [
        ("row.png", together(6, 1, row.map(|i| [i, 0]))),
        ("column.png", together(1, 6, row.map(|i| [0, i]))),
        ("cross.png", together(4, 3, [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]])),
        ("upright.png", together(3, 4, [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [1, 3]])),
    ];
    let cube = hash("cube");
    for (name, picture) in &shapes {
        picture.save(folder.0.join(name)).unwrap();
        assert_eq!(hash(name), cube, "{name}");
    }
    // In another order it is another one.
    together(6, 1, [1, 0, 2, 3, 4, 5].map(|i| [i, 0])).save(folder.0.join("other.png")).unwrap();
    assert_ne!(hash("other.png"), cube);
    // A picture of 2:1 is a panorama.
    imageops::crop_imm(&shapes[0].1, 0, 0, 32, 16).to_image().save(folder.0.join("around.png")).unwrap();
    assert_ne!(hash("around.png"), cube);
}

#[test]
fn pictures_that_are_no_cube_are_refused_by_name() {
    let refused = |change: &dyn Fn(&std::path::Path), why: &str| {
        let folder = folder("cube_refused");
        change(&folder.0.join("cube"));
        let output = folder.run("render scene.obj -o out.png --size 8x8 --environment cube");
        assert_eq!(code(&output), 3, "{}", stderr(&output));
        assert!(stderr(&output).contains(why), "{}", stderr(&output));
    };
    refused(&|cube| std::fs::remove_file(cube.join("ny.png")).unwrap(), "cube: it has no picture ny (.hdr");
    refused(
        &|cube| RgbImage::new(4, 3).save(cube.join("px.png")).unwrap(),
        "px.png: pictures of a cube are square, and this one has 4 x 3 pixels",
    );
    refused(
        &|cube| RgbImage::new(4, 4).save(cube.join("nz.png")).unwrap(),
        "nz.png: it has 4 columns, but cube/px.png has 16",
    );
    refused(&|cube| std::fs::write(cube.join("pz.png"), "no picture").unwrap(), "pz.png: it is not in the");
}

#[test]
fn pictures_of_other_shapes_are_refused_with_the_shapes_there_are() {
    let folder = folder("cube_photograph");
    let cross = || together(4, 3, [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]]);
    let said = |picture: RgbImage, name: &str| {
        picture.save(folder.0.join(name)).unwrap();
        let line = "render scene.obj --size 8x8 --samples 1 --backend cpu --hash --environment";
        let output = folder.run(&format!("{line} {name}"));
        (code(&output), stderr(&output))
    };
    assert_eq!(said(cross(), "cross.jpg").0, 0);
    // Empty may be white.
    let mut white = cross();
    white.pixels_mut().filter(|pixel| pixel.0 == [0; 3]).for_each(|pixel| pixel.0 = [255; 3]);
    assert_eq!(said(white, "white.jpg").0, 0);
    let mut photograph = cross();
    photograph.put_pixel(3 * SIDE + SIDE / 2, 2 * SIDE + SIDE / 2, Rgb([90, 90, 90]));
    let (code, error) = said(photograph, "photograph.png");
    assert!(code == 3 && error.contains("photograph.png: it is 4:3, as a cube unfolded"), "{error}");
    assert!(error.contains("not empty beside the cross, at 48,32; a panorama is 2:1"), "{error}");
    let (code, error) = said(RgbImage::new(16, 9), "wide.png");
    assert!(code == 3 && error.contains("it has 16 x 9 pixels; a panorama is 2:1, a cube 6:1"), "{error}");
}
