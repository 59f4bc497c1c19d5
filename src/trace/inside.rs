//! Which solids a ray is inside of (Schmidt and Budge, *Simple Nested Dielectrics in Ray Traced Images*, JGT 7(2),
//! 2002): the one with the highest precedence is the medium around the ray.

use crate::geometry::{Crossing, Primitives};
use crate::sample::{Matter, MediumId, Sample};

/// Bodies that may lie in one another.
const DEEPEST: usize = 8;

/// A small multiset of solids, the winner first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inside {
    solids: [u32; DEEPEST],
    len: u8,
}

/// The record contradicts itself: a body was left that was never entered, two bodies of equal precedence overlap,
/// or too many lie in one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contradiction;

impl Inside {
    /// In the open, above everything.
    pub const NOTHING: Self = Self { solids: [0; DEEPEST], len: 0 };

    /// The solid that decides what is around the ray.
    #[inline]
    pub fn winner(&self) -> Option<u32> {
        (self.len > 0).then_some(self.solids[0])
    }

    fn enter(&mut self, solid: u32, ranks: &[u32]) -> Result<(), Contradiction> {
        let n = usize::from(self.len);
        if n == DEEPEST {
            return Err(Contradiction);
        }
        let rank = ranks[solid as usize];
        let at = self.solids[..n].partition_point(|&s| ranks[s as usize] >= rank);
        self.solids.copy_within(at..n, at + 1);
        self.solids[at] = solid;
        self.len += 1;
        Ok(())
    }

    fn leave(&mut self, solid: u32) -> Result<(), Contradiction> {
        let n = usize::from(self.len);
        let at = self.solids[..n].iter().position(|&s| s == solid).ok_or(Contradiction)?;
        self.solids.copy_within(at + 1..n, at);
        self.len -= 1;
        Ok(())
    }
}

/// Media by solid, for following rays.
pub struct Ledger {
    ranks: Vec<u32>,
    matter: Vec<Matter>,
    above: MediumId,
}

impl Ledger {
    /// Of a sample.
    pub fn new(sample: &Sample) -> Self {
        let mut order: Vec<(i32, u32)> = sample.solids.iter().map(|s| s.precedence).collect();
        order.sort_unstable();
        order.dedup();
        let rank = |p| order.binary_search(&p).unwrap_or(0) as u32;
        Self {
            ranks: sample.solids.iter().map(|s| rank(s.precedence)).collect(),
            matter: sample.solids.iter().map(|s| s.matter).collect(),
            above: sample.above,
        }
    }

    /// What is around a ray.
    #[inline]
    pub fn matter(&self, inside: &Inside) -> Matter {
        inside.winner().map_or(Matter::Medium(self.above), |s| self.matter[s as usize])
    }

    /// The record after an interface: bodies that end there are left before others are entered.
    ///
    /// # Errors
    /// When the crossings contradict the record.
    #[inline]
    pub fn cross(&self, inside: &Inside, crossings: &[Crossing], primitives: &Primitives) -> Result<Inside, Contradiction> {
        let mut after = *inside;
        for c in crossings.iter().filter(|c| !c.enters) {
            after.leave(primitives.owner(c.prim))?;
        }
        for c in crossings.iter().filter(|c| c.enters) {
            after.enter(primitives.owner(c.prim), &self.ranks)?;
        }
        self.check(&after)?;
        Ok(after)
    }

    /// Two different bodies of equal precedence in one place: which medium is there?
    #[inline]
    fn check(&self, inside: &Inside) -> Result<(), Contradiction> {
        if inside.len < 2 {
            return Ok(());
        }
        let [a, b] = [inside.solids[0], inside.solids[1]].map(|s| s as usize);
        let unclear = a != b && self.ranks[a] == self.ranks[b] && self.matter[a] != self.matter[b];
        if unclear { Err(Contradiction) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_rank_wins_and_contradictions_show() {
        let ranks = [0, 2, 1];
        let mut inside = Inside::NOTHING;
        assert_eq!(inside.winner(), None);
        for solid in [0, 1, 2, 0] {
            inside.enter(solid, &ranks).unwrap();
        }
        assert_eq!(inside.winner(), Some(1));
        inside.leave(1).unwrap();
        assert_eq!(inside.winner(), Some(2));
        assert_eq!(inside.leave(1), Err(Contradiction));
        inside.leave(0).unwrap();
        inside.leave(2).unwrap();
        assert_eq!(inside.winner(), Some(0));
        for _ in 0..7 {
            inside.enter(0, &ranks).unwrap();
        }
        assert_eq!(inside.enter(0, &ranks), Err(Contradiction));
    }
}
