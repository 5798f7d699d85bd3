//! A sample of every kernel that computes a frame's numbers, as words: what a device is asked when
//! it is opened, and what the CPU compares the answer with.
//!
//! Traversal, lists and gathers have no numbers of their own: they compare and choose what these
//! kernels give. What a rasterizer draws (`project`) is outside of the promise.

mod fixture;

pub use fixture::{Fixture, Given};

use crate::grid::RayIndex;
use crate::kernel::area::{disc, light_offset};
use crate::kernel::brushed::{Brushed, bent};
use crate::kernel::cone::cone;
use crate::kernel::environment::{arriving, mirrored, octahedral};
use crate::kernel::falloff::falloff;
use crate::kernel::interpolate::Weights;
use crate::kernel::microfacet::{Microfacets, alpha_squared, lambert, widened};
use crate::kernel::mip::{footprint, levels};
use crate::kernel::offset::{ErrorBound, offset};
use crate::kernel::penumbra::penumbra_radius;
use crate::kernel::ray::{Ray, normal, point, vector};
use crate::kernel::refraction::{exit_normal, refracted};
use crate::kernel::screen_bounds::{screen_bounds, sphere_in_block};
use crate::kernel::shadow_distance::is_near;
use crate::kernel::sheen::Sheen;
use crate::kernel::slab::{RelativeBox, intersects, slab};
use crate::kernel::sphere::{self, Chord, ENTRY, EXIT};
use crate::kernel::split_sum::albedo;
use crate::kernel::tangent;
use crate::kernel::terminator::lift;
use crate::kernel::texture::{Maps, MaterialLookup, TexCoords, finest, sample};
use crate::kernel::thin_film::Film;
use crate::kernel::tone_map::tone_map;
use crate::kernel::transmittance::{Transmittance, color};
use crate::kernel::triangle::{Intersection, Triangle, intersect};
use crate::kernel::variance::{self, Curve};
use crate::kernel::view::{camera_ray, light_block};
use crate::lane::{Bits, Lane, Select, V3};
use crate::layout::{FinestLevel, Instance, MaterialRecord, ToneMap};
use crate::num::{self, flush, flush3};
use fixture::{CAMERA, SKY, SPOT, SUN};

/// Names the words of [`canary`].
macro_rules! names {
    ($($name:literal,)*) => {
        /// What each word of [`canary`] is: a function, or one of several results of it.
        pub const NAMES: [&str; OUTPUTS] = [$($name),*];
        /// How many words [`canary`] gives.
        pub const OUTPUTS: usize = [$($name),*].len();
    };
}
names! {
    "recip",
    "rsqrt",
    "sqrt",
    "exp2",
    "log2",
    "pow",
    "atan2",
    "sine",
    "cosine",
    "srgb_encode",
    "srgb_decode",
    "floor",
    "round",
    "normalize",
    "slab near",
    "slab far",
    "box",
    "triangle",
    "t",
    "u",
    "v",
    "front",
    "sphere entered",
    "sphere left",
    "sphere point",
    "sphere start",
    "sphere tangents",
    "sphere longitude and latitude",
    "sphere texture density",
    "point",
    "ray to object",
    "vector",
    "normal",
    "offset",
    "placed offset",
    "lift",
    "weights",
    "camera ray",
    "light block",
    "screen bounds",
    "sphere in block",
    "shadow distance",
    "disc",
    "light offset",
    "falloff",
    "inverse square falloff",
    "cone",
    "lambert",
    "diffuse share",
    "microfacets",
    "brushed microfacets",
    "bent normal",
    "width of a lobe",
    "widened roughness",
    "albedo",
    "reflectance",
    "sheen",
    "albedo of a sheen",
    "refraction",
    "normal where light leaves",
    "thin film",
    "variance of a triangle",
    "variance of a sphere",
    "variance of a map",
    "mip footprint",
    "mip levels",
    "texture",
    "finest level",
    "packed tangent",
    "packed direction",
    "bump",
    "octahedral",
    "mirrored environment",
    "arriving environment",
    "transmittance",
    "transmitted color",
    "penumbra radius",
    "tone map neutral",
    "tone map agx",
    "tone map aces",
}

/// Words that one case reads, from its own on: a ray's origin and direction, and the three
/// corners of a triangle.
pub const INPUTS: u32 = 15;

