//! Sine, cosine and exponential of several numbers at once, without a branch or a call.

use std::f64::consts::FRAC_2_PI;

use pulp::Simd;

use super::lanes::{Lanes, Number as _};

/// Largest |x| of [`sin_cos`].
pub const LARGEST: f64 = 1e5;

/// Sine and cosine, to one unit in the last place, for |x| ≤ [`LARGEST`].
///
/// Reduction to ±π/4 after Cody & Waite, with π/2 in parts of 33 and 53 bits; polynomials of fdlibm (`k_sin.c`,
/// `k_cos.c`, Sun Microsystems 1993).
#[inline(always)]
pub fn sin_cos<S: Simd>(x: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    const FIRST: f64 = 1.570_796_326_734_125_6;
    const REST: f64 = 6.077_100_506_506_192e-11;
    let (quarters, [odd, half]) = (x * FRAC_2_PI).quarter_turns();
    let near = x - quarters * FIRST;
    let correction = quarters * REST;
    let high = near - correction;
    let low = (near - high) - correction;
    let (sin, cos) = (kernel_sin(high, low), kernel_cos(high, low));
    let (a, b) = (odd.choose(cos, sin), odd.choose(sin, cos));
    (half.choose(-a, a), half.xor(odd).choose(-b, b))
}

/// c₀ + z (c₁ + z (…)).
#[inline(always)]
fn polynomial<S: Simd, const N: usize>(z: Lanes<S>, coefficients: [f64; N]) -> Lanes<S> {
    coefficients.iter().rev().skip(1).fold(z.number(coefficients[N - 1]), |sum, &c| z.number(c) + z * sum)
}

/// sin(x + y), |x| ≤ π/4, |y| ≪ |x|.
#[inline(always)]
fn kernel_sin<S: Simd>(x: Lanes<S>, y: Lanes<S>) -> Lanes<S> {
    let z = x * x;
    let cube = z * x;
    let rest = polynomial(
        z,
        [
            0.008_333_333_333_322_49,
            -0.000_198_412_698_298_579_5,
            2.755_731_370_707_006_8e-6,
            -2.505_076_025_340_686_3e-8,
            1.589_690_995_211_55e-10,
        ],
    );
    x - ((z * (y * 0.5 - cube * rest) - y) + cube * 0.166_666_666_666_666_32)
}

/// cos(x + y), |x| ≤ π/4, |y| ≪ |x|.
#[inline(always)]
fn kernel_cos<S: Simd>(x: Lanes<S>, y: Lanes<S>) -> Lanes<S> {
    let z = x * x;
    let rest = z * polynomial(
        z,
        [
            0.041_666_666_666_666_6,
            -0.001_388_888_888_887_411,
            2.480_158_728_947_673e-5,
            -2.755_731_435_139_066_3e-7,
            2.087_572_321_298_175e-9,
            -1.135_964_755_778_819_5e-11,
        ],
    );
    let one = x.number(1.0);
    let half = z * 0.5;
    let w = one - half;
    w + (((one - w) - half) + (z * rest - x * y))
}

/// A number −x ≤ 0 as −k ln 2 + r, and e^r − 1.
#[inline(always)]
fn split<S: Simd>(x: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    let k = (x * std::f64::consts::LOG2_E).round();
    let (high, low) = (x - k * LN2_HIGH, k * LN2_LOW);
    let r = high - low;
    let c = (high - r) - low;
    // fdlibm, `s_expm1.c`: a rational form of e^r − 1 in r²/2.
    let half = r * 0.5;
    let z = r * half;
    let q = polynomial(
        z,
        [
            1.0,
            -3.333_333_333_333_313e-2,
            1.587_301_587_254_814_6e-3,
            -7.936_507_578_674_88e-5,
            4.008_217_827_329_362e-6,
            -2.010_992_181_836_243_7e-7,
        ],
    );
    let t = x.number(3.0) - q * half;
    let e = z * (q - t).over(x.number(6.0) - r * t);
    (k, r - ((r * (e - c) - c) - z))
}

/// e^x − 1 for x ≤ 0, to about one unit in the last place.
#[inline(always)]
pub fn exp_m1_negative<S: Simd>(x: Lanes<S>) -> Lanes<S> {
    // e^−60 is lost beside 1.
    let (k, m) = split(x.max(x.number(-60.0)));
    let scale = k.power_of_two();
    scale * m + (scale - x.number(1.0))
}

/// e^−x for x ≥ 0, as a number near 1 and a power of two.
#[inline(always)]
pub fn exp_split<S: Simd>(x: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    // Beyond, the result is 0 in any scale.
    let (k, m) = split(-x.min(x.number(1e5)));
    (m + x.number(1.0), k)
}

