//! The slow twin: asks every primitive. For tests, and for scenes so small that nothing is faster.

use crate::geometry::{PrimId, Primitives, Query, Sink};

/// Offers the crossings of all bounded primitives.
pub fn propose(primitives: &Primitives, query: &Query, sink: &mut impl Sink) {
    for id in 0..primitives.bounded_count() as u32 {
        primitives.propose(query, PrimId(id), sink);
    }
}
