//! The rays of a packet in one space, side by side.

use super::{GROUPS, PACKET, Set};
use crate::kernel::ray::Ray as WorldRay;
use crate::kernel::shear::Shear;
use crate::kernel::slab::RelativeBox;
use crate::kernel::triangle::passing;
use crate::lane::{Lane, Mask, V3};
use crate::num::recip;
use crate::query::ray::LONG;
use crate::query::rows::{load, load_v3, store_v3};
use crate::query::wide::WIDTH;
use crate::scene::{Bounds, COORDINATE_LIMIT};

/// Coordinates of rays side by side.
type Rows = [[f32; WIDTH]; 3];

/// Rays side by side.
#[derive(Clone, Copy)]
struct Group {
    origin: Rows,
    direction: Rows,
    inverse: Rows,
}

impl Group {
    const ZERO: Self =
        Self { origin: [[0.0; WIDTH]; 3], direction: [[0.0; WIDTH]; 3], inverse: [[0.0; WIDTH]; 3] };
}

/// The rays of a packet.
pub(super) struct Rays {
    groups: [Group; GROUPS],
}

impl Rays {
    /// Before there are any.
    pub const NONE: Self = Self { groups: [Group::ZERO; GROUPS] };

    /// Puts a ray in place of another; its reciprocals are made by [`Rays::prepare`].
    #[inline(always)]
    pub fn set(&mut self, number: usize, origin: [f32; 3], direction: [f32; 3]) {
        let (group, lane) = (&mut self.groups[number / WIDTH % GROUPS], number % WIDTH);
        let mut axis = 0;
        while axis < 3 {
            group.origin[axis][lane] = origin[axis];
            group.direction[axis][lane] = direction[axis];
            axis += 1;
        }
    }

    /// Puts a copy of a ray in place of another.
    #[inline(always)]
    fn copy(&mut self, from: usize, to: usize) {
        let (copied, from) = (self.groups[from / WIDTH % GROUPS], from % WIDTH);
        let (group, lane) = (&mut self.groups[to / WIDTH % GROUPS], to % WIDTH);
        let mut axis = 0;
        while axis < 3 {
            group.origin[axis][lane] = copied.origin[axis][from];
            group.direction[axis][lane] = copied.direction[axis][from];
            group.inverse[axis][lane] = copied.inverse[axis][from];
            axis += 1;
        }
    }

    /// Makes the reciprocals of directions.
    #[inline(always)]
    pub fn prepare<L: Lane>(&mut self, token: L::Token) {
        let mut g = 0;
        while g < GROUPS {
            let group = &mut self.groups[g];
            let mut first = 0;
            while first < WIDTH {
                let V3 { x, y, z } = load_v3::<L>(token, &group.direction, first);
                store_v3(V3 { x: recip(x), y: recip(y), z: recip(z) }, &mut group.inverse, first);
                first += L::WIDTH;
            }
            g += 1;
        }
    }

    /// The rays with a start within the bounds of coordinates and a direction that needs no other length: see
    /// [`Ray::scaled`](crate::query::Ray::scaled).
    #[inline(always)]
    pub fn usual<L: Lane>(&self, token: L::Token) -> Set {
        let (limit, long) = (L::splat(token, COORDINATE_LIMIT), L::splat(token, LONG));
        let short = L::splat(token, 1.0 / LONG);
        let mut usual = 0;
        let mut g = 0;
        while g < GROUPS {
            let group = &self.groups[g];
            let mut first = 0;
            while first < WIDTH {
                let o = load_v3::<L>(token, &group.origin, first);
                let d = load_v3::<L>(token, &group.direction, first);
                let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
                let is_inside = o.x.abs().le(limit) & o.y.abs().le(limit) & o.z.abs().le(limit);
                let is_short = x.le(long) & y.le(long) & z.le(long);
                let is_long = x.ge(short) | y.ge(short) | z.ge(short);
                usual |= Set::from((is_inside & is_short & is_long).bits()) << (g * WIDTH + first);
                first += L::WIDTH;
            }
            g += 1;
        }
        usual
    }

    /// The rays of a set in the space of an object; the others are copies of its first.
    #[inline(always)]
    pub fn transformed<L: Lane>(&self, token: L::Token, set: Set, to_object: &[[f32; 4]; 3]) -> Self {
        let mut local = Self::NONE;
        let mut g = 0;
        while g < GROUPS {
            let mut first = 0;
            while first < WIDTH {
                let WorldRay { origin, direction, inverse, .. } =
                    self.lanes::<L>(token, g * WIDTH + first).transformed(to_object);
                let group = &mut local.groups[g];
                store_v3(origin, &mut group.origin, first);
                store_v3(direction, &mut group.direction, first);
                store_v3(inverse, &mut group.inverse, first);
                first += L::WIDTH;
            }
            g += 1;
        }
        local.fill(set);
        local
    }

