//! The slow twin: asks every primitive. For tests, and for scenes so small that nothing is faster.

use crate::geometry::{Nearest, PrimId, Primitives, Query, Sink};

/// Offers the crossings of all bounded primitives.
pub fn propose(primitives: &Primitives, query: &Query, sink: &mut impl Sink) {
    for id in 0..primitives.bounded_count() as u32 {
        primitives.propose(query, PrimId(id), sink);
    }
}

/// Completes the nearest interfaces of `queries`.
pub fn nearest(primitives: &Primitives, queries: &[Query], answers: &mut [Nearest]) {
    for (query, answer) in queries.iter().zip(answers) {
        propose(primitives, query, answer);
    }
}
