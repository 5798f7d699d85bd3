//! An environment as the six pictures of a cube.

use crate::scene::brightness::usable;
use alloc::vec::Vec;
use glam::DVec3;

/// Light from all around: the pictures on the six sides of a cube around the origin, linear RGB.
///
/// The pictures follow the convention of cube maps: px, nx, py, ny, pz, nz. px lies toward +x, nx toward
/// −x, py toward +y, ny toward −y. Cube maps are left-handed, a scene is right-handed, so one axis turns
/// around to keep text readable: pz lies toward −z, where a camera without rotation looks, and nz toward
/// +z. The upper edges of px, nx, pz, nz are up; the upper edge of py is behind, that of ny in front.
#[derive(Debug, Clone, PartialEq)]
pub struct Cube {
    /// Columns of each picture, and rows.
    pub side: u32,
    /// px, nx, py, ny, pz, nz, each row by row. Negative numbers and NaN count as 0, larger ones than
    /// 65,408 as 65,408.
    pub faces: [Vec<[f32; 3]>; 6],
}

/// Why a cube was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{pixels} pixels do not make the picture {} of a cube of side {side}, within 1 .. {}", Cube::NAMES[*face], Cube::MAX_SIDE)]
pub struct CubeError {
    /// The picture.
    pub face: usize,
    /// Expected columns and rows.
    pub side: u32,
    /// Pixels that it has.
    pub pixels: usize,
}

impl Cube {
    /// The names of the pictures, in their order.
    pub const NAMES: [&str; 6] = ["px", "nx", "py", "ny", "pz", "nz"];
    /// The most columns of a picture.
    pub const MAX_SIDE: u32 = 8192;

    /// Checks the number of pixels of all pictures.
    pub(super) fn check(&self) -> Result<(), CubeError> {
        let side = self.side;
        let wanted = u64::from(side) * u64::from(side);
        let fits = |face: &Vec<[f32; 3]>| face.len() as u64 == wanted && (1..=Self::MAX_SIDE).contains(&side);
        let wrong = self.faces.iter().position(|face| !fits(face));
        wrong.map_or(Ok(()), |face| Err(CubeError { face, side, pixels: self.faces[face].len() }))
    }

    /// The light from a direction, bilinear, across edges too.
    pub(super) fn toward(&self, d: DVec3) -> DVec3 {
        let (face, place) = face(d);
        let [x, y] = place.map(|c| c * f64::from(self.side) - 0.5);
        let (left, upper) = (libm::floor(x), libm::floor(y));
        let at = |x: f64, y: f64| self.texel(face, [x, y]);
        let above = at(left, upper).lerp(at(left + 1.0, upper), x - left);
        let below = at(left, upper + 1.0).lerp(at(left + 1.0, upper + 1.0), x - left);
        above.lerp(below, y - upper)
    }

    /// A texel of a face, or of its neighbor for a place beyond its edge.
    fn texel(&self, number: usize, at: [f64; 2]) -> DVec3 {
        let side = f64::from(self.side);
        let is_within = at.iter().all(|c| (0.0..side).contains(c));
        let (number, at) = match is_within {
            true => (number, at),
            false => {
                let (number, place) = face(direction(number, at.map(|c| (c + 0.5) / side)));
                (number, place.map(|c| (c * side).clamp(0.0, side - 1.0)))
            }
        };
        let [x, y] = at.map(|c| c as usize);
        DVec3::from(self.faces[number][y * self.side as usize + x].map(usable))
    }
}

/// The face that a direction passes through, and the place on it from the left and from above,
/// `0 ..= 1`.
fn face(d: DVec3) -> (usize, [f64; 2]) {
    let DVec3 { x, y, z } = d;
    let (number, most, right, down) = if x.abs() >= y.abs() && x.abs() >= z.abs() {
        if x > 0.0 { (0, x, z, -y) } else { (1, -x, -z, -y) }
    } else if y.abs() >= z.abs() {
        if y > 0.0 { (2, y, x, -z) } else { (3, -y, x, z) }
    } else if z < 0.0 {
        (4, -z, x, -y)
    } else {
        (5, z, -x, -y)
    };
    (number, [right, down].map(|c| (c / most + 1.0) * 0.5))
}

