//! Kernels on arrays of edge values, on every device.

use conformance::shape::Random;
use rtrt_core::kernel::canary::{NAMES, canary};
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

#[test]
fn the_gpu_computes_every_kernel_as_the_cpu_does() {
    let gpu = match Gpu::new(Options { route: Route::Passthrough, ..Options::default() }) {
        Ok(gpu) => gpu,
        Err(why) => {
            assert!(!conformance::variants::requires_gpu(), "{why}");
            return println!("SKIPPED: {why}");
        }
    };
    let words = words();
    let answers = gpu.kernels(&words).expect("answers");
    assert_eq!(answers.len(), words.len());
    let mut met = 0;
    for (index, answers) in (0..).zip(&answers) {
        let expected = canary(&words, index);
        met += expected[13];
        for ((name, actual), expected) in NAMES.iter().zip(answers).zip(expected) {
            let word = words[index as usize];
            assert_eq!(
                *actual,
                expected,
                "{name} of word {index}, {word:#010x} ({:?})",
                f32::from_bits(word)
            );
        }
    }
    assert!(met > 100, "only {met} triangles were met");
    assert_eq!(gpu.layout().expect("the layout"), Gpu::expected_layout());
}
