//! Penumbra: the edges of shadows, blurred as far as a light with a radius makes them.
//!
//! One shadow ray a ray and light goes to the light's middle, and tells what is left of the light
//! and how wide a penumbra its nearest occluder casts. Then, on the screen, each ray looks for
//! shadows around it whose penumbras reach it ([`soften`]), and takes the average of what is left
//! within a disc as large as these penumbras are. For an edge across the light's way, and a
//! surface that goes on, that is the share of the light that is seen: what the occluder covers of
//! the light, as seen from the surface, is what its hard shadow covers of the disc.
//!
//! The paper blurs so too (Analytical soft shadows). Departures: it does not say how a surface
//! outside of a hard shadow comes to know of its penumbra, hence the search; and the disc lies
//! across the light's way, in the world, rather than on the screen, so that a penumbra does not
//! depend on where it is seen from.

use crate::grid::RayIndex;
use crate::kernel::lists::Lists;
use crate::kernel::penumbra::Nearest;
use crate::kernel::tint::{color, packed};
use crate::kernel::traverse::Geometry;
use crate::lane::{Bits, Lane, Select, V3, Word, groups};
use crate::layout::{Frame, Surface, View};
use crate::num::{clamp, floor, flush, normalize, recip, sqrt};
use crate::stage::occlusion::{cross, to_light};

/// Where what is left of a light at a ray is, in the words of a band's shadows: one for each ray
/// and light.
#[inline(always)]
pub fn left_at(frame: &Frame, ray: u32, light: u32) -> usize {
    (ray * frame.lights + light) as usize
}

/// Where the size of the penumbra is: behind those, one for each ray and light.
#[inline(always)]
pub fn size_at(frame: &Frame, ray: u32, light: u32) -> usize {
    (frame.rays * frame.lights) as usize + left_at(frame, ray, light)
}

/// What is left of a light at a group of surfaces, and the sizes of the penumbras there: those
/// of [`Nearest`] where the surfaces ask for the light (see [`ask`](super::occlusion::ask)), 0
/// and −1 elsewhere.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "structs of references cannot hold what loops change")]
pub fn near<L: Lane, const G: usize>(
    frame: &Frame,
    views: &[View],
    lists: &Lists<'_>,
    geometry: &Geometry<'_>,
    light: u32,
    first: RayIndex,
    origins: &[V3<L>; G],
    asked: &[L::Bits; G],
) -> [(L::Bits, L); G] {
    let mut searches: [Nearest<L>; G] = groups(
        #[inline(always)]
        |g| Nearest::new(origins[g].x),
    );
    cross(frame, views, lists, geometry, light, first, origins, asked, &mut searches);
    let light = &views[frame.light_view(light) as usize];
    groups(
        #[inline(always)]
        |g| answer(light, asked[g], &searches[g]),
    )
}

/// [`near`] of a group.
#[inline(always)]
fn answer<L: Lane>(light: &View, asked: L::Bits, search: &Nearest<L>) -> (L::Bits, L) {
    let none = asked.like(0);
    let is_asked = none.less_than(asked);
    let size = search.penumbra(light);
    (is_asked.select(search.word(), none), is_asked.select(size, size.like(-1.0)))
}

/// Taps of the search on either side of a ray, along both axes of its lattices.
const SEARCH: u32 = 4;
/// Taps of the blur on either side.
const BLUR: u32 = 5;
/// What one of them is of all.
const SHARE: f32 = 1.0 / BLUR as f32;

/// How many rays aside [`soften`] looks, at most.
#[inline(always)]
pub fn reach(frame: &Frame) -> u32 {
    // The wider lattices: those of the blur, whose steps are at most 5 · side (see `steps`).
    BLUR * (5 * frame.side + 1)
}

/// A ray that looks for others on its surface.
#[derive(Clone, Copy)]
struct Here {
    origin: V3<f32>,
    normal: V3<f32>,
    /// Unit vector to the light's middle.
    toward: V3<f32>,
}

