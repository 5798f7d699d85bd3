//! A packet of rays as one: intervals of origins and reciprocal directions, and the
//! boxes that none of the rays can meet.

use crate::kernel::ray::Ray;
use crate::kernel::slab::STRETCH;
use crate::kernel::traverse::Best;
use crate::lane::{Lane, V3};

/// Bounds on the rays of a packet.
///
/// Every bound is taken over the very numbers that [`crate::kernel::slab::slab`] uses,
/// and rounding is monotone, so [`Span::misses`] is exact interval arithmetic: it never
/// culls a box that one of the rays would enter, without any epsilon (after Boulos,
/// Wald and Shirley, "Geometric and Arithmetic Culling Methods for Entire Ray Packets",
/// 2006).
#[derive(Clone, Copy)]
pub struct Span {
    /// Smallest origin.
    pub origin_low: [f32; 3],
    /// Largest origin.
    pub origin_high: [f32; 3],
    /// Smallest reciprocal direction.
    pub inverse_low: [f32; 3],
    /// Largest reciprocal direction.
    pub inverse_high: [f32; 3],
}

impl Span {
    /// The bounds of those rays of the first `count` groups whose limit is not negative.
    #[inline(always)]
    pub fn of<L: Lane, O: Lane, const G: usize>(
        rays: &[Ray<L, O>; G],
        best: &[Best<L>; G],
        count: usize,
    ) -> Self {
        let inverse = Range::of(
            best,
            count,
            #[inline(always)]
            |g| rays[g].inverse,
        );
        let origin = if O::WIDTH < L::WIDTH {
            let start = rays[0].origin.lane(0);
            Range { low: start, high: start }
        } else {
            Range::of(
                best,
                count,
                #[inline(always)]
                |g| each(best[g].t, rays[g].origin),
            )
        };
        Self {
            origin_low: origin.low,
            origin_high: origin.high,
            inverse_low: inverse.low,
            inverse_high: inverse.high,
        }
    }

    /// Whether no ray of the packet meets the box at a `t ≤ limit`; may be false where
    /// none does.
    #[inline(always)]
    pub fn misses(&self, low: &[f32; 3], high: &[f32; 3], limit: f32) -> bool {
        let mut near = 0.0_f32;
        let mut far = limit;
        let mut axis = 0;
        while axis < 3 {
            let (i0, i1) = (self.inverse_low[axis], self.inverse_high[axis]);
            // Entry and exit plane by the sign that all rays share; an axis on which the
            // signs differ says nothing.
            if i0 > 0.0 {
                let entry = low[axis] - self.origin_high[axis];
                let exit = high[axis] - self.origin_low[axis];
                near = larger(near, entry * if entry >= 0.0 { i0 } else { i1 });
                far = smaller(far, exit * if exit >= 0.0 { i1 } else { i0 } * STRETCH);
            } else if i1 < 0.0 {
                let entry = high[axis] - self.origin_low[axis];
                let exit = low[axis] - self.origin_high[axis];
                near = larger(near, entry * if entry >= 0.0 { i0 } else { i1 });
                far = smaller(far, exit * if exit >= 0.0 { i1 } else { i0 } * STRETCH);
            }
            axis += 1;
        }
        far < near
    }
}

/// The smallest and the largest of some vectors, component by component.
struct Range {
    low: [f32; 3],
    high: [f32; 3],
}

impl Range {
    /// The range of `value(g)` in those lanes of the first `count` groups whose limit is not
    /// negative.
    #[inline(always)]
    fn of<L: Lane, const G: usize>(
        best: &[Best<L>; G],
        count: usize,
        value: impl Fn(usize) -> V3<L>,
    ) -> Self {
        let like = best[0].t;
        let (largest, smallest) = (like.like(f32::MAX), like.like(-f32::MAX));
        let everything = V3 { x: largest, y: largest, z: largest };
        let nothing = V3 { x: smallest, y: smallest, z: smallest };
        let (mut low, mut high) = (everything, nothing);
        let mut g = 0;
        while g < count {
            let active = like.like(0.0).less_equal(best[g].t);
            let value = value(g);
            low = low.min(V3::select(active, value, everything));
            high = high.max(V3::select(active, value, nothing));
            g += 1;
        }
        Self { low: least(low), high: most(high) }
    }
}

/// A vector of as many lanes as `like`, from one of as many.
#[inline(always)]
fn each<L: Lane, O: Lane>(like: L, v: V3<O>) -> V3<L> {
    let row = v.row();
    V3::from_fn(
        like.token(),
        #[inline(always)]
        |lane| row.at(lane),
    )
}

/// The smallest lane of each component.
#[inline(always)]
fn least<L: Lane>(v: V3<L>) -> [f32; 3] {
    let row = v.row();
    let mut least = row.at(0);
    let mut lane = 1;
    while lane < L::WIDTH {
        let next = row.at(lane);
        least = [smaller(least[0], next[0]), smaller(least[1], next[1]), smaller(least[2], next[2])];
        lane += 1;
    }
    least
}

/// The largest lane of each component.
#[inline(always)]
fn most<L: Lane>(v: V3<L>) -> [f32; 3] {
    let [x, y, z] = least(-v);
    [-x, -y, -z]
}

/// [`Lane::min`] of two plain numbers (`f32::min` is another function on some devices).
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    <f32 as Lane>::min(a, b)
}

/// [`Lane::max`] of two plain numbers.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    <f32 as Lane>::max(a, b)
}
