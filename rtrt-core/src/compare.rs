//! The first difference between two pictures of the same frame, bit for bit.
//!
//! Every buffer is compared as words, so that NaN differs from a number, −0 from 0, and
//! one NaN from another. Buffers are compared in the order of the stages that fill them:
//! the first difference is then in the stage that is to blame.

use crate::backend::{Deferred, Picture, Request};
use crate::grid::{BlockIndex, Grid, RayIndex};
use crate::kernel::lists::BlockLists;
use crate::kernel::view::camera_ray;
use crate::layout::{Hit, Lit, Surface};
use alloc::vec::Vec;
use bytemuck::cast_slice;
use core::fmt;

/// A word in which two pictures differ. Shown in one line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The stage that filled the buffer: see [`Stage::name`](crate::schedule::Stage::name).
    pub stage: &'static str,
    /// The buffer.
    pub buffer: &'static str,
    /// The field of the buffer's record; empty for a record of nameless words.
    pub field: &'static str,
    /// The word of the record.
    pub word: u32,
    /// The place in the frame.
    pub place: Place,
    /// The expected word.
    pub expected: u32,
    /// The actual word.
    pub actual: u32,
}

/// The place of a [`Difference`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// The buffer is longer or shorter; the words of the difference are the lengths, in
    /// words.
    Length,
    /// The list of a block holds more or fewer entries; the words of the difference are the starts of
    /// the next list. Blocks are numbered over all views.
    Count(BlockIndex),
    /// An entry in the list of a block.
    ListEntry(BlockIndex, u32),
    /// A sub-ray of a pixel; the first one for a whole pixel.
    Ray {
        /// Column and row of the pixel.
        pixel: [u32; 2],
        /// Column and row within the pixel.
        sub_ray: [u32; 2],
        /// The ray.
        ray: RayIndex,
        /// Its block.
        block: BlockIndex,
        /// Its origin and direction.
        primary: [[f32; 3]; 2],
    },
}

/// Compares two pictures of `request`, bit for bit.
///
/// Without deferred buffers in both, only the pixels are compared. Deferred buffers in one picture alone are
/// a difference.
///
/// ```
/// use rtrt_core::backend::{Picture, Request};
/// use rtrt_core::compare::compare;
/// use rtrt_core::scene::{Camera, Projection};
///
/// let camera = Camera {
///     eye: [0.0, 0.0, 3.0].into(),
///     look_at: [0.0; 3].into(),
///     up: [0.0, 1.0, 0.0].into(),
///     projection: Projection::Perspective { fov_y: 1.0 },
/// };
/// let request = Request::new(&camera, [2, 1]);
/// let expected = Picture { width: 2, height: 1, pixels: vec![7, 8], ..Picture::default() };
/// let mut actual = expected.clone();
/// assert!(compare(&request, &expected, &actual).is_ok());
/// actual.pixels[1] ^= 1;
/// let difference = compare(&request, &expected, &actual).unwrap_err();
/// assert!(difference.to_string().starts_with("resolve: pixels[0] at pixel 1,0"));
/// ```
///
/// # Errors
/// The first difference, in the order of the stages; within a buffer the lowest index.
pub fn compare(request: &Request<'_>, expected: &Picture, actual: &Picture) -> Result<(), Difference> {
    for (expected, actual) in buffers(expected).iter().zip(&buffers(actual)) {
        if let Some(difference) = first_difference(request, expected, actual) {
            return Err(difference);
        }
    }
    Ok(())
}

/// One buffer of a picture.
struct Buffer<'a> {
    stage: &'static str,
    name: &'static str,
    words: &'a [u32],
    /// Words in a record.
    stride: usize,
    /// Names of the words of a record, if they have any.
    fields: &'static [&'static str],
}

