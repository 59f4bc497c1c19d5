//! Random sequential insertion: bodies of falling size, each at the first random place where it is free.

use std::fmt;

use glam::DVec3;

/// A slab to be filled, whose lower face is z = 0 and whose axis is that of the sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    /// Edge lengths, µm.
    pub size: DVec3,
    /// Whether it repeats in x and y.
    pub periodic: bool,
}

/// Why a slab cannot be filled as asked.
#[derive(Clone, Debug, PartialEq)]
pub enum PackingError {
    /// A length is not positive, or a body does not fit.
    DoesNotFit(String),
    /// No place was found for the next body.
    Jammed {
        /// What is packed: `sphere`.
        what: &'static str,
        /// Bodies placed so far.
        placed: usize,
        /// Volume fraction reached.
        fraction: f64,
        /// What is known of the limit, and what to do.
        advice: &'static str,
    },
}

impl fmt::Display for PackingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DoesNotFit(why) => f.write_str(why),
            Self::Jammed { what, placed, fraction, advice } => {
                write!(f, "no room for {what} {} (volume fraction {fraction:.3}): {advice}", placed + 1)
            }
        }
    }
}

/// Cells of a grid per body, at most.
const CELLS_PER_BODY: f64 = 8.0;

/// Balls placed in a slab, in grids by size: one for each octave, so that small ones among large ones are found as fast.
pub(super) struct Balls<'a> {
    slab: &'a Slab,
    grids: Vec<Grid>,
    placed: Vec<DVec3>,
}

/// Cells of at least one diameter of the largest ball in it: a smaller one can only touch those in the 27 cells around.
struct Grid {
    /// Number of the first ball in it.
    first: usize,
    cells: [usize; 3],
    members: Vec<Vec<u32>>,
}

impl<'a> Balls<'a> {
    /// For balls of these radii, the largest first.
    pub fn new(slab: &'a Slab, radii: &[f64]) -> Self {
        let mut grids = Vec::new();
        let mut first = 0;
        while let Some(&largest) = radii.get(first) {
            let count = radii[first..].partition_point(|&r| r > 0.5 * largest);
            grids.push(Grid::new(slab, largest, first, count));
            first += count.max(1);
        }
        Self { slab, grids, placed: Vec::with_capacity(radii.len()) }
    }

    /// Places the next ball.
    pub fn push(&mut self, p: DVec3) {
        let number = self.placed.len();
        self.placed.push(p);
        let slab = *self.slab;
        if let Some(grid) = self.grids.iter_mut().rfind(|g| g.first <= number) {
            let at = grid.index(grid.cell(p, &slab));
            grid.members[at].push(number as u32);
        }
    }

    /// Places so far.
    pub fn placed(&self) -> &[DVec3] {
        &self.placed
    }

    /// Whether any ball that may meet the next one, if that lay at `p`, is as `is` says. Some are asked for twice.
    pub fn any_near(&self, p: DVec3, mut is: impl FnMut(usize) -> bool) -> bool {
        let filled = self.grids.iter().take_while(|g| g.first < self.placed.len().max(1));
        for grid in filled {
            let cell = grid.cell(p, self.slab);
            for z in grid.around(2, cell[2], false) {
                for y in grid.around(1, cell[1], self.slab.periodic) {
                    for x in grid.around(0, cell[0], self.slab.periodic) {
                        if grid.members[grid.index([x, y, z])].iter().any(|&n| is(n as usize)) {
                            return true;
                        }
                    }
                }
            }
        }
        false
    }
}

impl Grid {
    fn new(slab: &Slab, largest: f64, first: usize, count: usize) -> Self {
        let most = CELLS_PER_BODY * count as f64 + 1.0;
        let mut fitting = (slab.size / (2.0 * largest)).floor().max(DVec3::ONE);
        // In a dilute packing most cells would be empty.
        while fitting.element_product() > most {
            let longest = fitting.max_position();
            fitting[longest] = (0.5 * fitting[longest]).floor();
        }
        let cells = fitting.to_array().map(|n| n as usize);
        Self { first, cells, members: vec![Vec::new(); cells.iter().product()] }
    }

    fn cell(&self, p: DVec3, slab: &Slab) -> [usize; 3] {
        let from_corner = p + DVec3::new(0.5 * slab.size.x, 0.5 * slab.size.y, 0.0);
        std::array::from_fn(|i| {
            ((from_corner[i] / slab.size[i] * self.cells[i] as f64) as usize).min(self.cells[i] - 1)
        })
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.cells[1] + y) * self.cells[0] + x
    }

    /// The cells next to `c` along axis `i`; in a narrow periodic slab some twice.
    fn around(&self, i: usize, c: usize, wraps: bool) -> impl Iterator<Item = usize> + use<> {
        let n = self.cells[i];
        (0..3).filter_map(move |k| match (c + k).checked_sub(1) {
            Some(x) if x < n => Some(x),
            Some(_) => wraps.then_some(0),
            None => wraps.then_some(n - 1),
        })
    }
}

impl Slab {
    /// The shortest way from `a` to a repetition of `b`, squared.
    pub fn distance_squared(&self, a: DVec3, b: DVec3) -> f64 {
        let mut d = (a - b).abs();
        if self.periodic {
            d.x = d.x.min(self.size.x - d.x);
            d.y = d.y.min(self.size.y - d.y);
        }
        d.length_squared()
    }
}
