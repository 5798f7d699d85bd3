//! Share: sub-rays of a pixel that meet the same triangle are shaded as one, as with multisampling on GPUs.
//!
//! The first of them in number is shaded, and the others take its color. So do sub-rays that meet one side of a
//! sphere, and, where nothing is shown behind everything, those that meet nothing. A hit that takes another's color
//! has no instance any more, and its triangle is where that other ray is in its tile, which has all sub-rays of a pixel.

use crate::grid::number;
use crate::kernel::tiles::TILE;
use crate::layout::{Frame, Hit, NONE};

/// The sub-rays of a pixel whose colors its sub-rays take, four bits each: of the first eight, and of the others.
/// Sub-rays are numbered row by row, and `met` is what one has met: instance and triangle.
#[inline(always)]
fn leaders(frame: &Frame, met: impl Fn(u32) -> [u32; 2]) -> [u32; 2] {
    let (mut low, mut high) = (0, 0);
    let mut ray = 0;
    while ray < frame.side * frame.side {
        let own = met(ray);
        let mut leader = if is_shareable(frame, own[0]) { 0 } else { ray };
        while leader < ray && !is_same(met(leader), own) {
            leader += 1;
        }
        let four_bits = leader << (ray % 8 * 4);
        if ray < 8 {
            low |= four_bits;
        } else {
            high |= four_bits;
        }
        ray += 1;
    }
    [low, high]
}

/// Arrays that are compared do not compile for GPUs.
#[inline(always)]
fn is_same([instance, triangle]: [u32; 2], other: [u32; 2]) -> bool {
    instance == other[0] && triangle == other[1]
}

/// Whether rays that meet this instance, or none, can take another's color.
#[inline(always)]
fn is_shareable(frame: &Frame, instance: u32) -> bool {
    instance != NONE || !frame.shows_sky()
}

/// One of [`leaders`].
#[inline(always)]
fn leader([low, high]: [u32; 2], ray: u32) -> u32 {
    (if ray < 8 { low } else { high }) >> (ray % 8 * 4) & 15
}

/// Where a sub-ray of a pixel is, from the pixel's first one.
#[inline(always)]
fn place(side: u32, ray: u32) -> u32 {
    // The side is 1, 2 or 4.
    number([ray & (side - 1), ray >> (side >> 1)])
}

/// Lets hits of a pixel take another's color. `first` is the place of its first sub-ray among `hits`, which starts
/// with a tile.
#[inline(always)]
pub fn share(frame: &Frame, hits: &mut [Hit], first: u32) {
    let side = frame.side;
    let leaders = leaders(
        frame,
        #[inline(always)]
        |ray| {
            let hit = &hits[(first + place(side, ray)) as usize];
            [hit.instance, hit.triangle]
        },
    );
    let mut ray = 0;
    while ray < side * side {
        let leader = leader(leaders, ray);
        if leader != ray {
            let triangle = (first + place(side, leader)) % TILE as u32;
            hits[(first + place(side, ray)) as usize] = Hit { triangle, ..Hit::MISS };
        }
        ray += 1;
    }
}

/// For each ray of a tile, the ray of the tile whose color it takes. `instances` and `triangles` are what they have met.
#[inline(always)]
pub fn tile(frame: &Frame, instances: &[u32; TILE], triangles: &[u32; TILE]) -> [u8; TILE] {
    let side = frame.side;
    // The bits of a number that say where in its pixel a ray is.
    let within = number([side - 1, side - 1]) as usize;
    let mut taken = [0; TILE];
    // Most tiles are within one triangle, or meet nothing.
    let differs = |words: &[u32; TILE]| words.iter().fold(0, |differs, word| differs | (word ^ words[0]));
    if differs(instances) | differs(triangles) == 0 {
        let kept = if is_shareable(frame, instances[0]) { !within } else { !0 };
        for (ray, taken) in taken.iter_mut().enumerate() {
            *taken = (ray & kept) as u8;
        }
        return taken;
    }
    for first in (0..TILE).filter(|ray| ray & within == 0) {
        let at = |ray: u32| first + place(side, ray) as usize;
        let leaders = leaders(frame, |ray| [instances[at(ray)], triangles[at(ray)]]);
        for ray in 0..side * side {
            taken[at(ray)] = at(leader(leaders, ray)) as u8;
        }
    }
    taken
}

