//! Numbers that Python names things by.

use crate::arrays::there_are;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// Things by their numbers, from 0 in the order in which they were added. No number is given twice: that of what was removed
/// names nothing.
#[derive(Clone)]
pub struct Numbers<T> {
    what: &'static str,
    /// Which of these things have numbers: what errors say after how many there are.
    which: &'static str,
    all: BTreeMap<i32, T>,
    next: i32,
}

impl<T> Numbers<T> {
    /// None yet.
    pub const fn new(what: &'static str, which: &'static str) -> Self {
        Self { what, which, all: BTreeMap::new(), next: 0 }
    }

    /// How many things there are.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// All, in the order of their numbers.
    pub fn iter(&self) -> impl Iterator<Item = (i32, &T)> {
        self.all.iter().map(|(number, thing)| (*number, thing))
    }

    /// The number of what is added next.
    ///
    /// # Errors
    /// `ValueError`: arrays of int32 have no number for another one.
    pub fn next(&self) -> PyResult<i32> {
        if self.next < i32::MAX {
            return Ok(self.next);
        }
        Err(PyValueError::new_err(format!(
            "no number is left for another {}: {} were given",
            self.what, self.next
        )))
    }

    /// Adds a thing under the next number, and returns that.
    pub fn add(&mut self, thing: T) -> i32 {
        let number = self.next;
        self.all.insert(number, thing);
        self.next = number.saturating_add(1);
        number
    }

    /// Forgets the thing with a number.
    pub fn remove(&mut self, number: i64) {
        i32::try_from(number).ok().and_then(|number| self.all.remove(&number));
    }

    /// The thing with a number.
    pub fn find(&self, number: i64) -> Option<&T> {
        i32::try_from(number).ok().and_then(|number| self.all.get(&number))
    }

    /// The thing with a number.
    ///
    /// # Errors
    /// `IndexError`: there is none.
    pub fn get(&self, number: i64) -> PyResult<&T> {
        self.find(number).ok_or_else(|| self.missing(number))
    }

    /// The exception for a number that nothing has.
    pub fn missing(&self, number: i64) -> PyErr {
        PyIndexError::new_err(format!("there is no {} {number}: {}", self.what, self.why_not(number)))
    }

    /// Why nothing has a number.
    pub fn why_not(&self, number: i64) -> String {
        let Self { what, which, next, .. } = self;
        if (0..i64::from(*next)).contains(&number) {
            return "it was removed".into();
        }
        match self.len() {
            count if count == *next as usize => format!("{}{which}", there_are(count, what)),
            _ => format!("the last {what} that was added is {}", next - 1),
        }
    }
}