const HIT: &[&str] = &["t", "instance", "triangle", "u", "v"];
const SURFACE: &[&str] = &[
    "origin.x",
    "origin.y",
    "origin.z",
    "material",
    "normal.x",
    "normal.y",
    "normal.z",
    "color.rg",
    "color.ba",
    "uv.u",
    "uv.v",
    "footprint",
    "second_uv.u",
    "second_uv.v",
    "second_footprint",
    "variance",
    "coat_normal",
    "tangent",
];
const LIT: &[&str] = &[
    "diffuse.r",
    "diffuse.g",
    "diffuse.b",
    "specular.r",
    "specular.g",
    "specular.b",
    "grazing.r",
    "grazing.g",
    "grazing.b",
    "coating.r",
    "coating.g",
    "coating.b",
];
const COLOR: &[&str] = &["r", "g", "b", "a"];
const ENTRY: &[&str] = &["key", "instance"];
/// The fields that are whole numbers.
const WHOLE: &[&str] =
    &["", "instance", "triangle", "material", "color.rg", "color.ba", "coat_normal", "tangent"];
const _: () = assert!(HIT.len() * 4 == size_of::<Hit>() && LIT.len() * 4 == size_of::<Lit>());
const _: () = assert!(SURFACE.len() * 4 == size_of::<Surface>());

/// Empty deferred buffers, for a picture without any.
static NONE: Deferred = Deferred {
    lists: Vec::new(),
    hits: Vec::new(),
    surfaces: Vec::new(),
    masks: Vec::new(),
    raw_transmittance: Vec::new(),
    penumbra_radii: Vec::new(),
    transmittance: Vec::new(),
    lit: Vec::new(),
    colors: Vec::new(),
    layers: Vec::new(),
    mask_words: 0,
    layer_count: 0,
    transmittance_words: 0,
};

/// The buffers of a picture, in the order of the stages.
fn buffers(picture: &Picture) -> [Buffer<'_>; 11] {
    let d = picture.deferred.as_ref().unwrap_or(&NONE);
    let records = |stage, name, words, fields: &'static [&'static str]| Buffer {
        stage,
        name,
        words,
        stride: fields.len(),
        fields,
    };
    let masks = d.mask_words.max(1) as usize;
    let transmittance = d.transmittance_words.max(1) as usize;
    let layers = 5 * d.layer_count.max(1) as usize;
    [
        records("bin", "lists", &d.lists, ENTRY),
        records("visibility", "hits", cast_slice(&d.hits), HIT),
        records("surface", "surfaces", cast_slice(&d.surfaces), SURFACE),
        Buffer {
            stage: "occlusion",
            name: "raw transmittance",
            words: &d.raw_transmittance,
            stride: transmittance,
            fields: &[],
        },
        Buffer {
            stage: "occlusion",
            name: "penumbras",
            words: cast_slice(&d.penumbra_radii),
            stride: transmittance,
            fields: &[],
        },
        Buffer { stage: "occlusion", name: "masks", words: &d.masks, stride: masks, fields: &[] },
        Buffer {
            stage: "occlusion",
            name: "transmittance",
            words: &d.transmittance,
            stride: transmittance,
            fields: &[],
        },
        records("light", "lit", cast_slice(&d.lit), LIT),
        Buffer { stage: "layers", name: "layers", words: cast_slice(&d.layers), stride: layers, fields: &[] },
        records("shade", "colors", cast_slice(&d.colors), COLOR),
        Buffer { stage: "resolve", name: "pixels", words: &picture.pixels, stride: 1, fields: &[] },
    ]
}

