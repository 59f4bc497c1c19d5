//! Plane-parallel film stacks: the characteristic-vector sweep.
//!
//! For each polarization the tangential fields (U, V) are carried through the stack from the far side towards
//! the source; carried that way they follow the growing solution, so nothing cancels and nothing overflows
//! (their common power of two is kept apart). U = E_y, V = q U for s; U = H_y for p with q = k_z/n²; all wave
//! numbers in units of 2π/λ. Derivation: Byrnes, arXiv:1603.02720, §2, in the matrix form of Born & Wolf §1.6.2.

use std::f64::consts::TAU;

use super::{C64, Pair, outgoing_root};

/// One layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Complex index.
    pub index: C64,
    /// Thickness, in the unit of the wavelength.
    pub thickness: f64,
}

/// The direction of a plane wave in the first medium, whose index is real.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incidence {
    pub(super) index: f64,
    /// n cos θ.
    pub(super) kz: f64,
    /// n sin θ, the same in all media.
    pub(super) kx: f64,
    /// Whether `kz` is the better known of the two.
    pub(super) grazing: bool,
}

/// The least cosine of incidence: grazing incidence as a limit, reached to all digits, where 0 itself would leave
/// 0/0 between equal media.
const GRAZING: f64 = 1e-150;

impl Incidence {
    /// From the cosine of the angle of incidence, 0..=1.
    pub fn from_cos(index: f64, cos: f64) -> Self {
        let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
        Self { index, kz: index * cos.max(GRAZING), kx: index * sin, grazing: cos * cos < 0.5 }
    }

    /// From the tangential wave number n sin θ, 0..=n.
    pub fn from_kx(index: f64, kx: f64) -> Self {
        let (a, b) = (index - kx, index + kx);
        let kz = if (a * b).is_normal() { (a * b).sqrt() } else { a.sqrt() * b.sqrt() };
        Self { index, kz: kz.max(index * GRAZING), kx, grazing: false }
    }

    /// From the angle of incidence, radians, 0..=π/2.
    pub fn from_angle(index: f64, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { index, kz: index * cos.max(GRAZING), kx: index * sin, grazing: cos * cos < 0.5 }
    }

    /// Flux behind over flux in front, for electric fields of equal size: Re(n cos θ) (s) or Re(n cos θ*) (p) of the last
    /// medium over n cos θ of the first. 0 if nothing travels behind.
    pub fn flux_ratio(&self, last: C64, p: bool) -> f64 {
        flux_ratio(self.kz, last, self.normal(last), p)
    }

    /// Normal wave number k_z in a medium.
    pub(super) fn normal(&self, n: C64) -> C64 {
        if n == C64::new(self.index, 0.0) {
            return C64::new(self.kz, 0.0);
        }
        let n0 = self.index;
        outgoing_root(if self.grazing {
            (n - n0) * (n + n0) + self.kz * self.kz
        } else {
            (n - self.kx) * (n + self.kx)
        })
    }
}

/// Amplitude coefficients of a stack for one polarization, of the electric field. Reference planes: the first
/// interface for `r`, the last for `t`, at the same lateral position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amplitudes {
    /// Reflection, from the first medium.
    pub r: C64,
    /// Transmission, from the first medium.
    pub t: C64,
    /// Reflection, from the last medium at the same tangential wave number.
    pub r_back: C64,
    /// Transmission, from the last medium.
    pub t_back: C64,
    /// |t|² times this is the transmitted share of the power; 0 if nothing travels behind the stack.
    pub flux_ratio: f64,
}

impl Amplitudes {
    /// Whether all of it are numbers.
    pub fn is_finite(&self) -> bool {
        [self.r, self.t, self.r_back, self.t_back].iter().all(|z| z.is_finite()) && self.flux_ratio.is_finite()
    }

    /// Reflected share of the power.
    pub fn reflectance(&self) -> f64 {
        self.r.norm_sqr()
    }

    /// Transmitted share of the power; never computed as 1 − R.
    pub fn transmittance(&self) -> f64 {
        self.t.norm_sqr() * self.flux_ratio
    }

