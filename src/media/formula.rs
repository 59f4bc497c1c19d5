//! The dispersion formulas of refractiveindex.info, numbered as there.

/// n(λ) by one of nine formulas, valid between two wavelengths.
///
/// The numbers and the meaning of the coefficients are those of the database (Polyanskiy, Sci. Data 11, 94 (2024)); λ
/// is in µm, and coefficients left out at the end are 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    number: u8,
    coefficients: Vec<f64>,
    range: (f64, f64),
}

/// What there is to say of a formula.
struct Kind {
    name: &'static str,
    equation: &'static str,
    /// Numbers of coefficients that make sense.
    counts: &'static [usize],
}

const ODD_TO_11: &[usize] = &[1, 3, 5, 7, 9, 11];
const ODD_TO_17: &[usize] = &[1, 3, 5, 7, 9, 11, 13, 15, 17];

/// Formulas 1 to 9.
const KINDS: [Kind; 9] = [
    Kind {
        name: "Sellmeier",
        equation: "n² = 1 + C1 + Σ Ci λ²/(λ² − Cj²), (i, j) = (2, 3), (4, 5), ...",
        counts: ODD_TO_17,
    },
    Kind {
        name: "Sellmeier",
        equation: "n² = 1 + C1 + Σ Ci λ²/(λ² − Cj), (i, j) = (2, 3), (4, 5), ...",
        counts: ODD_TO_17,
    },
    Kind { name: "polynomial", equation: "n² = C1 + Σ Ci λ^Cj, (i, j) = (2, 3), (4, 5), ...", counts: ODD_TO_17 },
    Kind {
        name: "refractiveindex.info",
        equation: "n² = C1 + C2 λ^C3/(λ² − C4^C5) + C6 λ^C7/(λ² − C8^C9) + Σ Ci λ^Cj, (i, j) = (10, 11), (12, 13), ...",
        counts: &[1, 5, 9, 11, 13, 15, 17],
    },
    Kind { name: "Cauchy", equation: "n = C1 + Σ Ci λ^Cj, (i, j) = (2, 3), (4, 5), ...", counts: ODD_TO_11 },
    Kind {
        name: "gases", equation: "n = 1 + C1 + Σ Ci/(Cj − λ⁻²), (i, j) = (2, 3), (4, 5), ...", counts: ODD_TO_11
    },
    Kind {
        name: "Herzberger",
        equation: "n = C1 + C2 L + C3 L² + C4 λ² + C5 λ⁴ + C6 λ⁶, L = 1/(λ² − 0.028)",
        counts: &[1, 2, 3, 4, 5, 6],
    },
    Kind { name: "retro", equation: "(n² − 1)/(n² + 2) = C1 + C2 λ²/(λ² − C3) + C4 λ²", counts: &[3, 4] },
    Kind {
        name: "exotic", equation: "n² = C1 + C2/(λ² − C3) + C4 (λ − C5)/((λ − C5)² + C6)", counts: &[3, 6]
    },
];

impl Formula {
    /// Formula `number` (1 to 9) between two wavelengths in µm.
    ///
    /// # Errors
    /// What was expected: of the number, of how many coefficients there are, or of the range.
    pub fn new(number: u8, coefficients: Vec<f64>, range: (f64, f64)) -> Result<Self, String> {
        let Some(kind) = usize::from(number).checked_sub(1).and_then(|i| KINDS.get(i)) else {
            return Err(format!("formula {number}: expected one from 1 to 9"));
        };
        if !kind.counts.contains(&coefficients.len()) {
            let counts: Vec<String> = kind.counts.iter().map(usize::to_string).collect();
            let (found, counts) = (coefficients.len(), counts.join(", "));
            return Err(format!(
                "found {found} coefficients; formula {number} has {counts}; write 0 for a missing one"
            ));
        }
        let (low, high) = range;
        if !(low > 0.0 && low < high && high.is_finite()) {
            return Err(format!(
                "found a range of {low} to {high} µm; expected wavelengths greater than 0 that ascend"
            ));
        }
        Ok(Self { number, coefficients, range })
    }

    /// Range of validity, µm.
    pub fn range(&self) -> (f64, f64) {
        self.range
    }

    /// Its number, name, equation and coefficients, for people.
    pub fn description(&self) -> String {
        let Kind { name, equation, .. } = KINDS[usize::from(self.number) - 1];
        let coefficients: Vec<String> = self.coefficients.iter().map(f64::to_string).collect();
        let (number, coefficients) = (self.number, coefficients.join(", "));
        format!("formula {number} ({name}): {equation}; λ in µm, C1, C2, ... = {coefficients}")
    }