/// The kernels' answers to the words from `index` on, read as numbers and wrapping at the
/// end of `words`, which are not none; see [`NAMES`]. Lane `i` is the case of the words from
/// `index + i` on. `given` is that of a [`Fixture`].
///
/// Functions of [`num`] get words as they are, but for `floor` and `round`, which may be given no
/// denormal. Points are put in range as a mesh's positions are, shares are the lower 16 bits of a
/// word. Results that a stage flushes are flushed here. Several numbers that are one result make
/// one word. A packet of rays is asked for the triangle of each lane in turn. Results that are NaN
/// become one and the same NaN: devices choose different ones.
#[inline(always)]
pub fn canary<L: Lane>(token: L::Token, words: &[u32], given: &Given<'_>, index: u32) -> [L::Bits; OUTPUTS] {
    let Given { frame, views, instances, maps } = given;
    let to_object = &instances[0].to_object;
    let (x, y) = (number::<L>(token, words, index), number::<L>(token, words, index + 1));
    // Whole numbers are asked for of nothing that a device may flush.
    let whole = flush(x);
    let [sine, cosine] = num::sine_and_cosine(num::clamp(x, -1.0, 1.0));
    let ray = Ray::new(place::<L>(token, words, index), place::<L>(token, words, index + 3));
    let found = meet::<L>(&ray, words, index);
    let chord = Chord::new(&ray);
    let [entry, exit] = [
        chord.side(ray.direction, ENTRY, x.broadcast(f32::MAX)),
        chord.side(ray.direction, EXIT, x.broadcast(f32::MAX)),
    ];
    let [u, v, w] = [
        share::<L>(token, words, index),
        share::<L>(token, words, index + 1),
        share::<L>(token, words, index + 2),
    ];
    let ball = sphere::point(u, v);
    let [tangent, bitangent] = sphere::tangents(ball);
    let [longitude, latitude] = sphere::longitude_and_latitude(ball);
    let way = ray.direction;
    let unit = direction(way);
    let facing = direction(unit + ball);
    let chosen = packed::<L>(token, words, index);
    let seen = camera_ray(&views[CAMERA], u * 64.0, v * 64.0);
    let [across, up] = disc(u * 2.0 - 1.0, v * 2.0 - 1.0);
    let distance = num::sqrt(way.dot(way));
    let mip = levels(flush(x.abs()), v.broadcast(3.0), v.broadcast(4.0));
    let materials = chosen.gt(chosen.broadcast(0x7fff_ffff)).select(chosen.broadcast(2), chosen.broadcast(1));
    let materials = MaterialLookup::<L>::new(materials);
    let tex_coords = TexCoords { uv: [[whole, flush(y)], [u, v]], footprint: [w, u * 0.25] };
    let mut transmittance = Transmittance::<L, false>::new(x);
    transmittance.add([u, v, w, w * 0.5]);
    transmittance.add([v, w, u, u * 0.5]);
    let weights = Weights::new(u, v);
    let width = alpha_squared(w, u * 0.25);
    let bound = ErrorBound::of_triangle(ray.origin, [ball, unit], v);
    let answer = Microfacets::new(ball, facing, width).respond(unit, lambert(ball, unit), v);
    let brushed = Brushed::new(ball, tangent, facing, width, u).respond(unit, lambert(ball, unit), v);
    let (white, fibers) = (albedo(u, w), Sheen::new(ball, facing, w));
    let curve = Curve { edges: [ball, unit], turns: [tangent, facing], normal: ball + unit, area: v };
    [
        bits(num::recip(x)),
        bits(num::rsqrt(x)),
        bits(num::sqrt(x)),
        bits(num::exp2(x)),
        bits(num::log2(x)),
        bits(num::pow(x, y)),
        bits(num::atan2(y, x)),
        bits(sine),
        bits(cosine),
        bits(num::srgb_encode(x)),
        bits(num::srgb_decode(x)),
        bits(num::floor(whole)),
        bits(num::round(whole)),
        folded(unit),
        found.near,
        found.far,
        found.in_box,
        found.met,
        found.t,
        found.u,
        found.v,
        found.front,
        side(&entry),
        side(&exit),
        folded(ball),
        folded(flush3(sphere::start(ball, u.lt(v)))),
        fold(folded(flush3(tangent)), folded(flush3(bitangent))),
        fold(bits(longitude), bits(latitude)),
        bits(sphere::density(ball)),
        folded(flush3(point(&instances[0].to_world, ray.origin))),
        folded(flush3(ray.to_object(&instances[0]).origin)),
        folded(flush3(vector(to_object, way))),
        folded(flush3(normal(to_object, unit))),
        folded(flush3(offset(ray.origin, unit, bound.distance(unit)))),
        bits(bound.placed_distance(unit, &instances[0].to_world, to_object)),
        folded(flush3(lift(&weights, ball, &[unit, facing, way], &[tangent, ball, unit], facing))),
        folded(flush3(weights.mix3(unit, ball, ray.origin))),
        fold(folded(flush3(seen.origin)), folded(flush3(seen.direction))),
        fold(light_block(&views[SPOT], ray.origin), light_block(&views[SUN], ray.origin)),
        L::bits_from_fn(
            token,
            #[inline(always)]
            |lane| covered(given, words, index + lane as u32),
        ),
        L::bits_from_fn(
            token,
            #[inline(always)]
            |lane| reached(given, words, index + lane as u32),
        ),
        L::bits_from_fn(
            token,
            #[inline(always)]
            |lane| casts_shadow(given, words, index + lane as u32),
        ),
        fold(bits(flush(across)), bits(flush(up))),
        folded(flush3(light_offset(frame, &views[SPOT], RayIndex(index), way))),
        bits(flush(falloff(&views[SUN], distance))),
        bits(flush(falloff(&views[SPOT], distance))),
        bits(flush(cone(&views[SPOT], unit))),
        bits(lambert(unit, facing)),
        bits(answer.diffuse),
        fold(bits(answer.specular), bits(answer.grazing)),
        fold(bits(brushed.specular), bits(brushed.grazing)),
        folded(flush3(bent(ball, tangent, facing, u, v))),
        bits(width),
        bits(flush(widened(w, u))),
        fold(bits(flush(white.sum)), bits(flush(white.grazing))),
        bits(flush(white.reflectance(u, v))),
        bits(fibers.respond(unit, lambert(ball, unit))),
        bits(flush(fibers.albedo(w))),
        folded(flush3(refracted(-unit, ball, num::recip(u + 1.0)))),
        folded(flush3(exit_normal(ball, facing, num::recip(u + 1.0)))),
        folded(Film { ior: u * 2.0 + 1.0, thickness: v * 2048.0 }.reflectance(w, V3 { x: u, y: v, z: w })),
        bits(variance::of_curve(w, u, &curve)),
        bits(variance::of_sphere(u, v)),
        bits(variance::of_map(u, v)),
        bits(flush(footprint(u, v, w))),
        fold(fold(bits(mip.fine), bits(mip.coarse)), bits(flush(mip.share))),
        colored(sample::<L, { MaterialRecord::COLOR }, true>(maps, &materials, &tex_coords)),
        L::bits_from_fn(
            token,
            #[inline(always)]
            |lane| finest_level(maps, words, index + lane as u32),
        ),
        folded(unpacked::<L>(token, words, index)),
        folded(flush3(tangent::unpack_direction::<L>(tangent::pack_direction(way)))),
        folded(flush3(tangent::bumped(ball, tangent, bitangent, u.lt(v), [u, v, w]))),
        {
            let [u, v] = octahedral(unit);
            fold(bits(flush(u)), bits(flush(v)))
        },
        folded(flush3(mirrored(maps, SKY, unit, w))),
        folded(flush3(arriving(maps, SKY, unit))),
        transmittance.word(),
        folded(flush3(color::<L>(transmittance.word()))),
        fold(
            bits(penumbra_radius(&views[SPOT], u)),
            bits(penumbra_radius(&views[SUN], flush(x.abs().min(x.broadcast(f32::MAX))))),
        ),
        shown(ToneMap::Neutral, way, [u, v, w]),
        shown(ToneMap::Agx, way, [u, v, w]),
        shown(ToneMap::Aces, way, [u, v, w]),
    ]
}

