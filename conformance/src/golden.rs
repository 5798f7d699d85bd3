//! Hashes of frames in the repository: they compare machines that never meet.
//!
//! `golden.txt` has a line for each buffer of each scene of [`scenes`]: the scene, the buffer, and the SHA-256 of what
//! the [`crate::reference()`] makes of it. After a change that is meant to change pictures (or a buffer):
//!
//! ```text
//! cargo run --release -p conformance -- --regenerate
//! ```

use conformance_cases::{Case, cases};
use rtrt_core::backend::Picture;
use rtrt_core::scene::Sequential;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::LazyLock;

/// Some of the cases: about one for each kernel and way of moving.
const CASES: &[&str] = &[
    "camera/four_samples",
    "camera/sixteen_samples",
    "camera/parallel",
    "bin/many_small",
    "visibility/one_triangle",
    "visibility/dense",
    "surface/smooth_normals",
    "texture/minified_at_a_grazing_angle",
    "material/normal_map",
    "shadow/point",
    "light/spot",
    "environment/mirrored",
    "transparency/four_samples",
    "motion/reshaped",
    "soft/four_samples",
    "area/sixteen_points_jittered",
    "sphere/among_meshes",
];

/// Each buffer, with the stage that fills it.
const STAGES: [(&str, &str); 11] = [
    ("lists", "bin"),
    ("hits", "visibility"),
    ("surfaces", "surface"),
    ("left", "occlusion"),
    ("penumbras", "occlusion"),
    ("masks", "occlusion"),
    ("tints", "occlusion"),
    ("lit", "light"),
    ("layers", "layers"),
    ("colors", "shade"),
    ("pixels", "resolve"),
];

/// What the file begins with.
const HEADER: &str = "\
# SHA-256 of what the reference makes of the scenes in conformance/src/golden.rs: scene, buffer, hash.
# Written by: cargo run --release -p conformance -- --regenerate
";

/// Hashes of buffers, by scene and buffer.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Golden(BTreeMap<(String, String), String>);

/// A buffer that has another hash.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Changed {
    /// The scene.
    pub scene: String,
    /// The stage that fills the buffer.
    pub stage: &'static str,
    /// The buffer.
    pub buffer: &'static str,
    /// The hash in the file; empty if it is not there.
    pub expected: String,
    /// The hash here; empty if the scene is no longer there.
    pub actual: String,
}

/// A file that holds no hashes.
#[derive(Debug, thiserror::Error)]
#[error("line {line} is not a scene, a buffer and a hash")]
pub struct Malformed {
    /// Its number, from 1.
    pub line: usize,
}

/// The scenes with stored hashes: some cases, and the demo scenes of `rtrt`.
///
/// # Panics
/// A case has another name now.
pub fn scenes() -> &'static [Case] {
    static SCENES: LazyLock<Vec<Case>> = LazyLock::new(|| {
        let named = |name: &&str| *cases::named(name).unwrap_or_else(|| panic!("there is no case {name}"));
        let demo = |name, scene, camera| Case {
            name,
            claim: "A scene with everything in it is the same everywhere.",
            scene,
            camera,
            size: [96, 54],
            samples: 4,
            ..Case::USUAL
        };
        let [matchbox, glass] = [rtrt::demo::matchbox(&Sequential), rtrt::demo::glass(&Sequential)]
            .map(|loaded| loaded.expect("a scene without files").camera);
        let demos = [
            demo("demo:matchbox", || rtrt::demo::matchbox(&Sequential).expect("no file").scene, matchbox),
            demo("demo:glass", || rtrt::demo::glass(&Sequential).expect("no file").scene, glass),
        ];
        CASES.iter().map(named).chain(demos).collect()
    });
    &SCENES
}

/// Where the repository keeps the hashes.
pub fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("golden.txt")
}

impl Golden {
    /// The hashes that the repository had when this was built.
    pub fn committed() -> &'static str {
        include_str!("../golden.txt")
    }

    /// Reads a file's text.
    ///
    /// # Errors
    /// A line that is no comment lacks three words.
    pub fn parse(text: &str) -> Result<Self, Malformed> {
        let mut golden = Self::default();
        for (line, words) in (1..).zip(text.lines()).filter(|(_, line)| !line.starts_with('#')) {
            let words: Vec<&str> = words.split_whitespace().collect();
            let [scene, buffer, hash] = words[..] else { return Err(Malformed { line }) };
            golden.0.insert((scene.into(), buffer.into()), hash.into());
        }
        Ok(golden)
    }

    /// The hashes of the scenes whose names contain this.
    pub fn only(mut self, part: &str) -> Self {
        self.0.retain(|(scene, _), _| scene.contains(part));
        self
    }

    /// Adds a scene's picture.
    pub fn add(&mut self, scene: &str, picture: &Picture) {
        let buffers = rtrt::hash::buffers(picture).into_iter().flatten();
        for (buffer, hash) in buffers.chain([("pixels", rtrt::hash::pixels(picture))]) {
            self.0.insert((scene.into(), buffer.into()), hash);
        }
    }

    /// The text of a file with these hashes.
    pub fn text(&self) -> String {
        let lines = self.0.iter().map(|((scene, buffer), hash)| format!("{scene} {buffer} {hash}\n"));
        HEADER.chars().chain(lines.collect::<String>().chars()).collect()
    }

    /// The first buffer of each scene, in the order of the stages, that has another hash in `actual`: its stage is
    /// to blame.
    pub fn changes(&self, actual: &Self) -> Vec<Changed> {
        let mut scenes: Vec<&String> = self.0.keys().chain(actual.0.keys()).map(|(scene, _)| scene).collect();
        scenes.sort_unstable();
        scenes.dedup();
        let changed = |scene: &String| {
            STAGES.iter().find_map(|&(buffer, stage)| {
                let [expected, actual] = [self, actual]
                    .map(|golden| golden.0.get(&(scene.clone(), buffer.into())).cloned().unwrap_or_default());
                let scene = scene.clone();
                (expected != actual).then_some(Changed { scene, stage, buffer, expected, actual })
            })
        };
        scenes.into_iter().filter_map(changed).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// A name that only one side has would compare nothing with nothing.
    #[test]
    fn the_buffers_of_pictures_and_of_the_file_are_those_of_the_stages() {
        let stages = BTreeSet::from(STAGES.map(|(buffer, _)| buffer.to_owned()));
        let mut picture = Golden::default();
        picture.add("empty", &Picture { deferred: Some(Default::default()), ..Picture::default() });
        for golden in [Golden::parse(Golden::committed()).unwrap(), picture] {
            assert_eq!(golden.0.into_keys().map(|(_, buffer)| buffer).collect::<BTreeSet<_>>(), stages);
        }
    }

    #[test]
    fn every_buffer_with_another_hash_is_found() {
        let golden = Golden::parse(Golden::committed()).unwrap();
        for (buffer, stage) in STAGES {
            let mut other = golden.clone();
            other.0.insert(("demo:glass".into(), buffer.into()), "another".into());
            let [Changed { stage: found, .. }] = &golden.changes(&other)[..] else { panic!("{buffer}") };
            assert_eq!(*found, stage);
        }
    }
}
