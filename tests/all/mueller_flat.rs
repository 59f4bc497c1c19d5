//! Mueller matrices of flat samples against Fresnel, Airy and Lambert.
//!
//! Where light is chosen by lot the error is judged by Student's t over the batches: a right program fails each test with
//! probability 1e-3 (but seeds are fixed).

use crate::common::collapse;
use crate::common::matrices;

use crate::common::build::{Build, light};
use crate::common::listen::settings;
use crate::common::stats::student_two_sided;
use glam::DVec3;
use gonio_embree::bsdf::Scattering;
use gonio_embree::dome::Estimate;
use gonio_embree::experiment::{BATCHES, measure};
use gonio_embree::light::{Light, Polarization, SourceMode};
use gonio_embree::optics::C64;
use gonio_embree::plan::Limits;
use gonio_embree::sample::description::{Fill, Shape};
use matrices::{Mueller, applied, diagonal, product, turn};

const NM: f64 = 550.0;
const ALUMINIUM: C64 = C64::new(0.96, 6.69);
const FALSE_ALARM: f64 = 1e-3;

/// Amplitudes of reflection and power-normalised transmission, for p and for s.
#[derive(Clone, Copy)]
struct Fresnel {
    r: [C64; 2],
    t: [C64; 2],
}

/// Cosine behind an interface, in the branch that decays.
fn refracted(n1: C64, n2: C64, cos: C64) -> C64 {
    let cos2 = (1.0 - (n1 / n2).powi(2) * (1.0 - cos * cos)).sqrt();
    if (n2 * cos2).im < 0.0 { -cos2 } else { cos2 }
}

fn fresnel(n1: C64, n2: C64, c1: C64) -> Fresnel {
    let c2 = refracted(n1, n2, c1);
    let (s, p) = (n1 * c1 + n2 * c2, n2 * c1 + n1 * c2);
    let through = 2.0 * n1 * c1 * ((n2 * c2).re / (n1 * c1).re).max(0.0).sqrt();
    Fresnel { r: [(n2 * c1 - n1 * c2) / p, (n1 * c1 - n2 * c2) / s], t: [through / p, through / s] }
}

fn of([p, s]: [C64; 2]) -> Mueller {
    diagonal(p, s)
}

/// Unit vectors of the incidence: k and ŝ.
fn incident(theta: f64, phi: f64) -> (DVec3, DVec3) {
    let ((sin, cos), (sin_phi, cos_phi)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    (-DVec3::new(sin * cos_phi, sin * sin_phi, cos), DVec3::new(-sin_phi, cos_phi, 0.0))
}

/// A matrix that is told in (p̂, ŝ) for light that leaves along `dir`, told in (θ̂, φ̂).
fn told(m: &Mueller, dir: DVec3, s: DVec3) -> Mueller {
    // Of the pole as if it were reached along φ = 0.
    let azimuth = if dir.x.hypot(dir.y) > 1e-12 { dir.y.atan2(dir.x) } else { 0.0 };
    let (sin, cos) = azimuth.sin_cos();
    let theta = DVec3::new(dir.z * cos, dir.z * sin, -dir.x.hypot(dir.y));
    product(&turn(theta.dot(s.cross(dir)), theta.dot(s)), m)
}

/// Media above, within and below, the layers with thickness in µm.
struct Stack<'a> {
    above: f64,
    layers: &'a [(C64, f64)],
    below: C64,
    source: SourceMode,
}

