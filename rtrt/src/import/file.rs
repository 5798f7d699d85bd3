//! Reading files: regular ones only, up to a limit.

use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap};
use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// The size limit of a file, bytes: 4 GiB.
pub(super) const LONGEST: u64 = 1 << 32;

/// The files of a scene, including missing ones.
#[derive(Debug, Clone, Default)]
pub(crate) struct Files(Rc<RefCell<Known>>);

#[derive(Debug, Default)]
struct Known {
    /// The files that were read, or that could not be.
    read: BTreeSet<PathBuf>,
    /// The files of folders, by their names in lower case.
    listings: HashMap<PathBuf, HashMap<OsString, PathBuf>>,
}

impl Files {
    /// [`read`], and adds the file to the list.
    pub fn read(&self, path: &Path, limit: u64) -> io::Result<Vec<u8>> {
        self.add(path);
        read(path, limit)
    }

    /// Adds a file that was read.
    pub fn add(&self, path: &Path) {
        self.0.borrow_mut().read.insert(path.to_owned());
    }

    /// The files in order.
    pub fn list(&self) -> Vec<PathBuf> {
        self.0.borrow().read.iter().cloned().collect()
    }

    /// The file that another file calls `name`, with a path relative to its own folder.
    ///
    /// Names come from other machines: separators may be those of Windows, names may stand in quotes, lead to a folder
    /// that exists only there, or differ in upper and lower case. The first of these that exists counts: the name as it
    /// stands, with separators of this system, its last part alone; and then the same without regard to case. Each is
    /// looked for beside the files `from`, in their order. If none exists, the result is the place where the first would
    /// be.
    pub fn beside(&self, from: &[&Path], name: &str) -> PathBuf {
        let unquoted = name.trim_matches('"');
        let separated = unquoted.replace('\\', "/");
        let last = separated.rsplit('/').next().unwrap_or_default();
        let folders = || from.iter().map(|path| path.parent().unwrap_or(Path::new("")));
        let places = || {
            let names = [name, unquoted, &separated, last].into_iter().filter(|name| !name.is_empty());
            names.flat_map(|name| folders().map(move |folder| folder.join(name)))
        };
        let found = places()
            .find(|place| place.is_file())
            .or_else(|| places().find_map(|place| self.any_case(&place)));
        found.unwrap_or_else(|| folders().next().unwrap_or(Path::new("")).join(&separated))
    }

    /// The file in the folder of `place` whose name differs from it only in upper and lower case; the first in order, if
    /// there are several.
    fn any_case(&self, place: &Path) -> Option<PathBuf> {
        let (folder, name) = (place.parent()?, place.file_name()?.to_ascii_lowercase());
        let listings = &mut self.0.borrow_mut().listings;
        let listing = listings.entry(folder.to_owned()).or_insert_with(|| {
            let mut files: Vec<PathBuf> =
                std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
            files.sort_by(|a, b| b.cmp(a));
            files
                .into_iter()
                .filter_map(|path| Some((path.file_name()?.to_ascii_lowercase(), path)))
                .collect()
        });
        listing.get(&name).filter(|path| path.is_file()).cloned()
    }
}

/// The bytes of a file of at most `limit` bytes.
///
/// # Errors
/// The file cannot be read, is longer, or is not a regular file: a pipe or a device may have no end.
pub(super) fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if !metadata.is_file() {
        let what =
            if metadata.is_dir() { "it is a folder, not a file" } else { "it is a device, not a file" };
        return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    }
    if metadata.len() > limit {
        return Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("it has {} bytes; the limit is {limit}", metadata.len()),
        ));
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    File::open(path)?.take(limit).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The file with a path relative to the folder of another one. Separators may be those of Windows.
pub(super) fn relative(path: &Path, name: &str) -> PathBuf {
    let folder = path.parent().unwrap_or(Path::new(""));
    let exact = folder.join(name);
    if name.contains('\\') && !exact.exists() { folder.join(name.replace('\\', "/")) } else { exact }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_from_other_machines_are_found() {
        let folder = std::env::temp_dir().join(format!("rtrt-beside-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("maps")).unwrap();
        let wood = folder.join("maps/Wood 1.png");
        std::fs::write(&wood, "").unwrap();
        let files = Files::default();
        let (obj, mtl) = (folder.join("a.obj"), folder.join("maps/a.mtl"));
        for name in ["maps/Wood 1.png", "maps\\Wood 1.png", "\"maps/Wood 1.png\"", "maps/wood 1.PNG"] {
            assert_eq!(files.beside(&[&obj], name), wood, "{name}");
        }
        for name in ["Wood 1.png", "C:\\Users\\me\\Wood 1.png", "/home/me/wood 1.png"] {
            assert_eq!(files.beside(&[&mtl, &obj], name), wood, "{name}");
        }
        assert_eq!(files.beside(&[&obj, &mtl], "no\\such.png"), folder.join("no/such.png"));
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn what_is_no_file_is_named() {
        let error = read(&std::env::temp_dir(), 8).unwrap_err();
        assert_eq!(error.to_string(), "it is a folder, not a file");
    }
}
