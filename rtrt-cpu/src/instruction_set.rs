//! Which instructions run a block.

use crate::error::Error;
#[cfg(feature = "simd")]
use crate::wide::Float8;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
use crate::wide::Float16;
use crate::wide::Wide;
use alloc::vec::Vec;
#[cfg(all(feature = "simd", any(target_arch = "x86_64", target_arch = "aarch64")))]
use fearless_simd::Simd;
use rtrt_core::lane::Lane;

/// Lane groups in a packet. A packet is a block, but for single lanes, whose packets are
/// smaller: a mask of groups has 32 bits.
const GROUPS_1: usize = 16;
#[cfg(feature = "simd")]
const GROUPS_8: usize = 32;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
const GROUPS_16: usize = 16;

/// What eight lanes need where they are not.
#[cfg(feature = "simd")]
const EIGHT_NEED: &str = if cfg!(feature = "sse4_2") { "SSE4.2" } else { "AVX2" };

/// An instruction set that is there, and how it is used.
#[derive(Debug, Clone, Copy)]
pub enum InstructionSet {
    /// One number at a time.
    Scalar,
    /// Eight numbers, AVX2.
    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    Avx2(fearless_simd::Avx2),
    /// Sixteen numbers, AVX-512 (Ice Lake and later).
    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    Avx512(fearless_simd::Avx512),
    /// Eight numbers in two registers, NEON.
    #[cfg(all(feature = "simd", target_arch = "aarch64"))]
    Neon(fearless_simd::Neon),
    /// Eight numbers in two registers, SSE4.2.
    #[cfg(all(feature = "sse4_2", target_arch = "x86_64"))]
    Sse4_2(fearless_simd::Sse4_2),
    /// Eight numbers in whatever every processor of the target has.
    #[cfg(all(feature = "simd", not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
    Baseline(fearless_simd::Level),
}

impl InstructionSet {
    /// The level for this many lanes; without a number the fastest. Sixteen lanes need
    /// AVX-512.
    #[cfg(feature = "simd")]
    pub fn new(lanes: Option<u32>) -> Result<Self, Error> {
        let here = fearless_simd::Level::new();
        match lanes {
            Some(1) => Ok(Self::Scalar),
            Some(8) => Self::eight(here).ok_or(Error::Unsupported { lanes: 8, needed: EIGHT_NEED }),
            Some(16) => Self::sixteen(here).ok_or(Error::Unsupported { lanes: 16, needed: "AVX-512" }),
            Some(lanes) => Err(Error::Lanes { lanes }),
            None => Ok(Self::sixteen(here).or_else(|| Self::eight(here)).unwrap_or(Self::Scalar)),
        }
    }

    /// The level for this many lanes: one.
    #[cfg(not(feature = "simd"))]
    pub fn new(lanes: Option<u32>) -> Result<Self, Error> {
        match lanes {
            None | Some(1) => Ok(Self::Scalar),
            Some(lanes @ (8 | 16)) => Err(Error::NoSimd { lanes }),
            Some(lanes) => Err(Error::Lanes { lanes }),
        }
    }

    /// Every level that is there, but for single lanes: none.
    #[cfg(not(feature = "simd"))]
    pub fn wide() -> Vec<Self> {
        Vec::new()
    }

    /// Every level that is there, but for single lanes.
    #[cfg(feature = "simd")]
    pub fn wide() -> Vec<Self> {
        let here = fearless_simd::Level::new();
        let wide = [Self::eight(here), Self::sixteen(here)];
        #[cfg(all(feature = "sse4_2", target_arch = "x86_64"))]
        // Where there is AVX2, nothing else runs this one.
        let wide = [here.as_sse4_2().map(Self::Sse4_2)].into_iter().chain(wide);
        wide.into_iter().flatten().collect()
    }

    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    fn eight(here: fearless_simd::Level) -> Option<Self> {
        let eight = here.as_avx2().map(Self::Avx2);
        #[cfg(feature = "sse4_2")]
        let eight = eight.or_else(|| here.as_sse4_2().map(Self::Sse4_2));
        eight
    }
    #[cfg(all(feature = "simd", target_arch = "aarch64"))]
    fn eight(here: fearless_simd::Level) -> Option<Self> {
        here.as_neon().map(Self::Neon)
    }
    #[cfg(all(feature = "simd", not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
    fn eight(here: fearless_simd::Level) -> Option<Self> {
        Some(Self::Baseline(here))
    }

    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    fn sixteen(here: fearless_simd::Level) -> Option<Self> {
        here.as_avx512().map(Self::Avx512)
    }
    #[cfg(all(feature = "simd", not(target_arch = "x86_64")))]
    fn sixteen(_: fearless_simd::Level) -> Option<Self> {
        None
    }

