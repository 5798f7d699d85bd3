//! Kernels on arrays of edge values, on every device and at every width.

use conformance::shape::Random;
use conformance::variants::requires_gpu;
use rtrt_core::kernel::canary::{Fixture, NAMES, OUTPUTS, canary};
use rtrt_core::lane::Bits;
use rtrt_cpu::{InstructionSet, LaneTask, Wide};
use rtrt_gpu::{Gpu, Options, Route};

/// Zeros, denormals, the ends of every range that `num` names, infinities, NaN, the
/// neighbors of powers of two, random bits, and numbers around 1, of which triangles are
/// made that are met.
fn words() -> Vec<u32> {
    let special = [0.0, f32::MIN_POSITIVE, f32::MAX, f32::INFINITY, f32::NAN, 1e-45, 12_582_912.0];
    let mut words: Vec<u32> = special.iter().map(|x| x.to_bits()).collect();
    words.extend([0x7f80_0001, 0x7fff_ffff, 0x007f_ffff]);
    for exponent in 0..255_u32 {
        words.extend([(exponent << 23).saturating_sub(1), exponent << 23, exponent << 23 | 1]);
    }
    words.extend((0..256).map(|i| (i as f32 / 255.0).to_bits()));
    words.extend((0..70).map(|i| (i as f32 * 0.5).to_bits()));
    let negative: Vec<u32> = words.iter().map(|word| word | 0x8000_0000).collect();
    words.extend(negative);
    let mut random = Random(14);
    words.extend((0..4000).map(|_| random.bits() << 1 ^ random.bits()));
    words.extend((0..6000).map(|_| random.within(-2.0, 2.0).to_bits()));
    words
}

/// Whether all answers are those of single lanes on the CPU.
fn check(who: &str, words: &[u32], answers: &[[u32; OUTPUTS]]) {
    assert_eq!(answers.len(), words.len());
    let triangle = NAMES.iter().position(|name| *name == "triangle").expect("a name");
    let (fixture, mut met) = (Fixture::default(), 0);
    for (index, answers) in (0..).zip(answers) {
        let expected = canary::<f32>((), words, &fixture.given(), index).map(|word| word.0);
        met += expected[triangle];
        for ((name, actual), expected) in NAMES.iter().zip(answers).zip(expected) {
            let word = words[index as usize];
            assert_eq!(
                *actual,
                expected,
                "{who}: {name} of word {index}, {word:#010x} ({:?})",
                f32::from_bits(word)
            );
        }
    }
    assert!(met > 100, "only {met} triangles were met");
}

#[test]
fn every_width_computes_every_kernel_as_single_lanes_do() {
    let words = words();
    let all = InstructionSet::wide();
    assert!(!all.is_empty(), "no instruction set with several lanes");
    for level in all {
        println!("{}", level.name());
        check(level.name(), &words, &level.run(Kernels { words: &words }));
    }
}

/// Every kernel's answers to every word.
struct Kernels<'a> {
    words: &'a [u32],
}

impl LaneTask for Kernels<'_> {
    type Output = Vec<[u32; OUTPUTS]>;

    #[inline(always)]
    fn run<L: Wide, const G: usize>(self, token: L::Token) -> Self::Output {
        let fixture = Fixture::default();
        let mut answers = vec![[0; OUTPUTS]; self.words.len()];
        for (packet, answers) in answers.chunks_mut(L::WIDTH).enumerate() {
            let found = canary::<L>(token, self.words, &fixture.given(), (packet * L::WIDTH) as u32);
            for (output, bits) in found.into_iter().enumerate() {
                for (lane, answer) in answers.iter_mut().enumerate() {
                    answer[output] = bits.lane(lane);
                }
            }
        }
        answers
    }
}

#[test]
fn the_gpu_computes_every_kernel_as_the_cpu_does_and_finds_every_field() {
    let words = words();
    let mut tried = 0;
    for route in [Route::Passthrough, Route::Naga] {
        match Gpu::new(Options { route, ..Options::default() }) {
            Ok(gpu) => {
                check(&format!("{route:?}"), &words, &gpu.kernels(&words).expect("answers"));
                assert_eq!(gpu.layout().expect("the layout"), Gpu::expected_layout(), "{route:?}");
                tried += 1;
            }
            Err(why) => println!("SKIPPED: {route:?}: {why}"),
        }
    }
    assert!(tried > 0 || !requires_gpu(), "no GPU");
}
