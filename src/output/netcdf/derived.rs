//! Names in the file of what follows from a measurement.

use crate::dome::Precision;

/// Errors of the whole.
pub(super) const PRECISION: [(&str, &str); 6] = [
    ("error_above", "relative error of the BRDF over the dome, not exceeded by 95 of 100 measurements"),
    ("error_below", "relative error of the BTDF over the dome, not exceeded by 95 of 100 measurements"),
    ("error_reflected", "relative error of all reflected light, not exceeded by 95 of 100 measurements"),
    ("error_transmitted", "relative error of all transmitted light, not exceeded by 95 of 100 measurements"),
    ("error_whole", "the greatest of these, but for faint light"),
    ("error_worst_facet", "95 % error of the worst facet that has a hundredth of the brightest, relative"),
];

/// Ratios.
pub(super) const SHARES: [(&str, &str); 2] = [
    ("specular_share", "part of the reflected light in the mirror direction"),
    ("undeflected_share", "part of the transmitted light straight through"),
];

/// Colours.
pub(super) const COLOURS: [(&str, &str); 2] = [
    ("reflected_lab", "CIE L*, a*, b* of the reflected light, 2 degree observer, D65"),
    ("transmitted_lab", "CIE L*, a*, b* of the transmitted light, 2 degree observer, D65"),
];

/// The numbers that [`PRECISION`] names.
pub(super) fn precision_mut(p: &mut Precision) -> [&mut f64; 6] {
    [&mut p.above, &mut p.below, &mut p.reflected, &mut p.transmitted, &mut p.whole, &mut p.facet]
}
