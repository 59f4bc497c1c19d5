//! Media known by name, each with its source and what is to be said of it.
//!
//! The files under `data` are of refractiveindex.info (public domain, CC0) as they are there.

use super::{Curve, Dispersion, Formula, refractiveindex};
use crate::optics::C64;

/// A medium known by name.
#[derive(Debug)]
pub struct Builtin {
    /// Names, the first being the usual one.
    pub names: &'static [&'static str],
    /// Who measured it.
    pub source: &'static str,
    /// Whether its numbers can be relied on.
    pub certainty: Certainty,
    /// What else is to be known of it.
    pub remark: &'static str,
    data: Data,
}

/// How much the numbers of a medium can be relied on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Certainty {
    /// All of them are as the source has them.
    Published,
    /// Some are not, or the source leaves a choice: which ones and why.
    Uncertain(&'static str),
}

/// Where the numbers are.
#[derive(Debug)]
enum Data {
    /// n = 1.
    Vacuum,
    /// A file of refractiveindex.info.
    Page(&'static str),
    /// n = a + b/λ², λ in µm, and k = p exp(−λ/q), q in µm, over [`BIOLOGICAL`].
    Biological { a: f64, b: f64, k: Option<(f64, f64)> },
}

/// Range of the formulas of biological media, µm: a little more than what the eye sees.
const BIOLOGICAL: (f64, f64) = (0.35, 0.85);

impl Builtin {
    /// Its index over wavelength.
    pub fn dispersion(&self) -> Dispersion {
        match self.data {
            Data::Vacuum => Dispersion::Constant(C64::new(1.0, 0.0)),
            Data::Page(text) => refractiveindex::parse(text).expect("built-in files are tested").dispersion,
            Data::Biological { a, b, k } => {
                let cauchy = Formula::new(5, vec![a, b, -2.0], BIOLOGICAL).expect("a formula of three coefficients");
                let k = k.map_or(Curve::Constant(0.0), |(a, b)| Curve::Exponential { a, b, range: BIOLOGICAL });
                Dispersion::Curves { n: Curve::Formula(cauchy), k }
            }
        }
    }
}

/// Looks a medium up by name, ignoring case.
pub fn builtin(name: &str) -> Option<&'static Builtin> {
    BUILTINS.iter().find(|b| b.names.iter().any(|n| n.eq_ignore_ascii_case(name)))
}

/// All built-in media.
pub fn builtins() -> &'static [Builtin] {
    BUILTINS
}

/// What is said of uniaxial crystals.
const ORDINARY: &str = "Electric field perpendicular to the axis. Here a medium has one index for all light.";
const EXTRAORDINARY: &str = "Electric field along the axis. Here a medium has one index for all light.";

/// What is said of the coefficients of Leertouwer and others.
const FITTED: Certainty = Certainty::Uncertain(
    "The two coefficients are published, and so are n at 400, 500 and 600 nm, which they give to the last digit; \
     beyond, to 350 and 850 nm, the formula is continued. k is taken as 0: towards the ultraviolet it is not.",
);

