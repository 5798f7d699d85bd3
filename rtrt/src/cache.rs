//! A cache of BVHs in files: a mesh that was loaded once loads faster.
//!
//! The name of a file is the SHA-256 of its input: the version of the format, and the mesh's positions
//! and indices. Its content, in little-endian words:
//!
//! ```text
//! magic "rtrttree", version, that SHA-256, number of nodes, number of triangles,
//! [first, kind] of each node, the triangles in the order of the leaves,
//! SHA-256 of all that
//! ```
//!
//! The content is not trusted. A file of another mesh or version, a truncated or damaged file, and one
//! whose words form no BVH ([`Bvh::from_links`]) is replaced by a new one. Boxes are computed from the
//! mesh. So the worst effects of a forged file are a slow BVH, and another order of two triangles at
//! exactly the same distance.

use crate::replace::replace;
use rtrt_core::scene::{Bvh, Join, Mesh};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 8] = b"rtrttree";
/// The version of the format and of the BVHs of [`Bvh::build`].
const VERSION: u32 = 2;
/// Bytes before the nodes.
const HEADER: usize = 8 + 4 + 32 + 4 + 4;
/// Bytes of a SHA-256.
const DIGEST: usize = 32;

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
        match replace(&path, &encode(&tree, &key)) {
            Ok(()) => Ok(tree),
            Err(error) => Err((tree, error)),
        }
    }

    fn path(&self, key: &[u8; DIGEST]) -> PathBuf {
        let name: String = key.iter().map(|byte| format!("{byte:02x}")).collect();
        self.folder.join(name + ".tree")
    }
}

/// The SHA-256 of the input of a BVH.
fn key(mesh: &Mesh) -> [u8; DIGEST] {
    let mut digest = Sha256::new();
    digest.update(MAGIC);
    digest.update(VERSION.to_le_bytes());
    digest.update((mesh.positions().len() as u64).to_le_bytes());
    for position in mesh.positions() {
        digest.update(position.map(f32::to_le_bytes).as_flattened());
    }
    for index in mesh.indices() {
        digest.update(index.to_le_bytes());
    }
    digest.finalize().into()
}

fn encode(tree: &Bvh, key: &[u8; DIGEST]) -> Vec<u8> {
    let links = tree.links();
    let mut bytes = Vec::with_capacity(length(links.len(), tree.triangles.len()));
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(key);
    for number in [links.len() as u32, tree.triangles.len() as u32] {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    for word in links.as_flattened().iter().chain(&tree.triangles) {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    let digest = Sha256::digest(&bytes);
    bytes.extend_from_slice(&digest);
    bytes
}

/// Bytes of a file.
fn length(nodes: usize, triangles: usize) -> usize {
    HEADER + 8 * nodes + 4 * triangles + DIGEST
}

/// The BVH in a file; none if the file is missing or invalid.
fn read(path: &Path, mesh: &Mesh, key: &[u8; DIGEST]) -> Option<Bvh> {
    // A BVH of n triangles has at most 2n − 1 nodes; an empty one has one.
    let longest = length(2 * mesh.triangles() + 1, mesh.triangles()) as u64;
    let file = File::open(path).ok()?;
    if !file.metadata().ok()?.is_file() {
        return None;
    }
    let mut bytes = Vec::new();
    file.take(longest + 1).read_to_end(&mut bytes).ok()?;
    decode(&bytes, mesh, key)
}

fn decode(bytes: &[u8], mesh: &Mesh, key: &[u8; DIGEST]) -> Option<Bvh> {
    let (content, digest) = bytes.split_at_checked(bytes.len().checked_sub(DIGEST)?)?;
    let (header, words) = content.split_at_checked(HEADER)?;
    if !header.starts_with(MAGIC) || header[8..12] != VERSION.to_le_bytes() || header[12..44] != key[..] {
        return None;
    }
    let word = |bytes: &[u8]| bytes.try_into().map(u32::from_le_bytes);
    let [nodes, triangles] = [word(&header[44..48]).ok()? as usize, word(&header[48..52]).ok()? as usize];
    if triangles != mesh.triangles() || nodes > 2 * triangles + 1 || bytes.len() != length(nodes, triangles) {
        return None;
    }
    if Sha256::digest(content)[..] != *digest {
        return None;
    }
    let words = words.chunks_exact(4).map(word).collect::<Result<Vec<_>, _>>().ok()?;
    let (links, triangles) = words.split_at(2 * nodes);
    let links: Vec<[u32; 2]> = links.chunks_exact(2).map(|link| [link[0], link[1]]).collect();
    Bvh::from_links(mesh, &links, triangles.to_vec()).ok()
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
    fn no_damaged_byte_is_trusted() {
        let mesh = mesh(25);
        let (tree, key) = (Bvh::build(&mesh, &Sequential), key(&mesh));
        let whole = encode(&tree, &key);
        assert_eq!(decode(&whole, &mesh, &key), Some(tree));
        for end in 0..whole.len() {
            assert_eq!(decode(&whole[..end], &mesh, &key), None, "cut off at {end}");
        }
        for bit in 0..8 * whole.len() {
            let mut damaged = whole.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(decode(&damaged, &mesh, &key), None, "bit {bit}");
        }
        let longer = [&whole[..], &[0]].concat();
        assert_eq!(decode(&longer, &mesh, &key), None);
    }

    #[test]
    fn a_file_with_the_right_sums_and_the_wrong_words_is_refused() {
        let mesh = mesh(25);
        let (tree, key) = (Bvh::build(&mesh, &Sequential), key(&mesh));
        let whole = encode(&tree, &key);
        let mut refused = 0;
        for at in (HEADER..whole.len() - DIGEST).step_by(4) {
            for value in [0, 1, 3, 7, 24, 25, u32::MAX] {
                let mut forged = whole.clone();
                forged[at..at + 4].copy_from_slice(&value.to_le_bytes());
                let content = forged.len() - DIGEST;
                let digest = Sha256::digest(&forged[..content]);
                forged[content..].copy_from_slice(&digest);
                // Another axis of a node is valid, with the same boxes.
                match decode(&forged, &mesh, &key) {
                    Some(other) => {
                        assert!(other.triangles == tree.triangles && other.nodes[0].low == tree.nodes[0].low)
                    }
                    None => refused += 1,
                }
            }
        }
        assert!(refused > 100, "{refused}");
    }

    #[test]
    fn a_damaged_or_stale_file_is_written_anew() {
        let cache = cache("anew");
        let mesh = mesh(40);
        let tree = cache.tree(&mesh, &Sequential).unwrap();
        let path = cache.path(&key(&mesh));
        let whole = std::fs::read(&path).unwrap();
        let other = encode(&Bvh::build(&self::mesh(41), &Sequential), &key(&self::mesh(41)));
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