/// Where the ray is whose color a ray takes: its own place, unless its hit in the first layer says otherwise. Places are
/// counted from the start of a tile.
#[inline(always)]
pub fn shaded(ray: u32, hit: &Hit) -> u32 {
    if hit.instance == NONE && hit.triangle != NONE { ray - ray % TILE as u32 + hit.triangle } else { ray }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Backdrop;
    use bytemuck::Zeroable;

    /// Hits of the second pixel of a tile whose pixels have four sub-rays, which have met these instances and triangles; after
    /// [`share`]. Its rays are numbered 2, 3, 6 and 7.
    fn shared(frame: Frame, met: [[u32; 2]; 4]) -> [u32; 4] {
        let mut hits = [Hit::MISS; 32];
        for ([instance, triangle], at) in met.into_iter().zip([18, 19, 22, 23]) {
            hits[at] = Hit { t: 1.0, instance, triangle, u: 0.3, v: 0.3 };
        }
        share(&Frame { side: 2, ..frame }, &mut hits, 18);
        [18, 19, 22, 23].map(|ray| shaded(ray, &hits[ray as usize]))
    }

    #[test]
    fn rays_take_the_color_of_the_first_that_met_their_triangle() {
        let [a, b, c] = [[1, 7], [1, 8], [2, 7]];
        let frame = Frame::zeroed();
        assert_eq!(shared(frame, [a; 4]), [18; 4]);
        assert_eq!(shared(frame, [a, b, c, b]), [18, 19, 22, 19]);
        assert_eq!(shared(frame, [c, a, a, c]), [18, 19, 19, 18]);
    }

    #[test]
    fn what_meets_nothing_is_shaded_where_there_is_something_to_show() {
        let (miss, hit) = ([NONE; 2], [1, 7]);
        assert_eq!(shared(Frame::zeroed(), [miss, hit, miss, hit]), [18, 19, 18, 19]);
        let sky = Frame { sky_first: 1, backdrop: Backdrop::Environment as u32, ..Frame::zeroed() };
        assert_eq!(shared(sky, [miss, hit, miss, hit]), [18, 19, 22, 19]);
    }

    #[test]
    fn a_tile_is_shared_as_its_pixels_are() {
        let sky = Frame { sky_first: 1, backdrop: Backdrop::Environment as u32, ..Frame::zeroed() };
        for side in [1, 2, 4] {
            for frame in [Frame::zeroed(), sky].map(|frame| Frame { side, ..frame }) {
                // One triangle, nothing, both, several instances, and several triangles of one.
                for case in 0..5 {
                    let of = |ray: u32| {
                        let both = if ray.is_multiple_of(3) { [1, 5] } else { [NONE; 2] };
                        [[1, 5], [NONE; 2], both, [ray % 2, 5], [1, ray % 3]][case]
                    };
                    let instances: [u32; TILE] = core::array::from_fn(|ray| of(ray as u32)[0]);
                    let triangles: [u32; TILE] = core::array::from_fn(|ray| of(ray as u32)[1]);
                    let mut hits = [Hit::MISS; TILE];
                    for ((hit, instance), triangle) in hits.iter_mut().zip(instances).zip(triangles) {
                        if instance != NONE {
                            *hit = Hit { t: 1.0, instance, triangle, u: 0.0, v: 0.0 };
                        }
                    }
                    let within = number([side - 1, side - 1]);
                    for first in (0..TILE as u32).filter(|ray| ray & within == 0) {
                        share(&frame, &mut hits, first);
                    }
                    for (ray, taken) in (0..).zip(tile(&frame, &instances, &triangles)) {
                        assert_eq!(shaded(ray, &hits[ray as usize]), taken.into(), "{side} {case} {ray}");
                    }
                }
            }
        }
    }

    #[test]
    fn sixteen_sub_rays_have_leaders_too() {
        let frame = Frame { side: 4, ..Frame::zeroed() };
        let leaders = leaders(&frame, |ray| [0, ray % 5]);
        assert!((0..16).all(|ray| leader(leaders, ray) == ray % 5));
        assert!(
            (0..16).all(|ray| place(4, ray) == ray && place(2, ray % 4) == [0, 1, 4, 5][ray as usize % 4])
        );
    }
}
