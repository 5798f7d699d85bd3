//! Where instances are: the bounds of all of them, and which of them have moved.

use crate::scene::bvh::Bounds;
use alloc::vec;
use alloc::vec::Vec;

/// What rays ask of an instance, and pictures do not.
#[derive(Debug, Clone, Copy)]
pub struct Tag {
    /// The groups that it belongs to, one a bit.
    pub mask: u32,
    /// The caller's number.
    pub user: u32,
    /// Counts what has been at this place, two for each: odd while nothing is there.
    pub generation: u32,
}

impl Tag {
    /// That of the place once its instance is removed, or once there is a new one.
    pub(crate) fn next(self) -> Self {
        Self { generation: self.generation.wrapping_add(1), ..Self::default() }
    }
    /// Whether an instance is at this place.
    pub(crate) fn is_live(self) -> bool {
        self.generation.is_multiple_of(2)
    }
}

impl Default for Tag {
    fn default() -> Self {
        Self { mask: u32::MAX, user: 0, generation: 0 }
    }
}

/// Bounds under one that is around them.
const GROUP: usize = 16;
/// The fewest moves that are remembered.
const FEWEST: usize = 64;

/// The bounds of instances, in a tree that is as flat as its numbers: a move costs one path to the root.
#[derive(Debug, Clone, Default)]
pub struct Places {
    /// The bounds of each instance, empty if it is hidden; then of each group; and so on, up to one.
    levels: Vec<Vec<Bounds>>,
    /// The instances that moved last, one after the other. Not more than memory is reserved for, so that a
    /// move does not allocate.
    moved: Vec<u32>,
    /// So many moves were before those.
    forgotten: u64,
    /// So many moves are in the levels above the first.
    applied: u64,
}

impl Places {
    /// One more instance.
    pub(crate) fn push(&mut self, bounds: &Bounds) {
        self.update();
        let index = self.len();
        if self.levels.is_empty() {
            self.levels.push(vec![]);
        }
        self.levels[0].push(*bounds);
        let moves = FEWEST.max(self.len() / 8);
        self.moved.reserve(moves - self.moved.len().min(moves));
        self.raise(index);
    }

    /// The number of instances.
    pub(crate) fn len(&self) -> usize {
        self.levels.first().map_or(0, Vec::len)
    }

    /// Moves one of them. [`Places::update`] must follow before the next [`Places::all`].
    pub(crate) fn set(&mut self, index: usize, bounds: &Bounds) {
        self.levels[0][index] = *bounds;
        if self.moved.len() < self.moved.capacity() {
            self.moved.push(index as u32);
        } else {
            self.forgotten = self.moves() + 1;
            self.moved.clear();
        }
    }

    /// Takes the moves over into the bounds of all.
    pub(crate) fn update(&mut self) {
        match self.moved_since(self.applied).map(<[u32]>::len) {
            Some(count) => {
                for i in self.moved.len() - count..self.moved.len() {
                    self.raise(self.moved[i] as usize);
                }
            }
            None => {
                let mut level = 0;
                while self.levels[level].len() > 1 {
                    (0..self.levels[level].len().div_ceil(GROUP)).for_each(|group| self.gather(level, group));
                    level += 1;
                }
            }
        }
        self.applied = self.moves();
    }

    /// The number of moves so far.
    pub(crate) fn moves(&self) -> u64 {
        self.forgotten + self.moved.len() as u64
    }

    /// The instances that moved after the first `moves` moves, perhaps more than once; `None` if that is
    /// forgotten, because there were many.
    pub(crate) fn moved_since(&self, moves: u64) -> Option<&[u32]> {
        let first = moves.checked_sub(self.forgotten)?;
        self.moved.get(first as usize..)
    }

    /// The bounds of an instance; empty if it is hidden.
    pub(crate) fn bounds(&self, index: usize) -> &Bounds {
        &self.levels[0][index]
    }

    /// The bounds of all instances but hidden ones.
    pub(crate) fn all(&self) -> Bounds {
        self.levels.last().and_then(|level| level.first()).copied().unwrap_or(Bounds::EMPTY)
    }

    /// Computes all bounds around that of an instance, from below.
    fn raise(&mut self, mut index: usize) {
        let mut level = 0;
        while self.levels[level].len() > 1 {
            index /= GROUP;
            self.gather(level, index);
            level += 1;
        }
    }

    /// Computes the bounds of a group of a level.
    fn gather(&mut self, level: usize, group: usize) {
        let below = &self.levels[level];
        let members = &below[group * GROUP..below.len().min((group + 1) * GROUP)];
        let bounds = members.iter().fold(Bounds::EMPTY, |all, bounds| all.union(bounds));
        if level + 1 == self.levels.len() {
            self.levels.push(vec![]);
        }
        let above = &mut self.levels[level + 1];
        if group < above.len() { above[group] = bounds } else { above.push(bounds) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f32) -> Bounds {
        Bounds { low: [x; 3], high: [x + 1.0, x, x] }
    }

    #[test]
    fn the_bounds_of_all_are_those_of_each_whatever_moved() {
        let mut places = Places::default();
        assert!(places.all().is_empty());
        let mut seed = 1_u32;
        let mut random = |below: u32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) % below
        };
        for count in 1..600_u32 {
            places.push(&at(random(1000) as f32));
            // From one to all of them.
            for _ in 0..random(count.min(100)) {
                let bounds = if random(5) == 0 { Bounds::EMPTY } else { at(random(1000) as f32) };
                places.set(random(count) as usize, &bounds);
            }
            places.update();
            let all = places.levels[0].iter().fold(Bounds::EMPTY, |all, bounds| all.union(bounds));
            assert_eq!((places.all().low, places.all().high), (all.low, all.high));
        }
    }

    #[test]
    fn moves_are_remembered_as_long_as_there_is_memory_and_then_all_at_once_forgotten() {
        let mut places = Places::default();
        (0..40).for_each(|x| places.push(&at(x as f32)));
        let (start, room) = (places.moves(), places.moved.capacity());
        places.set(7, &at(1.0));
        places.set(3, &at(1.0));
        assert_eq!(places.moved_since(start), Some(&[7, 3][..]));
        assert_eq!(places.moved_since(start + 1), Some(&[3][..]));
        (2..=room).for_each(|_| places.set(1, &at(0.0)));
        assert_eq!((places.moved_since(start), places.moved.capacity()), (None, room));
        assert_eq!(places.moved_since(places.moves()), Some(&[][..]));
    }
}