/// What a tone map makes of light of any strength, or of light around white.
#[inline(always)]
fn shown<L: Lane>(map: ToneMap, any: V3<L>, usual: [L; 3]) -> L::Bits {
    let [x, y, z] = usual;
    let is_usual = x.lt(x.broadcast(0.5));
    let usual = V3 { x: x * 8.0, y: y * 4.0, z: z * 4.0 };
    folded(flush3(tone_map(map as u32, V3::select(is_usual, usual, any))))
}

/// The first of a device's answers to every index of `words` that is not the CPU's: its case, and
/// which of [`NAMES`] it is.
pub fn first_difference(words: &[u32], answers: &[[u32; OUTPUTS]]) -> Option<(usize, usize)> {
    let fixture = Fixture::default();
    answers.iter().enumerate().find_map(|(case, answers)| {
        let expected = canary::<f32>((), words, &fixture.given(), case as u32);
        let wrong = (0..OUTPUTS).find(|&output| answers[output] != expected[output].0)?;
        Some((case, wrong))
    })
}

/// What each ray of a packet makes of a triangle and of its box.
#[derive(Clone, Copy)]
struct Found<B> {
    near: B,
    far: B,
    in_box: B,
    met: B,
    t: B,
    u: B,
    v: B,
    front: B,
}

