//! Sine and cosine without a branch or a call, so that loops over lanes become vector code.

use std::f64::consts::FRAC_2_PI;

/// Largest |x| of [`sin_cos`].
pub const LARGEST: f64 = 1e5;

/// Sine and cosine, to one unit in the last place, for |x| ≤ [`LARGEST`]. No fused operations: every processor
/// gives the same bits.
///
/// Reduction to ±π/4 after Cody & Waite, with π/2 in parts of 33 and 53 bits; polynomials of fdlibm (`k_sin.c`,
/// `k_cos.c`, Sun Microsystems 1993).
#[inline(always)]
pub fn sin_cos(x: f64) -> (f64, f64) {
    const FIRST: f64 = 1.570_796_326_734_125_6;
    const REST: f64 = 6.077_100_506_506_192e-11;
    // Adding 1.5·2⁵² rounds to an integer, whose last bits then are those of the sum.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let shifted = x * FRAC_2_PI + ROUND;
    let quarters = shifted - ROUND;
    let near = x - quarters * FIRST;
    let correction = quarters * REST;
    let high = near - correction;
    let low = (near - high) - correction;
    let (sin, cos) = (kernel_sin(high, low), kernel_cos(high, low));
    let bits = shifted.to_bits();
    let (a, b) = if bits & 1 == 0 { (sin, cos) } else { (cos, sin) };
    let sign = |bits: u64| (bits & 2) << 62;
    (f64::from_bits(a.to_bits() ^ sign(bits)), f64::from_bits(b.to_bits() ^ sign(bits.wrapping_add(1))))
}

/// sin(x + y), |x| ≤ π/4, |y| ≪ |x|.
#[inline(always)]
fn kernel_sin(x: f64, y: f64) -> f64 {
    let z = x * x;
    let cube = z * x;
    let rest = 0.008_333_333_333_322_49
        + z * (-0.000_198_412_698_298_579_5
            + z * (2.755_731_370_707_006_8e-6 + z * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10)));
    x - ((z * (0.5 * y - cube * rest) - y) + cube * 0.166_666_666_666_666_32)
}

/// cos(x + y), |x| ≤ π/4, |y| ≪ |x|.
#[inline(always)]
fn kernel_cos(x: f64, y: f64) -> f64 {
    let z = x * x;
    let rest = z
        * (0.041_666_666_666_666_6
            + z * (-0.001_388_888_888_887_411
                + z * (2.480_158_728_947_673e-5
                    + z * (-2.755_731_435_139_066_3e-7
                        + z * (2.087_572_321_298_175e-9 - z * 1.135_964_755_778_819_5e-11)))));
    let half = 0.5 * z;
    let w = 1.0 - half;
    w + (((1.0 - w) - half) + (z * rest - x * y))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance in units of the last place of `b`.
    fn units(a: f64, b: f64) -> f64 {
        let place = f64::from_bits(b.abs().to_bits() + 1) - b.abs();
        ((a - b) / place).abs()
    }

    #[test]
    fn like_the_library() {
        let mut worst: f64 = 0.0;
        for i in -1_000_000..=1_000_000 {
            let t = f64::from(i) * 1e-6;
            for x in [t, 110.0 * t, LARGEST * t, t * t * t * 1e-6] {
                let ((s, c), (sin, cos)) = (sin_cos(x), x.sin_cos());
                worst = worst.max(units(s, sin)).max(units(c, cos));
            }
        }
        println!("worst: {worst} units in the last place");
        assert!(worst <= 1.0, "{worst}");
    }

    #[test]
    fn near_multiples_of_a_right_angle() {
        for i in -60_000..60_000 {
            let x = f64::from(i) * std::f64::consts::FRAC_PI_2;
            for x in [x, x * (1.0 + 1e-15), x * (1.0 - 1e-12)] {
                let ((s, c), (sin, cos)) = (sin_cos(x), x.sin_cos());
                assert!((s - sin).abs() <= 2e-16 && (c - cos).abs() <= 2e-16, "{x}");
            }
        }
    }
}
