//! File names with placeholders.

use super::Error;
use std::path::{Path, PathBuf};

/// What stands in braces in names of files.
const PLACEHOLDERS: [&str; 4] = ["scene", "camera", "frame", "n"];

/// Fills in `{scene}`, `{camera}`, `{n}` and `{frame}`.
pub fn filled(path: &Path, scene: &Path, camera: &str, frame: u32) -> PathBuf {
    let Some(name) = path.to_str() else { return path.to_owned() };
    let scene = match scene.to_str() {
        Some("-") => "stdin".into(),
        Some(demo) if demo.starts_with("demo:") => demo["demo:".len()..].into(),
        _ => scene.file_stem().unwrap_or_default().to_string_lossy(),
    };
    name.replace("{scene}", &scene)
        .replace("{camera}", camera)
        .replace("{n}", &frame.to_string())
        .replace("{frame}", &format!("{frame:04}"))
        .into()
}

/// Whether the name differs from camera to camera.
pub fn has_camera(path: &Path) -> bool {
    path.to_str().is_some_and(|name| name.contains("{camera}"))
}

/// Whether the name differs from frame to frame.
pub fn is_numbered(path: &Path) -> bool {
    path.to_str().is_some_and(|name| name.contains("{n}") || name.contains("{frame}"))
}

/// Checks that the name has no other word in braces.
pub fn check(path: &Path) -> Result<(), Error> {
    match path.to_str().and_then(unknown) {
        None => Ok(()),
        Some(word) => Err(Error::Line {
            what: format!("unknown placeholder: {}: nothing is called {{{word}}}", path.display()),
            hint: format!("names of files may contain {{{}}}", PLACEHOLDERS.join("}, {")),
        }),
    }
}

/// The first word in braces that is no placeholder.
fn unknown(name: &str) -> Option<&str> {
    let words = name.split('{').skip(1).filter_map(|rest| rest.split_once('}')).map(|(word, _)| word);
    words.into_iter().find(|word| !PLACEHOLDERS.contains(word))
}

#[test]
fn placeholders_are_filled_in() {
    let name = |path: &str, scene: &str| filled(path.as_ref(), scene.as_ref(), "left", 7);
    assert_eq!(name("out/{scene}-{n}-{frame}.png", "a/box.v2.glb"), Path::new("out/box.v2-7-0007.png"));
    assert_eq!(name("{scene}.png", "demo:glass"), Path::new("glass.png"));
    assert_eq!(name("{camera}/{n}.png", "a.glb"), Path::new("left/7.png"));
    assert_eq!(name("{scene}.png", "-"), Path::new("stdin.png"));
    assert!(is_numbered("a{n}.png".as_ref()) && !is_numbered("{scene}.png".as_ref()));
}

#[test]
fn unknown_words_in_braces_are_found() {
    assert_eq!(unknown("{scene}-{frame}{n}.png"), None);
    assert_eq!(unknown("a}b{c.png"), None);
    assert_eq!(unknown("{scene}-{frmae}.png"), Some("frmae"));
    assert_eq!(unknown("{}.png"), Some(""));
}