impl Stack<'_> {
    /// What is measured, with both ways followed at so many interfaces.
    fn measured(&self, theta: f64, phi: f64, splits: u32) -> Scattering {
        let light = Light { source: self.source, ..light(&[NM], &[(theta, phi)], Polarization::Mueller) };
        let build = Build::within(self.above).below(self.below).films(0.0, self.layers);
        let mut settings = settings(if splits > 1 { 64 } else { 20_000 });
        settings.options.limits = Limits { splits: Some(splits), faintest: 1e-24, ..Limits::default() };
        measure(&build.sample(&light), &light, &settings, |_| {}).unwrap().bsdf.incidences.swap_remove(0)
    }

    /// The mirror direction and the straight one as they should be: `truth` is told in (p̂, ŝ).
    fn expected(&self, theta: f64, phi: f64, truth: &[Mueller; 2]) -> [Mueller; 2] {
        let (k, s) = incident(theta, phi);
        let across = (self.above / self.below.re) * k.with_z(0.0);
        let straight = across.with_z(-(1.0 - across.length_squared()).max(0.0).sqrt());
        [told(&truth[0], k.with_z(-k.z), s), told(&truth[1], straight, s)]
    }

    fn check_all_round(&self, theta: f64, splits: u32, truth: &[Mueller; 2]) {
        AZIMUTHS.iter().for_each(|&phi| self.check(theta, phi, splits, truth));
    }

    /// Compares with what has no noise.
    fn check(&self, theta: f64, phi: f64, splits: u32, truth: &[Mueller; 2]) {
        let measured = self.measured(theta, phi, splits);
        let deltas = measured.deltas.as_ref().unwrap();
        let expected = self.expected(theta, phi, truth);
        for (is, expected) in [&deltas.specular[0], &deltas.undeflected[0]].into_iter().zip(expected) {
            let off = matrices::distance(&is.map(|e| e.value), &expected);
            assert!(off < 1e-12, "{theta}°, {phi}°: {off:e}\n{is:?}\n{expected:?}");
            assert!(is.iter().all(|e| e.se < 1e-12), "{is:?}");
        }
        let ledger = &measured.ledger;
        assert_eq!((ledger.specular[0], ledger.undeflected[0]), (deltas.specular[0][0], deltas.undeflected[0][0]));
    }
}

const AZIMUTHS: [f64; 3] = [0.0, 35.0, 200.0];

/// A half-space; light from both sides, at the angles of Brewster and of total reflection, too.
#[test]
fn an_interface_is_fresnels() {
    for (n1, n2) in [(1.0, 1.5), (1.5, 1.0), (1.0, 2.4), (1.6, 1.3)] {
        let brewster = f64::atan2(n2, n1).to_degrees();
        let critical = (n2 / n1).min(1.0).asin().to_degrees();
        for theta in [0.0, 20.0, brewster, critical - 0.1, (critical + 0.1).min(89.0), 60.0, 85.0] {
            let f = fresnel(n1.into(), n2.into(), theta.to_radians().cos().into());
            let stack = Stack { above: n1, layers: &[(n2.into(), 100.0)], below: n2.into(), source: SourceMode::Line };
            stack.check_all_round(theta, 1, &[of(f.r), of(f.t)]);
        }
    }
}

/// Metal: nothing goes on, and p is ahead of s.
#[test]
fn a_mirror_of_metal_retards() {
    let stack = Stack { above: 1.0, layers: &[(ALUMINIUM, 100.0)], below: ALUMINIUM, source: SourceMode::Line };
    for theta in [0.0, 30.0, 60.0, 85.0f64] {
        let f = fresnel(C64::ONE, ALUMINIUM, theta.to_radians().cos().into());
        stack.check_all_round(theta, 1, &[of(f.r), [0.0; 16]]);
    }
}

/// The two faces of a slab without interference, in the order of the ways: `down` and `up` are its upper face from both
/// sides, `floor` its lower one.
fn slab(above: f64, index: f64, below: f64, cos: f64) -> [Mueller; 2] {
    let [n1, n2, n3] = [above, index, below].map(C64::from);
    let within = refracted(n1, n2, cos.into());
    let (down, up, floor) = (fresnel(n1, n2, cos.into()), fresnel(n2, n1, within), fresnel(n2, n3, within));
    let (mut inside, mut out) = (of(down.t), [of(down.r), [0.0; 16]]);
    while inside.iter().any(|x| x.abs() > 1e-18) {
        let returned = product(&of(floor.r), &inside);
        let add = |sum: &mut Mueller, m: Mueller| sum.iter_mut().zip(m).for_each(|(s, x)| *s += x);
        add(&mut out[1], product(&of(floor.t), &inside));
        add(&mut out[0], product(&of(up.t), &returned));
        inside = product(&of(up.r), &returned);
    }
    out
}