/// Each ray's answers for its own lane's triangle.
#[inline(always)]
fn meet<L: Lane>(ray: &Ray<L>, words: &[u32], index: u32) -> Found<L::Bits> {
    let (none, one) = (ray.origin.x.broadcast_bits(0), ray.origin.x.broadcast_bits(1));
    let mut found =
        Found { near: none, far: none, in_box: none, met: none, t: none, u: none, v: none, front: none };
    let numbers = L::bits_from_fn(
        ray.origin.x.token(),
        #[inline(always)]
        |lane| lane as u32,
    );
    let mut lane = 0;
    while lane < L::WIDTH as u32 {
        let [a, b, c] = corners(words, index + lane);
        let triangle = Triangle::new(a, b, c);
        let (low, high) = triangle.bounds();
        let around = RelativeBox::new(ray.origin, &low, &high);
        let (near, far) = slab(ray, &around);
        let in_box = intersects(ray, &around, near.broadcast(f32::MAX));
        let seen = triangle.relative_to(ray.origin);
        let hit = intersect(ray, &seen, near.broadcast(f32::MAX));
        let here = numbers.eq(none.broadcast(lane));
        let met = here & hit.mask;
        found = Found {
            near: here.select(bits(near), found.near),
            far: here.select(bits(far), found.far),
            in_box: (here & in_box).select(one, found.in_box),
            met: met.select(one, found.met),
            t: met.select(bits(hit.t), found.t),
            u: met.select(bits(hit.u), found.u),
            v: met.select(bits(hit.v), found.v),
            front: (here & seen.front(near)).select(one, found.front),
        };
        lane += 1;
    }
    found
}

/// Where a ray meets one side of a sphere; 0 where it does not.
#[inline(always)]
fn side<L: Lane>(met: &Intersection<L>) -> L::Bits {
    let none = met.t.broadcast_bits(0);
    met.mask.select(fold(bits(met.t), fold(bits(met.u), bits(met.v))), none)
}

/// An instance around the camera and the light, from 0 to 2 units on a side.
#[inline(always)]
fn instance(given: &Given<'_>, words: &[u32], index: u32) -> Instance {
    let at = |number: u32| share::<f32>((), words, index + number);
    let low = [at(0) * 12.0 - 6.0, at(1) * 12.0 - 6.0, at(2) * 16.0 - 12.0];
    let half = [at(3), at(4), at(5)];
    let center = [low[0] + half[0], low[1] + half[1], low[2] + half[2]];
    let high = [center[0] + half[0], center[1] + half[1], center[2] + half[2]];
    Instance { low, high, center, radius: half[0] + half[1] + half[2], ..given.instances[0] }
}

/// The blocks in which the camera sees the instance of word `index`.
#[inline(always)]
fn covered(given: &Given<'_>, words: &[u32], index: u32) -> u32 {
    let bounds = screen_bounds(&given.views[CAMERA], &instance(given, words, index), given.frame.magnitude);
    bounds.x0 ^ bounds.y0 << 4 ^ bounds.x1 << 8 ^ bounds.y1 << 12 ^ bounds.key.rotate_left(16)
}

/// Whether the rays of a block of the camera may meet the sphere of the instance of word `index`.
#[inline(always)]
fn reached(given: &Given<'_>, words: &[u32], index: u32) -> u32 {
    let block = word(words, index + 6) >> 4;
    let instance = instance(given, words, index);
    sphere_in_block(&given.views[CAMERA], &instance, given.frame.magnitude, block & 3, block >> 2 & 3) as u32
}

