//! Thin films in the geometry: found, solved, and remembered.

use std::collections::HashMap;

use rustc_hash::FxBuildHasher;

use super::beams::{BeamTable, Beams};
use super::finder::{Finder, Reach, Stack, Start, World};
use super::media::Media;
use super::report::Stacks;
use crate::optics::batch::{Question, Sides, Solver};
use crate::optics::field::Field;
use crate::optics::film::{Amplitudes, Incidence};
use crate::optics::table::{Table, Tabulated};
use crate::optics::{C64, Coefficients, Pair};
use crate::plan::FilmRules;
use crate::sample::MediumId;

/// Finds stacks, and remembers solved ones. One per worker: no lock, no sharing; what it answers is a pure
/// function of the question.
pub struct Films<F: Field> {
    finder: Finder,
    solved: Solved<F>,
    /// The stacks met since they were last taken.
    pub stacks: Stacks,
}

/// A stack with what it does to each lane.
pub struct Found<'a, P> {
    /// The stack.
    pub stack: &'a Stack,
    /// By number of the lane.
    pub beams: &'a BeamTable<P>,
    /// Who absorbs, if anything does.
    pub absorption: Option<Absorption<'a>>,
}

/// How the layers of a stack, and the body behind it, absorb.
#[derive(Clone, Copy)]
pub struct Absorption<'a> {
    /// Shares of s and p light, layer by layer, for each lane; none where no layer absorbs.
    shares: &'a [Pair<f64>],
    /// The group of the body each layer belongs to.
    groups: &'a [u16],
    /// That of the body behind, which takes what is left.
    pub behind: u16,
}

impl Absorption<'_> {
    /// Groups of the layers, with their shares for a lane.
    pub fn layers(&self, lane: u16) -> impl Iterator<Item = (u16, Pair<f64>)> {
        let n = self.groups.len();
        let shares = self.shares.get(usize::from(lane) * n..).unwrap_or_default();
        self.groups.iter().copied().zip(shares.iter().copied())
    }
}

impl<F: Field> Films<F> {
    /// An empty memory, for so many lanes.
    pub fn new(rules: &FilmRules, lanes: usize) -> Self {
        Self { finder: Finder::new(), solved: Solved::new(rules.tables, lanes), stacks: Stacks::default() }
    }

    /// Looks for a stack under a point; says whether there is a layer.
    pub fn search(&mut self, world: &World<'_>, start: &Start<'_>, reach: Reach) -> bool {
        self.finder.search(world, start, reach)
    }

    /// Whether the stack just found ends nearby.
    pub fn near_edge(&mut self, world: &World<'_>, start: &Start<'_>) -> bool {
        self.finder.near_edge(world, start)
    }

    /// Solves the stack just found for every lane. `power` of the light (a share of the incident power) meets it.
    pub fn solve(&mut self, world: &World<'_>, start: &Start<'_>, power: f64) -> Found<'_, F::Passage> {
        let stack = self.finder.stack();
        self.stacks.add(&stack.layers, power);
        let curved = stack.uniform && world.scene.primitives().plane(start.surface).is_none();
        let solution = self.solved.stack(world.media, start, stack, curved);
        let absorbs = world.media.is_opaque(stack.last) || !solution.losses.is_empty();
        let absorption = absorbs.then(|| Absorption {
            shares: &solution.losses,
            groups: &stack.groups,
            behind: world.solids.group_around(&stack.inside),
        });
        Found { stack, beams: &solution.beams, absorption }
    }
}

/// What a stack does to each lane.
struct Solution<P> {
    beams: BeamTable<P>,
    /// What each layer absorbs, lane by lane; empty if none does.
    losses: Vec<Pair<f64>>,
}

/// What was found, by key.
struct Known<T> {
    numbers: HashMap<Box<[u64]>, usize, FxBuildHasher>,
    found: Vec<T>,
}

impl<T> Known<T> {
    const NOTHING: Self = Self { numbers: HashMap::with_hasher(FxBuildHasher), found: Vec::new() };

    /// What is known of a key, or becomes known now; before more than `most` are, all are forgotten.
    fn get(&mut self, most: usize, key: &[u64], find: impl FnOnce() -> T) -> &T {
        let number = self.numbers.get(key).copied().unwrap_or_else(|| {
            if self.found.len() >= most {
                *self = Self::NOTHING;
            }
            self.found.push(find());
            self.numbers.insert(key.into(), self.found.len() - 1);
            self.found.len() - 1
        });
        &self.found[number]
    }
}

/// Solutions by stack and cosine, and tables over the cosine by stack.
struct Solved<F: Field> {
    key: Vec<u64>,
    exact: Known<Solution<F::Passage>>,
    /// `None` for stacks that cannot be tabulated.
    tables: Known<Option<Table>>,
    /// Whether stacks on curved faces are tabulated.
    tabulate: bool,
    work: Work,
    /// An answer that is not kept.
    fleeting: Solution<F::Passage>,
}

/// Working memory of the solver.
#[derive(Default)]
struct Work {
    solver: Solver,
    incidences: Vec<Incidence>,
    amplitudes: Vec<Pair<Amplitudes>>,
    coefficients: Vec<Coefficients>,
    losses: Vec<Pair<f64>>,
    scratch: Vec<f64>,
}