    /// Transmission normalised to power: |·|² is the transmittance.
    pub fn t_power(&self) -> C64 {
        self.t * self.flux_ratio.sqrt()
    }
}

/// Solves `layers` between a transparent first medium and a last one, both polarizations, from both sides.
///
/// Every amplitude lies within four times the change that rounding of the input can cause, for all cases of
/// `tests/reference/films.json` and those that `tests/peers/film_truth.py` makes. All finite numbers of passive media have
/// a finite answer; indices and lengths beyond 1e±70 times those of the first medium count as that, or as something nearer
/// where that is needed.
pub fn solve(incidence: &Incidence, layers: &[Layer], last: C64, wavelength: f64) -> Pair<Amplitudes> {
    let finite = |both: &Pair<Amplitudes>| both.s.is_finite() && both.p.is_finite();
    within_range(incidence, layers, last, wavelength, solve_moderate, finite)
}

/// What `solve` gives, in units and within limits in which its answer is finite.
fn within_range<T>(
    incidence: &Incidence,
    layers: &[Layer],
    last: C64,
    wavelength: f64,
    solve: impl Fn(&Incidence, &[Layer], C64, f64) -> T,
    finite: impl Fn(&T) -> bool,
) -> T {
    let usual = (1e-6..1e6).contains(&incidence.index) && is_moderate(last);
    if usual && layers.iter().all(|l| is_moderate(l.index) && l.thickness / wavelength < MOST) {
        return solve(incidence, layers, last, wavelength);
    }
    let limited = |most| {
        let (incidence, layers, last) = limit(incidence, layers, last, wavelength, most);
        solve(&incidence, &layers, last, 1.0)
    };
    [MOST, 1e30].map(limited).into_iter().find(finite).unwrap_or_else(|| limited(1e12))
}

/// Largest and smallest numbers that matter, where those of the first medium are near 1.
const MOST: f64 = 1e70;

fn is_moderate(n: C64) -> bool {
    let size = n.l1_norm();
    size > 1.0 / MOST && size < MOST
}

/// The same in units in which the first index is near 1, and the wavelength there, too; indices and lengths count as no
/// larger than `most`, indices as no smaller than its inverse.
#[cold]
fn limit(
    incidence: &Incidence,
    layers: &[Layer],
    last: C64,
    wavelength: f64,
    most: f64,
) -> (Incidence, Vec<Layer>, C64) {
    let unit = 2f64.powf(-incidence.index.log2().floor());
    let index = |n: C64| {
        let n = C64::new((n.re * unit).min(most), (n.im * unit).min(most));
        if n.re.max(n.im) < 1.0 / most { C64::from(1.0 / most) } else { n }
    };
    let length = |d: f64| (d / wavelength / unit).min(most);
    let layers = layers.iter().map(|l| Layer { index: index(l.index), thickness: length(l.thickness) }).collect();
    let Incidence { index: n, kz, kx, grazing } = *incidence;
    let (n, kz, kx) = (n * unit, (kz * unit).max(GRAZING), kx * unit);
    (Incidence { index: n, kz, kx, grazing }, layers, index(last))
}

fn solve_moderate(incidence: &Incidence, layers: &[Layer], last: C64, wavelength: f64) -> Pair<Amplitudes> {
    if layers.is_empty() {
        return bare(incidence, last);
    }
    Pair {
        s: sweep_both(incidence, layers, last, wavelength, false),
        p: sweep_both(incidence, layers, last, wavelength, true),
    }
}

/// Quotient, whatever the size of the denominator's square. A denominator of nothing is a bound mode: a large number.
fn over(a: C64, b: C64) -> C64 {
    let size = b.re.abs().max(b.im.abs());
    match size {
        1e-140..1e140 => a / b,
        0.0 => a * 1e100,
        _ => (a / size) / (b / size),
    }
}

/// Tangential fields, and what is left out of them: a power of two, and e^{iδ} of the layers that absorb much.
#[derive(Clone, Copy)]
struct Fields {
    u: C64,
    v: C64,
    exponent: i32,
    /// Sum of Im δ, and the product of e^{i Re δ}: added up, phases would lose digits.
    decay: f64,
    phase: C64,
}