    /// Numbers side by side.
    pub fn lanes(self) -> u32 {
        match self {
            Self::Scalar => 1,
            #[cfg(all(feature = "simd", target_arch = "x86_64"))]
            Self::Avx512(_) => 16,
            #[cfg(feature = "simd")]
            _ => 8,
        }
    }

    /// The instruction set.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            #[cfg(all(feature = "simd", target_arch = "x86_64"))]
            Self::Avx2(_) => "AVX2",
            #[cfg(all(feature = "simd", target_arch = "x86_64"))]
            Self::Avx512(_) => "AVX-512",
            #[cfg(all(feature = "simd", target_arch = "aarch64"))]
            Self::Neon(_) => "NEON",
            #[cfg(all(feature = "sse4_2", target_arch = "x86_64"))]
            Self::Sse4_2(_) => "SSE4.2",
            #[cfg(all(feature = "simd", not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
            Self::Baseline(_) => {
                if cfg!(target_arch = "wasm32") {
                    "simd128"
                } else {
                    "baseline"
                }
            }
        }
    }

    /// Runs the work with it.
    pub fn run<W: LaneTask>(self, work: W) -> W::Output {
        match self {
            Self::Scalar => work.run::<f32, GROUPS_1>(()),
            #[cfg(all(feature = "simd", target_arch = "x86_64"))]
            Self::Avx2(token) => token.vectorize(
                #[inline(always)]
                || work.run::<Float8<_>, GROUPS_8>(token),
            ),
            #[cfg(all(feature = "simd", target_arch = "x86_64"))]
            Self::Avx512(token) => token.vectorize(
                #[inline(always)]
                || work.run::<Float16<_>, GROUPS_16>(token),
            ),
            #[cfg(all(feature = "simd", target_arch = "aarch64"))]
            Self::Neon(token) => token.vectorize(
                #[inline(always)]
                || work.run::<Float8<_>, GROUPS_8>(token),
            ),
            #[cfg(all(feature = "sse4_2", target_arch = "x86_64"))]
            Self::Sse4_2(token) => token.vectorize(
                #[inline(always)]
                || work.run::<Float8<_>, GROUPS_8>(token),
            ),
            #[cfg(all(feature = "simd", not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
            Self::Baseline(level) => {
                fearless_simd::dispatch!(level, token => work.run::<Float8<_>, GROUPS_8>(token))
            }
        }
    }
}

impl InstructionSet {
    /// Runs work that has no use for more than eight lanes.
    pub fn run_eight<W: EightTask>(self, work: W) -> W::Output {
        match self {
            #[cfg(all(feature = "simd", target_arch = "x86_64"))]
            Self::Avx2(token) => token.vectorize(
                #[inline(always)]
                || work.run::<Float8<_>>(token),
            ),
            #[cfg(all(feature = "simd", target_arch = "aarch64"))]
            Self::Neon(token) => token.vectorize(
                #[inline(always)]
                || work.run::<Float8<_>>(token),
            ),
            #[cfg(all(feature = "sse4_2", target_arch = "x86_64"))]
            Self::Sse4_2(token) => token.vectorize(
                #[inline(always)]
                || work.run::<Float8<_>>(token),
            ),
            #[cfg(all(feature = "simd", not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
            Self::Baseline(level) => fearless_simd::dispatch!(level, token => work.run::<Float8<_>>(token)),
            _ => work.run::<f32>(()),
        }
    }
}

/// What runs with up to eight lanes. Implementations are `#[inline(always)]`, as those of [`LaneTask`].
pub trait EightTask {
    /// What comes of it.
    type Output;

    /// Runs it.
    fn run<L: Lane>(self, token: L::Token) -> Self::Output;
}

/// What runs at any level. Implementations are `#[inline(always)]`, or they would be compiled
/// without the level's instructions.
pub trait LaneTask {
    /// What comes of it.
    type Output;

    /// Runs it, with `G` lane groups in a packet.
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Self::Output;
}
