//! What surrounds a scene: the studio, panoramas that are turned, and their suns.

use crate::folder::{Folder, code, stderr, stdout};
use exr::prelude::write_rgb_file;
use std::fs;

const LINE: &str =
    "render scene.obj --size 48x32 --samples 1 --backend cpu --eye 0,3,6 --look-at 0,0.5,0 --tone-map none";

fn pixels(folder: &Folder, options: &str) -> Vec<[u8; 4]> {
    drawn(folder, &format!("{LINE} {options}"))
}

fn drawn(folder: &Folder, line: &str) -> Vec<[u8; 4]> {
    stdout(&folder.run(&format!("{line} -o out.png")));
    let picture = image::open(folder.0.join("out.png")).unwrap().into_rgba8();
    picture.pixels().map(|pixel| pixel.0).collect()
}

/// A panorama in the Radiance format, of texels that it can hold: powers of two.
fn hdr(width: usize, height: usize, texel: impl Fn(usize, usize) -> [i32; 3]) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let exponents = texel(x, y);
        let most = *exponents.iter().max().unwrap();
        // A mantissa of 128 is a half.
        bytes.extend(exponents.map(|e| (128_u32 >> (most - e).min(8)) as u8));
        bytes.push((most + 1 + 128) as u8);
    }
    bytes
}

/// Each quarter of the horizon has a brightness of its own.
fn quarters(x: usize, _: usize) -> [i32; 3] {
    [[-1, -2, -3], [-4, -1, -2], [-2, -3, -1], [-3, -4, -5]][x / 4]
}

#[test]
fn a_scene_without_light_is_in_the_studio() {
    let folder = Folder::new("studio");
    let usual = pixels(&folder, "");
    assert_eq!(usual, pixels(&folder, "--environment studio"));
    let [none, lamp, ambient] =
        ["--environment none", "--light point:1,3,2", "--ambient 0.5,0.5,0.5"].map(|o| pixels(&folder, o));
    for other in [&none, &lamp, &ambient] {
        assert_ne!(usual, *other);
    }
    // With lights, the studio is asked for, and its key light stays away.
    assert_ne!(pixels(&folder, "--light point:1,3,2 --environment studio"), lamp);
    assert_ne!(usual, pixels(&folder, "--environment-sun drop"));
    assert_ne!(usual, pixels(&folder, "--environment-blur 0"));
    // It is neutral, and neither dark nor clipped.
    let is_gray = |pixel: &[u8; 4]| pixel[0].abs_diff(pixel[1]) <= 1 && pixel[1].abs_diff(pixel[2]) <= 1;
    assert!(usual.iter().all(is_gray));
    let white = usual.iter().filter(|pixel| pixel[0] >= 250).count();
    let mean = usual.iter().map(|pixel| u32::from(pixel[0])).sum::<u32>() / usual.len() as u32;
    assert!(white * 4 < usual.len() && (90..230).contains(&mean), "{white} {mean}");
}

#[test]
fn a_quarter_of_a_turn_moves_a_panorama_by_a_quarter() {
    let folder = Folder::new("turned");
    fs::write(folder.0.join("a.hdr"), hdr(16, 8, quarters)).unwrap();
    fs::write(folder.0.join("b.hdr"), hdr(16, 8, |x, y| quarters((x + 12) % 16, y))).unwrap();
    let turned = pixels(&folder, "--environment a.hdr --environment-rotation 90");
    let moved = pixels(&folder, "--environment b.hdr");
    assert_ne!(pixels(&folder, "--environment a.hdr"), moved);
    // The squares that panoramas become are filtered along their own axes.
    let off = turned.iter().zip(&moved).filter(|(a, b)| (0..3).any(|i| a[i].abs_diff(b[i]) > 3)).count();
    assert!(off * 50 < moved.len(), "{off}");
    assert_eq!(
        pixels(&folder, "--environment a.hdr --environment-rotation 0"),
        pixels(&folder, "--environment a.hdr")
    );
    let [plain, bright] = ["1", "4"].map(|factor| {
        pixels(&folder, &format!("--environment a.hdr --exposure -4 --environment-intensity {factor}"))
    });
    let raised = pixels(&folder, "--environment a.hdr --exposure -2");
    assert!(
        plain != bright && bright.iter().zip(&raised).all(|(a, b)| (0..3).all(|i| a[i].abs_diff(b[i]) <= 1))
    );
    // The blur is for the background alone.
    let [sharp, blurred] = ["0", "0.5"].map(|blur| {
        pixels(&folder, &format!("--environment a.hdr --background transparent --environment-blur {blur}"))
    });
    assert_eq!(sharp, blurred);
    assert_ne!(
        pixels(&folder, "--environment a.hdr"),
        pixels(&folder, "--environment a.hdr --environment-blur 0.5")
    );
}

