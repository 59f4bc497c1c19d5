//! When polarization matters, and when not: what the plan decides, against the truth.
#![allow(clippy::print_stdout, reason = "figures are shown with --nocapture")]

use crate::common::Mesh;
use crate::common::build::{Build, ball, light, mesh};
use crate::common::listen::settings;
use glam::DVec3;
use gonio_embree::bsdf::Scattering;
use gonio_embree::experiment::{Outcome, measure};
use gonio_embree::light::Polarization;
use gonio_embree::optics::C64;
use gonio_embree::optics::fresnel::{into_complex, other_leg};
use gonio_embree::plan::{Name, State, Wanted};
use gonio_embree::sample::description::{Fill, Shape};
use gonio_embree::sample::generate::packing::Packing;

const ALUMINIUM: C64 = C64::new(0.96, 6.69);
const TREES: u64 = 200_000;
/// Standard errors of what may happen once in 10⁴ times, with 31 degrees of freedom.
const SIGMAS: f64 = 4.5;

fn run(build: &Build, from: (f64, f64), polarization: Polarization, wanted: Wanted) -> Outcome {
    let light = light(&[550.0], &[from], polarization);
    let mut settings = settings(TREES);
    (settings.options.wanted, settings.dome_level) = (wanted, 1);
    measure(&build.sample(&light), &light, &settings, |_| {}).unwrap()
}

/// The plan's choice and, with it or against it, what is measured with polarization and without.
struct Comparison {
    auto: Outcome,
    with: Scattering,
    without: Scattering,
}

impl Comparison {
    fn new(build: &Build, from: (f64, f64)) -> Self {
        let run = |wanted| run(build, from, Polarization::Unpolarized, wanted);
        let by_hand = |on| run(Wanted::AUTO.with(Name::Polarization, on)).bsdf.incidences.swap_remove(0);
        Self { auto: run(Wanted::AUTO), with: by_hand(true), without: by_hand(false) }
    }

    fn bound(&self) -> f64 {
        self.auto.plan.effects[Name::Polarization as usize].bound
    }

    /// Relative change of the reflected light, in standard errors too.
    fn change(&self) -> (f64, f64) {
        let [a, b] = [&self.without, &self.with].map(|s| s.ledger.reflected[0]);
        ((a.value - b.value) / b.value, (a.value - b.value) / a.se.hypot(b.se))
    }

    /// No part of the light on a side changes by more than the bound, of all on that side, but for noise.
    fn check_bound(&self, name: &str) {
        for above in [true, false] {
            let side = |s: &Scattering| if above { s.ledger.reflected[0] } else { s.ledger.transmitted[0] };
            let all = side(&self.with);
            let facets =
                self.with.facets.iter().zip(&self.without.facets).filter(|(f, _)| (f.facet.center().z > 0.0) == above);
            let facets = facets.map(|(a, b)| (a.value[0], b.value[0], a.facet.projected_solid_angle()));
            for (a, b, angle) in facets.chain([(all, side(&self.without), 1.0)]) {
                let change = (a.value - b.value).abs() - SIGMAS * a.se.hypot(b.se);
                assert!(change * angle <= self.bound() * all.value + 1e-12, "{name}: {a:?} {b:?}");
            }
        }
    }
}

fn half_space(n: impl Into<C64> + Copy) -> Build {
    Build::within(1.0).below(n).put(Shape::Slab { top: 0.0, bottom: -10.0 }, n)
}

/// A roof along y, so flat that light from above meets it once.
fn roof(fill: impl Fn(&mut Build) -> Fill) -> Build {
    let section = [(-5.0, 0.0), (5.0, 0.0), (0.0, 1.5)];
    let vertices = [-5.0, 5.0].map(|y| section.map(|(x, z)| DVec3::new(x, y, z))).concat();
    let sides = (0..3).flat_map(|i| [[i, (i + 1) % 3, (i + 1) % 3 + 3], [i, (i + 1) % 3 + 3, i + 3]]);
    let triangles = sides.chain([[0, 2, 1], [3, 4, 5]]).collect();
    let mut build = Build::within(1.0).patch(10.0, 10.0);
    let fill = fill(&mut build);
    build.fill(mesh(Mesh { vertices, triangles }), fill)
}