    /// n at a vacuum wavelength in µm; no number where the formula has none.
    pub fn n(&self, wavelength: f64) -> f64 {
        let (l, l2) = (wavelength, wavelength * wavelength);
        let c = |i: usize| self.coefficients.get(i - 1).copied().unwrap_or(0.0);
        // Σ of terms of two coefficients, the first of them number `first`.
        let pairs = |first: usize, term: &dyn Fn(f64, f64) -> f64| -> f64 {
            let rest = self.coefficients.get(first - 1..).unwrap_or_default();
            rest.chunks_exact(2).map(|pair| term(pair[0], pair[1])).sum()
        };
        match self.number {
            1 => (1.0 + c(1) + pairs(2, &|b, c| b * l2 / (l2 - c * c))).sqrt(),
            2 => (1.0 + c(1) + pairs(2, &|b, c| b * l2 / (l2 - c))).sqrt(),
            3 => (c(1) + pairs(2, &|b, p| b * l.powf(p))).sqrt(),
            4 => {
                let resonance = |b: f64, p: f64, c: f64, q: f64| match b {
                    // The pole of a term that is not there must not matter.
                    0.0 => 0.0,
                    b => b * l.powf(p) / (l2 - c.powf(q)),
                };
                let resonances = resonance(c(2), c(3), c(4), c(5)) + resonance(c(6), c(7), c(8), c(9));
                (c(1) + resonances + pairs(10, &|b, p| b * l.powf(p))).sqrt()
            }
            5 => c(1) + pairs(2, &|b, p| b * l.powf(p)),
            6 => 1.0 + c(1) + pairs(2, &|b, c| b / (c - 1.0 / l2)),
            7 => {
                let pole = 1.0 / (l2 - 0.028);
                c(1) + pole * (c(2) + pole * c(3)) + l2 * (c(4) + l2 * (c(5) + l2 * c(6)))
            }
            8 => {
                let r = c(1) + c(2) * l2 / (l2 - c(3)) + c(4) * l2;
                ((1.0 + 2.0 * r) / (1.0 - r)).sqrt()
            }
            _ => (c(1) + c(2) / (l2 - c(3)) + c(4) * (l - c(5)) / ((l - c(5)).powi(2) + c(6))).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_left_out_are_zero() {
        let n = |number, c: &[f64]| Formula::new(number, c.to_vec(), (0.3, 1.0)).unwrap().n(0.5);
        assert_eq!(n(7, &[1.5]), n(7, &[1.5, 0.0, 0.0, 0.0, 0.0, 0.0]));
        assert_eq!(n(8, &[0.2, 0.1, 0.01]), n(8, &[0.2, 0.1, 0.01, 0.0]));
        assert_eq!(n(9, &[2.5, 0.02, 0.03]), n(9, &[2.5, 0.02, 0.03, 0.0, 0.0, 1.0]));
        // A term that is not there has no pole either, though 1^0 would be that of λ = 1 µm.
        let devore = Formula::new(4, vec![5.913, 0.2441, 0.0, 0.0803, 1.0], (0.43, 1.53)).unwrap();
        assert!((devore.n(1.0) - (5.913_f64 + 0.2441 / (1.0 - 0.0803)).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn what_makes_no_formula_is_refused() {
        let wrong = |number, count, range| Formula::new(number, vec![1.5; count], range).unwrap_err();
        assert_eq!(wrong(0, 1, (0.3, 1.0)), "formula 0: expected one from 1 to 9");
        assert_eq!(wrong(10, 1, (0.3, 1.0)), "formula 10: expected one from 1 to 9");
        let counts = "found 4 coefficients; formula 5 has 1, 3, 5, 7, 9, 11; write 0 for a missing one";
        assert_eq!(wrong(5, 4, (0.3, 1.0)), counts);
        assert!(wrong(1, 0, (0.3, 1.0)).starts_with("found 0 coefficients"));
        assert!(wrong(1, 19, (0.3, 1.0)).starts_with("found 19 coefficients"));
        for range in [(1.0, 0.3), (0.5, 0.5), (0.0, 1.0), (-1.0, 1.0), (f64::NAN, 1.0), (0.3, f64::INFINITY)] {
            assert!(wrong(5, 1, range).contains("expected wavelengths greater than 0 that ascend"), "{range:?}");
        }
    }
}
