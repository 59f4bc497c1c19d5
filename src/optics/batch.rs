//! Film stacks at many wavelengths at once: the sweep of [`super::film`] in lanes.
//!
//! What depends on a layer only (its phase, its wave number) is computed once for both polarizations and both
//! directions. Loops over lanes are plain arithmetic on arrays, compiled for several instruction sets, of which
//! the processor's best is chosen at run time; none of them fuses operations, so all give the same bits.

use std::f64::consts::TAU;

use super::film::{Amplitudes, Ends, Fields, Incidence, bare, decaying, travelling};
use super::sincos::{LARGEST, sin_cos};
use super::{C64, Pair};

/// Wavelengths solved together.
const LANES: usize = 4;

/// One number per lane.
type Row = [f64; LANES];

/// A layer whose index depends on the wavelength.
#[derive(Clone, Copy, Debug)]
pub struct Film<'a> {
    /// Complex index at each wavelength.
    pub indices: &'a [C64],
    /// Thickness, in the unit of the wavelengths.
    pub thickness: f64,
}

/// A stack at many wavelengths.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// Direction of the light in the first medium, at each wavelength.
    pub incidences: &'a [Incidence],
    /// Layers, from the side of the light.
    pub films: &'a [Film<'a>],
    /// Index of the last medium at each wavelength.
    pub last: &'a [C64],
    /// Vacuum wavelengths.
    pub wavelengths: &'a [f64],
}

/// Solves stacks; keeps its memory from one to the next.
#[derive(Default)]
pub struct Solver {
    steps: Vec<Step>,
}

impl Solver {
    /// What [`super::film::solve`] gives, for each wavelength.
    pub fn solve(&mut self, q: &Question<'_>, out: &mut Vec<Pair<Amplitudes>>) {
        out.clear();
        if q.films.is_empty() {
            out.extend(q.incidences.iter().zip(q.last).map(|(incidence, &last)| bare(incidence, last)));
            return;
        }
        let n = q.wavelengths.len();
        for start in (0..n).step_by(LANES) {
            let lanes = std::array::from_fn(|l| (start + l).min(n - 1));
            let block = Block::new(q, lanes);
            let fields = solve_block(&block, q.films, &mut self.steps);
            for (l, &w) in lanes.iter().enumerate().take(n - start) {
                let one = |[forward, back]: &[Waves; 2], ends: &Ends| {
                    ends.amplitudes(&forward.lane(l, block.log_factor(&self.steps, l)), &back.lane(l, C64::ZERO))
                };
                let ends = |p| Ends::new(&q.incidences[w], q.last[w], p);
                out.push(Pair { s: one(&fields.s, &ends(false)), p: one(&fields.p, &ends(true)) });
            }
        }
    }
}

/// The question at the wavelengths of the lanes.
struct Block {
    lanes: [usize; LANES],
    incidences: [Incidence; LANES],
    wavelengths: Row,
    /// Admittances around the stack: before, behind.
    outgoing: Pair<[[C64; LANES]; 2]>,
}

impl Block {
    fn new(q: &Question<'_>, lanes: [usize; LANES]) -> Self {
        let ends = |p| lanes.map(|w| Ends::new(&q.incidences[w], q.last[w], p));
        let both = |p| [ends(p).map(|e| e.q0), ends(p).map(|e| e.qn)];
        Self {
            lanes,
            incidences: lanes.map(|w| q.incidences[w]),
            wavelengths: lanes.map(|w| q.wavelengths[w]),
            outgoing: Pair { s: both(false), p: both(true) },
        }
    }

    /// Logarithm of what the steps left out.
    fn log_factor(&self, steps: &[Step], lane: usize) -> C64 {
        let of = |s: &Step| if let Step::Complex(s) = s { s.log_factor[lane] } else { C64::ZERO };
        steps.iter().map(of).sum()
    }
}

/// How fields change through a layer: U' = c U + b V, V' = c V + g U.
#[expect(clippy::large_enum_variant, reason = "one at a time, on the stack")]
enum Step {
    /// All lanes travel: c, ib and ig are real.
    Real(RealStep),
    Complex(ComplexStep),
}

struct RealStep {
    c: Row,
    /// b and g.
    off: Pair<[Row; 2]>,
}

