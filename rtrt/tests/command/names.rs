//! Names of files with places to fill in.

use crate::folder::{Folder, code, stderr, stdout};

#[test]
fn names_are_filled_in_and_every_frame_has_its_own() {
    let folder = Folder::new("names");
    let line = "render scene.obj --size 8x8 --backend cpu --frames 2";
    stdout(&folder.run(&format!("{line} -o {{scene}}-{{n}}.png --aov {{scene}}.{{frame}}.exr")));
    let mut files = folder.files();
    files.sort();
    assert_eq!(files, ["scene-0.png", "scene-1.png", "scene.0000.exr", "scene.0001.exr"]);
    let output = folder.run(&format!("{line} -o {{scene}}.png"));
    assert!(code(&output) == 2 && stderr(&output).contains("{n}"), "{}", stderr(&output));
    let output = folder.run(&format!("{line} -o {{scene}}-{{frmae}}.png"));
    let said = stderr(&output);
    assert!(said.contains("unknown placeholder: {scene}-{frmae}.png: nothing is called {frmae}"), "{said}");
    assert!(said.contains("hint: names of files may contain {scene}, {camera}, {frame}, {n}"), "{said}");
    stdout(&folder.run("render demo:glass --size 8x8 --backend cpu -o {scene}.png"));
    assert!(folder.0.join("glass.png").is_file());
}
