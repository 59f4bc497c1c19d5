//! How a result came about, for the files that hold it.

use std::path::PathBuf;

use super::{Outcome, Settings};
use crate::light::Light;
use crate::output::{EffectUsed, Measured, Provenance, StackHits, UsedBackend, Validity};
use crate::sample::Sample;
use crate::trace::Stacks;

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

/// Media of a stack that are listed by name.
const MEDIA_LISTED: usize = 24;

impl Outcome {
    /// The result with its provenance.
    pub fn into_measured(self, sample: &Sample, light: &Light, settings: &Settings, origin: Origin) -> Measured {
        let Outcome { bsdf, plan, stacks, .. } = self;
        let doubtful = bsdf.incidences.iter().flat_map(|s| &s.ledger.doubtful);
        let smallest = plan.features.smallest().min(stacks.thinnest);
        let validity = Validity {
            // To a femtometre: what lies beyond is rounding.
            smallest_feature_um: smallest.is_finite().then(|| (smallest * 1e9).round() / 1e9),
            small_feature_flux: doubtful.map(|e| e.value).fold(0.0, f64::max),
        };
        let effect =
            |e: crate::plan::Effect| EffectUsed { name: e.name.into(), on: e.on, reason: e.reason, bound: e.bound };
        let provenance = Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            command: origin.command,
            seed: settings.seed,
            polarization: light.polarization.to_string(),
            source_mode: light.source.to_string(),
            sample_files: origin.files.iter().map(|f| f.display().to_string()).collect(),
            sample_sha256: origin.sha256,
            backend: UsedBackend { name: settings.backend.name().into(), version: settings.backend.version() },
            effects: plan.effects.into_iter().map(effect).collect(),
            validity,
            stacks: stack_hits(sample, &stacks),
        };
        Measured { bsdf, provenance }
    }
}

fn stack_hits(sample: &Sample, stacks: &Stacks) -> Vec<StackHits> {
    let name = |&medium: &u16| sample.media[usize::from(medium)].name.clone();
    let hits = |(media, &hits): (&Vec<u16>, &u64)| StackHits {
        layers: media.len(),
        media: media.iter().take(MEDIA_LISTED).map(name).collect(),
        hits,
    };
    stacks.hits.iter().map(hits).collect()
}