#[cfg(test)]
mod tests {
    use super::super::lanes::WIDEST;
    use super::*;

    /// Applies a function to many numbers with the best registers there are, and with none.
    struct Apply<'a> {
        x: &'a [f64],
        out: [Vec<f64>; 2],
        function: Function,
    }

    enum Function {
        SinCos,
        ExpM1,
        Exp,
    }

    impl pulp::WithSimd for Apply<'_> {
        type Output = [Vec<f64>; 2];

        #[inline(always)]
        fn with_simd<S: Simd>(mut self, s: S) -> [Vec<f64>; 2] {
            for out in &mut self.out {
                out.resize(self.x.len(), 0.0);
            }
            for block in 0..self.x.len() / S::F64_LANES {
                let x = Lanes::load(s, self.x, block);
                let (a, b) = match self.function {
                    Function::SinCos => sin_cos(x),
                    Function::ExpM1 => (exp_m1_negative(x), x),
                    Function::Exp => {
                        let (m, k) = exp_split(-x);
                        (m * k.power_of_two(), x)
                    }
                };
                a.store(&mut self.out[0], block);
                b.store(&mut self.out[1], block);
            }
            self.out
        }
    }

    fn apply(function: fn() -> Function, x: &[f64]) -> [Vec<f64>; 2] {
        assert!(x.len().is_multiple_of(WIDEST));
        let work = || Apply { x, out: Default::default(), function: function() };
        let best = pulp::Arch::new().dispatch(work());
        let plain = pulp::WithSimd::with_simd(work(), pulp::Scalar);
        assert_eq!(best, plain, "all registers give the same bits");
        best
    }

    /// Distance in units of the last place of `b`.
    fn units(a: f64, b: f64) -> f64 {
        let place = f64::from_bits(b.abs().to_bits() + 1) - b.abs();
        ((a - b) / place).abs()
    }

    #[test]
    fn sine_and_cosine_are_those_of_the_library() {
        let numbers = (-1_000_000..1_000_000).flat_map(|i| {
            let t = f64::from(i) * 1e-6;
            [t, 110.0 * t, LARGEST * t, t * t * t * 1e-6]
        });
        let x: Vec<f64> = numbers.collect();
        let [sin, cos] = apply(|| Function::SinCos, &x);
        let worst = x.iter().zip(sin.iter().zip(&cos)).map(|(x, (s, c))| {
            let (sin, cos) = x.sin_cos();
            units(*s, sin).max(units(*c, cos))
        });
        let worst = worst.fold(0.0, f64::max);
        assert!(worst <= 1.0, "{worst} units in the last place");
    }

    #[test]
    fn sine_and_cosine_near_multiples_of_a_right_angle() {
        let multiples = (-60_000..60_000).map(|i| f64::from(i) * std::f64::consts::FRAC_PI_2);
        let x: Vec<f64> = multiples.flat_map(|x| [x, x * (1.0 + 1e-15), x * (1.0 - 1e-12)]).collect();
        let [sin, cos] = apply(|| Function::SinCos, &x);
        for (x, (s, c)) in x.iter().zip(sin.iter().zip(&cos)) {
            assert!((s - x.sin()).abs() <= 2e-16 && (c - x.cos()).abs() <= 2e-16, "{x}");
        }
    }

    #[test]
    fn exponentials_are_those_of_the_library() {
        let numbers = (0..200_000).flat_map(|i| {
            let t = -f64::from(i) / 200_000.0;
            [t, 40.0 * t, 700.0 * t, t * t * t * 1e-9]
        });
        let mut x: Vec<f64> = numbers.collect();
        x.extend([-0.0, -1e-300, -5e-324, -60.0, -1e3, -1e300, f64::NEG_INFINITY, -36.0]);
        let [small, _] = apply(|| Function::ExpM1, &x);
        let worst = x.iter().zip(&small).map(|(x, e)| units(*e, x.exp_m1())).fold(0.0, f64::max);
        assert!(worst <= 1.5, "e^x − 1: {worst} units in the last place");
        let moderate: Vec<f64> = x.iter().copied().filter(|x| *x > -700.0).chain([0.0; WIDEST]).collect();
        let moderate = &moderate[..moderate.len() / WIDEST * WIDEST];
        let [exp, _] = apply(|| Function::Exp, moderate);
        let worst = moderate.iter().zip(&exp).map(|(x, e)| units(*e, x.exp())).fold(0.0, f64::max);
        assert!(worst <= 1.5, "e^x: {worst} units in the last place");
    }
}
