//! What is varied: one knob at a time, from the settings of the user.

use super::super::Settings;
use crate::intersect::choose::Backend;
use crate::light::{Light, SourceMode, Wavelengths};
use crate::plan::{Edges, Limits, Name, Plan, Probe, Wanted};
use crate::units::significant;

/// A way to measure.
#[derive(Clone, Debug)]
pub struct Rung {
    /// What is varied.
    pub knob: &'static str,
    /// To what: an option of the command line, which begins with dashes, or words.
    pub setting: String,
    /// How it is measured then,
    pub settings: Settings,
    /// and by what light.
    pub light: Light,
}

/// The knob of the settings as they were given.
pub const BASE: &str = "as given";
/// The knob that is meant to show in a plot how errors fall.
pub const TREES: &str = "trees";

/// All rungs, the settings as given first. `plan` is theirs.
pub fn rungs(settings: &Settings, light: &Light, plan: &Plan) -> Vec<Rung> {
    let base = Builder { settings, light };
    let mut all = vec![base.rung(BASE, format!("--trees {}", settings.trees), |_| {})];
    for factor in [1.0 / 64.0, 1.0 / 16.0, 0.25, 4.0] {
        let trees = ((settings.trees as f64 * factor) as u64).max(64);
        all.push(base.rung(TREES, format!("--trees {trees}"), |s| s.trees = trees));
    }
    for level in (1..=settings.dome_level + 1).filter(|&l| l != settings.dome_level) {
        all.push(base.rung("dome level", format!("--dome-level {level}"), |s| s.dome_level = level));
    }
    for rung in [2, 4].into_iter().filter_map(|step| base.fewer_wavelengths(step)) {
        if all.last().is_none_or(|last| last.setting != rung.setting) {
            all.push(rung);
        }
    }
    for depth in [4, 16, 64, 256] {
        all.push(base.rung("depth", format!("--depth {depth}"), |s| s.options.limits.depth = depth));
    }
    for share in [0.0, 1e-3, 1e-1] {
        let name = if share > 0.0 { format!("shares below {share}") } else { "none".into() };
        all.push(base.rung("beams by lot", name, |s| s.options.limits.least_share = share));
    }
    let found = plan.limits.splits;
    for splits in [0, 1, 2, 3, 4].into_iter().filter(|&n| found != Some(n)) {
        all.push(base.rung("splits", format!("{splits} interfaces"), |s| s.options.limits.splits = Some(splits)));
    }
    if plan.has(Name::Dispersion) {
        for factor in [0.0, 4.0] {
            let spread = factor * Limits::spread_for(settings.dome_level);
            all.push(base.rung("bundles", format!("--spread {}", significant(spread.to_degrees(), 2)), |s| {
                s.options.limits.spread = spread
            }));
        }
    }
    if plan.has(Name::Interference) {
        all.push(base.rung("film search", "--probe refracted".into(), |s| s.options.probe = Probe::Refracted));
        all.push(base.rung("film search", "--edges reject".into(), |s| s.options.edges = Edges::Reject));
        let line = Rung {
            light: Light { source: SourceMode::Line, ..light.clone() },
            ..base.rung("coherence", "--source-mode line".into(), |_| {})
        };
        all.push(line);
    }
    all.extend(base.effects(plan));
    for backend in Backend::available().into_iter().filter(|&b| b != settings.backend && b != Backend::Brute) {
        all.push(base.rung("backend", format!("--backend {backend}"), |s| s.backend = backend));
    }
    all
}

struct Builder<'a> {
    settings: &'a Settings,
    light: &'a Light,
}

impl Builder<'_> {
    fn rung(&self, knob: &'static str, setting: String, change: impl FnOnce(&mut Settings)) -> Rung {
        let mut settings = self.settings.clone();
        change(&mut settings);
        Rung { knob, setting, settings, light: self.light.clone() }
    }

    /// Every `step`th wavelength, and the last; none if that leaves fewer than two.
    fn fewer_wavelengths(&self, step: usize) -> Option<Rung> {
        let all = self.light.wavelengths.nm();
        let last = all.len() - 1;
        let nm: Vec<f64> = (0..all.len()).filter(|i| i % step == 0 || *i == last).map(|i| all[i]).collect();
        if nm.len() < 2 || nm.len() == all.len() {
            return None;
        }
        let setting = format!("{} of {}", nm.len(), all.len());
        let light = Light { wavelengths: Wavelengths::from_nm(nm).ok()?, ..self.light.clone() };
        Some(Rung { light, ..self.rung("wavelengths", setting, |_| {}) })
    }

    /// Each effect switched over that people may switch, and all of them on.
    fn effects(&self, plan: &Plan) -> Vec<Rung> {
        let wanted = self.settings.options.wanted;
        let switchable = plan.effects.iter().filter(|e| e.name.is_for_hands());
        let mut rungs: Vec<Rung> = switchable
            .map(|e| {
                let wanted = wanted.with(e.name, !e.on);
                self.rung("effects", format!("--effects {wanted}"), |s| s.options.wanted = wanted)
            })
            .collect();
        rungs.push(self.rung("effects", "--effects all".into(), |s| s.options.wanted = Wanted::ALL));
        rungs
    }
}
