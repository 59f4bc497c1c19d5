//! How far waves interfere: films that grow into slabs under light of a finite coherence length.
//!
//! A tree interferes over a path drawn for it, so that many together show the share γ(path) of the fringes. Estimates may be
//! four standard errors off, once in 2700 times; a test of so many comparisons fails a right program with the sum of that
//! (but seeds are fixed).

use crate::common::collapse;
use std::f64::consts::{LN_2, PI, TAU};

use crate::common::build::{Build, light};
use crate::common::listen::settings;
use crate::common::reference::{Comparisons, closed_forms};
use gonio_embree::dome::Estimate;
use gonio_embree::experiment::{Settings, measure};
use gonio_embree::light::{Light, Polarization, SourceMode};
use gonio_embree::optics::C64;
use gonio_embree::plan::{Limits, Options};

const POLARIZATIONS: [Polarization; 2] = [Polarization::S, Polarization::P];
const NM: [f64; 2] = [470.0, 610.0];
/// λ²/Δλ of the light, µm.
const LENGTH: f64 = 30.0;

const TREES: u64 = 20_000;

/// A degree of coherence of less than 10⁻⁶ is taken as none.
const NONE: f64 = 1e-6;

/// Degree of coherence of a Gaussian line of full width 1/l (in wave numbers): its Fourier transform.
fn gamma(path: f64, l: f64) -> f64 {
    (-(PI * path / l).powi(2) / (4.0 * LN_2)).exp()
}

/// A film of index n between two half-spaces of index n₀, lit at an angle.
#[derive(Clone, Copy, Debug)]
struct Film {
    outside: f64,
    n: f64,
    d: f64,
    theta_deg: f64,
    polarization: Polarization,
}

impl Film {
    /// n cos θ outside and in the film, 0 beyond the critical angle.
    fn normal(&self) -> [f64; 2] {
        let (sin, cos) = self.theta_deg.to_radians().sin_cos();
        [self.outside * cos, (self.n * self.n - (self.outside * sin).powi(2)).max(0.0).sqrt()]
    }

    /// The difference of optical paths between one reflection and the next, µm.
    fn path(&self) -> f64 {
        2.0 * self.d * self.normal()[1]
    }

    /// Reflectance of a face.
    fn face(&self) -> f64 {
        let [a, b] = self.normal();
        let [a, b] = match self.polarization {
            Polarization::S => [a, b],
            _ => [self.n / self.outside * a, self.outside / self.n * b],
        };
        ((a - b) / (a + b)).powi(2)
    }

    /// Airy's sum; beyond the critical angle by the film formula.
    fn coherent(&self, um: f64) -> f64 {
        let [_, inside] = self.normal();
        if inside == 0.0 {
            let layers = [(C64::from(self.n), self.d)];
            let cos = self.theta_deg.to_radians().cos();
            let both = collapse::collapse(self.outside, cos, &layers, C64::from(self.outside), um);
            return if self.polarization == Polarization::S { both.s } else { both.p }.0.norm_sqr();
        }
        let rho = self.face();
        1.0 - (1.0 - rho).powi(2) / (1.0 - 2.0 * rho * (TAU * self.path() / um).cos() + rho * rho)
    }

    fn incoherent(&self) -> f64 {
        2.0 * self.face() / (1.0 + self.face())
    }

    /// The share γ of trees that interfere, and the rest.
    fn blend(&self, gamma: f64, um: f64) -> f64 {
        gamma * self.coherent(um) + (1.0 - gamma) * self.incoherent()
    }

    /// What the blend is off if the few trees that are coherent, or those that are not, have not been drawn at all.
    fn unseen(&self, gamma: f64, um: f64) -> f64 {
        let rare = gamma.min(1.0 - gamma);
        if rare * (TREES as f64) < 10.0 { rare * (self.coherent(um) - self.incoherent()).abs() } else { 0.0 }
    }

    fn measure(&self, nm: &[f64], source: SourceMode) -> Vec<Estimate> {
        let light = Light { source, ..light(nm, &[(self.theta_deg, 25.0)], self.polarization) };
        reflected(&Build::within(self.outside).films(0.0, &[(self.n, self.d)]), &light)
    }
}