impl Fields {
    /// Of a single wave leaving the stack.
    fn outgoing(admittance: C64) -> Self {
        Self { u: C64::ONE, v: admittance, exponent: 0, decay: 0.0, phase: C64::ONE }
    }

    /// Power that flows through the interface, in the units of these fields.
    fn flux(&self) -> f64 {
        (self.u.conj() * self.v).re
    }
}

fn sweep_both(incidence: &Incidence, layers: &[Layer], last: C64, wavelength: f64, p: bool) -> Amplitudes {
    let ends = Ends::new(incidence, last, p);
    let forward = sweep(incidence, layers.iter().rev(), ends.qn, wavelength, p);
    let back = sweep(incidence, layers.iter(), ends.q0, wavelength, p);
    ends.amplitudes(&forward, &back)
}

/// The media around a stack, for one polarization: normal wave numbers and admittances.
struct Ends {
    first: C64,
    last: C64,
    kz0: C64,
    kzn: C64,
    /// Admittance of the first medium.
    q0: C64,
    /// Admittance of the last.
    qn: C64,
    p: bool,
}

impl Ends {
    fn new(incidence: &Incidence, last: C64, p: bool) -> Self {
        let first = C64::from(incidence.index);
        let (kz0, kzn) = (incidence.normal(first), incidence.normal(last));
        Self { first, last, kz0, kzn, q0: admittance(first, kz0, p), qn: admittance(last, kzn, p), p }
    }

    /// From the fields at the front of the stack, and, lit from behind, at its back.
    fn amplitudes(&self, forward: &Fields, back: &Fields) -> Amplitudes {
        let Self { first, last, kz0, kzn, q0, qn, p } = *self;
        let denominator = q0 * forward.u + forward.v;
        // t of U is 2 q0 t'/(q0 U + V); for the electric field of p, times n0/nN. Kept without the factor kz0, so
        // that both directions have it.
        let common = over(forward.phase, if p { denominator * first * last } else { denominator });
        // Only a bound mode without losses has more; its square is to be a number, too.
        let most = 1e100 / (kz0 * common).l1_norm().max((kzn * common).l1_norm()).max(1.0);
        let common = common * (2.0 * exp_scaled(-forward.decay, -forward.exponent).min(most));
        Amplitudes {
            r: over(q0 * forward.u - forward.v, denominator),
            t: kz0 * common,
            r_back: over(qn * back.u - back.v, qn * back.u + back.v),
            t_back: kzn * common,
            flux_ratio: flux_ratio(kz0.re, last, kzn, p),
        }
    }
}

/// Share of the incident power that each layer absorbs: the difference of the fluxes through its two interfaces.
/// 0 in layers of real index, where only rounding would be left. All finite numbers have a finite answer, as in [`solve`].
pub fn absorptances(incidence: &Incidence, layers: &[Layer], last: C64, wavelength: f64) -> Pair<Vec<f64>> {
    let losses = |incidence: &Incidence, layers: &[Layer], last: C64, wavelength: f64| {
        let of = |p: bool| losses(incidence, layers, last, wavelength, p);
        Pair { s: of(false), p: of(true) }
    };
    let finite = |both: &Pair<Vec<f64>>| both.s.iter().chain(&both.p).all(|share| share.is_finite());
    within_range(incidence, layers, last, wavelength, losses, finite)
}

/// For one polarization.
fn losses(incidence: &Incidence, layers: &[Layer], last: C64, wavelength: f64, p: bool) -> Vec<f64> {
    let Ends { q0, qn, .. } = Ends::new(incidence, last, p);
    let mut f = Fields::outgoing(qn);
    // From the back: what each layer takes, and what one unit of power behind it is, in units of the power in front.
    let cross = |layer: &Layer| {
        let before = f.flux();
        (f.exponent, f.decay) = (0, 0.0);
        cross(&mut f, layer, incidence, wavelength, p);
        // No power flows in a bound mode.
        let behind = if f.decay < 0.0 { 0.0 } else { exp_scaled(-2.0 * f.decay, -2 * f.exponent) };
        (f.flux() - before * behind, behind)
    };
    let met: Vec<(f64, f64)> = layers.iter().rev().map(cross).collect();
    // From the front: what one unit is of the incident power, |q0 U + V|²/4 q0.
    let size = (q0 * f.u + f.v).norm();
    let mut unit = 4.0 * q0.re / size / size;
    let share = |(layer, (lost, behind)): (&Layer, (f64, f64))| {
        let share = lost * unit;
        unit *= behind;
        if layer.index.im <= 0.0 || share < 0.0 { 0.0 } else { share }
    };
    layers.iter().zip(met.into_iter().rev()).map(share).collect()
}