struct ComplexStep {
    c: [Row; 2],
    /// Real and imaginary parts of b and g.
    off: Pair<[[Row; 2]; 2]>,
    log_factor: [C64; LANES],
}

/// Fields of a wave that left the stack.
#[derive(Clone, Copy)]
struct Waves {
    u: [Row; 2],
    v: [Row; 2],
    exponent: [i64; LANES],
}

impl Waves {
    #[inline(always)]
    fn outgoing(admittance: &[C64; LANES]) -> Self {
        let v = [admittance.map(|q| q.re), admittance.map(|q| q.im)];
        Self { u: [[1.0; LANES], [0.0; LANES]], v, exponent: [0; LANES] }
    }

    fn lane(&self, l: usize, log_factor: C64) -> Fields {
        let at = |z: &[Row; 2]| C64::new(z[0][l], z[1][l]);
        Fields { u: at(&self.u), v: at(&self.v), exponent: self.exponent[l] as i32, log_factor }
    }

    #[inline(always)]
    fn cross_real(&mut self, c: &Row, [b, g]: &[Row; 2]) {
        for l in 0..LANES {
            let (ur, ui, vr, vi) = (self.u[0][l], self.u[1][l], self.v[0][l], self.v[1][l]);
            self.u[0][l] = ur * c[l] + vi * b[l];
            self.u[1][l] = ui * c[l] - vr * b[l];
            self.v[0][l] = vr * c[l] + ui * g[l];
            self.v[1][l] = vi * c[l] - ur * g[l];
        }
    }

    #[inline(always)]
    fn cross_complex(&mut self, c: &[Row; 2], [b, g]: &[[Row; 2]; 2]) {
        for l in 0..LANES {
            let (ur, ui, vr, vi) = (self.u[0][l], self.u[1][l], self.v[0][l], self.v[1][l]);
            self.u[0][l] = (ur * c[0][l] - ui * c[1][l]) + (vr * b[0][l] - vi * b[1][l]);
            self.u[1][l] = (ur * c[1][l] + ui * c[0][l]) + (vr * b[1][l] + vi * b[0][l]);
            self.v[0][l] = (vr * c[0][l] - vi * c[1][l]) + (ur * g[0][l] - ui * g[1][l]);
            self.v[1][l] = (vr * c[1][l] + vi * c[0][l]) + (ur * g[1][l] + ui * g[0][l]);
        }
    }

    /// Keeps the fields near 1 by exact powers of two.
    #[inline(always)]
    fn rescale(&mut self) {
        for l in 0..LANES {
            let larger = |a: f64, b: f64| if a.abs() > b.abs() { a } else { b };
            let size = larger(larger(self.u[0][l], self.u[1][l]), larger(self.v[0][l], self.v[1][l]));
            let exponent = ((size.to_bits() >> 52) & 0x7ff).clamp(1, 2045);
            let factor = f64::from_bits((2046 - exponent) << 52);
            for part in self.u.iter_mut().chain(&mut self.v) {
                part[l] *= factor;
            }
            self.exponent[l] += exponent as i64 - 1023;
        }
    }
}