fn reflected(build: &Build, light: &Light) -> Vec<Estimate> {
    // Rays may go as far aside as they like.
    let limits = Limits { walk: 1e9, ..Limits::default() };
    let settings = Settings { options: Options { limits, ..Options::default() }, ..settings(TREES) };
    let bsdf = measure(&build.sample(light), light, &settings, |_| {}).unwrap().bsdf;
    let ledger = &bsdf.incidences[0].ledger;
    assert!(ledger.sum().iter().all(|sum| (sum - 1.0).abs() < 1e-9), "{ledger:?}");
    assert_eq!(ledger.specular, ledger.reflected);
    ledger.specular.clone()
}

/// Films of glass, for all polarizations.
fn glass(thicknesses: &[f64], angles: &[f64]) -> Vec<Film> {
    let of = |theta_deg, polarization| {
        thicknesses.iter().map(move |&d| Film { outside: 1.0, n: 1.5, d, theta_deg, polarization })
    };
    angles.iter().flat_map(|&theta| POLARIZATIONS.map(|p| of(theta, p)).into_iter().flatten()).collect()
}

#[test]
fn films_show_as_much_of_their_fringes_as_light_is_coherent() {
    let thicknesses = [0.2, 0.9, 2.0, 3.1, 4.2, 5.5, 7.0, 8.3, 10.0, 13.0, 19.9, 20.1, 29.9, 30.1, 60.0];
    let mut comparisons = Comparisons::default();
    for film in glass(&thicknesses, &[0.0, 50.0]) {
        for (measured, nm) in film.measure(&NM, SourceMode::Gaussian(LENGTH)).into_iter().zip(NM) {
            let gamma = gamma(film.path(), LENGTH);
            let (truth, unseen) = (film.blend(gamma, nm / 1e3), film.unseen(gamma, nm / 1e3));
            comparisons.within(&format!("{film:?}, {nm} nm"), measured, truth, unseen + NONE);
        }
    }
    comparisons.judge(2e-3);
}

/// A band is coherent up to λ²/Δλ of its shortest wavelength, not at all beyond twice that; in between γ falls linearly.
#[test]
fn films_show_fringes_as_far_as_a_grid_resolves_them() {
    let full = NM[0] * NM[0] / (NM[1] - NM[0]) / 1e3;
    let mut comparisons = Comparisons::default();
    for film in glass(&[0.2, 0.4, 0.52, 0.53, 0.6, 0.7, 0.8, 0.9, 1.0, 1.04, 1.1, 2.0], &[0.0, 50.0]) {
        for (measured, nm) in film.measure(&NM, SourceMode::Band).into_iter().zip(NM) {
            let gamma = (2.0 - film.path() / full).clamp(0.0, 1.0);
            comparisons.add(&format!("{film:?}, {nm} nm"), measured, film.blend(gamma, nm / 1e3));
        }
    }
    comparisons.judge(2e-3);
}

/// Mean of a function of the wavelength (µm) over a Gaussian line, in wave numbers.
fn line_average(nm: f64, l: f64, value: impl Fn(f64) -> f64) -> f64 {
    const STEPS: i32 = 4000;
    let (mut sum, mut all) = (0.0, 0.0);
    for step in -STEPS..=STEPS {
        let off = 4.0 * f64::from(step) / f64::from(STEPS) / l;
        let weight = (-4.0 * LN_2 * (off * l).powi(2)).exp();
        sum += weight * value(1.0 / (1e3 / nm + off));
        all += weight;
    }
    sum / all
}

