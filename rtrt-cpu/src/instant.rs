//! What tells the time. Without the feature `std` nothing does: every moment is the same, and stages take no time.

#[cfg(feature = "std")]
pub use web_time::Instant;

#[cfg(not(feature = "std"))]
pub use none::Instant;

#[cfg(not(feature = "std"))]
mod none {
    use core::ops::Sub;
    use core::time::Duration;

    /// The only moment.
    #[derive(Clone, Copy)]
    pub struct Instant;

    impl Instant {
        /// It.
        pub fn now() -> Self {
            Self
        }

        /// None.
        pub fn elapsed(&self) -> Duration {
            Duration::ZERO
        }
    }

    impl Sub for Instant {
        type Output = Duration;

        fn sub(self, _: Self) -> Duration {
            Duration::ZERO
        }
    }
}
