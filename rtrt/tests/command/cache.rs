//! Trees of meshes that are kept.

use crate::folder::{Folder, code, stderr, stdout};
use std::fs;

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
