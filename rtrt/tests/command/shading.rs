//! Sub-rays that are shaded as one.

use crate::folder::{Folder, code, stderr, stdout};

const LINE: &str = "render scene.obj --size 97x61 --backend cpu --light point:2,3,4";

/// The hash of the pixels.
fn hash(folder: &Folder, options: &str) -> String {
    let printed = stdout(&folder.run(&format!("{LINE} --hash --shading {options}")));
    printed.lines().next().expect("a line").split_whitespace().next().expect("a hash").into()
}

#[test]
fn a_color_a_triangle_is_the_same_however_it_is_asked_for() {
    let folder = Folder::new("shading");
    let pixels = hash(&folder, "pixel --samples 4 -o out.png");
    for options in ["--samples 4", "--samples 4 --lanes 8", "--samples 4 --lanes 1 --threads 1"] {
        let options = format!("pixel -o out.png {options}");
        assert_eq!(hash(&folder, &options), pixels, "{options}");
        assert_eq!(hash(&folder, &options.replace("-o out.png", "")), pixels, "{options}");
    }
    assert_ne!(hash(&folder, "sample --samples 4"), pixels);
    // A pixel of one sub-ray has one color anyway.
    assert_eq!(hash(&folder, "pixel --samples 1"), hash(&folder, "sample --samples 1"));
}

#[test]
fn a_frame_that_cannot_have_it_says_so() {
    let folder = Folder::new("shading_refused");
    let said = |options: &str| stderr(&folder.run(&format!("{LINE} --shading pixel -o out.png {options}")));
    let warning = "--shading pixel is not possible with";
    for options in ["--light-radius 0.2", "--ambient 1,1,1 --ambient-occlusion 2", "--ground"] {
        assert!(said(options).contains(warning), "{options}");
    }
    for options in ["", "--light-radius 0.2 --shadows hard", "--light-radius 0.2 --samples 1"] {
        assert!(!said(options).contains(warning), "{options}: {}", said(options));
    }
    let strict = folder.run(&format!("{LINE} --shading pixel -o strict.png --light-radius 0.2 --strict"));
    assert_eq!(code(&strict), 3);
    assert!(!folder.files().contains(&"strict.png".into()));
}