/// V/U of a wave: k_z (s), or k_z/n² (p).
fn admittance(n: C64, kz: C64, p: bool) -> C64 {
    if p { over(kz, n * n) } else { kz }
}

/// Re(n cos θ) (s) or Re(n cos θ*) (p) of the last medium over n cos θ of the first.
fn flux_ratio(kz0: f64, last: C64, kzn: C64, p: bool) -> f64 {
    let flux = if p { (last * over(kzn, last).conj()).re } else { kzn.re };
    if kz0 > 0.0 { flux.max(0.0) / kz0 } else { 0.0 }
}

/// Carries the fields of the outgoing wave behind the last of `layers` to the front of the first.
fn sweep<'a>(
    incidence: &Incidence,
    layers: impl Iterator<Item = &'a Layer>,
    admittance: C64,
    wavelength: f64,
    p: bool,
) -> Fields {
    let mut f = Fields::outgoing(admittance);
    layers.for_each(|layer| cross(&mut f, layer, incidence, wavelength, p));
    f
}

/// Carries the fields from the back of a layer to its front.
fn cross(f: &mut Fields, layer: &Layer, incidence: &Incidence, wavelength: f64, p: bool) {
    let n2 = layer.index * layer.index;
    let kz = incidence.normal(layer.index);
    if kz.im == 0.0 {
        // Real wave number: plain cosine and sine keep the determinant, hence the flux, at 1.
        let (c, b, g) = travelling(kz.re, layer.thickness, wavelength);
        let (b, g) = if p { (b * n2, over(g.into(), n2)) } else { (C64::new(b, 0.0), C64::new(g, 0.0)) };
        let minus_i = |z: C64| C64::new(z.im, -z.re);
        (f.u, f.v) = (f.u * c + minus_i(f.v * b), f.v * c + minus_i(f.u * g));
    } else {
        let turns = kz * (layer.thickness / wavelength);
        let (decay, phase) = ((TAU * turns.im).min(ALL_GONE), reduced_phase(turns.re));
        if decay <= MUCH {
            let (c, s) = complex_cos_sin(phase, decay);
            let (b, g) = (over(-C64::I * s, kz), -C64::I * s * kz);
            let (b, g) = if p { (b * n2, over(g, n2)) } else { (b, g) };
            (f.u, f.v) = (f.u * c + f.v * b, f.v * c + f.u * g);
        } else {
            cross_as_waves(f, admittance(layer.index, kz, p), decay, phase);
        }
    }
    rescale(f);
}

/// Im δ from which on the two waves in a layer are followed apart.
///
/// Their sum and difference, U and V/q, are then nearly equal but for sign, and near a bound mode only what they differ
/// by counts. In a layer that absorbs less both waves count, and the fields themselves keep the flux.
pub(super) const MUCH: f64 = 0.5;

/// Im δ after which nothing is left in any scale.
const ALL_GONE: f64 = 1e6;

/// The wave that grows towards the source stays as it is; that which decays is multiplied by e^{2iδ}; both lack e^{iδ}.
fn cross_as_waves(f: &mut Fields, q: C64, decay: f64, phase: f64) {
    let w = over(f.v, q);
    let (growing, decaying) = (0.5 * (f.u + w), 0.5 * (f.u - w));
    let once = C64::cis(phase);
    if growing == C64::ZERO {
        // A bound mode, to the last bit: only the other wave is left, and it is not to be lost.
        (f.u, f.v) = (decaying, -decaying * q);
        f.decay -= decay;
        f.phase *= once.conj();
        return;
    }
    let decaying = decaying * (once * once * (-2.0 * decay).exp());
    (f.u, f.v) = (growing + decaying, (growing - decaying) * q);
    f.decay += decay;
    f.phase *= once;
}

