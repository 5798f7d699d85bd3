//! What a frame must not cost more for: the number of a texture's texels.

use conformance::shape::paved;
use rtrt_core::kernel::texture::{Maps, MaterialLookup, TexCoords, sample};
use rtrt_core::lane::{Lane, Word};
use rtrt_core::layout::MaterialRecord;
use rtrt_core::scene::Scene;
use std::cell::Cell;
use std::ops::{Add, Mul, Neg, Sub};

/// What a lookup takes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Cost {
    /// Words read: where a texture and each of its levels begin, and texels.
    words: u32,
    /// Operations on numbers, comparisons among them.
    operations: u32,
}

thread_local! {
    /// What this thread has spent.
    static SPENT: Cell<Cost> = const { Cell::new(Cost { words: 0, operations: 0 }) };
}

fn spend(words: u32, operations: u32) {
    let spent = SPENT.get();
    SPENT.set(Cost { words: spent.words + words, operations: spent.operations + operations });
}

/// A lane of width 1 that counts what is done with it.
#[derive(Clone, Copy)]
struct Counting(f32);

macro_rules! counting_operator {
    ($($operator:ident $name:ident $symbol:tt;)*) => {$(
        impl $operator for Counting {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                spend(0, 1);
                Self(self.0 $symbol other.0)
            }
        }
        impl $operator<f32> for Counting {
            type Output = Self;
            fn $name(self, other: f32) -> Self {
                self $symbol Self(other)
            }
        }
    )*};
}
counting_operator! {
    Add add +;
    Sub sub -;
    Mul mul *;
}

impl Neg for Counting {
    type Output = Self;
    fn neg(self) -> Self {
        spend(0, 1);
        Self(-self.0)
    }
}

impl Lane for Counting {
    type Token = ();
    type Mask = bool;
    type Bits = Word;
    type Row = [f32; 1];

    const WIDTH: usize = 1;

    fn splat((): (), value: f32) -> Self {
        Self(value)
    }
    fn gather<const N: usize>((): (), f: impl Fn(usize) -> [f32; N]) -> [Self; N] {
        f(0).map(Self)
    }
    fn gather_fours<const N: usize>((): (), f: impl Fn(usize) -> [[f32; 4]; N]) -> [[Self; 4]; N] {
        f(0).map(|four| four.map(Self))
    }
    fn bits_from_fn((): (), f: impl Fn(usize) -> u32) -> Word {
        spend(1, 0);
        Word(f(0))
    }
    fn gather_bits((): (), f: impl Fn(usize) -> [u32; 4]) -> [Word; 4] {
        spend(4, 0);
        f(0).map(Word)
    }
    fn token(self) {}
    fn row(self) -> [f32; 1] {
        [self.0]
    }
    fn lt(self, other: Self) -> bool {
        spend(0, 1);
        self.0 < other.0
    }
    fn le(self, other: Self) -> bool {
        spend(0, 1);
        self.0 <= other.0
    }
    fn to_bits(self) -> Word {
        Word(self.0.to_bits())
    }
    fn from_bits(bits: Word) -> Self {
        Self(f32::from_bits(bits.0))
    }
}

/// What it takes to look up the color of the scene's second material, its floor, at a point with this
/// footprint.
fn cost(scene: &Scene, uv: [f32; 2], footprint: f32) -> Cost {
    let maps = Maps { materials: scene.materials(), texels: scene.texels() };
    let floor = scene.instances()[0].material + 1;
    let (uv, footprint) = (uv.map(Counting), Counting(footprint));
    let tex_coords = TexCoords { uv: [uv; 2], footprint: [footprint; 2] };
    SPENT.set(Cost::default());
    sample::<Counting, { MaterialRecord::COLOR }, true>(
        &maps,
        &MaterialLookup::new(Word(floor)),
        &tex_coords,
    );
    SPENT.get()
}

/// A texture of 65,536 times as many texels, with 13 levels instead of 5, takes the same reads and the same
/// operations: those of one level, or of two that are mixed.
#[test]
fn a_larger_texture_costs_no_more() {
    let (small, large) = (paved(16), paved(4096));
    let [finest, mixed] = [1e-9, 0.3].map(|footprint| cost(&small, [0.2, 0.7], footprint));
    assert_eq!((finest.words, mixed.words), (1 + 5, 1 + 2 * 5));
    assert!(finest.operations > 50 && mixed.operations > finest.operations, "{finest:?} {mixed:?}");
    for step in 0..2000_u16 {
        let footprint = 2_f32.powf(f32::from(step) * 0.01 - 18.0);
        let uv = [f32::from(step) * 0.37 - 300.0, f32::from(step) * 0.11];
        for scene in [&small, &large] {
            let cost = cost(scene, uv, footprint);
            assert!(cost == finest || cost == mixed, "{footprint}: {cost:?}, not {finest:?} or {mixed:?}");
        }
    }
}
