//! Media known by name, each with its source.

use super::Dispersion;
use crate::optics::C64;

/// A medium known by name.
#[derive(Clone, Debug)]
pub struct Builtin {
    /// Names, the first being the usual one.
    pub names: &'static [&'static str],
    /// Where the numbers come from.
    pub source: &'static str,
    /// The numbers.
    pub dispersion: Dispersion,
}

/// Looks a medium up by name, ignoring case.
pub fn builtin(name: &str) -> Option<Builtin> {
    builtins().into_iter().find(|b| b.names.iter().any(|n| n.eq_ignore_ascii_case(name)))
}

/// All built-in media.
pub fn builtins() -> Vec<Builtin> {
    let sellmeier = |terms: &[(f64, f64)], range| Dispersion::Sellmeier { a: 0.0, terms: terms.to_vec(), range };
    vec![
        Builtin {
            names: &["air", "vacuum"],
            source: "n = 1 by definition of the surroundings",
            dispersion: Dispersion::Constant(C64::new(1.0, 0.0)),
        },
        Builtin {
            names: &["N-BK7", "BK7"],
            source: "Schott data sheet N-BK7 (Sellmeier)",
            dispersion: sellmeier(
                &[(1.039_612_12, 0.006_000_698_67), (0.231_792_344, 0.020_017_914_4), (1.010_469_45, 103.560_653)],
                (0.3, 2.5),
            ),
        },
        Builtin {
            names: &["fused silica", "silica", "SiO2"],
            source: "Malitson, J. Opt. Soc. Am. 55, 1205 (1965)",
            dispersion: sellmeier(
                &[
                    (0.696_166_3, 0.068_404_3 * 0.068_404_3),
                    (0.407_942_6, 0.116_241_4 * 0.116_241_4),
                    (0.897_479_4, 9.896_161 * 9.896_161),
                ],
                (0.21, 6.7),
            ),
        },
        Builtin {
            names: &["water"],
            source: "Daimon and Masumura, Appl. Opt. 46, 3811 (2007), 20 °C",
            dispersion: sellmeier(
                &[
                    (5.684_027_565e-1, 5.101_829_712e-3),
                    (1.726_177_391e-1, 1.821_153_936e-2),
                    (2.086_189_578e-2, 2.620_722_293e-2),
                    (1.130_748_688e-1, 10.697_927_21),
                ],
                (0.182, 1.129),
            ),
        },
        Builtin {
            names: &["cellulose"],
            source: "Sultanova, Kasarova and Nikolov, Acta Phys. Pol. A 116, 585 (2009)",
            dispersion: sellmeier(&[(1.124, 0.011_087)], (0.4368, 1.052)),
        },
        Builtin {
            names: &["keratin", "bird keratin"],
            source: "Leertouwer, Wilts and Stavenga, Opt. Express 19, 24061 (2011)",
            dispersion: Dispersion::Cauchy { a: 1.532, b: 5.89e3 },
        },
        Builtin {
            names: &["chitin", "butterfly chitin"],
            source: "Leertouwer, Wilts and Stavenga, Opt. Express 19, 24061 (2011)",
            dispersion: Dispersion::Cauchy { a: 1.517, b: 8.80e3 },
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published values at 450, 550, 589 and 650 nm.
    #[test]
    fn indices_match_published_values() {
        let cases = [
            ("N-BK7", [1.525320, 1.518522, 1.516740, 1.514520]),
            ("silica", [1.465566, 1.459911, 1.458413, 1.456535]),
            ("cellulose", [1.479562, 1.471993, 1.470070, 1.467750]),
            ("water", [1.339608, 1.334683, 1.333358, 1.331667]),
        ];
        for (name, truth) in cases {
            let medium = builtin(name).unwrap().dispersion;
            for (l, n) in [0.45, 0.55, 0.589, 0.65].into_iter().zip(truth) {
                assert!((medium.index(l).unwrap().re - n).abs() < 1e-6, "{name} at {l}");
            }
        }
        let keratin = builtin("Keratin").unwrap().dispersion;
        assert!((keratin.index(0.4).unwrap().re - 1.569).abs() < 5e-4);
        assert!(builtin("N-BK7").unwrap().dispersion.index(0.2).is_err());
        assert!(builtin("unobtainium").is_none());
    }
}
