//! Ambient: the share of the light from all around that reaches a surface past what is near it.
//!
//! Light from all around comes from [`DIRECTIONS`] directions, which are the same everywhere: views like those of suns,
//! so that lists of blocks serve here too. A ray of the camera asks for a quarter of them, chosen by its place in a
//! square of two by two rays, and shares what it finds with the others on its surface:
//!
//! ```text
//! open  = Σ cos · min(t / reach, 1),  total = Σ cos,  over its directions in front of the surface
//! share = Σ open / Σ total,           over the rays of its square on its surface
//! ```
//!
//! where `t` is the distance of the nearest opaque surface in that direction, and `cos` that of direction and normal. So
//! what touches a surface hides all of its direction, and what is `reach` away nothing: no edge shows where rays end.
//! The weights are those of diffuse surfaces (obscurances; Zhukov, Iones and Kronin, 1998).
//!
//! Refused: rays in directions of their own for each pixel, because packets and lists want one direction; a filter over
//! more pixels, because it needs a barrier between blocks, and more rays of the same directions find nothing new.

use crate::grid::RayIndex;
use crate::kernel::hit_filter::Opaque;
use crate::kernel::ray::Ray;
use crate::lane::{Bits, Lane, Row, Select, V3, groups};
use crate::layout::{Frame, Surface, View};
use crate::num::{flush, recip};
use crate::stage::context::Context;
use crate::stage::occlusion::trace_by_block;
use crate::stage::surface::Surfaces;

/// The directions from which light comes.
pub const DIRECTIONS: u32 = 16;
/// The rays of a square, each of which asks for every fourth direction.
const CLASSES: u32 = 4;

/// What a ray has found: the open share of its directions, and all of them, weighted.
pub type Found<L> = [L; 2];

/// The class of the ray with this number.
#[inline(always)]
fn class(number: u32) -> u32 {
    (number & 1) | (number >> 1 & 2)
}

/// The number of rays of a packet that sorts them by their classes: a block's.
const SORTED: usize = 256;

/// Where the ray with this number in its block is in the order of classes: rays of one class after another, so that
/// all rays of a group ask for the same directions; within a class by tiles of 4 × 4, which reach over 8 × 8 rays.
#[inline(always)]
fn sorted_place(number: u32) -> usize {
    let bit = |from: u32, to: u32| (number >> from & 1) << to;
    (bit(1, 0) | bit(4, 1) | bit(3, 2) | bit(6, 3) | bit(5, 4) | bit(7, 5) | class(number) << 6) as usize
}

/// The number in its block of the ray at this place in the order of classes.
#[inline(always)]
fn number_at(place: u32) -> usize {
    let bit = |from: u32, to: u32| (place >> from & 1) << to;
    (bit(0, 1) | bit(1, 4) | bit(2, 3) | bit(3, 6) | bit(4, 5) | bit(5, 7) | bit(6, 0) | bit(7, 2)) as usize
}

/// Values of the rays of a packet in another order: `from(place)` is the place at which one was. Packets that are
/// not sorted keep their order.
#[inline(always)]
fn reordered<L: Lane, const G: usize>(values: [L; G], from: impl Fn(u32) -> usize) -> [L; G] {
    if G * L::WIDTH != SORTED {
        return values;
    }
    let rows: [L::Row; G] = groups(
        #[inline(always)]
        |g| values[g].row(),
    );
    groups(
        #[inline(always)]
        |g| {
            let [value] = L::gather(
                values[g].token(),
                #[inline(always)]
                |lane| {
                    let place = from((g * L::WIDTH + lane) as u32);
                    [rows[place / L::WIDTH].at(place % L::WIDTH)]
                },
            );
            value
        },
    )
}

/// [`reordered`] vectors, by classes.
#[inline(always)]
fn by_class<L: Lane, const G: usize>(values: [V3<L>; G]) -> [V3<L>; G] {
    let x = groups(
        #[inline(always)]
        |g| values[g].x,
    );
    let y = groups(
        #[inline(always)]
        |g| values[g].y,
    );
    let z = groups(
        #[inline(always)]
        |g| values[g].z,
    );
    let (x, y, z): ([L; G], [L; G], [L; G]) =
        (reordered(x, number_at), reordered(y, number_at), reordered(z, number_at));
    groups(
        #[inline(always)]
        |g| V3 { x: x[g], y: y[g], z: z[g] },
    )
}

