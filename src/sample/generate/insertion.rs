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
    radii: &'a [f64],
    grids: Vec<Grid>,
    placed: Vec<DVec3>,
    /// For each ball, the one that came into its cell before it, or [`NOBODY`].
    before: Vec<u32>,
    /// The ways from a cell to those around it, the shortest first: most places are taken, and it is the ball in the same cell
    /// or next to it that takes them.
    steps: Vec<[isize; 3]>,
}

const NOBODY: u32 = u32::MAX;

/// A ball that was placed.
#[derive(Clone, Copy)]
pub(super) struct Ball {
    /// Its number, or [`NOBODY`].
    number: u32,
    /// µm.
    pub radius: f64,
    /// Its centre, µm.
    pub place: DVec3,
}

impl Ball {
    const NONE: Self = Self { number: NOBODY, radius: 0.0, place: DVec3::ZERO };

    /// Its number.
    pub fn number(&self) -> usize {
        self.number as usize
    }
}

/// Cells of at least one diameter of the largest ball in it: a smaller one can only touch those in the 27 cells around.
struct Grid {
    /// Number of the first ball in it.
    first: usize,
    cells: [usize; 3],
    /// The ball that came last into each cell.
    latest: Vec<Ball>,
}

impl<'a> Balls<'a> {
    /// For balls of these radii, the largest first.
    pub fn new(slab: &'a Slab, radii: &'a [f64]) -> Self {
        let mut grids = Vec::new();
        let mut first = 0;
        while let Some(&largest) = radii.get(first) {
            let count = radii[first..].partition_point(|&r| r > 0.5 * largest);
            grids.push(Grid::new(slab, largest, first, count));
            first += count.max(1);
        }
        let step = |i: isize| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1];
        let mut steps: Vec<[isize; 3]> = (0..27).map(step).collect();
        steps.sort_by_key(|step| step.iter().map(|d| d * d).sum::<isize>());
        let (placed, before) = (Vec::with_capacity(radii.len()), Vec::with_capacity(radii.len()));
        Self { slab, radii, grids, placed, before, steps }
    }

    /// Places the next ball.
    pub fn push(&mut self, place: DVec3) {
        let number = self.placed.len();
        let ball = Ball { number: number as u32, radius: self.radii[number], place };
        self.placed.push(place);
        let before = self.grids.iter_mut().rfind(|g| g.first <= number).map_or(NOBODY, |grid| {
            let at = grid.index(grid.cell(place, self.slab));
            std::mem::replace(&mut grid.latest[at], ball).number
        });
        self.before.push(before);
    }

    /// Places so far.
    pub fn placed(&self) -> &[DVec3] {
        &self.placed
    }

    /// A ball before which one came into its cell.
    fn earlier(&self, ball: Ball) -> Ball {
        match self.before[ball.number()] {
            NOBODY => Ball::NONE,
            number => Ball { number, radius: self.radii[number as usize], place: self.placed[number as usize] },
        }
    }

    /// Whether any ball that may meet the next one, if that lay at `p`, is as `is` says, of those from number `first` on.
    /// Some are asked for twice.
    pub fn any_near(&self, p: DVec3, first: usize, mut is: impl FnMut(&Ball) -> bool) -> bool {
        let filled = self.grids.iter().take_while(|g| g.first < self.placed.len().max(1));
        for grid in filled {
            let cell = grid.cell(p, self.slab);
            for number in self.steps.iter().filter_map(|&step| grid.beside(cell, step, self.slab.periodic)) {
                let mut ball = grid.latest[number];
                while ball.number != NOBODY && ball.number() >= first {
                    if is(&ball) {
                        return true;
                    }
                    ball = self.earlier(ball);
                }
            }
        }
        false
    }

    /// Places that come one after another in this order are near one another.
    pub fn order(&self, p: DVec3) -> usize {
        self.grids.first().map_or(0, |grid| grid.index(grid.cell(p, self.slab)))
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
        Self { first, cells, latest: vec![Ball::NONE; cells.iter().product()] }
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

    /// The number of the cell one step away, if there is one; in a narrow periodic slab several steps lead to the same.
    fn beside(&self, cell: [usize; 3], step: [isize; 3], periodic: bool) -> Option<usize> {
        let mut to = [0; 3];
        for axis in 0..3 {
            let n = self.cells[axis];
            to[axis] = match cell[axis].checked_add_signed(step[axis]) {
                Some(x) if x < n => x,
                _ if axis == 2 || !periodic => return None,
                Some(_) => 0,
                None => n - 1,
            };
        }
        Some(self.index(to))
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
