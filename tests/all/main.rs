//! All integration tests, one module each: what they share is compiled once.
#![allow(missing_docs)]

#[path = "../common/mod.rs"]
mod common;
mod desk;

mod absorption;
mod accuracy;
mod backends;
mod brewster;
mod bsdf;
mod bundles;
mod checkpoints;
mod cli;
mod cli_accuracy;
mod cli_batch;
mod cli_film;
mod cli_materials;
mod cli_results;
mod closed_forms;
mod coherence;
mod compare;
mod determinism;
mod effects;
mod explicit_tree;
mod exports;
mod film_extremes;
mod film_losses;
mod film_peaks;
mod film_properties;
mod films;
mod films_in_place;
mod finder;
mod furnace;
mod guide;
mod hard_cases;
mod invariance;
mod invisible;
mod media;
mod mueller;
mod mueller_dome;
mod mueller_flat;
mod mueller_reciprocity;
mod paper_figures;
mod paper_samples;
mod polarization_plan;
mod polarization_trace;
mod reciprocity;
mod reliefs;
mod report;
mod samples;
mod scan;
