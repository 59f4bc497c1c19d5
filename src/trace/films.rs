//! Thin films in the geometry: found, solved, and remembered.

use std::collections::HashMap;

use rustc_hash::FxBuildHasher;

use super::finder::{Finder, Reach, Stack, Start, World};
use super::media::{Beams, Media, Slant};
use super::report::Stacks;
use crate::optics::batch::{Film, Question, Sides, Solver};
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
    pub beams: &'a [Beams<P>],
}

impl<F: Field> Films<F> {
    /// An empty memory.
    pub fn new(rules: &FilmRules) -> Self {
        Self { finder: Finder::new(), solved: Solved::new(rules.tables), stacks: Stacks::default() }
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
        let beams = self.solved.stack(world.media, start, stack, curved);
        Found { stack, beams }
    }

    /// A single interface for every lane.
    pub fn interface(&mut self, media: &Media, first: MediumId, last: MediumId, slant: Slant) -> &[Beams<F::Passage>] {
        self.solved.interface(media, first, last, slant)
    }
}

/// What a stack does to each lane.
type PerLane<F> = Vec<Beams<<F as Field>::Passage>>;
type Known<T> = HashMap<Box<[u64]>, T, FxBuildHasher>;

/// Solutions by stack and cosine, and tables over the cosine by stack.
struct Solved<F: Field> {
    key: Vec<u64>,
    exact: Known<PerLane<F>>,
    /// `None` for stacks that cannot be tabulated.
    tables: Known<Option<Table>>,
    /// Whether stacks on curved faces are tabulated.
    tabulate: bool,
    work: Work,
    /// An answer that is not kept.
    fleeting: PerLane<F>,
}

/// Working memory of the solver.
#[derive(Default)]
struct Work {
    solver: Solver,
    incidences: Vec<Incidence>,
    amplitudes: Vec<Pair<Amplitudes>>,
    coefficients: Vec<Coefficients>,
    scratch: Vec<f64>,
}

/// Solutions, and tables, kept before the memory is emptied.
const MOST_SOLVED: usize = 1 << 14;
const MOST_TABLES: usize = 1 << 8;
/// Thinner stacks are solved faster than looked up.
const FEWEST_TABULATED: usize = 5;

impl<F: Field> Solved<F> {
    fn new(tabulate: bool) -> Self {
        Self {
            key: Vec::new(),
            exact: Known::default(),
            tables: Known::default(),
            tabulate,
            work: Work::default(),
            fleeting: Vec::new(),
        }
    }

    /// A stack at every lane. Whether it comes from a table depends on the stack alone, so that what was asked before
    /// does not matter.
    fn stack(&mut self, media: &Media, start: &Start<'_>, stack: &Stack, curved: bool) -> &[Beams<F::Passage>] {
        if !curved {
            self.set_key(start.first, &stack.layers, stack.last, Some((start.slant.cos, stack.walked)));
            let solve = || self.work.exact::<F>(media, start, stack);
            return remember::<PerLane<F>>(&mut self.exact, MOST_SOLVED, &self.key, solve);
        }
        let mut from_table = false;
        if self.tabulate && stack.layers.len() >= FEWEST_TABULATED {
            self.set_key(start.first, &stack.layers, stack.last, None);
            let work = &mut self.work;
            let build = || Table::new(&mut work.solver, &tabulated(media, start.first, stack));
            if let Some(table) = remember(&mut self.tables, MOST_TABLES, &self.key, build) {
                table.at(start.slant.cos, &mut work.scratch, &mut work.coefficients);
                from_table = true;
            }
        }
        if !from_table {
            self.work.solve(media, start.first, start.slant, &stack.layers, stack.last);
        }
        self.fleeting.clear();
        self.fleeting.extend(self.work.beams::<F>(media, start, stack));
        &self.fleeting
    }

    fn interface(&mut self, media: &Media, first: MediumId, last: MediumId, slant: Slant) -> &[Beams<F::Passage>] {
        self.set_key(first, &[], last, Some((slant.cos, 0.0)));
        remember::<PerLane<F>>(&mut self.exact, MOST_SOLVED, &self.key, || {
            (0..media.lanes() as u16).map(|lane| media.interface::<F>(first, last, lane, slant).0).collect()
        })
    }

    fn set_key(&mut self, first: MediumId, films: &[Film], last: MediumId, at: Option<(f64, f64)>) {
        self.key.clear();
        self.key.push(u64::from(first.0) << 16 | u64::from(last.0));
        self.key.extend(at.into_iter().flat_map(|(cos, walked)| [cos.to_bits(), walked.to_bits()]));
        self.key.extend(films.iter().flat_map(|f| [f.medium as u64, f.thickness.to_bits()]));
    }
}

/// What is known of a key, or becomes known now.
fn remember<'a, T>(known: &'a mut Known<T>, most: usize, key: &[u64], find: impl FnOnce() -> T) -> &'a T {
    if !known.contains_key(key) {
        if known.len() >= most {
            known.clear();
        }
        known.insert(key.into(), find());
    }
    &known[key]
}

fn tabulated<'a>(media: &'a Media, first: MediumId, stack: &'a Stack) -> Tabulated<'a> {
    let (first, last) = (usize::from(first.0), usize::from(stack.last.0));
    Tabulated { media: media.spectra(), first, films: &stack.layers, last, wavelengths: media.wavelengths() }
}

impl Work {
    fn exact<F: Field>(&mut self, media: &Media, start: &Start<'_>, stack: &Stack) -> PerLane<F> {
        self.solve(media, start.first, start.slant, &stack.layers, stack.last);
        self.beams::<F>(media, start, stack).collect()
    }

    /// Coefficients of a stack at every lane.
    fn solve(&mut self, media: &Media, first: MediumId, slant: Slant, films: &[Film], last: MediumId) {
        let lanes = 0..media.lanes() as u16;
        self.incidences.clear();
        self.incidences.extend(lanes.map(|lane| Incidence::from_cos(media.index(first, lane).re, slant.cos)));
        let question = Question {
            incidences: &self.incidences,
            media: media.spectra(),
            films,
            last: usize::from(last.0),
            wavelengths: media.wavelengths(),
        };
        self.solver.solve(&question, Sides::Front, &mut self.amplitudes);
        let of = |both: &Pair<Amplitudes>| Coefficients { r: both.map(|a| a.r), t: both.map(|a| a.t_power()) };
        self.coefficients.clear();
        self.coefficients.extend(self.amplitudes.iter().map(of));
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