#[test]
fn open_exr_holds_the_same_panorama() {
    let folder = Folder::new("exr_panorama");
    fs::write(folder.0.join("a.hdr"), hdr(16, 8, quarters)).unwrap();
    write_rgb_file(folder.0.join("a.exr"), 16, 8, |x, y| {
        let [r, g, b] = quarters(x, y).map(|e| (e as f32).exp2());
        (r, g, b)
    })
    .unwrap();
    assert_eq!(pixels(&folder, "--environment a.hdr"), pixels(&folder, "--environment a.exr"));
    fs::write(folder.0.join("broken.exr"), [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0, 1]).unwrap();
    let output = folder.run(&format!("{LINE} -o out.png --environment broken.exr"));
    assert_eq!(code(&output), 3, "{}", stderr(&output));
    assert!(stderr(&output).starts_with("error: environment refused: broken.exr: "), "{}", stderr(&output));
}

#[test]
fn the_sun_of_a_panorama_casts_shadows_and_is_not_counted_twice() {
    let folder = Folder::new("sun_in_panorama");
    // A floor without anything on it.
    fs::write(folder.0.join("scene.obj"), "v -9 0 -9\nv 9 0 -9\nv 9 0 9\nv -9 0 9\nf 4 3 2 1\n").unwrap();
    let sun =
        |x: usize, y: usize| if (20..22).contains(&x) && (6..8).contains(&y) { [10; 3] } else { [-3; 3] };
    fs::write(folder.0.join("sun.hdr"), hdr(64, 32, sun)).unwrap();
    let options = |how: &str| format!("--environment sun.hdr --exposure -6 --environment-sun {how}");
    let [light, keep, drop] = ["light", "keep", "drop"].map(|how| pixels(&folder, &options(how)));
    let middle = |pixels: &[[u8; 4]]| f64::from(pixels[20 * 48 + 24][1]);
    let linear = |c: f64| ((c / 255.0 + 0.055) / 1.055).powf(2.4);
    let [light, keep, drop] = [light, keep, drop].map(|pixels| linear(middle(&pixels)));
    assert!(drop < 0.5 * keep, "{drop} {keep}");
    assert!((light / keep - 1.0).abs() < 0.15, "{light} {keep}");
    // What stands on the floor has a shadow now.
    let tower = "v -9 0 -9\nv 9 0 -9\nv 9 0 9\nv -9 0 9\nf 4 3 2 1\nv -1 0 0\nv 1 0 0\nv 1 2 0\nv -1 2 0\nf 5 6 7 8\n";
    fs::write(folder.0.join("scene.obj"), tower).unwrap();
    let [light, keep] = ["light", "keep"].map(|how| linear(middle(&pixels(&folder, &options(how)))));
    assert!(light < 0.5 * keep, "{light} {keep}");
}

#[test]
fn a_ground_shows_shadows_and_nothing_else() {
    let folder = Folder::new("ground");
    // A table in the air above the origin.
    fs::write(
        folder.0.join("scene.obj"),
        "v -1 1 -1\nv 1 1 -1\nv 1 1 1\nv -1 1 1\nv 0 0 0\nf 4 3 2 1\nf 1 1 5\n",
    )
    .unwrap();
    let line = "render scene.obj --size 48x32 --samples 1 --backend cpu --tone-map none --light sun:0,1,0 \
        --background transparent --eye 0,4,0.01 --look-at 0,0,0 --fov-y 90";
    let [without, with] =
        ["", "--ground"].map(|ground| drawn(&folder, &format!("{line} --ambient 0.1,0.1,0.1 {ground}")));
    // From straight above, all of the shadow is behind the table.
    assert_eq!(with, without);
    let aside = line.replace("sun:0,1,0", "sun:1,0.5,0");
    let all = drawn(&folder, &format!("{aside} --ambient 0,0,0 --ground"));
    let part = drawn(&folder, &format!("{aside} --ambient 0.3,0.3,0.3 --ground"));
    let shadow: Vec<_> = (0..all.len()).filter(|&i| without[i][3] == 0 && all[i][3] > 0).collect();
    // Four square units of the picture's 96, but for what is behind the table and at its edges.
    assert!((20..200).contains(&shadow.len()), "{}", shadow.len());
    for &i in &shadow {
        assert_eq!((all[i], part[i][..3].to_vec()), ([0, 0, 0, 255], vec![0; 3]));
        assert!((30..250).contains(&part[i][3]), "{:?}", part[i]);
    }
    // The last layer of a ray counts as opaque, and a ground never does.
    for background in ["transparent", "0.2,0.4,0.8", "env"] {
        let line = aside.replace("--background transparent", &format!("--background {background}"));
        let [one, many] = [1, 8].map(|n| {
            drawn(&folder, &format!("{line} --environment studio --ground --transparency-depth {n}"))
        });
        assert!(one.iter().flatten().zip(many.iter().flatten()).all(|(a, b)| a.abs_diff(*b) <= 1));
        let shadow = one.iter().filter(|[r, g, b, a]| *a == 255 && r.max(g).max(b) < &8).count();
        assert!(shadow < 4, "{background}: {shadow} black pixels");
    }
    let off = drawn(&folder, &format!("{aside} --shadows off --ground"));
    assert!(off.iter().zip(&without).all(|(a, b)| a[3] == b[3]));
}
