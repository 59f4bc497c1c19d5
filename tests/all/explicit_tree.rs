//! The self-test of coherence: all paths through a stack of films, each with its own amplitude and phase, add up to what
//! the film solver says.

use std::f64::consts::TAU;

use crate::common::build::{Build, light};
use crate::common::listen::{Heard, coherent_sum, listen_to};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Light, Polarization, SourceMode};
use gonio_embree::optics::C64;
use gonio_embree::optics::field::Jones;
use gonio_embree::optics::film::{Incidence, Layer, solve};
use gonio_embree::plan::stacks::Marks;
use gonio_embree::plan::{Limits, Name, Options, Plan, Wanted};
use gonio_embree::sample::Sample;
use gonio_embree::trace::TreeKey;

const NM: [f64; 2] = [450.0, 633.0];

/// A stack: index above, (index, thickness in µm) from the top, index below.
struct Stack<'a> {
    above: f64,
    layers: &'a [(f64, f64)],
    below: f64,
}

impl Stack<'_> {
    /// r and t of the solver, t referred to the wavefront through the point of entry as if the medium below began there.
    fn solved(&self, light: &Light, nm: f64) -> [C64; 2] {
        let theta = light.incidences[0].theta_deg.to_radians();
        let layer = |&(n, thickness): &(f64, f64)| Layer { index: n.into(), thickness };
        let layers: Vec<Layer> = self.layers.iter().map(layer).collect();
        let both = solve(&Incidence::from_cos(self.above, theta.cos()), &layers, self.below.into(), nm / 1e3);
        let exact = if light.polarization == Polarization::S { both.s } else { both.p };
        let depth: f64 = layers.iter().map(|l| l.thickness).sum();
        let kx = self.above * theta.sin();
        let kz = ((self.below - kx) * (self.below + kx)).sqrt();
        [exact.r, exact.t_power() * C64::cis(-TAU / (nm / 1e3) * kz * depth)]
    }
}

/// Every path of an amplitude above 1e-14: what is left out adds up to less than 1e-9.
fn enumerate(sample: &Sample, light: &Light) -> Heard<Jones> {
    let limits = Limits::whole_trees(1e-28);
    let mut plan = Plan::new(
        sample,
        light,
        &Options { limits, wanted: Wanted::AUTO.with(Name::Phase, true), ..Options::default() },
    );
    plan.marks = Marks::default();
    let entry = ([0.3, 0.6], TreeKey { key: 1, first: [0.5; 2] });
    listen_to(&plan, sample, light, Backend::Auto, &vec![entry])
}

fn check(stack: &Stack<'_>) {
    for theta in [0.0, 25.0, 50.0] {
        for polarization in [Polarization::S, Polarization::P] {
            let light = Light { source: SourceMode::Line, ..light(&NM, &[(theta, 30.0)], polarization) };
            let sample = Build::within(stack.above).below(stack.below).films(0.7, stack.layers).sample(&light);
            let heard = enumerate(&sample, &light);
            let up = coherent_sum(&heard, &sample, &light, true, stack.above);
            let down = coherent_sum(&heard, &sample, &light, false, stack.below);
            for (w, &nm) in NM.iter().enumerate() {
                let [r, t] = stack.solved(&light, nm);
                let at = format!("{} layers, {theta}°, {polarization}, {nm} nm", stack.layers.len());
                assert!((up[w] - r).norm() < 1e-9, "{at}: r {} for {r}", up[w]);
                assert!((down[w] - t).norm() < 1e-9, "{at}: t {} for {t}", down[w]);
            }
        }
    }
}

#[test]
fn all_paths_add_up_to_the_film() {
    let check = |above, layers: &[(f64, f64)], below| check(&Stack { above, layers, below });
    check(1.0, &[(1.5, 0.25)], 1.0);
    check(1.0, &[(2.0, 0.1)], 1.52);
    check(1.33, &[(1.5, 0.3), (1.4, 0.21)], 1.2);
    check(1.0, &[(1.2, 0.11), (1.35, 0.4), (1.25, 0.09)], 1.3);
    check(1.3, &[(1.37, 0.2), (1.32, 0.15), (1.38, 0.31), (1.34, 0.1)], 1.3);
}
