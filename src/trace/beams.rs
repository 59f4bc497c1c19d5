//! What an interface, or a stack, does to the reflected and the transmitted beam.

use std::marker::PhantomData;

use pulp::Simd;

use crate::optics::Coefficients;
use crate::optics::field::{Parts, Passage, gather, load, scatter, splat};
use crate::optics::lanes::{Lanes, padded};

/// One passage for each beam.
#[derive(Clone, Copy, Debug)]
pub struct Beams<P> {
    /// Reflection.
    pub reflected: P,
    /// Transmission.
    pub transmitted: P,
}

impl<P: Passage> Beams<P> {
    /// From amplitude coefficients.
    pub fn new(c: &Coefficients) -> Self {
        Self { reflected: P::new(c.r), transmitted: P::new(c.t) }
    }

    /// The same for each of several lanes.
    #[inline(always)]
    pub fn splat<S: Simd, W: Parts<Lanes<S>>>(&self, s: S) -> Beams<W> {
        Beams { reflected: splat(s, &self.reflected), transmitted: splat(s, &self.transmitted) }
    }
}

/// The beams of all lanes, number by number, so that several lanes can be read at once.
#[derive(Debug)]
pub struct BeamTable<P> {
    apart: usize,
    reflected: Vec<f64>,
    transmitted: Vec<f64>,
    kind: PhantomData<P>,
}

impl<P: Passage> BeamTable<P> {
    /// For so many lanes.
    pub fn new(lanes: usize) -> Self {
        let apart = padded(lanes);
        let numbers = vec![0.0; P::PARTS * apart];
        Self { apart, reflected: numbers.clone(), transmitted: numbers, kind: PhantomData }
    }

    /// Of all lanes, in order.
    pub fn set_all(&mut self, all: impl Iterator<Item = Beams<P>>) {
        all.enumerate().for_each(|(lane, beams)| self.set(lane, &beams));
    }

    /// Of one lane.
    #[inline]
    pub fn set(&mut self, lane: usize, beams: &Beams<P>) {
        scatter(&beams.reflected, &mut self.reflected, lane, self.apart);
        scatter(&beams.transmitted, &mut self.transmitted, lane, self.apart);
    }

    /// Of one lane.
    #[inline]
    pub fn get(&self, lane: usize) -> Beams<P> {
        Beams {
            reflected: gather(&self.reflected, lane, self.apart),
            transmitted: gather(&self.transmitted, lane, self.apart),
        }
    }

    /// Of a block of lanes.
    #[inline(always)]
    pub fn load<S: Simd, W: Parts<Lanes<S>>>(&self, s: S, block: usize) -> Beams<W> {
        Beams {
            reflected: load(s, &self.reflected, block, self.apart),
            transmitted: load(s, &self.transmitted, block, self.apart),
        }
    }
}
