//! File names with placeholders.

use std::path::{Path, PathBuf};

/// Fills in `{scene}`, `{n}` and `{frame}`.
pub fn filled(path: &Path, scene: &Path, frame: u32) -> PathBuf {
    let Some(name) = path.to_str() else { return path.to_owned() };
    let scene = match scene.to_str().and_then(|scene| scene.strip_prefix("demo:")) {
        Some(demo) => demo.into(),
        None => scene.file_stem().unwrap_or_default().to_string_lossy(),
    };
    name.replace("{scene}", &scene)
        .replace("{n}", &frame.to_string())
        .replace("{frame}", &format!("{frame:04}"))
        .into()
}

/// Whether the name differs from frame to frame.
pub fn is_numbered(path: &Path) -> bool {
    path.to_str().is_some_and(|name| name.contains("{n}") || name.contains("{frame}"))
}

#[test]
fn placeholders_are_filled_in() {
    let name = |path: &str, scene: &str| filled(path.as_ref(), scene.as_ref(), 7);
    assert_eq!(name("out/{scene}-{n}-{frame}.png", "a/box.v2.glb"), Path::new("out/box.v2-7-0007.png"));
    assert_eq!(name("{scene}.png", "demo:glass"), Path::new("glass.png"));
    assert!(is_numbered("a{n}.png".as_ref()) && !is_numbered("{scene}.png".as_ref()));
}
