//! What one chunk of trees, or one batch of chunks, has put into the dome.

use serde::{Deserialize, Serialize};

/// Entries of the energy ledger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// Upwards, the mirror direction included.
    Reflected,
    /// Downwards, the straight direction included.
    Transmitted,
    /// In the sample.
    Absorbed,
    /// Sideways.
    Side,
    /// In the mirror direction.
    Specular,
    /// In the straight direction.
    Undeflected,
    /// Met faces so narrow that ray optics is in doubt.
    Doubtful,
    /// Met films near to their edges.
    Edge,
    /// Lost, by [`crate::trace::Loss::ALL`].
    LostMedium,
    /// Lost beyond the depth limit.
    LostDepth,
    /// Lost to numbers.
    LostNumeric,
}

impl Entry {
    /// How many there are.
    pub const COUNT: usize = 11;
}

/// How many numbers a tally holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shape {
    /// Lanes: wavelengths that are traced.
    pub lanes: usize,
    /// Numbers that tell of light that has left: its power, or 16 elements of a Mueller matrix by rows.
    pub components: usize,
    /// Groups of bodies whose absorbed power is told apart.
    pub groups: usize,
}

impl Shape {
    /// Of power alone.
    pub fn of_power(lanes: usize) -> Self {
        Self { lanes, components: 1, groups: 0 }
    }

    /// Numbers per facet.
    pub fn row(&self) -> usize {
        self.lanes * self.components
    }

    /// Terms of the ledger, each of which has a number per lane: the entries, what each group absorbs, and the elements of
    /// the matrices of the mirror direction and the straight one.
    pub fn terms(&self) -> usize {
        Entry::COUNT + self.groups + if self.components > 1 { 2 * self.components } else { 0 }
    }

    /// The term of what a group absorbs.
    pub fn group(&self, group: usize) -> usize {
        Entry::COUNT + group
    }

    /// The term of an element of the matrix of the mirror direction or, behind the sample, of the straight one.
    pub fn delta(&self, behind: bool, component: usize) -> usize {
        Entry::COUNT + self.groups + usize::from(behind) * self.components + component
    }
}

/// Power per lane in each term of the ledger, and per facet.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    shape: Shape,
    /// Trees traced.
    pub trees: u64,
    /// Segments traced.
    pub segments: u64,
    /// A row of lanes per term.
    terms: Vec<f64>,
    /// Facets hit, ascending, with the trees that hit them.
    facets: Vec<(u32, u32)>,
    /// What they got: a row per facet, lane by lane, in frames that are [carried from the pole](super::frame).
    power: Vec<f64>,
}

impl Tally {
    /// Nothing yet.
    pub fn new(shape: Shape) -> Self {
        Self { shape, terms: vec![0.0; shape.terms() * shape.lanes], ..Self::default() }
    }

    /// How many numbers it holds.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// All terms of the ledger, a row of lanes each.
    pub fn terms(&self) -> &[f64] {
        &self.terms
    }

    /// An entry of the ledger, per lane.
    pub fn entry(&self, entry: Entry) -> &[f64] {
        &self.terms[entry as usize * self.shape.lanes..][..self.shape.lanes]
    }

    /// Adds to a term of the ledger.
    #[inline]
    pub(super) fn add(&mut self, term: usize, lane: u16, power: f64) {
        self.terms[term * self.shape.lanes + usize::from(lane)] += power;
    }

    /// Facets hit, ascending: number, trees, numbers per lane.
    pub fn facets(&self) -> impl ExactSizeIterator<Item = (u32, u32, &[f64])> {
        let rows = self.power.chunks_exact(self.shape.row());
        self.facets.iter().zip(rows).map(|(&(code, trees), power)| (code, trees, power))
    }

    /// What a facet got.
    pub fn facet(&self, code: u32) -> Option<&[f64]> {
        let row = self.facets.binary_search_by_key(&code, |f| f.0).ok()?;
        Some(&self.power[row * self.shape.row()..][..self.shape.row()])
    }

    /// Adds a facet beyond all others.
    pub(super) fn push_facet(&mut self, code: u32, trees: u32, power: &[f64]) {
        self.facets.push((code, trees));
        self.power.extend_from_slice(power);
    }

    /// Adds another tally of other trees.
    pub fn merge(&mut self, other: &Self) {
        self.trees += other.trees;
        self.segments += other.segments;
        self.terms.iter_mut().zip(&other.terms).for_each(|(a, b)| *a += b);
        self.merge_facets(other);
    }

    /// Merges two ascending lists of facets.
    fn merge_facets(&mut self, other: &Self) {
        let (a, b) = (std::mem::take(&mut self.facets), &other.facets);
        let power = std::mem::take(&mut self.power);
        let width = self.shape.row();
        let row = |power: &[f64], i: usize| -> std::ops::Range<usize> {
            debug_assert!(power.len() >= (i + 1) * width);
            i * width..(i + 1) * width
        };
        let (mut i, mut j) = (0, 0);
        while i < a.len() || j < b.len() {
            let (x, y) = (a.get(i).map(|f| f.0), b.get(j).map(|f| f.0));
            let code = [x, y].into_iter().flatten().min().unwrap_or_default();
            let mut trees = 0;
            let first = self.power.len();
            self.power.resize(first + width, 0.0);
            let sum = &mut self.power[first..];
            if x == Some(code) {
                trees += a[i].1;
                sum.copy_from_slice(&power[row(&power, i)]);
                i += 1;
            }
            if y == Some(code) {
                trees += b[j].1;
                sum.iter_mut().zip(&other.power[row(&other.power, j)]).for_each(|(s, p)| *s += p);
                j += 1;
            }
            self.facets.push((code, trees));
        }
    }
}