/// Whether the instance of word `index` is near enough to the camera to cast a sun's shadow.
#[inline(always)]
fn casts_shadow(given: &Given<'_>, words: &[u32], index: u32) -> u32 {
    is_near(&given.views[CAMERA], &given.views[SUN], &instance(given, words, index)) as u32
}

/// A texture of colors at the shares of word `index`, at its finest level.
#[inline(always)]
fn finest_level(maps: &Maps<'_>, words: &[u32], index: u32) -> u32 {
    let map = &maps.materials[0].textures[MaterialRecord::COLOR];
    let level = FinestLevel {
        first: map.first,
        width: map.width,
        height: map.height,
        wrap_u: map.wrap_u,
        wrap_v: map.wrap_v,
        filter: map.filter,
        turn: map.turn,
        shift: map.shift,
    };
    let uv = [share::<f32>((), words, index) * 3.0 - 1.0, share::<f32>((), words, index + 1)];
    colored(finest(maps.texels, &level, uv)).0
}

/// The direction that word `index` packs.
#[inline(always)]
fn unpacked<L: Lane>(token: L::Token, words: &[u32], index: u32) -> V3<L> {
    let [x, y, sign] = L::gather(
        token,
        #[inline(always)]
        |lane| tangent::unpack(word(words, index + lane as u32)),
    );
    let along = flush3(tangent::direction(x, y));
    V3::select(sign.lt(sign.broadcast(0.0)), -along, along)
}

/// The bits of word `index`.
#[inline(always)]
fn packed<L: Lane>(token: L::Token, words: &[u32], index: u32) -> L::Bits {
    L::bits_from_fn(
        token,
        #[inline(always)]
        |lane| word(words, index + lane as u32),
    )
}

/// Word `index` as a number.
#[inline(always)]
fn number<L: Lane>(token: L::Token, words: &[u32], index: u32) -> L {
    L::from_bits(packed::<L>(token, words, index))
}

/// What one of 16 bits stands for.
const STEP: f32 = 1.0 / 65_536.0;

/// A number within 0 .. 1, of the lower half of word `index`.
#[inline(always)]
fn share<L: Lane>(token: L::Token, words: &[u32], index: u32) -> L {
    let bits = packed::<L>(token, words, index);
    num::from_integer::<L>(bits & bits.broadcast(0xffff)) * STEP
}

/// A point of the words from `index` on.
#[inline(always)]
fn place<L: Lane>(token: L::Token, words: &[u32], index: u32) -> V3<L> {
    V3::from_fn(
        token,
        #[inline(always)]
        |lane| corner(words, index + lane as u32),
    )
}

/// The vector at length 1.
#[inline(always)]
fn direction<L: Lane>(v: V3<L>) -> V3<L> {
    flush3(num::normalize(flush3(v)))
}

/// A word; after the last comes the first.
#[inline(always)]
fn word(words: &[u32], index: u32) -> u32 {
    words[(index % words.len() as u32) as usize]
}

/// The triangle of word `index`, behind its ray.
#[inline(always)]
fn corners(words: &[u32], index: u32) -> [[f32; 3]; 3] {
    [corner(words, index + 6), corner(words, index + 9), corner(words, index + 12)]
}

/// A point made of three words.
#[inline(always)]
fn corner(words: &[u32], index: u32) -> [f32; 3] {
    [
        coordinate(f32::from_bits(word(words, index))),
        coordinate(f32::from_bits(word(words, index + 1))),
        coordinate(f32::from_bits(word(words, index + 2))),
    ]
}

/// The number's bits; one word for every NaN.
#[inline(always)]
fn bits<L: Lane>(value: L) -> L::Bits {
    let bits = value.to_bits();
    let size = value.abs().to_bits();
    size.gt(bits.broadcast(0x7f80_0000)).select(bits.broadcast(0x7fc0_0000), bits)
}

/// One word of two, which changes with each.
#[inline(always)]
fn fold<B: Bits>(a: B, b: B) -> B {
    ((a << 11) | (a >> 21)).xor(b)
}

/// One word of a vector.
#[inline(always)]
fn folded<L: Lane>(v: V3<L>) -> L::Bits {
    fold(fold(bits(v.x), bits(v.y)), bits(v.z))
}

