//! Which solids a ray is inside of (Schmidt and Budge, *Simple Nested Dielectrics in Ray Traced Images*, JGT 7(2),
//! 2002): the one with the highest precedence is the medium around the ray.

use crate::geometry::Crossing;
use crate::sample::{Matter, MediumId, Sample};

/// Bodies that may lie in one another.
const DEEPEST: usize = 32;

/// Few rays are in more.
const USUAL: usize = 4;

/// A small multiset of solids, the winner first.
#[derive(Debug)]
pub struct Inside {
    solids: [u32; DEEPEST],
    len: u32,
}

impl Clone for Inside {
    fn clone(&self) -> Self {
        let mut out = Self::NOTHING;
        out.clone_from(self);
        out
    }

    /// Copies only what is there, or little more: this happens at every interface.
    #[inline]
    fn clone_from(&mut self, other: &Self) {
        self.len = other.len;
        self.solids[..USUAL].copy_from_slice(&other.solids[..USUAL]);
        if self.len as usize > USUAL {
            self.solids = other.solids;
        }
    }
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

    fn enter(&mut self, solid: u32, briefs: &[Brief]) -> Result<(), Contradiction> {
        let n = self.len as usize;
        if n == DEEPEST {
            return Err(Contradiction);
        }
        let rank = briefs[solid as usize].rank;
        let at = self.solids[..n].iter().take_while(|&&s| briefs[s as usize].rank >= rank).count();
        for i in (at..n).rev() {
            self.solids[i + 1] = self.solids[i];
        }
        self.solids[at] = solid;
        self.len += 1;
        Ok(())
    }

    fn leave(&mut self, solid: u32) -> Result<(), Contradiction> {
        let n = self.len as usize;
        let at = self.solids[..n].iter().position(|&s| s == solid).ok_or(Contradiction)?;
        for i in at + 1..n {
            self.solids[i - 1] = self.solids[i];
        }
        self.len -= 1;
        Ok(())
    }
}

/// What surrounds a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Around {
    /// A medium.
    Medium(MediumId),
    /// Nothing can be inside this solid.
    Opaque(u32),
}

/// What the tracer needs of a solid, small enough to stay in the cache.
#[derive(Clone, Copy, Debug)]
struct Brief {
    rank: u32,
    /// Its medium, or [`OPAQUE`].
    medium: u16,
    closed: bool,
    lonely: bool,
}

const OPAQUE: u16 = u16::MAX;

/// The solids of a sample, for following rays.
pub struct Solids {
    briefs: Vec<Brief>,
    /// The group each solid belongs to in the ledger.
    groups: Vec<u16>,
    any_open: bool,
    above: MediumId,
}

impl Solids {
    /// Of a sample.
    pub fn new(sample: &Sample) -> Self {
        let mut order: Vec<(i32, u32)> = sample.solids.iter().map(|s| s.precedence).collect();
        order.sort_unstable();
        order.dedup();
        let brief = |s: &crate::sample::Solid| Brief {
            rank: order.binary_search(&s.precedence).unwrap_or(0) as u32,
            medium: if let Matter::Medium(id) = s.matter { id.0 } else { OPAQUE },
            closed: s.closed,
            lonely: s.lonely,
        };
        let any_open = sample.solids.iter().any(|s| !s.closed);
        Self {
            briefs: sample.solids.iter().map(brief).collect(),
            groups: sample.groups.of_solid.clone(),
            any_open,
            above: sample.above,
        }
    }

    /// What is around a ray.
    #[inline]
    pub fn around(&self, inside: &Inside) -> Around {
        match inside.winner() {
            None => Around::Medium(self.above),
            Some(solid) => match self.briefs[solid as usize].medium {
                OPAQUE => Around::Opaque(solid),
                medium => Around::Medium(MediumId(medium)),
            },
        }
    }

    /// The group of a solid in the ledger.
    #[inline]
    pub fn group(&self, solid: u32) -> u16 {
        self.groups[solid as usize]
    }

    /// The group of what is around a ray. Where there is no body nothing absorbs.
    #[inline]
    pub fn group_around(&self, inside: &Inside) -> u16 {
        inside.winner().map_or(0, |solid| self.group(solid))
    }

    /// Whether a solid is one convex primitive with nothing in it.
    #[inline]
    pub fn is_lonely(&self, solid: u32) -> bool {
        self.briefs[solid as usize].lonely
    }

    /// An opaque surface without an inside among the faces met.
    #[inline]
    pub fn open_surface(&self, crossings: &[Crossing]) -> Option<u32> {
        if !self.any_open {
            return None;
        }
        crossings.iter().map(|c| c.owner).find(|&s| !self.briefs[s as usize].closed)
    }

    /// Takes the record over an interface: bodies that end there are left before others are entered.
    ///
    /// # Errors
    /// When the crossings contradict the record.
    #[inline]
    pub fn cross(&self, inside: &mut Inside, crossings: &[Crossing]) -> Result<(), Contradiction> {
        for c in crossings.iter().filter(|c| !c.enters) {
            inside.leave(c.owner)?;
        }
        for c in crossings.iter().filter(|c| c.enters) {
            inside.enter(c.owner, &self.briefs)?;
        }
        self.check(inside)
    }

    /// Two different bodies of equal precedence in one place: which medium is there?
    #[inline]
    fn check(&self, inside: &Inside) -> Result<(), Contradiction> {
        if inside.len < 2 || inside.solids[0] == inside.solids[1] {
            return Ok(());
        }
        let [a, b] = [inside.solids[0], inside.solids[1]].map(|s| self.briefs[s as usize]);
        let unclear = a.rank == b.rank && (a.medium != b.medium || a.medium == OPAQUE);
        if unclear { Err(Contradiction) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_rank_wins_and_contradictions_show() {
        let briefs = [0, 2, 1].map(|rank| Brief { rank, medium: 0, closed: true, lonely: false });
        let mut inside = Inside::NOTHING;
        assert_eq!(inside.winner(), None);
        for solid in [0, 1, 2, 0] {
            inside.enter(solid, &briefs).unwrap();
        }
        assert_eq!(inside.winner(), Some(1));
        inside.leave(1).unwrap();
        assert_eq!(inside.winner(), Some(2));
        assert_eq!(inside.leave(1), Err(Contradiction));
        inside.leave(0).unwrap();
        inside.leave(2).unwrap();
        assert_eq!(inside.winner(), Some(0));
        for _ in 1..DEEPEST {
            inside.enter(0, &briefs).unwrap();
        }
        assert_eq!(inside.enter(0, &briefs), Err(Contradiction));
    }
}