/// Spheres on spheres.
fn heap() -> Build {
    let balls = [[0.0, 0.0, 0.0], [1.0, 0.5, 4.0], [-2.0, 2.0, -3.0]];
    balls.into_iter().fold(Build::within(1.0).open().patch(8.0, 8.0), |b, center| b.put(ball(center, 2.0), 1.5))
}

fn packing() -> Build {
    let size = DVec3::new(20.0, 20.0, 12.0);
    Build::within(1.0).packing(&Packing { count: 350, radius: 1.0, size, periodic: true, seed: 3 }, 1.5)
}

/// Light that is polarized is not the mean of s and p, not even at one interface.
#[test]
fn polarized_light_keeps_its_polarization() {
    let states = [Polarization::S, Polarization::P, Polarization::Stokes([1.0, -0.6, 0.3, 0.0])];
    for n in [C64::from(1.5), ALUMINIUM] {
        for theta in [45.0, 75.0f64] {
            let cos = theta.to_radians().cos();
            let r = into_complex(1.0, n, cos, other_leg(cos)).map(|r| r.norm_sqr());
            for state in states {
                let outcome = run(&half_space(n), (theta, 20.0), state, Wanted::AUTO);
                let [s, p] = state.shares();
                let reflected = outcome.bsdf.incidences[0].ledger.reflected[0].value;
                assert!((reflected - (s * r.s + p * r.p)).abs() < 1e-12, "{n}, {theta}°, {state}: {reflected}");
                assert_eq!(outcome.plan.kernel.state, State::Stokes);
            }
        }
    }
}

/// Light that meets one interface is divided by the mean of s and p, exactly.
#[test]
fn one_interface_needs_no_polarization() {
    let metal = roof(|build| Fill::Medium(build.medium(ALUMINIUM)));
    let mirror = roof(|_| Fill::Mirror(0.9));
    let cases = [
        ("glass", half_space(1.5), (85.0, 0.0)),
        ("metal", half_space(ALUMINIUM), (0.0, 0.0)),
        ("metal", half_space(ALUMINIUM), (70.0, 20.0)),
        ("metal roof", metal, (20.0, 30.0)),
        ("mirror roof", mirror, (20.0, 30.0)),
    ];
    for (name, build, from) in cases {
        let c = Comparison::new(&build, from);
        assert_eq!(c.auto.plan.kernel.state, State::Power, "{name}, {from:?}");
        assert_eq!(c.auto.bsdf.incidences[0], c.without);
        let told = |s: &Scattering| -> Vec<f64> {
            let entries = s.ledger.entries().map(|(_, e)| e[0].value);
            entries.into_iter().chain(s.facets.iter().map(|f| f.value[0].value)).collect()
        };
        let off = told(&c.with).into_iter().zip(told(&c.without)).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12, "{name}, {from:?}");
    }
}

/// Light that meets several interfaces is not: some percent of what spheres reflect.
#[test]
fn spheres_need_polarization() {
    let cases = [
        ("packing", packing(), (0.0, 0.0), 0.02..0.04),
        ("packing", packing(), (40.0, 0.0), 0.01..0.03),
        ("heap", heap(), (0.0, 0.0), 0.04..0.08),
        ("heap", heap(), (60.0, 0.0), 0.04..0.07),
    ];
    for (name, build, from, expected) in cases {
        let c = Comparison::new(&build, from);
        let (change, sigmas) = c.change();
        println!("{name}, {from:?}: {:.2} % ({sigmas:.1} standard errors), bound {:.3}", 100.0 * change, c.bound());
        assert_eq!(c.auto.plan.kernel.state, State::Stokes, "{name}, {from:?}");
        assert_eq!(c.auto.bsdf.incidences[0], c.with);
        assert!(expected.contains(&change) && sigmas > SIGMAS, "{name}, {from:?}: {change}");
        c.check_bound(name);
    }
}

/// Two bounces between the sides of a roof of metal, at some places: little, but the bound says so.
#[test]
fn what_is_left_out_stays_within_its_bound() {
    let metal = roof(|build| Fill::Medium(build.medium(ALUMINIUM)));
    for theta in [20.0, 45.0, 60.0, 75.0] {
        let c = Comparison::new(&metal, (theta, 30.0));
        println!("{theta}°: {:.3} %, bound {:.3} %", 100.0 * c.change().0, 100.0 * c.bound());
        assert!(c.change().0.abs() < c.bound());
        c.check_bound("metal roof");
    }
}