/// One word of a color.
#[inline(always)]
fn colored<L: Lane>([red, green, blue, alpha]: [L; 4]) -> L::Bits {
    fold(folded(flush3(V3 { x: red, y: green, z: blue })), bits(flush(alpha)))
}

/// A coordinate as a mesh may have it: 0 or of a magnitude within 2⁻⁶⁰ ..= 2³⁰; NaN is 0.
#[inline(always)]
fn coordinate(value: f32) -> f32 {
    let bits = value.to_bits();
    let size = bits & 0x7fff_ffff;
    let (tiny, nan) = (size < (127 - 60) << 23, size > 0x7f80_0000);
    if tiny || nan {
        0.0
    } else if size > (127 + 30) << 23 {
        f32::from_bits((127 + 30) << 23 | bits & 0x8000_0000)
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::Word;
    use crate::lane::flushing::Flushing;
    use std::collections::BTreeSet;
    use std::vec::Vec;

    fn answers<L: Lane<Token = (), Bits = Word>>(words: &[u32], index: u32) -> [u32; OUTPUTS] {
        canary::<L>((), words, &Fixture::default().given(), index).map(|word| word.0)
    }

    fn answer(name: &str) -> usize {
        NAMES.iter().position(|other| *other == name).unwrap()
    }

    /// Numbers of everyday size, and edge values among them.
    fn words() -> Vec<u32> {
        let mut words: Vec<u32> = (0..=255_u32)
            .flat_map(|e| [(e << 23).saturating_sub(1), e << 23, e << 23 | 1 << 31, e << 23 | 1])
            .collect();
        let mut state = 1_u32;
        words.extend((0..6000).map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (120 + (state >> 5 & 15)) << 23 | state & 0x807f_ffff
        }));
        words
    }

    #[test]
    fn answers_whatever_the_words_are() {
        let words = [f32::NAN, 0.0, f32::INFINITY, 1e-40, -3.5].map(f32::to_bits);
        for index in [0, 1, 4, 900] {
            assert_ne!(answers::<f32>(&words, index), [0; OUTPUTS]);
        }
    }

    fn all<L: Lane<Token = (), Bits = Word>>(words: &[u32]) -> Vec<[u32; OUTPUTS]> {
        (0..words.len() as u32).map(|index| answers::<L>(words, index)).collect()
    }

    /// Case and name of the first answer that is wrong.
    fn wrong(words: &[u32], answers: &[[u32; OUTPUTS]]) -> Option<(usize, &'static str)> {
        first_difference(words, answers).map(|(case, output)| (case, NAMES[output]))
    }

    #[test]
    fn devices_that_flush_denormals_give_the_same_answers() {
        let words = words();
        assert_eq!(wrong(&words, &all::<Flushing<true>>(&words)), None);
        assert_eq!(wrong(&words, &all::<Flushing<false>>(&words)), None);
    }

    #[test]
    fn a_wrong_answer_is_named() {
        let words = words();
        let right = all::<f32>(&words);
        for (output, name) in NAMES.iter().enumerate() {
            let mut answers = right.clone();
            answers[77 + output][output] ^= 1;
            assert_eq!(wrong(&words, &answers), Some((77 + output, *name)));
        }
    }

    #[test]
    fn every_function_has_many_answers() {
        let words = words();
        let all = all::<f32>(&words);
        for (output, name) in NAMES.iter().enumerate() {
            let different: BTreeSet<u32> = all.iter().map(|answers| answers[output]).collect();
            let least = if ["box", "triangle", "front", "sphere in block", "shadow distance"].contains(name) {
                2
            } else {
                50
            };
            assert!(different.len() >= least, "{name}: {}", different.len());
        }
        assert_eq!(NAMES.iter().collect::<BTreeSet<_>>().len(), OUTPUTS);
    }

    #[test]
    fn a_triangle_ahead_is_met() {
        let ray_and_triangle =
            [0.2, 0.3, -2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0_f32];
        let found = answers::<f32>(&ray_and_triangle.map(f32::to_bits), 0);
        assert_eq!(found[answer("triangle")], 1);
        for (name, exact) in [("t", 2.0_f32), ("u", 0.2), ("v", 0.3)] {
            let got = found[answer(name)];
            // Two roundings of the reciprocal and one of the product.
            assert!(got.abs_diff(exact.to_bits()) <= 3, "{} is not {exact}", f32::from_bits(got));
        }
    }
}
