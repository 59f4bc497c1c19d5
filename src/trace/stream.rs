//! Rays in flight: a stream of one generation, with what each carries stored in flat lists.

use std::ops::Range;

use glam::DVec3;

use super::inside::Inside;
use crate::geometry::{Order, PrimId, Query, Ray, SurfaceId};
use crate::optics::jones::Jones;
use crate::sample::MediumId;

/// A ray between two interfaces. What it carries per lane lies in the lists of its [`Stream`].
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// Start (µm) and direction.
    pub ray: Ray,
    /// Interfaces count after this place (a ray goes on straight where media are equal).
    pub from: Order,
    /// The surface it started on.
    pub last: SurfaceId,
    /// The primitive that surface was met on.
    pub at: PrimId,
    /// x̂ of the frame of its fields.
    pub frame: DVec3,
    /// The solids it is inside of.
    pub inside: Inside,
    /// The medium around it.
    pub medium: MediumId,
    /// Its tree, in the chunk.
    pub tree: u32,
    /// Its branch of the tree: 1 before the split, then 2 (reflected) or 3 (transmitted).
    pub branch: u32,
    /// Interfaces at which its path was decided.
    pub events: u32,
    /// Periods by which it was moved back.
    pub walk: [i32; 2],
    /// Where the tree entered, µm.
    pub anchor: DVec3,
}

/// Rays of one generation. Rays are only appended and read in order, so there is nothing to allocate per ray.
#[derive(Debug)]
pub struct Stream<const C: usize> {
    flights: Vec<Flight>,
    /// Where the part of each ray ends in the lists of lanes and fields.
    ends: Vec<usize>,
    lanes: Vec<u16>,
    fields: Vec<Jones<C>>,
    lengths: Vec<f64>,
    /// Number of media whose lengths are followed; 0 if phase is not.
    media: usize,
}

/// What a ray carries.
#[derive(Clone, Copy, Debug)]
pub struct Load<'a, const C: usize> {
    /// Numbers of the lanes.
    pub lanes: &'a [u16],
    /// Field of each lane.
    pub fields: &'a [Jones<C>],
    /// Length travelled per medium, µm.
    pub lengths: &'a [f64],
}

impl<const C: usize> Stream<C> {
    /// An empty stream that follows lengths in `media` media.
    pub fn new(media: usize) -> Self {
        Self { flights: Vec::new(), ends: Vec::new(), lanes: Vec::new(), fields: Vec::new(), lengths: Vec::new(), media }
    }

    /// Removes all rays.
    pub fn clear(&mut self) {
        self.flights.clear();
        self.ends.clear();
        self.lanes.clear();
        self.fields.clear();
        self.lengths.clear();
    }

    /// Whether there are no rays.
    pub fn is_empty(&self) -> bool {
        self.flights.is_empty()
    }

    /// Adds a ray.
    pub fn push(&mut self, flight: Flight, load: Load<'_, C>) {
        self.lanes.extend_from_slice(load.lanes);
        self.fields.extend_from_slice(load.fields);
        self.lengths.extend_from_slice(load.lengths);
        self.ends.push(self.lanes.len());
        self.flights.push(flight);
    }

    /// The rays.
    pub fn flights(&self) -> &[Flight] {
        &self.flights
    }

    fn part(&self, i: usize) -> Range<usize> {
        let first = if i == 0 { 0 } else { self.ends[i - 1] };
        first..self.ends[i]
    }

    /// What ray `i` carries.
    pub fn load(&self, i: usize) -> Load<'_, C> {
        let part = self.part(i);
        Load {
            lanes: &self.lanes[part.clone()],
            fields: &self.fields[part],
            lengths: &self.lengths[i * self.media..(i + 1) * self.media],
        }
    }

    /// Fields (to be changed) and lanes of ray `i`.
    pub fn fields_mut(&mut self, i: usize) -> (&mut [Jones<C>], &[u16]) {
        let part = self.part(i);
        (&mut self.fields[part.clone()], &self.lanes[part])
    }

    /// Adds to the length ray `i` has travelled in a medium, if lengths are followed.
    pub fn add_length(&mut self, i: usize, medium: MediumId, length: f64) {
        if self.media > 0 {
            self.lengths[i * self.media + usize::from(medium.0)] += length;
        }
    }
}

impl Flight {
    /// A ray of a new tree, in the open.
    pub fn start(ray: Ray, frame: DVec3, medium: MediumId, tree: u32) -> Self {
        Self {
            ray,
            from: Order { t: 0.0, surface: SurfaceId::NONE },
            last: SurfaceId::NONE,
            at: PrimId(u32::MAX),
            frame,
            inside: Inside::NOTHING,
            medium,
            tree,
            branch: 1,
            events: 0,
            walk: [0, 0],
            anchor: ray.origin,
        }
    }

    /// The question where it meets something within `limit` µm.
    #[inline]
    pub fn query(&self, limit: f64) -> Query {
        Query { from: self.from, limit, ..Query::leaving(self.ray, self.last) }
    }
}
