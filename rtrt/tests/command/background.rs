//! What is behind everything.

use crate::folder::{Folder, code, stderr, stdout};
use std::fs;

/// Half of the picture is a square, and half is nothing.
const LINE: &str =
    "render half.obj --size 16x8 --samples 4 --backend cpu --eye 0,0,5 --look-at 0,0,0 --fov-y 60";

fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    let square = "v -9 -9 0\nv 0.2 -9 0\nv 0.2 9 0\nv -9 9 0\nf 1 2 3 4\n";
    fs::write(folder.0.join("half.obj"), square).unwrap();
    // A panorama of 4 x 2 pixels, all of them green.
    let mut hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    hdr.extend([0, 128, 0, 128].repeat(8));
    fs::write(folder.0.join("green.hdr"), hdr).unwrap();
    folder
}

fn pixels(folder: &Folder, options: &str) -> Vec<[u8; 4]> {
    stdout(&folder.run(&format!("{LINE} -o out.png {options}")));
    let picture = image::open(folder.0.join("out.png")).unwrap().into_rgba8();
    picture.pixels().map(|pixel| pixel.0).collect()
}

#[test]
fn a_color_takes_the_place_of_the_usual_one() {
    let folder = folder("color");
    let (usual, red) = (pixels(&folder, ""), pixels(&folder, "--background 1,0,0"));
    assert_eq!((usual[0], usual[15][3]), (red[0], 255));
    assert_ne!(usual[15], red[15]);
    assert_eq!(red[15], [255, 0, 0, 255]);
    let black = pixels(&folder, "--environment green.hdr --background 0,0,0");
    let green = pixels(&folder, "--environment green.hdr");
    assert_eq!(green, pixels(&folder, "--environment green.hdr --background env"));
    assert_eq!((black[15], black[0]), ([0, 0, 0, 255], green[0]));
    assert!(green[15][1] > 100);
}

#[test]
fn transparent_is_an_alpha_of_0_where_nothing_is_hit() {
    let folder = folder("transparent");
    let (usual, clear) = (pixels(&folder, ""), pixels(&folder, "--background transparent"));
    let alphas: Vec<u8> = clear.iter().map(|pixel| pixel[3]).collect();
    assert_eq!((alphas[0], alphas[15]), (255, 0));
    assert!(alphas.iter().any(|alpha| [64, 128, 191].contains(alpha)), "no edge: {alphas:?}");
    for (usual, clear) in usual.iter().zip(&clear) {
        assert!(clear[3] != 255 || usual == clear);
        assert!(clear[3] != 0 || *clear == [0; 4]);
    }
    // In 16 bits and as numbers it is the same.
    stdout(&folder.run(&format!("{LINE} --background transparent -o 16.png --bits 16")));
    let wide = image::open(folder.0.join("16.png")).unwrap().into_rgba16();
    assert_eq!(wide.pixels().map(|p| ((u32::from(p.0[3]) + 128) / 257) as u8).collect::<Vec<_>>(), alphas);
    stdout(&folder.run(&format!("{LINE} --background transparent -o out.exr")));
    let exr = exr::prelude::read_all_flat_layers_from_file(folder.0.join("out.exr")).unwrap();
    let channels = &exr.layer_data[0].channel_data.list;
    let alpha = channels.iter().find(|channel| channel.name.eq("A")).unwrap();
    let exr::prelude::FlatSamples::F32(samples) = &alpha.sample_data else { panic!("not numbers") };
    assert_eq!(samples.iter().map(|a| (a * 255.0 + 0.5) as u8).collect::<Vec<_>>(), alphas);
}

#[test]
fn backgrounds_that_make_no_sense_are_wrong_usage() {
    let folder = folder("nonsense");
    for wrong in
        ["-1,0,0", "1,2", "checker", "env --environment none", "transparent --debug depth", "nan,0,0"]
    {
        let output = folder.run(&format!("{LINE} -o out.png --background {wrong}"));
        assert_eq!(code(&output), 2, "{wrong}: {}", stderr(&output));
    }
}

#[test]
fn what_is_behind_everything_is_seen_through_panes() {
    let folder = folder("panes");
    fs::write(folder.0.join("half.mtl"), "newmtl pane\nKd 0 0 0\nd 0.5\n").unwrap();
    let square = "mtllib half.mtl\nusemtl pane\nv -9 -9 0\nv 0.2 -9 0\nv 0.2 9 0\nv -9 9 0\nf 1 2 3 4\n";
    fs::write(folder.0.join("half.obj"), square).unwrap();
    let line = "--environment green.hdr --background";
    let [black, red] = ["0,0,0", "1,0,0"].map(|color| pixels(&folder, &format!("{line} {color}")));
    assert_eq!((black[15], red[15]), ([0, 0, 0, 255], [255, 0, 0, 255]));
    // Half of the red comes through, and what the pane itself mirrors stays.
    assert!(red[0][0] > 180 && red[0][1..] == black[0][1..], "{:?} {:?}", red[0], black[0]);
    assert!(pixels(&folder, &format!("{line} env"))[0][1] > black[0][1] + 50);
    let clear = pixels(&folder, &format!("{line} transparent"));
    assert_eq!((clear[0][3], clear[15]), (128, [0; 4]));
    // In front of red it is what was rendered in front of red.
    let wide = pixels(&folder, "--background transparent");
    let [over, plain] = [pixels(&folder, "--background 0,0,0"), wide];
    assert_eq!((over[0][3], plain[0][3]), (255, 128));
}