/// cos and sin of Re δ + i Im δ.
fn complex_cos_sin(re: f64, im: f64) -> (C64, C64) {
    let ((sin, cos), (sinh, cosh)) = (re.sin_cos(), (im.sinh(), im.cosh()));
    (C64::new(cos * cosh, -sin * sinh), C64::new(sin * cosh, cos * sinh))
}

/// cos δ, sin δ/k_z, k_z sin δ for a real wave number.
fn travelling(kz: f64, thickness: f64, wavelength: f64) -> (f64, f64, f64) {
    let (sin, cos) = reduced_phase(kz * thickness / wavelength).sin_cos();
    let b = if kz == 0.0 { TAU * thickness / wavelength } else { sin / kz };
    (cos, b, kz * sin)
}

/// Beyond, whole turns cannot be told from the last bits.
pub(super) const MOST_TURNS: f64 = 1e15;

/// 2π·turns. Whole turns are dropped only where that helps: below some 100 rad sin and cos are exact enough, and
/// the reduction would only add its own rounding.
fn reduced_phase(turns: f64) -> f64 {
    const MANY: f64 = 16.0;
    if turns.is_nan() || turns > MOST_TURNS {
        return 0.0;
    }
    TAU * if turns > MANY { turns - turns.round() } else { turns }
}

/// Keeps the fields near 1 by an exact power of two.
fn rescale(f: &mut Fields) {
    let size = f.u.l1_norm().max(f.v.l1_norm());
    if !(2f64.powi(-32)..=2f64.powi(32)).contains(&size) && size > 0.0 && size.is_finite() {
        let exponent = (size.log2() as i32).clamp(-1000, 1000);
        let factor = 2f64.powi(-exponent);
        f.u *= factor;
        f.v *= factor;
        f.exponent += exponent;
    }
}

/// e^x 2^exponent without leaving the range before the result does.
fn exp_scaled(x: f64, exponent: i32) -> f64 {
    let x = x.max(-ALL_GONE);
    // Split off a power of two, so that a tiny exponential and a large scale meet in the exponent.
    let twos = (x / std::f64::consts::LN_2).round();
    let mantissa = (x - twos * std::f64::consts::LN_2).exp();
    let total = f64::from(exponent) + twos;
    let (a, b) = ((total / 2.0).floor(), (total / 2.0).ceil());
    mantissa * 2f64.powf(a.max(-1074.0)) * 2f64.powf(b.max(-1074.0))
}

/// No layer: differences of squares, relatively accurate for nearly equal indices.
fn bare(incidence: &Incidence, last: C64) -> Pair<Amplitudes> {
    let n0 = C64::new(incidence.index, 0.0);
    let (kz0, kzn) = (incidence.normal(n0), incidence.normal(last));
    let (n0_2, nn_2) = (n0 * n0, last * last);
    let difference = (n0 - last) * (n0 + last);
    let (sum_s, sum_p) = (kz0 + kzn, nn_2 * kz0 + n0_2 * kzn);
    let kx_2 = incidence.kx * incidence.kx;
    let (r_s, r_p) = if difference == C64::ZERO {
        (C64::ZERO, C64::ZERO)
    } else {
        let rest = over(nn_2 * kz0 * kz0 - n0_2 * kx_2, sum_p);
        (over(over(difference, sum_s), sum_s), -over(difference, sum_p) * rest)
    };
    let one = |r: C64, t: C64, t_back: C64, p: bool| Amplitudes {
        r,
        t,
        r_back: -r,
        t_back,
        flux_ratio: flux_ratio(kz0.re, last, kzn, p),
    };
    let (t_s, t_p) = (over(2.0.into(), sum_s), over(n0 * last * 2.0, sum_p));
    Pair { s: one(r_s, t_s * kz0, t_s * kzn, false), p: one(r_p, t_p * kz0, t_p * kzn, true) }
}
