//! Work on many things, side by side.

use rtrt_core::scene::Join;

/// What comes of each of these things, in their order. Workers of `join` take halves of them, and halves of those.
pub(crate) fn each<T: Sync, R: Send>(
    join: &impl Join,
    things: &[T],
    of: &(impl Fn(&T) -> R + Sync),
) -> Vec<R> {
    match things {
        [] => Vec::new(),
        [one] => vec![of(one)],
        several => {
            let (a, b) = several.split_at(several.len() / 2);
            let (mut a, b) = join.join(|| each(join, a, of), || each(join, b, of));
            a.extend(b);
            a
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rtrt_cpu::Parallel;

    #[test]
    fn the_order_is_kept() {
        let numbers: Vec<u32> = (0..100).collect();
        for count in 0..numbers.len() {
            let doubled: Vec<u32> = numbers[..count].iter().map(|n| 2 * n).collect();
            assert_eq!(each(&Parallel, &numbers[..count], &|n| 2 * n), doubled);
        }
    }
}