/// Solutions, and tables, kept before the memory is emptied.
const MOST_SOLVED: usize = 1 << 14;
const MOST_TABLES: usize = 1 << 8;
/// Thinner stacks are solved faster than looked up.
const FEWEST_TABULATED: usize = 5;

impl<F: Field> Solved<F> {
    fn new(tabulate: bool, lanes: usize) -> Self {
        Self {
            key: Vec::new(),
            exact: Known::NOTHING,
            tables: Known::NOTHING,
            tabulate,
            work: Work::default(),
            fleeting: Solution { beams: BeamTable::new(lanes), losses: Vec::new() },
        }
    }

    /// A stack at every lane. Whether it comes from a table depends on the stack alone, so that what was asked before
    /// does not matter.
    fn stack(&mut self, media: &Media, start: &Start<'_>, stack: &Stack, curved: bool) -> &Solution<F::Passage> {
        if !curved {
            self.set_key(start, stack, true);
            let solve = || {
                self.work.solve(media, start, stack);
                let mut beams = BeamTable::new(media.lanes());
                beams.set_all(self.work.beams::<F>(media, start, stack));
                Solution { beams, losses: std::mem::take(&mut self.work.losses) }
            };
            return self.exact.get(MOST_SOLVED, &self.key, solve);
        }
        if !self.look_up(media, start, stack) {
            self.work.solve(media, start, stack);
        }
        self.fleeting.beams.set_all(self.work.beams::<F>(media, start, stack));
        std::mem::swap(&mut self.fleeting.losses, &mut self.work.losses);
        &self.fleeting
    }

    /// Takes the coefficients from the table of the stack, if there is one.
    fn look_up(&mut self, media: &Media, start: &Start<'_>, stack: &Stack) -> bool {
        let absorbs = stack.layers.iter().any(|l| media.absorbs(MediumId(l.medium as u16)));
        if !self.tabulate || stack.layers.len() < FEWEST_TABULATED || absorbs {
            return false;
        }
        self.set_key(start, stack, false);
        let work = &mut self.work;
        let build = || Table::new(&mut work.solver, &tabulated(media, start.first, stack));
        let Some(table) = self.tables.get(MOST_TABLES, &self.key, build) else { return false };
        table.at(start.slant.cos, &mut work.scratch, &mut work.coefficients);
        work.losses.clear();
        true
    }

    fn set_key(&mut self, start: &Start<'_>, stack: &Stack, with_cosine: bool) {
        self.key.clear();
        self.key.push(u64::from(start.first.0) << 16 | u64::from(stack.last.0));
        if with_cosine {
            self.key.extend([start.slant.cos, stack.walked].map(f64::to_bits));
        }
        self.key.extend(stack.layers.iter().flat_map(|f| [f.medium as u64, f.thickness.to_bits()]));
    }
}

fn tabulated<'a>(media: &'a Media, first: MediumId, stack: &'a Stack) -> Tabulated<'a> {
    let (first, last) = (usize::from(first.0), usize::from(stack.last.0));
    Tabulated { media: media.spectra(), first, films: &stack.layers, last, wavelengths: media.wavelengths() }
}

impl Work {
    /// Coefficients of a stack at every lane, and what its layers absorb.
    fn solve(&mut self, media: &Media, start: &Start<'_>, stack: &Stack) {
        let lanes = 0..media.lanes() as u16;
        self.incidences.clear();
        self.incidences
            .extend(lanes.map(|lane| Incidence::from_cos(media.index(start.first, lane).re, start.slant.cos)));
        let question = Question {
            incidences: &self.incidences,
            media: media.spectra(),
            films: &stack.layers,
            last: usize::from(stack.last.0),
            wavelengths: media.wavelengths(),
        };
        self.solver.solve(&question, Sides::Front, &mut self.amplitudes);
        let of = |both: &Pair<Amplitudes>| Coefficients { r: both.map(|a| a.r), t: both.map(|a| a.t_power()) };
        self.coefficients.clear();
        self.coefficients.extend(self.amplitudes.iter().map(of));
        self.losses.clear();
        if stack.layers.iter().any(|l| media.absorbs(MediumId(l.medium as u16))) {
            self.solver.absorptances(&question, &mut self.losses);
        }
    }

    /// What these coefficients do to light that starts behind the stack where the probe left it.
    fn beams<F: Field>(
        &self,
        media: &Media,
        start: &Start<'_>,
        stack: &Stack,
    ) -> impl Iterator<Item = Beams<F::Passage>> {
        let ends = media.is_opaque(stack.last);
        self.coefficients.iter().enumerate().map(move |(lane, c)| {
            if ends {
                let t = Pair { s: C64::ZERO, p: C64::ZERO };
                return Beams::new(&Coefficients { t, ..*c });
            }
            if stack.walked == 0.0 {
                return Beams::new(c);
            }
            // The phase of t is that straight below the first point.
            let kx = media.wave_number(lane as u16) * media.index(start.first, lane as u16).re * start.slant.sin;
            let phase = C64::cis(kx * stack.walked);
            Beams::new(&Coefficients { t: c.t.map(|t| t * phase), ..*c })
        })
    }
}
