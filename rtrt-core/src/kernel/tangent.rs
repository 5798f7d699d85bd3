//! Tangents in one word, and the normal that a normal map makes.

use crate::lane::{Bits, Lane, Select, V3};
use crate::num::{TINY, clamp, floor, from_integer, normalize, recip, to_integer};

/// The bit of a packed tangent that says that there is one.
pub const PRESENT: u32 = 1 << 31;
/// The bit of a packed tangent whose bitangent is `−normal × tangent`.
pub const MIRRORED: u32 = 1 << 30;
/// The most that a packed coordinate can be: 15 bits.
pub const MOST: u32 = (1 << 15) - 1;
/// What a packed coordinate is multiplied with to be within 0 ..= 2.
const STEP: f32 = 2.0 / 32_767.0;
/// A step of a direction's 16 bits.
const UNIT: f32 = 2.0 / 65_535.0;

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

/// A direction of any length in one word: the coordinates of the octahedral map, 16 bits each, the first one lowest.
#[inline(always)]
pub fn pack_direction<L: Lane>(v: V3<L>) -> L::Bits {
    let shrink = recip(v.x.abs() + v.y.abs() + v.z.abs());
    let (x, y) = (v.x * shrink, v.y * shrink);
    let (zero, one) = (x.broadcast(0.0), x.broadcast(1.0));
    let folded = |a: L, b: L| {
        let over = one - b.abs();
        v.z.lt(zero).select(a.lt(zero).select(-over, over), a)
    };
    let byte = |c: L| to_integer(floor(clamp(c * 0.5 + 0.5, 0.0, 1.0) * 65_535.0 + 0.5));
    byte(folded(x, y)) | (byte(folded(y, x)) << 16)
}

/// The direction that is packed so, of unit length: at most 0.005° off.
#[inline(always)]
pub fn unpack_direction<L: Lane>(packed: L::Bits) -> V3<L> {
    let at = |bits: L::Bits| from_integer::<L>(bits & packed.broadcast(0xffff)) * UNIT - 1.0;
    normalize(direction(at(packed), at(packed >> 16)))
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
    fn a_packed_direction_comes_back() {
        for i in 0..2000_u32 {
            let turn = f64::from(i) * 2.399_963;
            let z = (f64::from(i) + 0.5) / 1000.0 - 1.0;
            let r = (1.0 - z * z).sqrt();
            let v = [r * turn.cos(), r * turn.sin(), z].map(|c| c as f32);
            let back = unpack_direction::<f32>(pack_direction(V3::<f32>::splat((), v).scale(3.0))).lane(0);
            let off: f32 = v.iter().zip(back).map(|(a, b)| (a - b) * (a - b)).sum();
            assert!(off < 1e-8, "{v:?} {back:?}");
        }
        let none = unpack_direction::<f32>(pack_direction(V3::<f32>::splat((), [0.0; 3])));
        assert!(none.lane(0).iter().all(|c| c.is_finite()));
    }

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
