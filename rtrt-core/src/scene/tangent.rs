//! Tangents of vertices: packed, and made from texture coordinates.

use crate::kernel::tangent::{MIRRORED, MOST, PRESENT};
use crate::layout::Attribute;
use alloc::vec;
use alloc::vec::Vec;
use glam::{DVec2, DVec3};

/// The word for a tangent with its handedness, as glTF has them: the bitangent is
/// `normal × tangent`, times −1 where `w` is negative. Any length; see
/// [`crate::kernel::tangent::unpack`].
pub(super) fn pack([x, y, z, w]: [f32; 4]) -> u32 {
    let v = DVec3::new(x.into(), y.into(), z.into());
    let size = v.x.abs() + v.y.abs() + v.z.abs();
    let v = if size > 0.0 && size.is_finite() { v / size } else { DVec3::X };
    let fold =
        |a: f64, b: f64| if v.z < 0.0 { (1.0 - b.abs()) * if a < 0.0 { -1.0 } else { 1.0 } } else { a };
    let coordinate = |c: f64| libm::round((c * 0.5 + 0.5) * f64::from(MOST)) as u32;
    let mirrored = if w < 0.0 { MIRRORED } else { 0 };
    PRESENT | mirrored | coordinate(fold(v.y, v.x)) << 15 | coordinate(fold(v.x, v.y))
}

/// Makes tangents, packed, from texture coordinates, and duplicates the vertices that
/// triangles of both hands share: the two halves of a mirrored texture have no tangent in
/// common.
///
/// A triangle's tangent is the direction in which `u` grows on it, weighted by its area; a
/// vertex has the sum of its triangles', at a right angle to its normal. The bitangent is
/// the direction in which `v` shrinks, since rows of a texture run down and a normal map's
/// second axis up. A triangle without area in the texture adds nothing. (MikkTSpace, which
/// glTF asks for, weights by angle and splits more vertices: seams differ slightly.)
///
/// Returns, for each old and new vertex, the vertex that it copies and its tangent. Updates `indices`.
pub(super) fn make(
    positions: &[[f32; 3]],
    attributes: &[Attribute],
    uv: impl Fn(usize) -> [f32; 2],
    indices: &mut [u32],
) -> Vec<(u32, u32)> {
    let point = |i: u32| DVec3::from(positions[i as usize].map(f64::from));
    let place = |i: u32| DVec2::from(uv(i as usize).map(f64::from));
    let mut copies: Vec<u32> = (0..positions.len() as u32).collect();
    let mut sums = vec![DVec3::ZERO; positions.len()];
    let mut hands: Vec<Option<bool>> = vec![None; positions.len()];
    // The copy of a vertex that has the other hand.
    let mut twins = vec![u32::MAX; positions.len()];
    for triangle in indices.chunks_exact_mut(3) {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
        let (ab, ac) = (point(b) - point(a), point(c) - point(a));
        let (s, t) = (place(b) - place(a), place(c) - place(a));
        let area = s.perp_dot(t);
        let along = if area == 0.0 { DVec3::ZERO } else { (ab * t.y - ac * s.y) * area.signum() };
        let weight = ab.cross(ac).length();
        let along = along.normalize_or_zero() * weight;
        // The normals of the vertices tell the front of the triangle.
        let normal = [a, b, c].map(|i| DVec3::from(attributes[i as usize].normal.map(f64::from)));
        let faces = ab.cross(ac).dot(normal[0] + normal[1] + normal[2]) >= 0.0;
        // With v down, an unmirrored texture turns the other way around than its triangle.
        let mirrored = (area > 0.0) == faces;
        for index in triangle {
            let vertex = *index as usize;
            if area != 0.0 && hands[vertex].is_some_and(|hand| hand != mirrored) {
                if twins[vertex] == u32::MAX {
                    twins[vertex] = copies.len() as u32;
                    copies.push(*index);
                    sums.push(DVec3::ZERO);
                    hands.push(Some(mirrored));
                }
                *index = twins[vertex];
            } else if area != 0.0 {
                hands[vertex] = Some(mirrored);
            }
            sums[*index as usize] += along;
        }
    }
    let tangent = |((&copy, &sum), hand): ((&u32, &DVec3), &Option<bool>)| {
        let normal = DVec3::from(attributes[copy as usize].normal.map(f64::from)).normalize_or_zero();
        let across = (sum - normal * normal.dot(sum)).normalize_or_zero();
        let across = if across == DVec3::ZERO { normal.any_orthogonal_vector() } else { across };
        let w = if *hand == Some(true) { -1.0 } else { 1.0 };
        (copy, pack([across.x as f32, across.y as f32, across.z as f32, w]))
    };
    copies.iter().zip(&sums).zip(&hands).map(tangent).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::tangent::{direction, unpack};

    /// The direction and the sign in a word.
    fn unpacked(packed: u32) -> ([f32; 3], f32) {
        let [x, y, sign] = unpack(packed);
        (direction(x, y).lane(0), sign)
    }

    fn near(a: [f32; 3], b: [f32; 3]) -> bool {
        let (a, b) = (DVec3::from(a.map(f64::from)).normalize(), DVec3::from(b.map(f64::from)).normalize());
        a.dot(b) > 1.0 - 1e-7
    }

    #[test]
    fn packed_directions_come_back() {
        for i in 0..2000_u32 {
            let number = |k: u32| (i.wrapping_mul(k) >> 8 & 0xffff) as f32 / 32768.0 - 1.0;
            let v = [number(2_654_435_761), number(40_503_017), number(2_246_822_519)];
            let (direction, sign) = unpacked(pack([v[0], v[1], v[2], -1.0]));
            assert!(near(direction, v) && sign == -1.0, "{v:?}");
        }
        for axis in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]] {
            assert!(near(unpacked(pack([axis[0], axis[1], axis[2], 1.0])).0, axis));
        }
    }

    #[test]
    fn mirrored_halves_share_no_vertex() {
        // A square of two triangles that face +z; u grows with x in the lower one and
        // shrinks with it in the upper one, where it ends in the corner that both start in.
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let uv = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [2.0, 0.0]];
        let attribute = |uv| Attribute { normal: [0.0, 0.0, 1.0], uv, color: [0; 2] };
        let mut indices = [0, 1, 2, 0, 2, 3];
        let made = make(&corners, &uv.map(attribute), |i| uv[i], &mut indices);
        assert_eq!(made.len(), 6);
        assert_eq!(indices, [0, 1, 2, 4, 5, 3]);
        assert_eq!((made[4].0, made[5].0), (0, 2));
        assert!(near(unpacked(made[1].1).0, [1.0, 0.0, 0.0]));
        assert_eq!([1, 3].map(|i: usize| unpacked(made[i].1).1), [1.0, -1.0]);
    }
}
