//! A virtual goniospectrophotometer.
//!
//! A **sample**'s microgeometry (meshes, spheres, cylinders, boxes, films) lies under a **light**. Rays wander
//! through it and carry power and polarization per wavelength; thin multilayers are found in the geometry and solved
//! analytically; a geodesic **dome** catches what leaves above and below; the result is a spectral **BSDF** with
//! standard errors and an energy ledger. After Schramm, Gondek and Meyer, *Light Scattering Simulations using Complex
//! Subsurface Models* (Graphics Interface 1997).
//!
//! The modules are the rooms of the instrument; data walks through them once, left to right, and no room knows
//! anything of those to its right:
//!
//! ```text
//! sample::Description ─► Sample ─┐
//!                                ├─► Plan ─► trace ─Exit─► dome ─► Bsdf ─► output, plot
//!                 light::Light ──┘            │  └ intersect ─ geometry
//!                                             └ optics
//! ```
//!
//! [`films`] is a side room: stacks by themselves, solved without a sample. [`jobs`] is another: many measurements, written down.
//!
//! [`experiment::measure`] walks the whole way:
//!
//! ```
//! use gonio_embree::experiment::{Settings, measure};
//! use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
//! use gonio_embree::sample::{Description, Sample};
//!
//! let light = Light {
//!     wavelengths: Wavelengths::from_nm(vec![450.0, 550.0, 650.0])?,
//!     incidences: vec![Incidence { theta_deg: 30.0, phi_deg: 0.0 }],
//!     polarization: Polarization::Unpolarized,
//!     source: SourceMode::Line,
//! };
//! let description = Description::from_toml("assets/samples/morpho.toml".as_ref())?;
//! let sample = Sample::new(&description, &light.wavelengths, light.coherence())?;
//! let outcome = measure(&sample, &light, &Settings { trees: 1000, ..Settings::default() }, |_| {})?;
//! let blue = outcome.bsdf.incidences[0].ledger.reflected[0];
//! assert!(blue.value > 0.9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//!
//! * Lengths are micrometres, wavelengths in vacuum included; angles are radians. A name with a unit (`_nm`, `_deg`)
//!   is in that unit. People read and type nm, µm, mm and degrees.
//! * Fields go like exp(i(**k**·**r** − ωt)); the index is n + ik, and k > 0 absorbs. p̂ = ŝ × k̂ for the incident,
//!   the reflected and the transmitted wave alike, so r_p = −r_s at normal incidence (Byrnes, arXiv:1603.02720).
//! * Amplitudes are power-normalised: |a|² is the power a wave carries through a plane parallel to the interface.
//! * +z is the outward normal of the sample; the light comes from z > 0. The incidence (θ, φ) points towards the
//!   source, the exit (θ, φ) where the light goes: reflection has θ < 90°, transmission θ > 90°.
//! * The value of the BRDF (BTDF) in a facet is the flux in it over the incident flux and ∫cos θ dω, in 1/sr. What
//!   leaves exactly in the mirror direction, or exactly straight on, is kept apart (`specular`, `undeflected`).
//! * reflected + transmitted + absorbed + side + lost = 1 for every incidence and wavelength; nothing is renormalised.
//! * All random numbers are a pure function of (seed, incidence, scramble, tree, branch, event): the same seed gives
//!   the same bytes for any number of threads.

pub mod bsdf;
pub mod colour;
pub mod dome;
pub mod experiment;
pub mod films;
pub mod geometry;
pub mod intersect;
pub mod jobs;
pub mod light;
pub mod media;
pub mod optics;
pub mod output;
pub mod plan;
pub mod plot;
pub mod sample;
pub mod text;
pub mod trace;
pub mod units;
