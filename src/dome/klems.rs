//! Divisions of a hemisphere into patches of about equal weight (J. H. Klems, *A New Method for Predicting the Solar Heat Gain
//! of Complex Fenestration Systems*, ASHRAE Transactions 100(1), 1994), as WINDOW and Radiance have them.

use std::f64::consts::PI;

use super::Patch;

/// Rings of a hemisphere: lower bound of the polar angle in degrees, and number of patches; the last ends at 90°.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// As files of LBNL WINDOW call it.
    pub name: &'static str,
    rings: &'static [(f64, u32)],
}

/// 145 patches.
pub const FULL: Basis = Basis {
    name: "LBNL/Klems Full",
    rings: &[(0.0, 1), (5.0, 8), (15.0, 16), (25.0, 20), (35.0, 24), (45.0, 24), (55.0, 24), (65.0, 16), (75.0, 12)],
};
/// 77 patches.
pub const HALF: Basis = Basis {
    name: "LBNL/Klems Half",
    rings: &[(0.0, 1), (6.5, 8), (19.5, 12), (32.5, 16), (45.5, 20), (58.5, 12), (71.5, 8)],
};
/// 41 patches.
pub const QUARTER: Basis =
    Basis { name: "LBNL/Klems Quarter", rings: &[(0.0, 1), (9.0, 8), (27.0, 12), (45.0, 12), (63.0, 8)] };

/// A ring of patches.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// Where it begins, degrees from the pole.
    pub lower: f64,
    /// Where it ends.
    pub upper: f64,
    /// How many patches.
    pub count: u32,
}

/// A patch, and the direction that stands for it, rad.
#[derive(Clone, Debug)]
pub struct Cell {
    /// The patch.
    pub patch: Patch,
    /// Polar angle of its middle; of the cap around the pole, the pole.
    pub theta: f64,
    /// Azimuth of its middle.
    pub phi: f64,
}

impl Basis {
    /// From the pole down.
    pub fn rings(&self) -> impl Iterator<Item = Ring> {
        let rings = self.rings;
        let upper = move |ring: usize| rings.get(ring + 1).map_or(90.0, |r| r.0);
        rings.iter().enumerate().map(move |(i, &(lower, count))| Ring { lower, upper: upper(i), count })
    }

    /// Ring by ring, by azimuth.
    pub fn cells(&self) -> Vec<Cell> {
        let cells = |ring: Ring| {
            let theta = [ring.lower, ring.upper].map(f64::to_radians);
            let step = 2.0 * PI / f64::from(ring.count);
            (0..ring.count).map(move |k| {
                let phi = f64::from(k) * step;
                let range = (ring.count > 1).then_some([phi - 0.5 * step, phi + 0.5 * step]);
                let middle = if ring.count > 1 { 0.5 * (theta[0] + theta[1]) } else { 0.0 };
                Cell { patch: Patch { theta, phi: range }, theta: middle, phi }
            })
        };
        self.rings().flat_map(cells).collect()
    }

    /// Polar angle and azimuth, degrees, of the sources whose light goes through the middle of each patch: the azimuths of
    /// a basis are those in which light goes.
    pub fn sources(&self) -> impl Iterator<Item = [f64; 2]> {
        self.rings().flat_map(|ring| {
            let theta = if ring.count > 1 { 0.5 * (ring.lower + ring.upper) } else { 0.0 };
            (0..ring.count).map(move |k| [theta, (360.0 * f64::from(k) / f64::from(ring.count) + 180.0) % 360.0])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_fill_the_hemisphere() {
        for (basis, count) in [(FULL, 145), (HALF, 77), (QUARTER, 41)] {
            let cells = basis.cells();
            let whole: f64 = cells.iter().map(|c| c.patch.projected_solid_angle()).sum();
            assert!(cells.len() == count && (whole - PI).abs() < 1e-12, "{basis:?}");
        }
    }

    #[test]
    fn light_comes_from_opposite_to_where_it_goes() {
        for basis in [FULL, HALF, QUARTER] {
            assert_eq!(basis.sources().count(), basis.cells().len());
            for ([theta, phi], cell) in basis.sources().zip(basis.cells()) {
                assert!((theta.to_radians() - cell.theta).abs() < 1e-12);
                assert!(((phi - 180.0).to_radians() - cell.phi).rem_euclid(2.0 * PI).sin().abs() < 1e-12);
            }
        }
    }
}
