//! Media at the traced wavelengths, and single interfaces between them.

use super::beams::Beams;
use crate::optics::batch::Spectrum;
use crate::optics::field::{Field, Passage};
use crate::optics::fresnel::{self, Dielectric};
use crate::optics::{C64, Coefficients, Pair};
use crate::plan::Plan;
use crate::sample::{MediumId, MediumTable};

/// Index of every medium at every lane.
pub struct Media {
    wavelengths: Vec<f64>,
    /// The same numbers as `index`, for the solver of films.
    spectra: Vec<Spectrum>,
    /// All lanes of the first medium, then all of the second, and so on.
    index: Vec<C64>,
    properties: Vec<Properties>,
}

/// What holds for a medium at all lanes.
#[derive(Clone, Copy)]
struct Properties {
    opaque: bool,
    varies: bool,
    absorbs: bool,
}

/// How a ray is bent: index before over index behind, and cosine of the angle of refraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refraction {
    /// n₁/n₂.
    pub ratio: f64,
    /// cos θ₂.
    pub cos: f64,
}

/// Direction of a ray towards an interface: cosine and sine of the angle of incidence.
#[derive(Clone, Copy, Debug)]
pub struct Slant {
    /// cos θ₁.
    pub cos: f64,
    /// sin θ₁.
    pub sin: f64,
}

impl Media {
    /// The media of a plan at its lanes; `wavelengths` (µm) are those of the light.
    pub fn new(plan: &Plan, wavelengths: &[f64]) -> Self {
        let lanes = &plan.lanes;
        let media = &plan.media;
        let spectra: Vec<Spectrum> = media.iter().map(|m| lanes.iter().map(|&w| m.index[w]).collect()).collect();
        let properties = |(m, s): (&MediumTable, &Spectrum)| Properties {
            opaque: m.is_opaque(),
            varies: (0..s.len()).any(|lane| s.at(lane) != s.at(0)),
            absorbs: (0..s.len()).any(|lane| s.at(lane).im > 0.0),
        };
        Self {
            wavelengths: lanes.iter().map(|&w| wavelengths[w]).collect(),
            index: spectra.iter().flat_map(|s| (0..s.len()).map(|lane| s.at(lane))).collect(),
            properties: media.iter().zip(&spectra).map(properties).collect(),
            spectra,
        }
    }

    /// Number of lanes.
    pub fn lanes(&self) -> usize {
        self.wavelengths.len()
    }

    /// Vacuum wavelengths by lane, µm.
    pub fn wavelengths(&self) -> &[f64] {
        &self.wavelengths
    }

    /// Complex index by medium.
    pub fn spectra(&self) -> &[Spectrum] {
        &self.spectra
    }

    /// 2π over the vacuum wavelength of a lane, 1/µm.
    #[inline]
    pub fn wave_number(&self, lane: u16) -> f64 {
        std::f64::consts::TAU / self.wavelengths[usize::from(lane)]
    }

    /// Index of a medium at a lane.
    #[inline]
    pub fn index(&self, medium: MediumId, lane: u16) -> C64 {
        self.index[usize::from(medium.0) * self.wavelengths.len() + usize::from(lane)]
    }

    /// Whether rays end in a medium.
    #[inline]
    pub fn is_opaque(&self, medium: MediumId) -> bool {
        self.properties[usize::from(medium.0)].opaque
    }

    /// Whether a medium absorbs at some lane.
    #[inline]
    pub fn absorbs(&self, medium: MediumId) -> bool {
        self.properties[usize::from(medium.0)].absorbs
    }

    /// Whether an interface is not the same for all lanes.
    pub fn varies(&self, first: MediumId, last: MediumId) -> bool {
        [first, last].iter().any(|m| self.properties[usize::from(m.0)].varies)
    }

    /// How a ray is bent; `None` in total reflection and where rays end.
    pub fn refraction(&self, first: MediumId, last: MediumId, lane: u16, slant: Slant) -> Option<Refraction> {
        if self.is_opaque(last) {
            return None;
        }
        let (n1, n2) = (self.index(first, lane).re, self.index(last, lane).re);
        fresnel::refracted_cos(n1, n2, slant.cos, slant.sin).map(|cos| Refraction { ratio: n1 / n2, cos })
    }

    /// A single interface at one lane, with its [refraction](Self::refraction).
    #[inline(always)]
    pub fn interface<F: Field>(
        &self,
        first: MediumId,
        last: MediumId,
        lane: u16,
        slant: Slant,
    ) -> (Beams<F::Passage>, Option<Refraction>) {
        let (n1, n2) = (self.index(first, lane), self.index(last, lane));
        if n1.im != 0.0 || n2.im != 0.0 {
            let c = self.absorbing_interface(n1, n2, slant, self.is_opaque(last));
            return (Beams::new(&c), self.refraction(first, last, lane, slant));
        }
        let d = fresnel::dielectric(n1.re, n2.re, slant.cos, slant.sin);
        let reflected = F::Passage::reflection(&d);
        match d {
            Dielectric::Partial(t) => {
                let transmitted = F::Passage::transmission(&t);
                (Beams { reflected, transmitted }, Some(Refraction { ratio: t.ratio, cos: t.cos }))
            }
            Dielectric::Total(_) => (Beams { reflected, transmitted: reflected }, None),
        }
    }

    #[cold]
    fn absorbing_interface(&self, n1: C64, n2: C64, slant: Slant, opaque: bool) -> Coefficients {
        if opaque {
            let r = fresnel::into_complex(n1.re, n2, slant.cos, slant.sin);
            return Coefficients { r, t: Pair { s: C64::ZERO, p: C64::ZERO } };
        }
        fresnel::weakly_absorbing(n1, n2, slant.cos, slant.sin)
    }
}
