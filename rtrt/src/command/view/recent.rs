//! The files that were opened last.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// So many are kept.
const KEPT: usize = 10;

/// A list of files, newest first, in a file of its own.
#[derive(Debug, Default)]
pub struct Recent {
    /// The file of the list; none where the system has no place for it.
    path: Option<PathBuf>,
    pub files: Vec<PathBuf>,
}

impl Recent {
    /// The list of this user.
    pub fn read() -> Self {
        let path = folder().map(|folder| folder.join("rtrt").join("recent.txt"));
        let text = path.as_ref().and_then(|path| fs::read_to_string(path).ok()).unwrap_or_default();
        Self { path, files: text.lines().map(PathBuf::from).take(KEPT).collect() }
    }

    /// Puts a file in front, and writes the list.
    pub fn add(&mut self, file: &Path) -> io::Result<()> {
        if !file.is_file() {
            return Ok(());
        }
        let file = std::path::absolute(file)?;
        self.files.retain(|known| *known != file);
        self.files.insert(0, file);
        self.files.truncate(KEPT);
        let Some(path) = &self.path else { return Ok(()) };
        fs::create_dir_all(path.parent().unwrap_or(Path::new("")))?;
        // A name with a line break would be two.
        let lines = self.files.iter().filter_map(|file| file.to_str()).filter(|name| !name.contains('\n'));
        fs::write(path, lines.map(|name| format!("{name}\n")).collect::<String>())
    }
}

/// The folder in which programs of this user keep what they remember.
fn folder() -> Option<PathBuf> {
    let named = |name| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    if cfg!(windows) {
        return named("LOCALAPPDATA");
    }
    let home = named("HOME");
    if cfg!(target_os = "macos") {
        return home.map(|home| home.join("Library/Application Support"));
    }
    named("XDG_STATE_HOME").or(home.map(|home| home.join(".local/state")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_file_comes_first_and_once() {
        let folder = env::temp_dir().join(format!("rtrt-recent-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let files: Vec<_> = (0..12).map(|number| folder.join(format!("{number}.obj"))).collect();
        files.iter().for_each(|file| fs::write(file, "").unwrap());
        let list = folder.join("state/recent.txt");
        let mut recent = Recent { path: Some(list.clone()), files: Vec::new() };
        for file in files.iter().chain([&files[5]]) {
            recent.add(file).unwrap();
        }
        recent.add(&folder.join("gone.obj")).unwrap();
        assert_eq!(recent.files.len(), KEPT);
        assert_eq!(recent.files[..2], [files[5].clone(), files[11].clone()]);
        assert_eq!(fs::read_to_string(&list).unwrap().lines().count(), KEPT);
        fs::remove_dir_all(&folder).unwrap();
    }
}
