//! The steps through all layers of a stack, in rows of lanes that are written once and read by every sweep.
//!
//! Layers in which all lanes travel keep real coefficients; where some are absorbed or evanescent all take complex ones,
//! which for the others are the same numbers beside zeros.

use pulp::Simd;

use crate::optics::lanes::{Complex, Lanes, Mask, Number as _};

/// What layers do to fields: rows of lanes, layer by layer.
#[derive(Debug, Default)]
pub(super) struct Steps {
    /// How, and where the rows start.
    layers: Vec<(Kind, usize)>,
    pub rows: Vec<f64>,
    /// What layers absorb: room for rows that `losses` fills in.
    pub losses: Vec<f64>,
}

/// How lanes go through a layer.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// Light travels in all: U' = c U + b V, V' = c V + g U with rows c, and ib and ig for s, then for p.
    Real,
    /// The same with complex coefficients: all real parts, then all imaginary ones.
    Complex,
    /// As two waves: rows e^{2iδ}, and the admittance and its inverse for s, then for p; real parts, then imaginary ones.
    Waves,
    /// Some lanes as `Complex`, some as `Waves`: the rows of both, then one that is not 0 where waves count.
    Mixed,
}

/// Complex coefficients of a layer.
pub(super) const COEFFICIENTS: usize = 5;

impl Kind {
    /// Number of its rows.
    fn rows(self) -> usize {
        match self {
            Self::Real => COEFFICIENTS,
            Self::Complex | Self::Waves => 2 * COEFFICIENTS,
            Self::Mixed => 4 * COEFFICIENTS + 1,
        }
    }
}

/// The step through one layer.
#[derive(Clone, Copy)]
pub(super) struct Step<'a, S: Simd> {
    s: S,
    pub kind: Kind,
    rows: &'a [f64],
}

impl<S: Simd> Step<'_, S> {
    #[inline(always)]
    fn row(&self, i: usize) -> Lanes<S> {
        Lanes::load(self.s, self.rows, i)
    }

    #[inline(always)]
    fn number(&self, at: usize, i: usize) -> Complex<S> {
        Complex { re: self.row(at + i), im: self.row(at + i + COEFFICIENTS) }
    }

    /// Coefficients of a `Real` layer.
    #[inline(always)]
    pub fn real(&self, p: bool) -> [Lanes<S>; 3] {
        let first = if p { 3 } else { 1 };
        [self.row(0), self.row(first), self.row(first + 1)]
    }

    /// Complex coefficients whose rows start at `at`.
    #[inline(always)]
    pub fn complex(&self, at: usize, p: bool) -> [Complex<S>; 3] {
        let first = if p { 3 } else { 1 };
        [self.number(at, 0), self.number(at, first), self.number(at, first + 1)]
    }

    /// One unit of power behind the layer, in units of the power in front: |e^{2iδ}| where fields lack e^{iδ}.
    #[inline(always)]
    pub fn behind(&self) -> Lanes<S> {
        let one = Lanes::splat(self.s, 1.0);
        match self.kind {
            Kind::Real | Kind::Complex => one,
            Kind::Waves => self.number(0, 0).norm_sqr().sqrt(),
            Kind::Mixed => self.much().choose(self.number(2 * COEFFICIENTS, 0).norm_sqr().sqrt(), one),
        }
    }

    /// Where waves count, in a `Mixed` layer.
    #[inline(always)]
    pub fn much(&self) -> Mask<S> {
        self.row(4 * COEFFICIENTS).gt(Lanes::splat(self.s, 0.0))
    }
}

impl Steps {
    /// Forgets all layers.
    pub fn clear(&mut self) {
        self.layers.clear();
    }

    /// Number of layers.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.layers.len()
    }

    /// The step through layer `i`.
    #[inline(always)]
    pub fn at<S: Simd>(&self, s: S, i: usize) -> Step<'_, S> {
        let (kind, start) = self.layers[i];
        Step { s, kind, rows: &self.rows[start..start + kind.rows() * S::F64_LANES] }
    }

    /// Makes room for the next layer; returns where its rows end.
    #[inline(always)]
    pub fn claim(&mut self, kind: Kind, start: usize, lanes: usize) -> usize {
        let end = start + kind.rows() * lanes;
        if self.rows.len() < end {
            self.rows.resize(end.next_power_of_two(), 0.0);
        }
        self.layers.push((kind, start));
        end
    }
}

#[inline(always)]
pub(super) fn store<S: Simd>(step: &[Complex<S>; COEFFICIENTS], rows: &mut [f64]) {
    for (i, z) in step.iter().enumerate() {
        z.re.store(rows, i);
        z.im.store(rows, i + COEFFICIENTS);
    }
}
