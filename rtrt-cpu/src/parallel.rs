//! Where work runs: on rayon's threads, or, without the feature `threads`, one part after another on the caller's.

pub use imp::{Pool, join, threads};

use crate::error::Error;

/// Calls `work` for each item with its index; a task takes at least so many items.
pub fn each<T: Send>(items: &mut [T], least: usize, work: impl Fn(usize, &mut T) + Sync) {
    imp::each(items, least, work);
}

/// Calls `work` for each part of so many items, the last of which may have fewer, with the part's index; a task
/// takes at least `least` parts.
pub fn each_part<T: Send>(
    items: &mut [T],
    length: usize,
    least: usize,
    work: impl Fn(usize, &mut [T]) + Sync,
) {
    imp::each_part(items, length, least, work);
}

/// The sum of what `work` gives for each part of so many items, with the part's index.
pub fn sum_parts<T: Send, S: Default + Send>(
    items: &mut [T],
    length: usize,
    work: impl Fn(usize, &mut [T]) -> S + Sync,
    plus: impl Fn(S, S) -> S + Send + Sync,
) -> S {
    imp::sum_parts(items, length, work, plus)
}

/// The sum of what `work` gives for each item with its index, and with the item at the same place of `others`, which
/// has as many or none. Items that follow one another on a thread share a `scratch`.
pub fn sum<T: Send, U: Send, M, S: Default + Send>(
    items: &mut [T],
    others: &mut [U],
    scratch: impl Fn() -> M + Send + Sync,
    work: impl Fn(&mut M, usize, &mut T, Option<&mut U>) -> S + Send + Sync,
    plus: impl Fn(S, S) -> S + Send + Sync,
) -> S {
    imp::sum(items, others, scratch, work, plus)
}

#[cfg(feature = "threads")]
mod imp {
    use super::Error;
    use rayon::prelude::*;

    /// Threads of one's own.
    #[derive(Debug)]
    pub struct Pool(rayon::ThreadPool);

    impl Pool {
        /// So many threads; `None` for as many as the machine runs at once.
        pub fn new(threads: Option<usize>) -> Result<Self, Error> {
            let threads = threads.unwrap_or(0);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.map(Self).map_err(|source| Error::Threads { threads, source })
        }

        /// Runs `work` on the threads.
        pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
            self.0.install(work)
        }

        /// How many there are.
        pub fn threads(&self) -> u32 {
            self.0.current_num_threads() as u32
        }
    }

    /// The threads of the pool that runs the caller.
    pub fn threads() -> u32 {
        rayon::current_num_threads() as u32
    }

    /// Runs both at once.
    pub fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        rayon::join(a, b)
    }

    pub fn each<T: Send>(items: &mut [T], least: usize, work: impl Fn(usize, &mut T) + Sync) {
        items.par_iter_mut().with_min_len(least).enumerate().for_each(|(index, item)| work(index, item));
    }

    pub fn each_part<T: Send>(
        items: &mut [T],
        length: usize,
        least: usize,
        work: impl Fn(usize, &mut [T]) + Sync,
    ) {
        let parts = items.par_chunks_mut(length).with_min_len(least).enumerate();
        parts.for_each(|(index, part)| work(index, part));
    }

    pub fn sum_parts<T: Send, S: Default + Send>(
        items: &mut [T],
        length: usize,
        work: impl Fn(usize, &mut [T]) -> S + Sync,
        plus: impl Fn(S, S) -> S + Send + Sync,
    ) -> S {
        let parts = items.par_chunks_mut(length).enumerate();
        parts.map(|(index, part)| work(index, part)).reduce(S::default, plus)
    }

    pub fn sum<T: Send, U: Send, M, S: Default + Send>(
        items: &mut [T],
        others: &mut [U],
        scratch: impl Fn() -> M + Send + Sync,
        work: impl Fn(&mut M, usize, &mut T, Option<&mut U>) -> S + Send + Sync,
        plus: impl Fn(S, S) -> S + Send + Sync,
    ) -> S {
        let items = items.par_iter_mut().enumerate();
        if others.is_empty() {
            let sums = items.map_init(scratch, |scratch, (index, item)| work(scratch, index, item, None));
            return sums.reduce(S::default, plus);
        }
        let pairs = items.zip(others.par_iter_mut());
        let sums = pairs
            .map_init(scratch, |scratch, ((index, item), other)| work(scratch, index, item, Some(other)));
        sums.reduce(S::default, plus)
    }
}

#[cfg(not(feature = "threads"))]
mod imp {
    use super::Error;

    /// The caller's thread.
    #[derive(Debug)]
    pub struct Pool;

    impl Pool {
        /// The thread; another number than 1 is refused.
        pub fn new(threads: Option<usize>) -> Result<Self, Error> {
            match threads {
                None | Some(0 | 1) => Ok(Self),
                Some(threads) => Err(Error::NoThreads { threads }),
            }
        }

        /// Runs `work`.
        pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
            work()
        }

        /// One.
        pub fn threads(&self) -> u32 {
            threads()
        }
    }

    /// One.
    pub fn threads() -> u32 {
        1
    }

    /// Runs one, then the other.
    pub fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        (a(), b())
    }

    pub fn each<T: Send>(items: &mut [T], _: usize, work: impl Fn(usize, &mut T) + Sync) {
        items.iter_mut().enumerate().for_each(|(index, item)| work(index, item));
    }

    pub fn each_part<T: Send>(
        items: &mut [T],
        length: usize,
        _: usize,
        work: impl Fn(usize, &mut [T]) + Sync,
    ) {
        items.chunks_mut(length).enumerate().for_each(|(index, part)| work(index, part));
    }

    pub fn sum_parts<T: Send, S: Default + Send>(
        items: &mut [T],
        length: usize,
        work: impl Fn(usize, &mut [T]) -> S + Sync,
        plus: impl Fn(S, S) -> S + Send + Sync,
    ) -> S {
        let parts = items.chunks_mut(length).enumerate();
        parts.fold(S::default(), |sum, (index, part)| plus(sum, work(index, part)))
    }

    pub fn sum<T: Send, U: Send, M, S: Default + Send>(
        items: &mut [T],
        others: &mut [U],
        scratch: impl Fn() -> M + Send + Sync,
        work: impl Fn(&mut M, usize, &mut T, Option<&mut U>) -> S + Send + Sync,
        plus: impl Fn(S, S) -> S + Send + Sync,
    ) -> S {
        let (mut others, mut scratch) = (others.iter_mut(), scratch());
        let mut sum = S::default();
        for (index, item) in items.iter_mut().enumerate() {
            sum = plus(sum, work(&mut scratch, index, item, others.next()));
        }
        sum
    }
}
