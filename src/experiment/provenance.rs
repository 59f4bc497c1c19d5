//! How a result came about, for the files that hold it.

use std::path::PathBuf;

use super::sealed::{Key, key_of};
use super::{Outcome, Settings};
use crate::bsdf::Ledger;
use crate::dome::Estimate;
use crate::intersect::choose::Backend;
use crate::light::Light;
use crate::output::{EffectUsed, Measured, Provenance, StackHits, UsedBackend, Validity};
use crate::sample::Sample;
use crate::trace::{Met, Stacks};

/// Where a sample came from, and by which command it was measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// The command, without the options that cannot change the result.
    pub command: String,
    /// Files of the sample.
    pub files: Vec<PathBuf>,
    /// SHA-256 of their contents.
    pub sha256: String,
}

impl Origin {
    /// What a result depends on: the version of the program, who intersects, the command, and the files of the sample.
    pub fn key(&self, backend: Backend) -> Key {
        let version = env!("CARGO_PKG_VERSION");
        key_of(&[version, backend.name(), &backend.version(), &self.command, &self.sha256])
    }
}

/// Layers of a stack that are listed.
const LAYERS_LISTED: usize = 64;

impl Outcome {
    /// The result with its provenance.
    pub fn into_measured(self, sample: &Sample, light: &Light, settings: &Settings, origin: Origin) -> Measured {
        let Outcome { bsdf, plan, stacks, .. } = self;
        let backend = settings.backend.fit(&sample.primitives, sample.domain);
        let most = |entry: fn(&Ledger) -> &Vec<Estimate>| {
            bsdf.incidences.iter().flat_map(|s| entry(&s.ledger)).map(|e| e.value).fold(0.0, f64::max).min(1.0)
        };
        let smallest = plan.features.smallest().min(stacks.thinnest());
        let trees: u64 = bsdf.incidences.iter().map(|s| s.trees).sum();
        let validity = Validity {
            smallest_feature_um: smallest.is_finite().then(|| rounded(smallest)),
            small_feature_flux: most(|l| &l.doubtful),
            edge_flux: most(|l| &l.edge),
            edges: plan.films.edges.to_string(),
        };
        let effect = |e: crate::plan::Effect| EffectUsed {
            name: e.name.to_string(),
            on: e.on,
            reason: e.reason,
            bound: e.bound,
        };
        let provenance = Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            command: origin.command,
            seed: settings.seed,
            polarization: light.polarization.to_string(),
            source_mode: light.source.to_string(),
            sample_files: origin.files.iter().map(|f| f.display().to_string()).collect(),
            sample_sha256: origin.sha256,
            backend: UsedBackend { name: backend.name().into(), version: backend.version() },
            effects: plan.effects.into_iter().map(effect).collect(),
            validity,
            stacks: stack_hits(sample, &stacks, trees),
            incomplete: None,
        };
        Measured { bsdf, provenance }
    }
}

/// To a femtometre: what lies beyond is rounding.
fn rounded(um: f64) -> f64 {
    (um * 1e9).round() / 1e9
}

/// Stacks, those that most of the light meets first.
fn stack_hits(sample: &Sample, stacks: &Stacks, trees: u64) -> Vec<StackHits> {
    let name = |&medium: &u16| sample.media[usize::from(medium)].name.clone();
    let hits = |(media, met): (&[u16], &Met)| StackHits {
        layers: media.len(),
        media: media.iter().take(LAYERS_LISTED).map(name).collect(),
        thickness_um: met.thickness.iter().take(LAYERS_LISTED).map(|t| [rounded(t.0), rounded(t.1)]).collect(),
        hits: met.hits,
        flux_share: met.power / trees as f64,
    };
    let mut all: Vec<StackHits> = stacks.iter().map(hits).collect();
    all.sort_by(|a, b| b.flux_share.total_cmp(&a.flux_share));
    all
}