/// What is left of a light at a ray (numbered in its band) once its shadow is soft, as a word.
/// `shadows` are the words that [`left_at`] and [`size_at`] find their ways in, `surfaces` those
/// of the rays.
///
/// ```text
/// radius = average of the penumbras that reach the ray
/// left   = Σ weight · left there / Σ weight, weight = 1 within the radius, 0 beyond it
/// ```
///
/// Both go through neighbors on lattices that are turned against the pixels' own, so that few of
/// them see edges along rows and columns come as evenly as others; the second one's steps
/// grow with the radius. A penumbra ends [`Frame::window`] rays aside. The weight falls from 1
/// to 0 over a step of the lattice, so that few taps show no steps.
///
/// A neighbor is on the same surface if it lies within some 14° of the surface's plane, and its
/// normal within 41° of the surface's; others have no say, so shadows do not leak over edges.
///
/// Where the search sees nothing but what is left here, too, nothing is blurred.
///
/// Sums are in the order of the lattice, whoever computes them.
#[inline(always)]
pub fn soften(
    frame: &Frame,
    views: &[View],
    surfaces: &[Surface],
    shadows: &[u32],
    ray: u32,
    light: u32,
) -> u32 {
    let own = shadows[left_at(frame, ray, light)];
    let size = f32::from_bits(shadows[size_at(frame, ray, light)]);
    if own == 0 && size < 0.0 {
        return 0;
    }
    let number = RayIndex(frame.first_ray + ray);
    let at = frame.grid().ray(number);
    let mut is_same = true;
    let mut tap = 0;
    while is_same && tap < SEARCHED {
        let there = searched(frame, at, tap);
        tap += 1;
        if there != MISSING {
            is_same = shadows[left_at(frame, there, light)] == own;
        }
    }
    if is_same {
        return own;
    }
    let (camera, view) = (&views[Frame::CAMERA as usize], &views[frame.light_view(light) as usize]);
    let surface = &surfaces[ray as usize];
    let origin = V3::<f32>::splat((), surface.origin);
    let here = Here {
        origin,
        normal: V3::splat((), surface.normal),
        toward: normalize(to_light(frame, view, number, origin).0),
    };

    let (mut sum, mut count) = (0.0_f32, 0.0_f32);
    let mut tap = 0;
    while tap < SEARCHED {
        let there = searched(frame, at, tap);
        tap += 1;
        if there == MISSING {
            continue;
        }
        let size = f32::from_bits(shadows[size_at(frame, there, light)]);
        if size > 0.0 {
            let aside = distance(&here, &surfaces[there as usize]);
            if aside >= 0.0 && aside <= flush(size * size) {
                sum += size;
                count += 1.0;
            }
        }
    }
    if count == 0.0 {
        return own;
    }

    // How many rays the radius is on the screen, if the surface faces the eye.
    let depth = (origin - V3::splat((), camera.center)).dot(V3::splat((), camera.depth));
    let cell = depth * camera.pixel_t + camera.pixel;
    let slope = here.normal.dot(here.toward);
    let cell = cell * if slope < LEAST_SLOPE { LEAST_SLOPE } else { slope };
    let widest = cell * frame.window as f32;
    let mean = sum * recip(count);
    let radius = if mean < widest { mean } else { widest };
    let steps = steps(radius * recip(cell), frame.side);
    let edge = radius * SHARE;
    let edge = if edge < cell { cell } else { edge };
    let sharpness = recip(radius * edge) * 0.5;
    let square = radius * radius;

    let (mut total, mut red, mut green, mut blue) = (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
    let mut tap = 0;
    while tap < (2 * BLUR + 1) * (2 * BLUR + 1) {
        let there = neighbor::<BLUR>(frame, at, steps, tap);
        tap += 1;
        if there == MISSING {
            continue;
        }
        let left = shadows[left_at(frame, there, light)];
        let is_asked = left != 0 || f32::from_bits(shadows[size_at(frame, there, light)]) >= 0.0;
        if is_asked {
            let aside = distance(&here, &surfaces[there as usize]);
            if aside >= 0.0 {
                let weight = clamp((square - aside) * sharpness + 0.5, 0.0, 1.0);
                let light = color::<f32>(Word(left));
                total += weight;
                red += light.x * weight;
                green += light.y * weight;
                blue += light.z * weight;
            }
        }
    }
    let inverse = recip(total);
    packed::<f32>([red * inverse, green * inverse, blue * inverse]).0
}

/// The least cosine between a surface's normal and the way to the light that is reckoned with.
const LEAST_SLOPE: f32 = 1.0 / 16.0;

/// The steps of the blur's lattice, so that it covers a disc of this radius, in rays:
/// `√((radius / BLUR)² − 1)`, rounded up, at most `5 · side`.
#[inline(always)]
fn steps(radius: f32, side: u32) -> u32 {
    let ratio = radius * SHARE;
    let steps = sqrt(ratio * ratio - 1.0);
    let steps = if steps > 0.0 { floor(steps) + 1.0 } else { 0.0 };
    let most = (5 * side) as f32;
    (if steps < most { steps } else { most }) as u32
}

/// Taps of the search.
const SEARCHED: u32 = 2 * (2 * SEARCH + 1) * (2 * SEARCH + 1);

/// The ray at a tap of the search around column and row `at`, as [`neighbor`] gives it: first of a
/// lattice as narrow as pixels, then of one as wide as the window.
#[inline(always)]
fn searched(frame: &Frame, at: [u32; 2], tap: u32) -> u32 {
    let steps = if 2 * tap < SEARCHED { frame.side } else { 6 * frame.side };
    neighbor::<SEARCH>(frame, at, steps, tap)
}

/// What [`neighbor`] gives where there is no ray.
const MISSING: u32 = u32::MAX;

/// The ray at a tap of a lattice around column and row `at`, numbered in the frame's band, or
/// [`MISSING`]. The lattice goes `N` times along `(steps, 1)` and `(−1, steps)`, both ways; it is
/// walked row by row, and again from the start.
#[inline(always)]
fn neighbor<const N: u32>(frame: &Frame, at: [u32; 2], steps: u32, tap: u32) -> u32 {
    let i = (tap % (2 * N + 1)).wrapping_sub(N);
    let j = (tap / (2 * N + 1) % (2 * N + 1)).wrapping_sub(N);
    let x = at[0].wrapping_add(i.wrapping_mul(steps)).wrapping_sub(j);
    let y = at[1].wrapping_add(i).wrapping_add(j.wrapping_mul(steps));
    // What is left of the first column, or above the first row, has wrapped around.
    if !frame.grid().contains([x, y]) {
        return MISSING;
    }
    let number = frame.grid().index([x, y]).0;
    let ray = number.wrapping_sub(frame.first_ray);
    if ray < frame.rays { ray } else { MISSING }
}

/// How much of the squared distance to the plane of a surface counts: 1 / tan² 14°.
const FLATNESS: f32 = 16.0;
/// The least cosine of two normals of one surface.
const BEND: f32 = 0.75;

/// The squared distance of a surface from here, across the way to the light; −1 if it is another
/// surface.
#[inline(always)]
fn distance(here: &Here, there: &Surface) -> f32 {
    let way = V3::<f32>::splat((), there.origin) - here.origin;
    let (square, height) = (flush(way.dot(way)), here.normal.dot(way));
    let along = way.dot(here.toward);
    let is_flat = flush(height * height) * FLATNESS <= square;
    let is_same = is_flat && here.normal.dot(V3::splat((), there.normal)) >= BEND;
    let aside = flush(square - along * along);
    if !is_same {
        -1.0
    } else if aside > 0.0 {
        aside
    } else {
        0.0
    }
}
