//! A cache of BVHs in files: a mesh that was loaded once loads faster.
//!
//! The name of a file is the [`Bvh::digest`] of the mesh, its content [`Bvh::to_bytes`]. A file of another mesh or
//! version, and a damaged one, is replaced by a new one.

use crate::replace::replace;
use rtrt_core::scene::{Bvh, Join, Mesh};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// A folder of BVHs.
#[derive(Debug, Clone)]
pub struct Cache {
    folder: PathBuf,
}

impl Cache {
    /// The cache in a folder. A missing folder is created.
    ///
    /// # Errors
    /// The folder cannot be created.
    pub fn new(folder: &Path) -> io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        Ok(Self { folder: folder.to_owned() })
    }

    /// The BVH of a mesh: from a valid file, else built and written. Both give the same BVH.
    ///
    /// # Errors
    /// The BVH was built but could not be written; the error comes with it.
    pub fn tree(&self, mesh: &Mesh, join: &impl Join) -> Result<Bvh, (Bvh, io::Error)> {
        let key = key(mesh);
        let path = self.path(&key);
        if let Some(tree) = read(&path, mesh, &key) {
            return Ok(tree);
        }
        let tree = Bvh::build(mesh, join);
        match replace(&path, &tree.to_bytes(&key)) {
            Ok(()) => Ok(tree),
            Err(error) => Err((tree, error)),
        }
    }

    fn path(&self, key: &[u8; 32]) -> PathBuf {
        let name: String = key.iter().map(|byte| format!("{byte:02x}")).collect();
        self.folder.join(name + ".tree")
    }
}

/// The [`Bvh::digest`] of a mesh.
fn key(mesh: &Mesh) -> [u8; 32] {
    Bvh::digest(mesh.positions(), mesh.indices())
}

/// The BVH in a file; none if the file is missing or invalid.
fn read(path: &Path, mesh: &Mesh, key: &[u8; 32]) -> Option<Bvh> {
    let file = File::open(path).ok()?;
    if !file.metadata().ok()?.is_file() {
        return None;
    }
    let mut bytes = Vec::new();
    file.take(Bvh::most_bytes(mesh.triangles()) as u64 + 1).read_to_end(&mut bytes).ok()?;
    Bvh::from_bytes(mesh.positions(), mesh.indices(), key, &bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rtrt_core::layout::Attribute;
    use rtrt_core::scene::Sequential;

    fn mesh(count: u32) -> Mesh {
        let corner = |i: u32| [(i * 37 % 101) as f32, (i * 53 % 89) as f32, (i * 29 % 97) as f32];
        let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: [0; 2] };
        let positions: Vec<_> = (0..3 * count).map(corner).collect();
        Mesh::new(positions, vec![attribute; 3 * count as usize], (0..3 * count).collect()).unwrap()
    }

    /// A cache of the test's own.
    fn cache(test: &str) -> Cache {
        let folder = std::env::temp_dir().join(format!("rtrt-cache-{test}-{}", std::process::id()));
        std::fs::remove_dir_all(&folder).ok();
        Cache::new(&folder).unwrap()
    }

    #[test]
    fn a_cached_bvh_equals_the_built_one() {
        let cache = cache("kept");
        for count in [0, 1, 2, 300] {
            let mesh = mesh(count);
            let (built, path) = (Bvh::build(&mesh, &Sequential), cache.path(&key(&mesh)));
            assert_eq!(read(&path, &mesh, &key(&mesh)), None);
            assert_eq!(cache.tree(&mesh, &Sequential).unwrap(), built);
            assert_eq!(read(&path, &mesh, &key(&mesh)), Some(built.clone()));
            assert_eq!(cache.tree(&mesh, &Sequential).unwrap(), built);
        }
        std::fs::remove_dir_all(&cache.folder).unwrap();
    }

    #[test]
    fn a_damaged_or_stale_file_is_written_anew() {
        let cache = cache("anew");
        let mesh = mesh(40);
        let tree = cache.tree(&mesh, &Sequential).unwrap();
        let path = cache.path(&key(&mesh));
        let whole = std::fs::read(&path).unwrap();
        let other = Bvh::build(&self::mesh(41), &Sequential).to_bytes(&key(&self::mesh(41)));
        for bad in [&whole[..100], b"", &other] {
            std::fs::write(&path, bad).unwrap();
            assert_eq!(cache.tree(&mesh, &Sequential).unwrap(), tree);
            assert_eq!(std::fs::read(&path).unwrap(), whole);
        }
        // Without a file there is still a BVH.
        std::fs::remove_file(&path).unwrap();
        std::fs::create_dir(&path).unwrap();
        let (built, _) = cache.tree(&mesh, &Sequential).unwrap_err();
        assert_eq!(built, tree);
        std::fs::remove_dir_all(&cache.folder).unwrap();
    }
}