/// Also with total reflection at its lower face, which retards what comes back through the upper one.
const SLABS: [(f64, f64, f64, f64); 6] = [
    (1.0, 1.5, 1.0, 0.0),
    (1.0, 1.5, 1.0, 40.0),
    (1.0, 1.5, 1.0, 56.309_932_474_020_215),
    (1.0, 1.5, 1.2, 75.0),
    (1.5, 2.0, 1.0, 30.0),
    (1.5, 2.0, 1.0, 60.0),
];

#[test]
fn a_slab_without_interference_is_a_sum_of_its_ways() {
    for (above, index, below, theta) in SLABS {
        let truth = slab(above, index, below, theta.to_radians().cos());
        let (layers, below) = ([(index.into(), 1000.0)], below.into());
        let stack = Stack { above, layers: &layers, below, source: SourceMode::Band };
        stack.check_all_round(theta, 1000, &truth);
    }
}

/// The same, one way at a time chosen by lot.
#[test]
fn a_slab_is_the_same_by_lot() {
    let mut worst = 1.0f64;
    for (above, index, below, theta) in SLABS {
        let truth = slab(above, index, below, theta.to_radians().cos());
        let (layers, below) = ([(index.into(), 1000.0)], below.into());
        let stack = Stack { above, layers: &layers, below, source: SourceMode::Band };
        let deltas = stack.measured(theta, 35.0, 1).deltas.unwrap();
        let expected = stack.expected(theta, 35.0, &truth);
        for (is, expected) in [&deltas.specular[0], &deltas.undeflected[0]].into_iter().zip(expected) {
            worst = is.iter().zip(expected).map(|(e, x)| chance(*e, x)).fold(worst, f64::min);
        }
    }
    assert!(worst > FALSE_ALARM / (SLABS.len() * 32) as f64, "p = {worst:e}");
}

/// Probability of an estimate so far from the truth.
fn chance(is: Estimate, truth: f64) -> f64 {
    let off = (is.value - truth).abs();
    if off < 1e-12 { 1.0 } else { student_two_sided(off / is.se, f64::from(BATCHES - 1)) }
}

/// Films by Airy's formula: transparent and absorbing ones, light that tunnels through one, a mirror behind them.
#[test]
fn films_are_airys() {
    let transparent = [(C64::from(2.3), 0.08), (C64::from(1.38), 0.11)];
    let absorbing = [(C64::new(1.7, 0.05), 0.2), (C64::from(1.45), 0.3)];
    let gap = [(C64::ONE, 0.15)];
    let stack = |above, layers, below| Stack { above, layers, below, source: SourceMode::Line };
    let stacks = [
        stack(1.0, &transparent[..], 1.52.into()),
        stack(1.0, &absorbing, 1.0.into()),
        stack(1.5, &transparent, 1.0.into()),
        stack(1.5, &gap, 1.5.into()),
        stack(1.0, &absorbing, ALUMINIUM),
    ];
    for stack in stacks {
        let Stack { above, layers, below, .. } = stack;
        for theta in [0.0, 35.0, 56.3, 80.0f64] {
            let cos = theta.to_radians().cos();
            let twin = collapse::collapse(above, cos, layers, below, NM / 1e3);
            let behind = below * refracted(above.into(), below, cos.into());
            // Of what goes on behind; nothing does in metal, or where reflection is total.
            let flux = if below.im > 0.0 { 0.0 } else { behind.re / (above * cos) };
            let r = [twin.p.0, twin.s.0];
            let t = [twin.p.1, twin.s.1].map(|t| t * flux.sqrt());
            stack.check_all_round(theta, 1, &[of(r), of(t)]);
        }
    }
}