/// A direction through a place of a face, which may lie beside it.
pub(super) fn direction(face: usize, place: [f64; 2]) -> DVec3 {
    let [right, down] = place.map(|c| 2.0 * c - 1.0);
    match face {
        0 => DVec3::new(1.0, -down, right),
        1 => DVec3::new(-1.0, -down, -right),
        2 => DVec3::new(right, 1.0, -down),
        3 => DVec3::new(right, -1.0, down),
        4 => DVec3::new(right, -down, -1.0),
        _ => DVec3::new(-right, -down, 1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::environment::decode;
    use crate::scene::Panorama;
    use alloc::vec;

    /// Light without two alike directions, that changes by less than 4 a radian.
    fn light(d: DVec3) -> DVec3 {
        let d = d / libm::sqrt(d.length_squared());
        DVec3::new(2.0 + d.x + d.y * d.z, 2.0 + d.y + d.z * d.x, 2.0 + d.z + d.x * d.y)
    }

    /// What `light` is seen as by the middles of a cube's texels.
    fn cube(side: u32, light: impl Fn(DVec3) -> DVec3) -> Cube {
        let place = |i: u32| [i % side, i / side].map(|c| (f64::from(c) + 0.5) / f64::from(side));
        let faces = core::array::from_fn(|number| {
            let texel = |i| light(direction(number, place(i))).as_vec3().to_array();
            (0..side * side).map(texel).collect()
        });
        Cube { side, faces }
    }

    /// The same of a panorama.
    fn panorama(width: u32) -> Panorama {
        let height = width / 2;
        let pixel = |i: u32| {
            let column = (f64::from(i % width) + 0.5) / f64::from(width);
            let row = (f64::from(i / width) + 0.5) / f64::from(height);
            let (z, x) = libm::sincos(core::f64::consts::TAU * (column - 0.5));
            let (out, up) = libm::sincos(core::f64::consts::PI * row);
            light(DVec3::new(x * out, up, z * out)).as_vec3().to_array()
        };
        Panorama { width, height, rgb: (0..width * height).map(pixel).collect() }
    }

    /// The largest difference of two environments, in any texel of any level.
    fn apart(cube: &Cube, panorama: &Panorama) -> f32 {
        let (mut a, mut b) = (vec![], vec![]);
        let (first, second) = (cube.append(&mut a).unwrap(), panorama.append(&mut b).unwrap());
        assert_eq!((first.side, a.len()), (second.side, b.len()));
        let after = a[first.first as usize] as usize;
        let pairs = a[after..].iter().zip(&b[after..]);
        let differences = pairs.flat_map(|(&a, &b)| {
            let (a, b) = (decode(a), decode(b));
            [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
        });
        differences.fold(0.0, |most, difference| most.max(difference.abs()))
    }

    #[test]
    fn a_panorama_as_a_cube_is_the_same_environment() {
        let panorama = panorama(256);
        let seen = cube(64, |d| panorama.toward(d / libm::sqrt(d.length_squared())));
        // The numbers go to 4; those of texels have steps of 1/64 there.
        let error = apart(&seen, &panorama);
        assert!(error <= 1.0 / 32.0, "{error}");
        // No other order of the faces is, nor are mirrored ones.
        for (a, b) in (0..6).flat_map(|a| (0..a).map(move |b| (a, b))) {
            let mut swapped = seen.clone();
            swapped.faces.swap(a, b);
            let error = apart(&swapped, &panorama);
            assert!(error > 0.3, "{a} and {b} swapped: {error}");
        }
        for face in 0..6 {
            let mut mirrored = seen.clone();
            mirrored.faces[face].chunks_mut(64).for_each(<[_]>::reverse);
            let error = apart(&mirrored, &panorama);
            assert!(error > 0.3, "{face} mirrored: {error}");
        }
    }

    #[test]
    fn faces_meet_without_a_seam() {
        // What is mixed across an edge is off by less than what a texel spans.
        let seen = cube(32, light);
        for (number, place) in (0..6).flat_map(|f| (0..400).map(move |i| (f, f64::from(i) / 399.0))) {
            for place in [[place, 0.0], [place, 1.0], [0.0, place], [1.0, place]] {
                let d = direction(number, place);
                let error = (seen.toward(d) - light(d)).abs().max_element();
                assert!(error < 0.02, "{number} {place:?}: {error}");
            }
        }
    }

    #[test]
    fn faces_are_where_their_names_say() {
        for (number, name) in Cube::NAMES.iter().enumerate() {
            let axis =
                DVec3::AXES[number / 2] * if name.starts_with('p') == (number < 4) { 1.0 } else { -1.0 };
            assert_eq!(face(axis), (number, [0.5; 2]), "{name}");
            assert_eq!(direction(number, [0.5; 2]), axis, "{name}");
            // From inside, what is on the right is on the right. Looking up, the upper edge is behind.
            let up = if axis.y == 0.0 { DVec3::Y } else { DVec3::Z * axis.y };
            assert!(direction(number, [1.0, 0.5]).dot(axis.cross(up)) > 0.9, "{name}");
            assert!(direction(number, [0.5, 0.0]).dot(up) > 0.9, "{name}");
        }
    }

    #[test]
    fn refuses_pictures_that_do_not_fit() {
        let mut wrong = cube(4, light);
        wrong.faces[2].pop();
        assert_eq!(wrong.append(&mut vec![]), Err(CubeError { face: 2, side: 4, pixels: 15 }));
        let empty = Cube { side: 0, faces: Default::default() };
        assert!(empty.append(&mut vec![]).is_err());
    }
}