static BUILTINS: &[Builtin] = &[
    Builtin {
        names: &["air", "vacuum"],
        source: "n = 1 by definition of the surroundings",
        certainty: Certainty::Published,
        remark: "Wavelengths are those in vacuum; air itself has n = 1.0003.",
        data: Data::Vacuum,
    },
    Builtin {
        names: &["N-BK7", "BK7"],
        source: "SCHOTT Zemax catalog 2017-01-20b",
        certainty: Certainty::Published,
        remark: "",
        data: Data::Page(include_str!("data/N-BK7.yml")),
    },
    Builtin {
        names: &["fused silica", "silica", "SiO2"],
        source: "Malitson, J. Opt. Soc. Am. 55, 1205 (1965)",
        certainty: Certainty::Published,
        remark: "The formula is of 0.21 to 3.71 µm; Tan, J. Non-Cryst. Solids 223, 158 (1998) found it good up to 6.7 \
                 µm. k is taken as 0, which it is not beyond 3.5 µm.",
        data: Data::Page(include_str!("data/SiO2-Malitson.yml")),
    },
    Builtin {
        names: &["water", "H2O"],
        source: "Daimon and Masumura, Appl. Opt. 46, 3811 (2007)",
        certainty: Certainty::Published,
        remark: "At 20 °C. k is taken as 0; Hale and Querry, Appl. Opt. 12, 555 (1973) have 2e-9 at 550 nm, 3e-8 at \
                 700 nm and 3e-6 at 1 µm.",
        data: Data::Page(include_str!("data/H2O-Daimon.yml")),
    },
    Builtin {
        names: &["cellulose"],
        source: "Sultanova, Kasarova and Nikolov, Acta Phys. Pol. A 116, 585 (2009)",
        certainty: Certainty::Uncertain(
            "The measurements are published; the formula is a fit to them by refractiveindex.info. The sample was an \
             optical plastic: fibres of plants are birefringent, and n differs in the second decimal. k is taken as 0.",
        ),
        remark: "At 20 °C.",
        data: Data::Page(include_str!("data/cellulose-Sultanova.yml")),
    },
    Builtin {
        names: &["calcite-o", "calcite o", "CaCO3-o"],
        source: "Ghosh, Opt. Commun. 163, 95 (1999)",
        certainty: Certainty::Published,
        remark: ORDINARY,
        data: Data::Page(include_str!("data/CaCO3-Ghosh-o.yml")),
    },
    Builtin {
        names: &["calcite-e", "calcite e", "CaCO3-e"],
        source: "Ghosh, Opt. Commun. 163, 95 (1999)",
        certainty: Certainty::Published,
        remark: EXTRAORDINARY,
        data: Data::Page(include_str!("data/CaCO3-Ghosh-e.yml")),
    },
    Builtin {
        names: &["rutile-o", "rutile o", "TiO2-o"],
        source: "Devore, J. Opt. Soc. Am. 41, 416 (1951)",
        certainty: Certainty::Published,
        remark: ORDINARY,
        data: Data::Page(include_str!("data/TiO2-Devore-o.yml")),
    },
    Builtin {
        names: &["rutile-e", "rutile e", "TiO2-e"],
        source: "Devore, J. Opt. Soc. Am. 41, 416 (1951)",
        certainty: Certainty::Published,
        remark: EXTRAORDINARY,
        data: Data::Page(include_str!("data/TiO2-Devore-e.yml")),
    },
    Builtin {
        names: &["Al", "aluminium", "aluminum"],
        source: "Rakić, Appl. Opt. 34, 4755 (1995)",
        certainty: Certainty::Published,
        remark: "Evaporated films, from many measurements made consistent.",
        data: Data::Page(include_str!("data/Al-Rakic.yml")),
    },
    Builtin {
        names: &["Ag", "silver"],
        source: "Johnson and Christy, Phys. Rev. B 6, 4370 (1972)",
        certainty: Certainty::Uncertain(
            "The table is published, but n is printed with two decimals and is 0.03 to 0.06 for visible light: rounding \
             alone changes what a mirror of silver absorbs by a tenth.",
        ),
        remark: "",
        data: Data::Page(include_str!("data/Ag-Johnson.yml")),
    },
    Builtin {
        names: &["Au", "gold"],
        source: "Johnson and Christy, Phys. Rev. B 6, 4370 (1972)",
        certainty: Certainty::Published,
        remark: "n has two decimals.",
        data: Data::Page(include_str!("data/Au-Johnson.yml")),
    },
    Builtin {
        names: &["keratin", "bird keratin"],
        source: "Leertouwer, Wilts and Stavenga, Opt. Express 19, 24061 (2011)",
        certainty: FITTED,
        remark: "Barbules of the white goose.",
        data: Data::Biological { a: 1.532, b: 5.89e-3, k: None },
    },
    Builtin {
        names: &["chitin", "butterfly chitin"],
        source: "Leertouwer, Wilts and Stavenga, Opt. Express 19, 24061 (2011)",
        certainty: FITTED,
        remark: "Glass scales of the butterfly Graphium sarpedon.",
        data: Data::Biological { a: 1.517, b: 8.8e-3, k: None },
    },
    Builtin {
        names: &["melanin"],
        source: "Stavenga, Leertouwer, Osorio and Wilts, Light Sci. Appl. 4, e243 (2015)",
        certainty: Certainty::Uncertain(
            "That n is 1.7 to 1.8 for visible light is published. The coefficients of n = 1.648 + 23700 nm²/λ² and of \
             k = 0.56 exp(−λ/270 nm) are from public models after Freyer and Stavenga, Faraday Discuss. 223, 49 \
             (2020), not from the papers themselves: check them before you build on them. k falls about exponentially, \
             but its size depends on how much pigment there is: from 0.03 to 0.14 has been fitted to layers of \
             beetles and damselflies. Outside of 400 to 700 nm both formulas are continued.",
        ),
        remark: "Feathers of birds.",
        data: Data::Biological { a: 1.648, b: 2.37e-2, k: Some((0.56, 0.27)) },
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Name, (wavelength in nm, n, k), and half of the last digit that is printed.
    type Published = (&'static str, &'static [(f64, f64, f64)], f64);

    const PUBLISHED: [Published; 15] = [
        ("air", &[(589.0, 1.0, 0.0)], 0.0),
        // Lines d, F' and e of the data sheet; k of the catalogue, between its lines.
        ("N-BK7", &[(587.5618, 1.5168, 9.75e-9), (479.9914, 1.52283, 9.93e-9), (546.074, 1.51872, 6.97e-9)], 6e-6),
        ("silica", &[(450.0, 1.465566, 0.0), (550.0, 1.459911, 0.0), (589.0, 1.458413, 0.0)], 6e-7),
        ("water", &[(450.0, 1.339608, 0.0), (550.0, 1.334683, 0.0), (589.0, 1.333358, 0.0)], 6e-7),
        ("cellulose", &[(450.0, 1.479562, 0.0), (550.0, 1.471993, 0.0), (650.0, 1.467750, 0.0)], 6e-7),
        ("calcite-o", &[(450.0, 1.672584, 0.0), (550.0, 1.661275, 0.0), (650.0, 1.654774, 0.0)], 6e-7),
        ("calcite-e", &[(450.0, 1.492808, 0.0), (550.0, 1.487496, 0.0), (650.0, 1.484493, 0.0)], 6e-7),
        ("rutile-o", &[(450.0, 2.812569, 0.0), (550.0, 2.647935, 0.0), (650.0, 2.574165, 0.0)], 6e-7),
        ("rutile-e", &[(450.0, 3.163462, 0.0), (550.0, 2.952873, 0.0), (650.0, 2.859940, 0.0)], 6e-7),
        ("Al", &[(442.8, 0.6079, 5.3676), (516.6, 0.8734, 6.2418), (563.57, 1.0728, 6.7839)], 1e-12),
        ("Ag", &[(450.9, 0.04, 2.657), (548.6, 0.06, 3.586), (659.5, 0.05, 4.483)], 1e-12),
        ("Au", &[(450.9, 1.38, 1.914), (520.9, 0.62, 2.081), (659.5, 0.14, 3.697)], 1e-12),
        // Of the abstract.
        ("keratin", &[(400.0, 1.569, 0.0), (500.0, 1.556, 0.0), (600.0, 1.548, 0.0)], 6e-4),
        ("chitin", &[(400.0, 1.572, 0.0), (500.0, 1.552, 0.0), (600.0, 1.541, 0.0)], 6e-4),
        // n of the abstract, for visible light; k is not published there.
        ("melanin", &[(400.0, 1.8, 0.127), (700.0, 1.7, 0.042)], 5e-3),
    ];

    #[test]
    fn indices_match_published_values() {
        for (name, values, tolerance) in PUBLISHED {
            let medium = builtin(name).unwrap().dispersion();
            for &(nm, n, k) in values {
                let found = medium.index(nm / 1e3).unwrap();
                assert!((found.re - n).abs() <= tolerance, "{name} at {nm} nm: {found}");
                assert!((found.im - k).abs() <= tolerance.min(0.01 * k), "{name} at {nm} nm: {found}");
            }
        }
        assert!(builtins().iter().all(|b| PUBLISHED.iter().any(|p| b.names.contains(&p.0))), "one is not tested");
    }

    #[test]
    fn every_name_is_of_one_medium() {
        let names: Vec<String> = builtins().iter().flat_map(|b| b.names).map(|n| n.to_lowercase()).collect();
        assert!(names.iter().enumerate().all(|(i, name)| !names[..i].contains(name)), "{names:?}");
        assert_eq!(builtin("fused SILICA").unwrap().names[0], "fused silica");
        assert!(builtin("unobtainium").is_none());
    }

    #[test]
    fn ranges_are_those_of_the_sources() {
        let range = |name: &str| builtin(name).unwrap().dispersion().range();
        assert_eq!(range("air"), (0.0, f64::INFINITY));
        assert_eq!(range("N-BK7"), (0.3, 2.5));
        assert_eq!(range("cellulose"), (0.4368, 1.052));
        assert_eq!(range("Ag"), (0.1879, 1.937));
        assert_eq!(range("melanin"), (0.35, 0.85));
        assert!(builtin("N-BK7").unwrap().dispersion().index(0.2).is_err());
    }
}
