//! The same thing the slow, obvious way.

pub mod brute;
pub mod wide;
