//! Rays in flight, in numbered slots: what is asked of the geometry, the answer, and what each ray carries lie in
//! one list each, so that a ray changes in place and nothing is allocated per ray.

use std::marker::PhantomData;

use glam::DVec3;

use super::inside::Inside;
use crate::geometry::{Nearest, PrimId, Query};
use crate::optics::field::{Field, gather, scatter};
use crate::optics::lanes::padded;
use crate::sample::MediumId;

/// What ends a segment if no interface does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Border {
    /// Nothing more can be met.
    Out,
    /// The ray goes on, moved by these periods.
    Seam([i32; 2]),
}

/// What a ray is besides its [`Query`].
#[derive(Clone, Debug)]
pub struct Flight {
    /// x̂ of the frame of its fields.
    pub frame: DVec3,
    /// The primitive on whose surface it started.
    pub at: PrimId,
    /// The medium around it.
    pub medium: MediumId,
    /// The solids it is inside of.
    pub inside: Inside,
    /// Its tree, in the chunk.
    pub tree: u32,
    /// Its branch of the tree: 1 before the split, then 2 (reflected) or 3 (transmitted).
    pub branch: u32,
    /// Interfaces at which its path was decided.
    pub events: u32,
    /// Periods by which it was moved back.
    pub walk: [i32; 2],
    /// What ends its way if no interface does.
    pub border: Border,
    /// By how much its direction may be off from that of one of its lanes, rad: the root of the sum of the squares of what
    /// each refraction has made.
    pub spread: f64,
    /// Whether it has met a face so narrow that ray optics is in doubt.
    pub doubtful: bool,
    /// Whether it has met a film near to an edge.
    pub edge: bool,
}

/// Number of a ray.
pub type Slot = usize;

/// Rays by slot.
#[derive(Debug)]
pub struct Stream<F> {
    words: usize,
    media: usize,
    /// Where each ray is and goes.
    pub queries: Vec<Query>,
    /// Where it meets something.
    pub answers: Vec<Nearest>,
    /// The rest.
    pub flights: Vec<Flight>,
    /// Which lanes it carries: a bit each.
    masks: Vec<u64>,
    /// Room for the lanes of one number of a field.
    apart: usize,
    /// Fields: for each ray all first numbers by lane, then all second ones, and so on. Those of lanes that it does not
    /// carry are left over from others.
    fields: Vec<f64>,
    kind: PhantomData<F>,
    /// Length travelled per medium, µm.
    lengths: Vec<f64>,
    free: Vec<Slot>,
}

impl<F: Field> Stream<F> {
    /// No rays yet; each will have `lanes` lanes and follow its length in `media` media.
    pub fn new(lanes: usize, media: usize) -> Self {
        Self {
            words: lanes.div_ceil(64),
            media,
            queries: Vec::new(),
            answers: Vec::new(),
            flights: Vec::new(),
            masks: Vec::new(),
            apart: padded(lanes),
            fields: Vec::new(),
            kind: PhantomData,
            lengths: Vec::new(),
            free: Vec::new(),
        }
    }

    /// A new ray without lanes.
    pub fn insert(&mut self, query: Query, flight: Flight) -> Slot {
        if let Some(slot) = self.free.pop() {
            self.queries[slot] = query;
            self.flights[slot] = flight;
            self.masks[slot * self.words..(slot + 1) * self.words].fill(0);
            self.lengths[slot * self.media..(slot + 1) * self.media].fill(0.0);
            return slot;
        }
        let slot = self.queries.len();
        self.queries.push(query);
        self.answers.push(Nearest::none(0.0));
        self.flights.push(flight);
        self.masks.resize((slot + 1) * self.words, 0);
        self.fields.resize((slot + 1) * self.room(), 0.0);
        self.lengths.resize((slot + 1) * self.media, 0.0);
        slot
    }

    /// A copy of a ray, without lanes.
    pub fn fork(&mut self, slot: Slot) -> Slot {
        let twin = self.insert(self.queries[slot], self.flights[slot].clone());
        let lengths = slot * self.media..(slot + 1) * self.media;
        self.lengths.copy_within(lengths, twin * self.media);
        twin
    }

