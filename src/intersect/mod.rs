//! Nearest interfaces of many rays among many primitives.
//!
//! A backend holds bounding boxes in single precision and proposes the primitives whose boxes a ray meets;
//! [`Primitives`] decides in double precision. Boxes are grown by far more than single precision can err
//! ([`proxy`]), so no backend misses a candidate, and all give the same answer to the last bit.
//!
//! Backends: [`embree`] (Intel Embree 3 or 4, found at build time), [`obvhs`] (pure Rust), [`grid`] (for packings of
//! spheres), [`brute`] (asks every primitive: the slow twin for tests). [`choose`] is the only place that knows which are compiled in.

pub mod brute;
pub mod choose;
#[cfg(has_embree)]
pub mod embree;
pub mod grid;
#[cfg(feature = "obvhs")]
pub mod obvhs;
pub mod proxy;

use std::sync::Arc;

use crate::geometry::{Aabb, All, Hit, Nearest, Primitives, Query};

use choose::{Accelerator, Backend, BackendError};

/// Whether the rays of a batch run close together: a hint that only changes the speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coherence {
    /// Neighbours in the batch have neighbouring origins and directions.
    Coherent,
    /// They have not.
    Scattered,
}

/// The geometry of a sample, ready to be asked.
pub struct Scene {
    primitives: Arc<Primitives>,
    accelerator: Accelerator,
}

impl Scene {
    /// Builds the accelerator of `backend`. `domain` bounds all rays (µm); what sticks out of it is never found.
    ///
    /// # Errors
    /// When the backend is not compiled in or its library refuses to work.
    pub fn new(primitives: Arc<Primitives>, domain: Aabb, backend: Backend) -> Result<Self, BackendError> {
        let accelerator = Accelerator::new(&primitives, domain, backend)?;
        Ok(Self { primitives, accelerator })
    }

    /// The geometry.
    pub fn primitives(&self) -> &Primitives {
        &self.primitives
    }

    /// Finds the nearest interface of the queries whose numbers are in `which`; writes the answers at the same
    /// numbers.
    ///
    /// # Panics
    /// When a number is out of range.
    pub fn nearest(&self, queries: &[Query], which: &[usize], coherence: Coherence, answers: &mut [Nearest]) {
        for &i in which {
            answers[i].reset(queries[i].limit);
            self.primitives.propose_layers(&queries[i], &mut answers[i]);
        }
        self.accelerator.nearest(&self.primitives, queries, which, coherence, answers);
    }

    /// Finds every crossing of `query` up to its limit, in order.
    pub fn all<'a>(&self, query: &Query, found: &'a mut All) -> &'a [Hit] {
        found.restart(query.limit);
        self.primitives.propose_layers(query, found);
        self.accelerator.all(&self.primitives, query, found);
        found.sorted()
    }
}