fn first_difference(request: &Request<'_>, expected: &Buffer<'_>, actual: &Buffer<'_>) -> Option<Difference> {
    let &Buffer { stage, name: buffer, words, stride, fields } = expected;
    if words == actual.words {
        return None;
    }
    let index = words.iter().zip(actual.words).position(|(a, b)| a != b);
    let is_list = stage == "bin";
    // Lists of different length also differ in a start, which is the better message.
    let Some(index) = index.filter(|_| is_list || words.len() == actual.words.len()) else {
        let lengths = [words.len() as u32, actual.words.len() as u32];
        let [expected, actual] = lengths;
        return Some(Difference {
            stage,
            buffer,
            field: "",
            word: 0,
            place: Place::Length,
            expected,
            actual,
        });
    };
    let (place, word) = if is_list {
        in_lists(words, index)
    } else {
        (at_ray(request, stage == "resolve", (index / stride) as u32), index % stride)
    };
    let field = if matches!(place, Place::Count(_)) { "" } else { fields.get(word).copied().unwrap_or("") };
    let (expected, actual) = (words[index], actual.words[index]);
    Some(Difference { stage, buffer, field, word: word as u32, place, expected, actual })
}

/// The list that a word belongs to, and the number of the word in its entry.
fn in_lists(words: &[u32], index: usize) -> (Place, usize) {
    // Starts do not fall, so only the last of them counts the words that follow it.
    let blocks = (0..words.len())
        .find(|&b| BlockLists::header(b as u32) as usize + 2 * words[b] as usize == words.len());
    let blocks = blocks.unwrap_or(0);
    if index <= blocks {
        return (Place::Count(BlockIndex(index.saturating_sub(1) as u32)), 0);
    }
    let place = index - BlockLists::header(blocks as u32) as usize;
    let entry = (place / 2) as u32;
    let block = words[..=blocks].partition_point(|&start| start <= entry).saturating_sub(1);
    (Place::ListEntry(BlockIndex(block as u32), entry.saturating_sub(words[block])), place % 2)
}

