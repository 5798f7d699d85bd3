//! A BVH as bytes, for files.

use super::{Bvh, BvhError};
use alloc::vec::Vec;
use sha2::{Digest, Sha256};

const MAGIC: &[u8; 8] = b"rtrttree";
/// The version of the format and of the BVHs of [`Bvh::build`].
const VERSION: u32 = 2;
/// Bytes before the nodes.
const HEADER: usize = 8 + 4 + 32 + 4 + 4;
/// Bytes of a SHA-256.
const DIGEST: usize = 32;

impl Bvh {
    /// The SHA-256 of what a BVH is built of: the version of the format, the positions and the indices.
    pub fn digest(positions: &[[f32; 3]], indices: &[u32]) -> [u8; 32] {
        let mut digest = Sha256::new();
        digest.update(MAGIC);
        digest.update(VERSION.to_le_bytes());
        digest.update((positions.len() as u64).to_le_bytes());
        for position in positions {
            digest.update(position.map(f32::to_le_bytes).as_flattened());
        }
        for index in indices {
            digest.update(index.to_le_bytes());
        }
        digest.finalize().into()
    }

    /// The BVH as bytes, the same on every machine. `digest` is the [`Bvh::digest`] of what it was built of.
    ///
    /// ```text
    /// magic "rtrttree", version, digest, number of nodes, number of triangles,
    /// [first, kind] of each node, the triangles in the order of the leaves,
    /// SHA-256 of all that; words are little-endian
    /// ```
    pub fn to_bytes(&self, digest: &[u8; 32]) -> Vec<u8> {
        let links = self.links();
        let mut bytes = Vec::with_capacity(Self::most_bytes(self.triangles.len()));
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        bytes.extend_from_slice(digest);
        for number in [links.len() as u32, self.triangles.len() as u32] {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        for word in links.as_flattened().iter().chain(&self.triangles) {
            bytes.extend_from_slice(&word.to_le_bytes());
        }
        let sum = Sha256::digest(&bytes);
        bytes.extend_from_slice(&sum);
        bytes
    }

    /// The most [`Bvh::to_bytes`] of so many triangles.
    pub fn most_bytes(triangles: usize) -> usize {
        // A BVH of n triangles has at most 2n − 1 nodes; an empty one has one.
        length(2 * triangles + 1, triangles)
    }

    /// The BVH of [`Bvh::to_bytes`], for triangles with three indices each. `digest` is their [`Bvh::digest`].
    ///
    /// The bytes are not trusted. Boxes are computed from the positions, so the worst effects of forged bytes are a
    /// slow BVH, and another order of two triangles at exactly the same distance.
    ///
    /// # Errors
    /// The bytes are of another version or of other triangles, they are damaged, their words form no BVH, or an index
    /// names no position.
    pub fn from_bytes(
        positions: &[[f32; 3]],
        indices: &[u32],
        digest: &[u8; 32],
        bytes: &[u8],
    ) -> Result<Self, BvhError> {
        let short = BvhError("the bytes end too early");
        let end = bytes.len().checked_sub(DIGEST).ok_or(short)?;
        let (content, sum) = bytes.split_at(end);
        let (header, words) = content.split_at_checked(HEADER).ok_or(short)?;
        if !header.starts_with(MAGIC) || header[8..12] != VERSION.to_le_bytes() {
            return Err(BvhError("the bytes are of another format"));
        }
        if header[12..44] != digest[..] {
            return Err(BvhError("the bytes are of other triangles"));
        }
        if indices.iter().any(|&index| index as usize >= positions.len()) {
            return Err(BvhError("an index names no position"));
        }
        let word =
            |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
        let (nodes, triangles) = (word(44) as usize, word(48) as usize);
        let is_right = triangles == indices.len() / 3 && nodes <= 2 * triangles + 1;
        if !is_right || bytes.len() != length(nodes, triangles) {
            return Err(BvhError("the number of triangles or nodes is wrong"));
        }
        if Sha256::digest(content)[..] != *sum {
            return Err(BvhError("the bytes are damaged"));
        }
        let (words, _) = words.as_chunks::<4>();
        let words: Vec<u32> = words.iter().map(|&bytes| u32::from_le_bytes(bytes)).collect();
        let (links, triangles) = words.split_at(2 * nodes);
        let (links, _) = links.as_chunks::<2>();
        Self::of_links(positions, indices, links, triangles.to_vec())
    }
}

/// Bytes of a BVH.
fn length(nodes: usize, triangles: usize) -> usize {
    HEADER + 8 * nodes + 4 * triangles + DIGEST
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Sequential;
    use std::vec::Vec;

    fn corners(count: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
        let corner = |i: u32| [(i * 37 % 101) as f32, (i * 53 % 89) as f32, (i * 29 % 97) as f32];
        ((0..3 * count).map(corner).collect(), (0..3 * count).collect())
    }

    fn stored(count: u32) -> (Vec<[f32; 3]>, Vec<u32>, [u8; 32], Bvh) {
        let (positions, indices) = corners(count);
        let digest = Bvh::digest(&positions, &indices);
        let built = Bvh::of_triangles(&positions, &indices, &Sequential);
        (positions, indices, digest, built)
    }

    #[test]
    fn bytes_give_the_bvh_back() {
        for count in [0, 1, 2, 300] {
            let (positions, indices, digest, built) = stored(count);
            let bytes = built.to_bytes(&digest);
            assert!(bytes.len() <= Bvh::most_bytes(count as usize));
            assert_eq!(Bvh::from_bytes(&positions, &indices, &digest, &bytes), Ok(built));
        }
    }

    #[test]
    fn no_damaged_byte_is_trusted() {
        let (positions, indices, digest, built) = stored(25);
        let whole = built.to_bytes(&digest);
        let read = |bytes: &[u8]| Bvh::from_bytes(&positions, &indices, &digest, bytes);
        for end in 0..whole.len() {
            assert!(read(&whole[..end]).is_err(), "cut off at {end}");
        }
        for bit in 0..8 * whole.len() {
            let mut damaged = whole.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(read(&damaged).is_err(), "bit {bit}");
        }
        assert!(read(&[&whole[..], &[0]].concat()).is_err());
        let (others, more, other, _) = stored(26);
        assert!(Bvh::from_bytes(&others, &more, &other, &whole).is_err());
        // The digest is the caller's word; indices are not.
        assert!(Bvh::from_bytes(&positions[..70], &indices, &digest, &whole).is_err());
    }

    #[test]
    fn bytes_with_the_right_sums_and_the_wrong_words_are_refused() {
        let (positions, indices, digest, built) = stored(25);
        let whole = built.to_bytes(&digest);
        let mut refused = 0;
        for at in (HEADER..whole.len() - DIGEST).step_by(4) {
            for value in [0, 1, 3, 7, 24, 25, u32::MAX] {
                let mut forged = whole.clone();
                forged[at..at + 4].copy_from_slice(&value.to_le_bytes());
                let content = forged.len() - DIGEST;
                let sum = Sha256::digest(&forged[..content]);
                forged[content..].copy_from_slice(&sum);
                // Another axis of a node is valid, with the same boxes.
                match Bvh::from_bytes(&positions, &indices, &digest, &forged) {
                    Ok(other) => {
                        assert!(
                            other.triangles == built.triangles && other.nodes[0].low == built.nodes[0].low
                        )
                    }
                    Err(_) => refused += 1,
                }
            }
        }
        assert!(refused > 100, "{refused}");
    }
}
