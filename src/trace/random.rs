//! Random numbers as a pure function of (seed, incidence, batch, tree, branch, event).
//!
//! Entry points and the first decision of a tree are Owen-scrambled Sobol points; each batch is an independent
//! scramble, so that the spread of batches gives honest standard errors. Later decisions are hashes.

/// Which set of trees: one incidence, one scramble.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Batch {
    /// The user's seed.
    pub seed: u64,
    /// Number of the incidence.
    pub incidence: u32,
    /// Number of the scramble.
    pub scramble: u32,
}

/// Random numbers of a tree, as far as its rays need them.
#[derive(Clone, Copy, Debug)]
pub struct TreeKey {
    /// Key of all later decisions.
    pub key: u64,
    /// First decision of the branches 2 and 3.
    pub first: [f64; 2],
}

/// Longest Sobol sequence `sobol_burley` makes; after that many trees a new scramble begins.
const SEQUENCE: u32 = 1 << 16;

/// The random numbers of one tree.
#[derive(Clone, Copy, Debug)]
pub struct TreeNumbers {
    key: u64,
    /// Position across the footprint, each in [0, 1).
    pub entry: [f64; 2],
    /// First decisions, of the branch reflected and the branch transmitted first.
    first: [f64; 2],
}

impl TreeNumbers {
    /// The numbers of tree `tree` of a batch.
    pub fn new(batch: Batch, tree: u32) -> Self {
        let key = mix(batch.key() ^ mix(u64::from(tree)));
        let block = u64::from(tree / SEQUENCE);
        let scramble = mix(batch.key() ^ mix(block).rotate_left(17)) as u32;
        let sobol = sobol_burley::sample_4d(tree % SEQUENCE, 0, scramble);
        // Sobol points have 24 bits; the rest of a scrambled digit expansion is random.
        let fine = |i: usize| {
            let rest = unit(mix(key ^ (0x9e37_79b9 + i as u64)));
            (f64::from(sobol[i]) + rest * 2f64.powi(-24)).min(1.0 - f64::EPSILON)
        };
        Self { key, entry: [fine(0), fine(1)], first: [fine(2), fine(3)] }
    }

    /// The key from which `decision` draws.
    pub fn key(&self) -> u64 {
        self.key
    }

    /// The first decision after the split.
    pub fn first(&self) -> [f64; 2] {
        self.first
    }
}

impl Batch {
    fn key(self) -> u64 {
        mix(mix(mix(self.seed) ^ u64::from(self.incidence)) ^ (u64::from(self.scramble) << 32))
    }
}

/// A number in [0, 1) for a decision of a branch; `draw` tells several numbers of one event apart.
#[inline]
pub fn decision(key: u64, branch: u32, event: u32, draw: u32) -> f64 {
    let place = u64::from(branch) << 32 | u64::from(event);
    unit(mix(key ^ mix(place ^ u64::from(draw) << 60)))
}

/// 53 random bits as a number in [0, 1).
#[inline]
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// The finalizer of splitmix64 (Steele, Lea and Flood, OOPSLA 2014).
#[inline]
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    const BATCH: Batch = Batch { seed: 1, incidence: 0, scramble: 0 };

    #[test]
    fn entry_points_are_stratified() {
        // A scrambled Sobol sequence puts one of its first 1024 points into each of 32 × 32 squares.
        let mut hits = vec![0; 1024];
        for tree in 0..1024 {
            let [x, y] = TreeNumbers::new(BATCH, tree).entry;
            hits[(x * 32.0) as usize * 32 + (y * 32.0) as usize] += 1;
        }
        assert!(hits.iter().all(|&n| n == 1));
    }

    #[test]
    fn batches_incidences_seeds_and_blocks_differ() {
        let first = |b: Batch, tree| TreeNumbers::new(b, tree).entry;
        let base = first(BATCH, 0);
        assert_ne!(base, first(Batch { seed: 2, ..BATCH }, 0));
        assert_ne!(base, first(Batch { incidence: 1, ..BATCH }, 0));
        assert_ne!(base, first(Batch { scramble: 1, ..BATCH }, 0));
        assert_ne!(base, first(BATCH, SEQUENCE));
        assert_eq!(base, first(BATCH, 0));
    }

    #[test]
    fn decisions_are_uniform() {
        // 10⁵ numbers in 20 bins: χ² with 19 degrees of freedom exceeds 43.8 with probability 0.1 %.
        let mut bins = [0f64; 20];
        for event in 0..100_000 {
            bins[(decision(7, 1, event, 0) * 20.0) as usize] += 1.0;
        }
        let chi2: f64 = bins.iter().map(|n| (n - 5000.0) * (n - 5000.0) / 5000.0).sum();
        assert!(chi2 < 43.8, "{chi2}");
    }
}
