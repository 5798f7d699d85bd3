//! A folder to run the command in, and what it gives back.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of the test's own, with a scene in it: `scene.obj`, a triangle on a floor.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new(test: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
        fs::remove_dir_all(&path).ok();
        fs::create_dir_all(&path).unwrap();
        let scene = "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nv -1 0.5 0\nv 1 0.5 0\nv 0 2 0\n\
                     f 4 3 2 1\nf 5 6 7\n";
        fs::write(path.join("scene.obj"), scene).unwrap();
        Self(path)
    }

    /// Runs the command here. `line` is split at white space.
    pub fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rtrt"));
        command
            .current_dir(&self.0)
            .args(line.split_whitespace())
            .env_remove("RTRT_REQUIRE_GPU")
            .env_remove("RTRT_CONFIG");
        command
    }

    /// What lies in the folder, but for the scene.
    pub fn files(&self) -> Vec<String> {
        let names = fs::read_dir(&self.0).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name != "scene.obj").collect()
    }
}

pub fn code(output: &Output) -> i32 {
    output.status.code().expect("ended by a signal")
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// What a run printed, which must have ended well.
pub fn stdout(output: &Output) -> String {
    assert_eq!(code(output), 0, "{}", stderr(output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub fn json(output: &Output) -> Value {
    serde_json::from_str(&stdout(output)).unwrap()
}

pub fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<_> = value.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}