#[multiversion::multiversion(targets("x86_64+avx2"))]
fn solve_block(block: &Block, films: &[Film<'_>], steps: &mut Vec<Step>) -> Pair<[Waves; 2]> {
    steps.clear();
    steps.extend(films.iter().map(|film| step(block, film)));
    Pair {
        s: sweep(steps, &block.outgoing.s, |r| &r.s, |c| &c.s),
        p: sweep(steps, &block.outgoing.p, |r| &r.p, |c| &c.p),
    }
}

/// Both sweeps at once: from the back to the front, and from the front to the back.
#[inline(always)]
fn sweep(
    steps: &[Step],
    [before, behind]: &[[C64; LANES]; 2],
    real: impl Fn(&Pair<[Row; 2]>) -> &[Row; 2],
    complex: impl Fn(&Pair<[[Row; 2]; 2]>) -> &[[Row; 2]; 2],
) -> [Waves; 2] {
    let (mut forward, mut back) = (Waves::outgoing(behind), Waves::outgoing(before));
    let cross = |waves: &mut Waves, step: &Step| match step {
        Step::Real(s) => waves.cross_real(&s.c, real(&s.off)),
        Step::Complex(s) => waves.cross_complex(&s.c, complex(&s.off)),
    };
    for (i, (a, b)) in steps.iter().rev().zip(steps).enumerate() {
        cross(&mut forward, a);
        cross(&mut back, b);
        if i % STEPS_PER_RESCALING == STEPS_PER_RESCALING - 1 {
            forward.rescale();
            back.rescale();
        }
    }
    [forward, back]
}

/// No layer multiplies fields by more than about 2⁶⁴, nor divides them.
const STEPS_PER_RESCALING: usize = 4;

#[inline(always)]
fn step(block: &Block, film: &Film<'_>) -> Step {
    let n = block.lanes.map(|w| film.indices[w]);
    let mut kz_squared = [0.0; LANES];
    let (mut travels, mut turns) = (true, [0.0; LANES]);
    for l in 0..LANES {
        let at = &block.incidences[l];
        let squared = if at.grazing {
            (n[l].re - at.index) * (n[l].re + at.index) + at.kz * at.kz
        } else {
            (n[l].re - at.kx) * (n[l].re + at.kx)
        };
        kz_squared[l] = if n[l].re == at.index { at.kz * at.kz } else { squared };
        travels &= n[l].im == 0.0 && kz_squared[l] > 0.0;
    }
    let mut kz = [0.0; LANES];
    for l in 0..LANES {
        kz[l] = kz_squared[l].sqrt();
        turns[l] = kz[l] * film.thickness / block.wavelengths[l];
        travels &= turns[l] < MOST_TURNS;
    }
    if travels { Step::Real(real_step(&kz, &turns, &n.map(|n| n.re))) } else { complex_step(block, film, &n) }
}

/// Beyond, whole turns cannot be told from the last bits.
const MOST_TURNS: f64 = 1e15;

#[inline(always)]
fn real_step(kz: &Row, turns: &Row, n: &Row) -> RealStep {
    let zero = [0.0; LANES];
    let mut s = RealStep { c: zero, off: Pair { s: [zero; 2], p: [zero; 2] } };
    for l in 0..LANES {
        let (sin, cos) = sin_cos(reduced_phase(turns[l]));
        let (b, g, n2) = (sin / kz[l], kz[l] * sin, n[l] * n[l]);
        s.c[l] = cos;
        (s.off.s[0][l], s.off.s[1][l]) = (b, g);
        (s.off.p[0][l], s.off.p[1][l]) = (b * n2, g / n2);
    }
    s
}

/// 2π·turns without whole turns where that helps, as for single wavelengths.
#[inline(always)]
fn reduced_phase(turns: f64) -> f64 {
    const { assert!(16.0 * TAU < LARGEST) };
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let whole = (turns + ROUND) - ROUND;
    TAU * if turns > 16.0 { turns - whole } else { turns }
}

/// Any mixture of lanes, one by one.
#[inline(never)]
fn complex_step(block: &Block, film: &Film<'_>, n: &[C64; LANES]) -> Step {
    let zero = [[0.0; LANES]; 2];
    let mut s = ComplexStep { c: zero, off: Pair { s: [zero; 2], p: [zero; 2] }, log_factor: [C64::ZERO; LANES] };
    for l in 0..LANES {
        let (c, b, g, log_factor) = coefficients(&block.incidences[l], n[l], film.thickness, block.wavelengths[l]);
        let n2 = n[l] * n[l];
        let set = |to: &mut [Row; 2], z: C64| (to[0][l], to[1][l]) = (z.re, z.im);
        set(&mut s.c, c);
        set(&mut s.off.s[0], b);
        set(&mut s.off.s[1], g);
        set(&mut s.off.p[0], b * n2);
        set(&mut s.off.p[1], g / n2);
        s.log_factor[l] = log_factor;
    }
    Step::Complex(s)
}

fn coefficients(incidence: &Incidence, n: C64, thickness: f64, wavelength: f64) -> (C64, C64, C64, C64) {
    let kz = incidence.normal(n);
    if kz.im != 0.0 {
        return decaying(kz, thickness, wavelength);
    }
    let (c, b, g) = travelling(kz.re, thickness, wavelength);
    (C64::from(c), C64::new(0.0, -b), C64::new(0.0, -g), C64::ZERO)
}