    /// The rays of a set in the space of an object, perhaps in `local`.
    #[inline(always)]
    pub fn placed<'a, L: Lane>(
        &'a self,
        token: L::Token,
        set: Set,
        is_identity: bool,
        to_object: &[[f32; 4]; 3],
        local: &'a mut Option<Self>,
    ) -> &'a Self {
        if is_identity { self } else { local.insert(self.transformed::<L>(token, set, to_object)) }
    }

    /// Puts copies of the first ray of a set in place of those that are not in it.
    #[inline(always)]
    pub fn fill(&mut self, set: Set) {
        let first = set.trailing_zeros() as usize;
        super::each(
            !set,
            #[inline(always)]
            |number| self.copy(first, number),
        );
    }

    /// One of the rays.
    #[inline(always)]
    pub fn ray(&self, number: usize) -> WorldRay<f32> {
        let (group, lane) = (&self.groups[number / WIDTH % GROUPS], number % WIDTH);
        let at = |[x, y, z]: &Rows| V3 { x: x[lane], y: y[lane], z: z[lane] };
        let (origin, direction, inverse) = (at(&group.origin), at(&group.direction), at(&group.inverse));
        WorldRay { origin, direction, inverse, shear: Shear::new(direction, inverse) }
    }

    /// The rays from `first` on, of one group.
    #[inline(always)]
    pub fn lanes<L: Lane>(&self, token: L::Token, first: usize) -> WorldRay<L> {
        let (group, first) = (&self.groups[first / WIDTH % GROUPS], first % WIDTH);
        let direction = load_v3(token, &group.direction, first);
        let inverse = load_v3(token, &group.inverse, first);
        let shear = Shear::new(direction, inverse);
        WorldRay { origin: load_v3(token, &group.origin, first), direction, inverse, shear }
    }

    /// The starts of the rays from `first` on, of one group.
    #[inline(always)]
    pub fn origins<L: Lane>(&self, token: L::Token, first: usize) -> V3<L> {
        load_v3(token, &self.groups[first / WIDTH % GROUPS].origin, first % WIDTH)
    }

    /// The reciprocals of their directions along an axis.
    #[inline(always)]
    pub fn inverse<L: Lane>(&self, token: L::Token, first: usize, axis: usize) -> L {
        load(token, &self.groups[first / WIDTH % GROUPS].inverse[axis], first % WIDTH)
    }

    /// The largest coordinate of a start.
    #[inline(always)]
    pub fn reach<L: Lane>(&self, token: L::Token) -> f32 {
        let mut most = L::splat(token, 0.0);
        let mut first = 0;
        while first < PACKET {
            let origin = self.origins::<L>(token, first);
            most = most.max(origin.x.abs()).max(origin.y.abs()).max(origin.z.abs());
            first += L::WIDTH;
        }
        most.largest()
    }

    /// How much wider boxes within these bounds have to be for all rays.
    #[inline(always)]
    pub fn widening<L: Lane>(&self, token: L::Token, Bounds { low, high }: &Bounds) -> f32 {
        let mut reach = L::splat(token, 0.0);
        let mut first = 0;
        while first < PACKET {
            reach = reach.max(RelativeBox::new(self.origins::<L>(token, first), low, high).reach());
            first += L::WIDTH;
        }
        passing(reach.largest(), low, high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::plain::Plain;
    use crate::query::Ray;
    use crate::query::fixture::Random;

    /// Around every limit, on both sides of 0.
    const ODD: [f32; 14] = [
        0.0,
        1e-45,
        0.99 / LONG,
        1.0 / LONG,
        1.0,
        1_073_741_824.0,
        1_073_741_952.0,
        LONG,
        LONG * 1.01,
        f32::MAX,
        f32::INFINITY,
        f32::NAN,
        -1.0,
        -LONG,
    ];

    #[test]
    fn usual_rays_are_those_that_stay_as_they_are() {
        let mut random = Random(9);
        let mut counts = [0, 0];
        for _ in 0..300 {
            let mut rays = Rays::NONE;
            let mut odd = |share| if random.below(share) == 0 { ODD[random.below(ODD.len())] } else { 0.5 };
            let asked: [Ray; PACKET] =
                core::array::from_fn(|_| Ray::new([0; 3].map(|_| odd(9)), [0; 3].map(|_| odd(2))));
            for (number, ray) in asked.iter().enumerate() {
                rays.set(number, ray.origin, ray.direction);
            }
            let usual = rays.usual::<f32>(());
            assert_eq!(rays.usual::<Plain<8>>(()), usual);
            rays.prepare::<f32>(());
            for (number, ray) in asked.iter().enumerate() {
                let is_usual = usual >> number & 1 == 1;
                let scaled = ray.scaled().ok().filter(|scaled| scaled.span.unit == 1.0);
                assert_eq!(is_usual, scaled.is_some(), "{ray:?}");
                counts[usize::from(is_usual)] += 1;
                if let Some(scaled) = scaled {
                    let (made, alone) = (rays.ray(number), scaled.ray);
                    assert_eq!(made.direction.lane(0), ray.direction);
                    assert_eq!(made.inverse.lane(0), alone.inverse.lane(0));
                }
            }
        }
        assert!(counts[0] > 3000 && counts[1] > 3000, "{counts:?}");
    }
}