/// What the rays that hit these surfaces find; they are numbered from `first` on.
#[inline(always)]
pub fn ambient<L: Lane, const G: usize>(
    context: &Context<'_>,
    first: RayIndex,
    surfaces: &[Surfaces<L>; G],
) -> [Found<L>; G] {
    let frame = context.frame;
    let none = surfaces[0].footprint.broadcast(0.0);
    let (mut open, mut total) = ([none; G], [none; G]);
    // A packet asks for one direction after another. A ray alone passes over those that it does not ask for.
    let is_alone = G * L::WIDTH == 1;
    let mut number = if is_alone { class(first.0) } else { 0 };
    let step = if is_alone { CLASSES } else { 1 };
    let inverse = recip(frame.ambient_reach);
    let origins = by_class::<L, G>(groups(
        #[inline(always)]
        |g| surfaces[g].origin,
    ));
    // Of a ray that hits nothing, 0: nothing is in front of it.
    let normals = by_class::<L, G>(groups(
        #[inline(always)]
        |g| {
            let found = surfaces[g].material.gt(surfaces[g].material.broadcast(0));
            V3::select(found, surfaces[g].normal, V3 { x: none, y: none, z: none })
        },
    ));
    while number < DIRECTIONS {
        let view = &context.views[(frame.ambient_view + number) as usize];
        let cosines: [L; G] = groups(
            #[inline(always)]
            |g| cosine::<L, G>(view, number % CLASSES, first.0 + (g * L::WIDTH) as u32, normals[g]),
        );
        let limits: [L; G] = groups(
            #[inline(always)]
            |g| cosines[g].gt(none).select(none.broadcast(frame.ambient_reach), none.broadcast(-1.0)),
        );
        let toward = -V3::splat(none.token(), view.along);
        let toward = Ray::<L>::new(origins[0], toward);
        let rays: [Ray<L>; G] = groups(
            #[inline(always)]
            |g| Ray { origin: origins[g], ..toward },
        );
        let ends = trace_by_block(context, view, &origins, &rays, &limits, &mut [Opaque; G]);
        let mut g = 0;
        while g < G {
            let share = ends[g].lt(limits[g]).select(flush(ends[g] * inverse), none.broadcast(1.0));
            open[g] = open[g] + flush(cosines[g] * share);
            total[g] = total[g] + cosines[g];
            g += 1;
        }
        number += step;
    }
    let (open, total) = (reordered(open, sorted_place), reordered(total, sorted_place));
    groups(
        #[inline(always)]
        |g| [open[g], total[g]],
    )
}

/// The cosine of normals and the direction to a view, in the lanes of a class that see it; else 0. `first` is the number
/// of the first lane's ray, or its place in the order of classes.
#[inline(always)]
fn cosine<L: Lane, const G: usize>(view: &View, class_of_view: u32, first: u32, normal: V3<L>) -> L {
    let token = normal.x.token();
    let none = normal.x.broadcast(0.0);
    let is_sorted = G * L::WIDTH == SORTED;
    if is_sorted && first >> 6 & 3 != class_of_view {
        return none;
    }
    let cosine = flush(-normal.dot(V3::splat(token, view.along)));
    let classes = L::bits_from_fn(
        token,
        #[inline(always)]
        |lane| if is_sorted { class_of_view } else { class(first + lane as u32) },
    );
    let is_asked = classes.eq(classes.broadcast(class_of_view)) & cosine.gt(none);
    is_asked.select(cosine, none)
}

/// What a ray shares with the others of its square: what it has found, its surface's origin, and its normal.
pub type Record = [f32; 8];