/// The real line has every order of interference faded by its own path: its mean transmittance is
/// T₀ (1 + 2 Σ ρᵐ γ(m path) cos(m δ)) with T₀ = (1−ρ)/(1+ρ). Trees fade all orders as the first: that is off by no more than
/// 2 T₀ Σ ρᵐ (γ(path) − γ(m path)), m ≥ 2, less than 2ρ² (0.3 % of the light for glass, 2 % at 50°).
#[test]
fn a_gaussian_line_averages_fringes_as_trees_do() {
    let mut comparisons = Comparisons::default();
    for film in glass(&[0.5, 2.0, 3.5, 5.0, 6.5, 8.0, 10.0, 14.0, 20.0, 40.0], &[0.0, 50.0]) {
        let (rho, path) = (film.face(), film.path());
        let t0 = (1.0 - rho) / (1.0 + rho);
        let orders = |gamma_of: &dyn Fn(f64) -> f64| -> f64 {
            (2..40).map(|m| 2.0 * t0 * rho.powi(m) * gamma_of(f64::from(m))).sum()
        };
        let bound = orders(&|m| gamma(path, LENGTH) - gamma(m * path, LENGTH));
        assert!((0.0..2.0 * rho * rho).contains(&bound), "{bound}");
        for (measured, nm) in film.measure(&NM, SourceMode::Gaussian(LENGTH)).into_iter().zip(NM) {
            let truth = line_average(nm, LENGTH, |um| film.coherent(um));
            let phase = |m: f64| (m * TAU * path / nm * 1e3).cos();
            let first = 2.0 * t0 * rho * gamma(path, LENGTH) * phase(1.0);
            let series = 1.0 - t0 - first - orders(&|m| gamma(m * path, LENGTH) * phase(m));
            assert!((series - truth).abs() < 1e-8, "{film:?}, {nm} nm: {series} for {truth}");
            let unseen = film.unseen(gamma(path, LENGTH), nm / 1e3);
            comparisons.within(&format!("{film:?}, {nm} nm"), measured, truth, bound + unseen + NONE);
        }
    }
    comparisons.judge(2e-3);
}

#[test]
fn thick_films_are_slabs() {
    let mut comparisons = Comparisons::default();
    for case in closed_forms("slab_incoherent") {
        let (theta, polarization) = (case.number("angle_deg"), case.word("pol").parse().unwrap());
        let film = Film { polarization, ..glass(&[60.0], &[theta])[0] };
        let measured = film.measure(&NM[..1], SourceMode::Gaussian(LENGTH))[0];
        comparisons.add(&format!("{case:?}"), measured, case.number("R"));
    }
    comparisons.judge(3e-3);
}

/// A gap of air in glass, up to the critical angle and beyond. Light that runs along a gap has a short path in a deep one;
/// stacks are searched no deeper than a coherence length, and interference fades towards that depth.
#[test]
fn gaps_fade_before_they_are_too_deep_to_be_searched() {
    let mut comparisons = Comparisons::default();
    for theta_deg in [38.0, 41.0, 41.7, 45.0] {
        for d in [0.15, 3.0, 7.0, 11.0, 14.9, 17.0, 19.0, 22.0, 26.0, 29.9, 30.1, 45.0] {
            let film = Film { outside: 1.5, n: 1.0, d, theta_deg, polarization: Polarization::S };
            let gamma = gamma(film.path().max(4.0 * d - 2.0 * LENGTH), LENGTH);
            for (measured, nm) in film.measure(&NM, SourceMode::Gaussian(LENGTH)).into_iter().zip(NM) {
                let (truth, unseen) = (film.blend(gamma, nm / 1e3), film.unseen(gamma, nm / 1e3));
                comparisons.within(&format!("{film:?}, {nm} nm"), measured, truth, unseen + NONE);
            }
        }
    }
    comparisons.judge(3e-3);
}

/// The same trees, a hundredth of a nanometre apart: fringes move by 4π n d/λ, less than a thousandth of what they are.
#[test]
fn nothing_jumps_when_a_film_grows() {
    const STEP: f64 = 1e-5;
    let band = 0.55 * 0.55 / 0.02;
    for (source, full, none) in
        [(SourceMode::Gaussian(LENGTH), 0.5 * LENGTH, 2.0 * LENGTH), (SourceMode::Band, band, 2.0 * band)]
    {
        for (outside, n, theta_deg) in [(1.0, 1.5, 0.0), (1.0, 1.5, 50.0), (1.5, 1.0, 38.0), (1.5, 1.0, 41.0)] {
            let film = Film { outside, n, d: 1.0, theta_deg, polarization: Polarization::S };
            let slope = film.path();
            for edge in [full / slope, none / slope, 0.25 * none, 0.5 * none] {
                let [below, above] = [edge - 0.5 * STEP, edge + 0.5 * STEP]
                    .map(|d| Film { d, ..film }.measure(&[550.0], source)[0].value);
                assert!((above - below).abs() < 1e-3, "{source}, {film:?} at {edge} µm: {below} to {above}");
            }
        }
    }
}

