//! The front door of rtrt: scenes from files and in code.

pub mod choose;
pub mod demo;
pub mod import;