/// A surface that only reflects has the signs of a perfect conductor, as seen under metal of a great index.
#[test]
fn a_mirror_is_a_perfect_conductor() {
    let build = Build::within(1.0).fill(Shape::Slab { top: 0.0, bottom: -1.0 }, Fill::Mirror(0.9));
    let m = flat(build, 50.0).deltas.unwrap().specular[0].map(|e| e.value);
    let f = fresnel(C64::ONE, C64::new(1e3, 1e14), f64::to_radians(50.0).cos().into());
    let expected = of(f.r).map(|x| 0.9 * x);
    assert!(matrices::distance(&m, &expected) < 1e-12, "{m:?}");
}

/// Light at +45° turns left-handed (V < 0) where reflection is total or metallic: p is ahead of s.
#[test]
fn p_is_ahead_of_s() {
    let glass = Stack { above: 1.5, layers: &[(C64::ONE, 100.0)], below: C64::ONE, source: SourceMode::Line };
    let metal = Stack { above: 1.0, layers: &[(ALUMINIUM, 100.0)], below: ALUMINIUM, source: SourceMode::Line };
    for stack in [glass, metal] {
        let m = stack.measured(55.0, 0.0, 1).deltas.unwrap().specular[0].map(|e| e.value);
        let [i, _, _, v] = applied(&m, [1.0, 0.0, 1.0, 0.0]);
        assert!(v < -0.1 * i, "{m:?}");
    }
}

/// A flat sample under light from `theta`.
fn flat(build: Build, theta: f64) -> Scattering {
    let light = light(&[NM], &[(theta, 35.0)], Polarization::Mueller);
    let mut settings = settings(100_000);
    settings.dome_level = 1;
    measure(&build.sample(&light), &light, &settings, |_| {}).unwrap().bsdf.incidences.swap_remove(0)
}

#[test]
fn a_matt_surface_depolarizes_totally() {
    const SHARE: f64 = 0.8;
    let floor = Shape::Slab { top: 0.0, bottom: -1.0 };
    let measured = flat(Build::within(1.0).fill(floor, Fill::Diffuse(SHARE)), 50.0);
    let above = measured.facets.iter().filter(|f| f.facet.center().z > 0.0);
    let chances = above.map(|f| chance(f.mueller[0][0], SHARE / std::f64::consts::PI));
    assert!(chances.fold(1.0, f64::min) > FALSE_ALARM / 40.0);
    let zero = |e: &Estimate| *e == Estimate { value: 0.0, se: 0.0 };
    assert!(measured.facets.iter().all(|f| f.mueller[0][1..].iter().all(zero)));
}

/// Under glass, light is polarized on its way in and, once more, on its way out, with nothing left in between: M = out·inᵀ.
#[test]
fn a_matt_surface_under_glass_keeps_what_the_glass_does() {
    let (theta, n) = (50.0f64, 1.5);
    let glass = Shape::Slab { top: 0.0, bottom: -1000.0 };
    let floor = Shape::Slab { top: -1000.0, bottom: -1001.0 };
    let build = Build::within(1.0).put(glass, n).fill(floor, Fill::Diffuse(0.8));
    let [p, s] = fresnel(C64::ONE, n.into(), theta.to_radians().cos().into()).t.map(|t| t.norm_sqr());
    let mut polarized = 0.0f64;
    for facet in flat(build, theta).facets.iter().filter(|f| f.facet.center().z > 0.0) {
        let m = facet.mueller[0].map(|e| e.value);
        let inwards = [1.0, (p - s) / (p + s), 0.0, 0.0];
        let outwards = [0, 1, 2, 3].map(|row| m[4 * row]);
        let rank_one: Mueller = std::array::from_fn(|at| outwards[at / 4] * inwards[at % 4]);
        assert!(matrices::distance(&m, &rank_one) < 1e-12 * m[0].max(1.0), "{m:?}");
        polarized = polarized.max(m[4] / m[0]);
    }
    assert!(polarized > 0.1, "light that leaves aslant is polarized");
}