/// A stack of two films on a ground of the same index as the medium above, by Airy's sums of intensities and amplitudes:
/// light comes vertically.
struct Two {
    outside: f64,
    films: [(f64, f64); 2],
}

impl Two {
    fn paths(&self) -> [f64; 2] {
        self.films.map(|(n, d)| 2.0 * n * d)
    }

    fn build(&self) -> Build {
        Build::within(self.outside).films(0.0, &self.films)
    }

    /// Reflectance and transmittance of a single film, or of both.
    fn coherent(&self, first: f64, films: &[(f64, f64)], last: f64, um: f64) -> [f64; 2] {
        let layers: Vec<(C64, f64)> = films.iter().map(|&(n, d)| (n.into(), d)).collect();
        let (r, _) = collapse::collapse(first, 1.0, &layers, last.into(), um).s;
        [r.norm_sqr(), 1.0 - r.norm_sqr()]
    }

    /// Reflectance of two parts without interference between them: of the upper from above, R and T, and of the lower. Both
    /// are transparent, and from below the upper reflects as from above.
    fn apart([r, t]: [f64; 2], [below, _]: [f64; 2]) -> f64 {
        r + t * t * below / (1.0 - r * below)
    }

    /// What a tree sees whose waves interfere over a path: both films; or the upper alone; or, where that is the thicker, the
    /// lower alone; or neither.
    fn seen(&self, reach: f64, um: f64) -> f64 {
        let [(n1, _), (n2, _)] = self.films;
        let [p1, p2] = self.paths();
        let n0 = self.outside;
        let of = |first, films: &[(f64, f64)], last| self.coherent(first, films, last, um);
        match (p1 + p2 <= reach, p1 <= reach, p2 <= reach) {
            (true, ..) => of(n0, &self.films, n0)[0],
            (_, true, _) => Self::apart(of(n0, &self.films[..1], n2), of(n2, &[], n0)),
            (_, _, true) => Self::apart(of(n0, &[], n1), of(n1, &self.films[1..], n0)),
            _ => {
                let lower = Self::apart(of(n1, &[], n2), of(n2, &[], n0));
                Self::apart(of(n0, &[], n1), [lower, 1.0 - lower])
            }
        }
    }
}

/// Two films that are each thinner than light is coherent, but not together. A real line would show some fringes of the
/// lower film, too: without them reflectance is up to 2 % of the light off.
#[test]
fn of_two_films_the_upper_interferes_if_both_are_too_much() {
    let mut comparisons = Comparisons::default();
    let normal = |source| Light { source, ..light(&NM, &[(0.0, 0.0)], Polarization::Unpolarized) };
    for films in [[(1.5, 2.7), (2.0, 3.1)], [(2.0, 3.1), (1.5, 2.7)], [(1.7, 1.0), (1.4, 4.0)]] {
        let two = Two { outside: 1.0, films };
        let [p1, p2] = two.paths();
        let limits = [p1.min(p2), p1.max(p2), p1 + p2, f64::INFINITY];
        let measured = reflected(&two.build(), &normal(SourceMode::Gaussian(20.0)));
        for (measured, nm) in measured.into_iter().zip(NM) {
            let (mut truth, mut before) = (0.0, 0.0);
            for limit in limits {
                let more = gamma(before, 20.0) - gamma(limit, 20.0);
                truth += more * two.seen(before, nm / 1e3);
                before = limit;
            }
            let real = line_average(nm, 20.0, |um| two.seen(f64::INFINITY, um));
            assert!((truth - real).abs() < 0.02, "{films:?}, {nm} nm: {truth} for {real}");
            comparisons.within(&format!("{films:?}, {nm} nm"), measured, truth, NONE);
        }
    }
    comparisons.judge(2e-3);
}