    /// Forgets a ray.
    pub fn remove(&mut self, slot: Slot) {
        self.free.push(slot);
    }

    /// The lanes of a ray, ascending.
    #[inline]
    pub fn lanes(&self, slot: Slot) -> impl Iterator<Item = u16> + use<'_, F> {
        let words = &self.masks[slot * self.words..(slot + 1) * self.words];
        words.iter().enumerate().flat_map(|(w, &mask)| Bits(mask).map(move |b| (64 * w) as u16 + b))
    }

    /// The first lane of a ray that has any, and whether it is the only one.
    #[inline]
    pub fn first_lane(&self, slot: Slot) -> (u16, bool) {
        let words = &self.masks[slot * self.words..(slot + 1) * self.words];
        let first = words.iter().position(|&m| m != 0).unwrap_or(0);
        let alone = words[first].is_power_of_two() && words[first + 1..].iter().all(|&m| m == 0);
        ((64 * first) as u16 + words[first].trailing_zeros() as u16, alone)
    }

    /// One word of the lanes of a ray.
    #[inline]
    pub fn word(&self, slot: Slot, word: usize) -> u64 {
        self.masks[slot * self.words + word]
    }

    /// Number of words.
    pub fn words(&self) -> usize {
        self.words
    }

    /// Gives a ray a lane.
    #[inline]
    pub fn put(&mut self, slot: Slot, lane: u16, field: F) {
        let lane = usize::from(lane);
        self.masks[slot * self.words + lane / 64] |= 1 << (lane % 64);
        let apart = self.apart;
        scatter(&field, self.numbers_mut(slot), lane, apart);
    }

    /// Takes a lane from a ray.
    #[inline]
    pub fn drop_lane(&mut self, slot: Slot, lane: u16) {
        let lane = usize::from(lane);
        self.masks[slot * self.words + lane / 64] &= !(1 << (lane % 64));
    }

    /// The field of a lane.
    #[inline]
    pub fn field(&self, slot: Slot, lane: u16) -> F {
        gather(self.numbers(slot), usize::from(lane), self.apart)
    }

    /// Numbers of the fields of a ray.
    #[inline]
    fn room(&self) -> usize {
        F::PARTS * self.apart
    }

    /// The fields of a ray: the first number of all lanes ([padded]), then the second, and so on.
    #[inline]
    pub fn numbers(&self, slot: Slot) -> &[f64] {
        &self.fields[slot * self.room()..(slot + 1) * self.room()]
    }

    /// The same, to be changed.
    #[inline]
    pub fn numbers_mut(&mut self, slot: Slot) -> &mut [f64] {
        let room = self.room();
        &mut self.fields[slot * room..(slot + 1) * room]
    }

    /// Takes all lanes from a ray, and gives it these: a bit each.
    #[inline]
    pub fn set_lanes(&mut self, slot: Slot, words: impl Iterator<Item = u64>) {
        self.masks[slot * self.words..(slot + 1) * self.words].iter_mut().zip(words).for_each(|(to, from)| *to = from);
    }

    /// Lanes with their fields.
    #[inline]
    pub fn loads(&self, slot: Slot) -> impl Iterator<Item = (u16, F)> + use<'_, F> {
        self.lanes(slot).map(move |lane| (lane, self.field(slot, lane)))
    }

    /// Length travelled per medium, µm; empty if not followed.
    pub fn lengths(&self, slot: Slot) -> &[f64] {
        &self.lengths[slot * self.media..(slot + 1) * self.media]
    }

    /// Adds to the length travelled in a medium; lengths must be followed.
    #[inline]
    pub fn add_length(&mut self, slot: Slot, medium: MediumId, length: f64) {
        self.lengths[slot * self.media + usize::from(medium.0)] += length;
    }
}

/// The numbers of the bits that are set, ascending.
pub struct Bits(pub u64);

impl Iterator for Bits {
    type Item = u16;

    #[inline]
    fn next(&mut self) -> Option<u16> {
        if self.0 == 0 {
            return None;
        }
        let bit = self.0.trailing_zeros() as u16;
        self.0 &= self.0 - 1;
        Some(bit)
    }
}