/// The record of a ray on a surface.
#[inline(always)]
pub fn record(found: [f32; 2], surface: &Surface) -> Record {
    let ([open, total], [x, y, z], [i, j, k]) = (found, surface.origin, surface.normal);
    [open, total, x, y, z, i, j, k]
}

/// How much of the squared distance to the plane of a surface counts: 1 / tan² 14°.
const FLATNESS: f32 = 16.0;
/// The least cosine of two normals of one surface.
const BEND: f32 = 0.75;

/// The share of the light from all around that reaches a group of surfaces, 0 ..= 1; 1 in frames that do not ask.
/// `record(number)` is that of the ray with this number; their own are numbered from `first` on.
#[inline(always)]
pub fn share<L: Lane>(token: L::Token, frame: &Frame, first: u32, record: impl Fn(u32) -> Record) -> L {
    let (zero, one) = (L::splat(token, 0.0), L::splat(token, 1.0));
    if !frame.has_ambient_rays() {
        return one;
    }
    let [mut open, mut total] = [zero; 2];
    let (mut origin, mut normal) = (V3 { x: zero, y: zero, z: zero }, V3 { x: zero, y: zero, z: zero });
    let mut other = 0;
    while other < CLASSES {
        // In a tile of 4 × 4 the next column is 1 away, and the next row 4.
        let aside = (other & 1) | (other & 2) << 1;
        let [there_open, there_total, x, y, z, i, j, k]: [L; 8] = L::gather(
            token,
            #[inline(always)]
            |lane| record((first + lane as u32) ^ aside),
        );
        let (place, facing) = (V3 { x, y, z }, V3 { x: i, y: j, z: k });
        if other == 0 {
            (origin, normal) = (place, facing);
        }
        let way = place - origin;
        let (square, height) = (flush(way.dot(way)), normal.dot(way));
        let is_same =
            square.ge(flush(height * height) * FLATNESS) & normal.dot(facing).ge(one.broadcast(BEND));
        open = is_same.select(open + there_open, open);
        total = is_same.select(total + there_total, total);
        other += 1;
    }
    open.lt(total).select(open * recip(total), one)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::plain::Plain;
    use crate::scene::{Material, Scene};
    use crate::stage::fixture::{Prepared, add_square, square_at, surfaces};
    use glam::{Mat4, Vec3};
    use std::vec::Vec;

    /// The shares of all rays of the fixture's picture, row by row, where the light from all around is hidden by what
    /// is nearer than `reach`.
    fn shares(mut scene: Scene, reach: f32) -> Vec<f32> {
        scene.ambient = Vec3::ONE;
        let prepared = Prepared::new(scene, |request| request.ambient_occlusion(reach));
        let (context, frame) = (prepared.context(), prepared.frame());
        let found: Vec<Record> = (0..256)
            .map(|number| {
                let [seen] = surfaces::<f32, 1>(&prepared, RayIndex(number));
                let [found] = ambient(&context, RayIndex(number), &[seen]);
                record(found, &seen.lane(0))
            })
            .collect();
        let share = |number: u32| share::<f32>((), frame, number, |ray| found[ray as usize]);
        let at = |x: u32, y: u32| share(frame.grid().index([x, y]).0);
        (0..16).flat_map(|y| (0..16).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect()
    }

    fn white() -> Material {
        Material::new([1.0; 3]).double_sided(true)
    }

    #[test]
    fn rays_are_sorted_by_their_class() {
        for number in 0..256 {
            let place = sorted_place(number);
            assert_eq!((place >> 6, number_at(place as u32)), (class(number) as usize, number as usize));
        }
    }

    #[test]
    fn packets_find_what_single_rays_find() {
        let mut scene = Scene::new();
        add_square(&mut scene, white(), square_at(100.0, [0.0; 3]));
        for i in 0..20 {
            let place = [(i % 5) as f32 * 3.0 - 6.0, (i / 5) as f32 * 3.5 - 6.0, 1.0];
            let turn = Mat4::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), i as f32 * 0.7);
            add_square(&mut scene, white(), square_at(1.0, place) * turn);
        }
        scene.ambient = Vec3::ONE;
        let prepared = Prepared::new(scene, |request| request.ambient_occlusion(3.0));
        let single = found_in_packets::<f32, 1>(&prepared);
        assert!(single.iter().filter(|[open, total]| open < total).count() > 60);
        assert_eq!(found_in_packets::<Plain<8>, 32>(&prepared), single);
        assert_eq!(found_in_packets::<f32, 16>(&prepared), single);
    }

    /// What all rays of the fixture's picture find, traced in packets.
    fn found_in_packets<L: Lane<Token = ()>, const G: usize>(prepared: &Prepared) -> Vec<[f32; 2]> {
        let (context, rays) = (prepared.context(), L::WIDTH * G);
        let packets = (0..256).step_by(rays).map(RayIndex);
        let all = packets.flat_map(|first| {
            let found = ambient(&context, first, &surfaces::<L, G>(prepared, first));
            (0..rays).map(move |ray| found[ray / L::WIDTH].map(|values| values.row().at(ray % L::WIDTH)))
        });
        all.collect()
    }

    #[test]
    fn nothing_hides_light_from_an_open_plane() {
        let mut scene = Scene::new();
        add_square(&mut scene, white(), square_at(100.0, [0.0; 3]));
        assert!(shares(scene, 50.0).iter().all(|share| *share == 1.0));
    }

    #[test]
    fn a_box_hides_all_light_from_its_inside() {
        let mut scene = Scene::new();
        add_square(&mut scene, white(), square_at(9.0, [0.0; 3]));
        // The camera, which looks down from above, is in it.
        add_square(&mut scene, white(), square_at(9.0, [0.0, 0.0, 18.0]));
        for turn in 0..4 {
            let turn = Mat4::from_rotation_z(turn as f32 * core::f32::consts::FRAC_PI_2);
            let wall = Mat4::from_translation(Vec3::new(9.0, 0.0, 9.0)) * Mat4::from_rotation_y(-1.570_796_4);
            add_square(&mut scene, white(), turn * wall * Mat4::from_scale(Vec3::splat(9.0)));
        }
        // The farthest corner is at 31, so 1 − 31 / reach is hidden at least.
        assert!(shares(scene, 3100.0).iter().all(|share| *share <= 0.01));
    }

    #[test]
    fn a_wall_hides_half_of_the_light_at_its_foot() {
        let mut scene = Scene::new();
        add_square(&mut scene, white(), square_at(1000.0, [0.0; 3]));
        let wall = Mat4::from_translation(Vec3::new(8.0, 0.0, 0.0)) * Mat4::from_rotation_y(1.570_796_4);
        add_square(&mut scene, white(), wall * Mat4::from_scale(Vec3::splat(1000.0)));
        let near = shares(scene, 1e6);
        // At the wall's foot half of the cosine-weighted hemisphere is hidden; sixteen directions tell it within a tenth.
        for row in near.chunks(16) {
            assert!((row[15] - 0.5).abs() < 0.1, "{}", row[15]);
        }
    }

    #[test]
    fn a_ceiling_hides_light_by_how_near_it_is() {
        // Below an endless ceiling at height h light goes h / cos far: the share is the mean of h / reach over the
        // directions, as h / (cos · reach) is weighted by cos. Below a nearer one it is less.
        let mut last = 0.0;
        for height in [0.5, 1.0, 2.0] {
            let mut scene = Scene::new();
            add_square(&mut scene, white(), square_at(1e4, [0.0; 3]));
            // The camera is below the ceiling.
            add_square(&mut scene, white(), square_at(1e4, [0.0, 0.0, 4.0 + height]));
            let all = shares(scene, 1e5);
            // Eight directions are in front; their cosines are 1/16, 3/16, … 15/16, of which the sum is 4, if the pole
            // of the directions is the normal. It is not, so the sum is only close to that.
            let expected = (4.0 + height) / 1e5 * 8.0 / 4.0;
            assert!(all.iter().all(|share| (*share / expected - 1.0).abs() < 0.3), "{} {expected}", all[0]);
            assert!(all[0] > last);
            last = all[0];
        }
    }
}
