//! Tangents in one word, and the normal that a normal map makes.

use crate::lane::{Lane, Select, V3};
use crate::num::{TINY, normalize};

/// The bit of a packed tangent that says that there is one.
pub const PRESENT: u32 = 1 << 31;
/// The bit of a packed tangent whose bitangent is `−normal × tangent`.
pub const MIRRORED: u32 = 1 << 30;
/// The most that a packed coordinate can be: 15 bits.
pub const MOST: u32 = (1 << 15) - 1;
/// What a packed coordinate is multiplied with to be within 0 ..= 2.
const STEP: f32 = 2.0 / 32_767.0;

/// The two coordinates of a packed tangent, −1 ..= 1, and the sign of its bitangent: 1 or −1;
/// all 0 if there is none.
///
/// The word holds the coordinates of the octahedral map (Meyer et al., "On Floating-Point
/// Normal Vectors", 2010), 15 bits each, the first one lowest: at most 0.01° off. Vertices
/// are so four bytes larger instead of sixteen, and only those of meshes that a normal map is
/// laid on.
#[inline(always)]
pub fn unpack(packed: u32) -> [f32; 3] {
    if packed & PRESENT == 0 {
        return [0.0; 3];
    }
    let sign = if packed & MIRRORED == 0 { 1.0 } else { -1.0 };
    [(packed & MOST) as f32 * STEP - 1.0, (packed >> 15 & MOST) as f32 * STEP - 1.0, sign]
}

/// The direction at these coordinates of the octahedral map; its length is within 0.57 ..= 1.
#[inline(always)]
pub fn direction<L: Lane>(x: L, y: L) -> V3<L> {
    let (zero, one) = (x.broadcast(0.0), x.broadcast(1.0));
    let z = one - x.abs() - y.abs();
    // Below z = 0 the corners of the square are folded over.
    let over = (-z).max(zero);
    let fold = |v: L| v.lt(zero).select(v + over, v - over);
    V3 { x: fold(x), y: fold(y), z }
}

/// `normal` (unit length, on the viewer's side), turned to where a normal map points:
///
/// ```text
/// x · t + y · b + z · normal,   t = tangent / |tangent|, b = bitangent / |bitangent|
/// ```
///
/// `tangent` and `bitangent` are the world's directions in which the map's columns and
/// upward rows run, seen from the side on which the vertex normals are; `behind` says that
/// the viewer is on the other side, where every bump is a dent. Nothing else turns the
/// result to the viewer: a normal that leans away from it is dark or bright by the light
/// alone, and has no seam. Where nothing is left of the sum, the normal stays.
#[inline(always)]
pub fn bumped<L: Lane>(
    normal: V3<L>,
    tangent: V3<L>,
    bitangent: V3<L>,
    behind: L::Mask,
    map: [L; 3],
) -> V3<L> {
    let along = normalize(tangent).scale(map[0]) + normalize(bitangent).scale(map[1]);
    let sum = V3::select(behind, -along, along) + normal.scale(map[2]);
    let length = sum.dot(sum);
    V3::select(length.gt(length.broadcast(TINY)), normalize(sum), normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_map_changes_nothing_and_behind_a_bump_is_a_dent() {
        let at = |v| V3::<f32>::splat((), v);
        let (n, t, b) = (at([0.0, 0.0, 1.0]), at([2.0, 0.0, 0.0]), at([0.0, 3.0, 0.0]));
        let turned = |behind, map| bumped(n, t, b, behind, map).lane(0);
        assert!((turned(false, [0.0, 0.0, 1.0])[2] - 1.0).abs() < 1e-6);
        assert!(turned(false, [0.6, 0.0, 0.8])[0] > 0.59 && turned(true, [0.6, 0.0, 0.8])[0] < -0.59);
        assert_eq!(turned(false, [0.0; 3]), [0.0, 0.0, 1.0]);
    }
}