/// The ray with this number, or the first one of the pixel with this number.
fn at_ray(request: &Request<'_>, is_pixel: bool, number: u32) -> Place {
    let side = match request.samples {
        16 => 4,
        4 => 2,
        _ => 1,
    };
    let grid = Grid { width: request.size[0], height: request.size[1], side };
    let at = if is_pixel { grid.pixel(number).map(|p| p * side) } else { grid.ray(RayIndex(number)) };
    let ray = grid.index(at);
    let primary = request.camera.view(grid).map_or([[f32::NAN; 3]; 2], |view| {
        let ray = camera_ray(&view, at[0] as f32, at[1] as f32);
        [ray.origin.lane(0), ray.direction.lane(0)]
    });
    let [pixel, sub_ray] = [at.map(|a| a / side), at.map(|a| a % side)];
    Place::Ray { pixel, sub_ray, ray, block: grid.block(ray), primary }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let &Self { stage, buffer, field, word, place, expected, actual } = self;
        write!(f, "{stage}: {buffer}")?;
        match place {
            Place::Length => return write!(f, " has {actual} words, not {expected}"),
            Place::Count(_) => f.write_str(" ends")?,
            _ if !field.is_empty() => write!(f, ".{field}")?,
            _ => write!(f, "[{word}]")?,
        }
        match place {
            Place::Length => {}
            Place::Count(block) => write!(f, " of block {}", block.0)?,
            Place::ListEntry(block, entry) => write!(f, " of block {}, entry {entry}", block.0)?,
            Place::Ray { pixel: [x, y], sub_ray: [a, b], ray, block, .. } => {
                write!(f, " at pixel {x},{y} sub-ray {a},{b} (ray {}, block {})", ray.0, block.0)?;
            }
        }
        write!(f, " is {actual:#010x}, not {expected:#010x}")?;
        if !WHOLE.contains(&field) {
            write!(f, " ({:?}, not {:?})", f32::from_bits(actual), f32::from_bits(expected))?;
        }
        if let Place::Ray { primary: [origin, direction], .. } = place {
            write!(f, "; primary ray from {origin:?} along {direction:?}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{Hit, Lit, Surface};
    use crate::scene::{Camera, Projection};
    use alloc::string::ToString;
    use alloc::vec;
    use bytemuck::Zeroable;

    const CAMERA: Camera = Camera {
        eye: glam::Vec3::ZERO,
        look_at: glam::Vec3::NEG_Z,
        up: glam::Vec3::Y,
        projection: Projection::Perspective { fov_y: 1.0 },
    };

    fn request() -> Request<'static> {
        Request::new(&CAMERA, [5, 3]).samples(4).deferred(true)
    }

    /// A frame of one block, in whose lists a second block (of a light) holds two entries.
    fn picture() -> Picture {
        let deferred = Deferred {
            lists: vec![0, 1, 3, 7, 0, 0, 0, 0, 1],
            hits: vec![Hit::MISS; 256],
            surfaces: vec![Surface::zeroed(); 256],
            masks: vec![0; 512],
            lit: vec![Lit::zeroed(); 256],
            colors: vec![[0.0; 4]; 256],
            mask_words: 2,
            ..Deferred::default()
        };
        Picture { width: 5, height: 3, pixels: vec![0; 15], deferred: Some(deferred), ..Picture::default() }
    }

    fn difference(change: impl FnOnce(&mut Picture, &mut Deferred)) -> Difference {
        let mut other = picture();
        let mut deferred = other.deferred.take().unwrap();
        change(&mut other, &mut deferred);
        other.deferred = Some(deferred);
        compare(&request(), &picture(), &other).unwrap_err()
    }

    #[test]
    fn a_picture_equals_itself() {
        assert_eq!(compare(&request(), &picture(), &picture()), Ok(()));
    }

    #[test]
    fn names_stage_field_and_ray() {
        let found = difference(|picture, d| {
            picture.pixels[0] = 1;
            d.lit[17].specular[1] = -0.0;
        });
        assert_eq!((found.stage, found.buffer, found.field), ("light", "lit", "specular.g"));
        assert_eq!((found.expected, found.actual), (0, 0x8000_0000));
        let Place::Ray { pixel, sub_ray, ray, block, primary } = found.place else { panic!("{found}") };
        assert_eq!((pixel, sub_ray, ray.0, block.0), ([2, 0], [1, 0], 17, 0));
        assert_eq!(primary[0], [0.0; 3]);
    }

    #[test]
    fn names_the_word_of_a_mask_and_the_pixel_of_a_color() {
        let found = difference(|_, d| d.masks[2 * 9 + 1] = 8);
        assert!(
            found.to_string().starts_with("occlusion: masks[1] at pixel 0,1 sub-ray 1,0 (ray 9"),
            "{found}"
        );
        let found = difference(|picture, _| picture.pixels[7] = 8);
        assert!(found.to_string().starts_with("resolve: pixels[0] at pixel 2,1 sub-ray 0,0"), "{found}");
    }

    #[test]
    fn names_the_list_and_the_entry() {
        let found = difference(|_, d| d.lists[8] = 2);
        assert_eq!((found.place, found.field), (Place::ListEntry(BlockIndex(1), 1), "instance"));
        let found = difference(|_, d| d.lists[1] = 0);
        assert_eq!((found.place, found.field), (Place::Count(BlockIndex(0)), ""));
    }

    #[test]
    fn a_missing_buffer_is_a_difference() {
        let mut other = picture();
        other.deferred = None;
        let found = compare(&request(), &picture(), &other).unwrap_err();
        assert_eq!((found.stage, found.place, found.actual), ("bin", Place::Length, 0));
        let found = difference(|picture, _| picture.pixels.clear());
        assert_eq!(found.to_string(), "resolve: pixels has 0 words, not 15");
    }

    #[test]
    fn nan_is_not_a_number_nor_another_nan() {
        for bits in [0x7fc0_0000, 0x7fc0_0001] {
            let mut expected = picture();
            expected.deferred.as_mut().unwrap().hits[0].u = f32::from_bits(0x7fc0_0002);
            let mut actual = picture();
            actual.deferred.as_mut().unwrap().hits[0].u = f32::from_bits(bits);
            assert_eq!(compare(&request(), &expected, &expected), Ok(()));
            assert_eq!(compare(&request(), &expected, &actual).unwrap_err().actual, bits);
        }
    }
}
