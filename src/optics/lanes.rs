//! Numbers of several wavelengths side by side in one register, real and complex.
//!
//! A thin layer over the crate `pulp`, which chooses the widest registers of the processor at run time (AVX-512,
//! AVX2, NEON, or none). No operation is fused with another, and no lane looks at its neighbours: every processor
//! gives the same bits, and a wavelength the same in any company.

use std::ops::{Add, Mul, Neg, Not, Sub};

use pulp::Simd;

/// Most numbers any processor holds side by side.
pub const WIDEST: usize = 8;

/// A real number, or several side by side: what holds for both is written once.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Mul<f64, Output = Self> + Neg<Output = Self>
{
    /// Quotient.
    fn over(self, other: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Size.
    fn abs(self) -> Self;
    /// Quotient, or 0 where there is nothing to divide by.
    fn share_of(self, whole: Self) -> Self;
}

/// The room that numbers of so many wavelengths need, so that whole registers can be read: one is read alone.
pub fn padded(wavelengths: usize) -> usize {
    if wavelengths == 1 { 1 } else { wavelengths.next_multiple_of(WIDEST) }
}

/// Real numbers.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Simd> {
    s: S,
    x: S::f64s,
}

/// Yes or no for each number.
#[derive(Clone, Copy, Debug)]
pub struct Mask<S: Simd> {
    s: S,
    m: S::m64s,
}

/// Complex numbers.
#[derive(Clone, Copy, Debug)]
pub struct Complex<S: Simd> {
    /// Real parts.
    pub re: Lanes<S>,
    /// Imaginary parts.
    pub im: Lanes<S>,
}

/// 2 to the power of the place.
const BITS: [f64; WIDEST] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0];

/// 1.5·2⁵²: adding it rounds to an integer, whose last bits then are those of the sum.
const ROUND: f64 = 6_755_399_441_055_744.0;

impl<S: Simd> Lanes<S> {
    /// The same number everywhere.
    #[inline(always)]
    pub fn splat(s: S, x: f64) -> Self {
        Self { s, x: s.splat_f64s(x) }
    }

    /// The numbers of block `block` of a list that is padded to [`WIDEST`].
    #[inline(always)]
    pub fn load(s: S, from: &[f64], block: usize) -> Self {
        Self { s, x: S::as_simd_f64s(from).0[block] }
    }

    /// Writes the numbers to block `block` of a list.
    #[inline(always)]
    pub fn store(self, to: &mut [f64], block: usize) {
        S::as_mut_simd_f64s(to).0[block] = self.x;
    }

    /// The numbers one by one; what the register does not hold is 0.
    #[inline(always)]
    pub fn to_array(self) -> [f64; WIDEST] {
        let mut out = [0.0; WIDEST];
        self.store(&mut out, 0);
        out
    }

    #[inline(always)]
    fn like(self, x: S::f64s) -> Self {
        Self { s: self.s, x }
    }

    /// This constant everywhere.
    #[inline(always)]
    pub fn number(self, x: f64) -> Self {
        Self::splat(self.s, x)
    }

    /// The larger; `other` where this is no number.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.gt(other).choose(self, other)
    }

    /// The smaller; `other` where this is no number.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        other.gt(self).choose(self, other)
    }

    /// Nearest integer, for sizes below 2⁵¹.
    #[inline(always)]
    pub fn round(self) -> Self {
        let shift = self.number(ROUND);
        (self + shift) - shift
    }

    /// Greater than.
    #[inline(always)]
    pub fn gt(self, other: Self) -> Mask<S> {
        Mask { s: self.s, m: self.s.greater_than_f64s(self.x, other.x) }
    }

    /// Equal to.
    #[inline(always)]
    pub fn eq(self, other: Self) -> Mask<S> {
        Mask { s: self.s, m: self.s.equal_f64s(self.x, other.x) }
    }

    #[inline(always)]
    fn bits(self) -> S::u64s {
        self.s.transmute_u64s_f64s(self.x)
    }

    #[inline(always)]
    fn from_bits(s: S, bits: S::u64s) -> Self {
        Self { s, x: s.transmute_f64s_u64s(bits) }
    }

    /// The nearest integer, for sizes below 2⁵¹, and whether its last bit and the one before are set.
    #[inline(always)]
    pub fn quarter_turns(self) -> (Self, [Mask<S>; 2]) {
        let s = self.s;
        let shifted = self + self.number(ROUND);
        let bit = |bit: u64| {
            let mask = s.splat_u64s(bit);
            Mask { s, m: s.equal_u64s(s.and_u64s(shifted.bits(), mask), mask) }
        };
        (shifted - self.number(ROUND), [bit(1), bit(2)])
    }

    /// 2^k for integers −1022 to 1023.
    #[inline(always)]
    pub fn power_of_two(self) -> Self {
        let s = self.s;
        let shifted = self + self.number(ROUND + 1023.0);
        let biased = s.and_u64s(shifted.bits(), s.splat_u64s(0x7ff));
        // No instruction set lacks the product that stands for a shift here.
        Self::from_bits(s, s.mul_u64s(biased, s.splat_u64s(1 << 52)))
    }
}

impl Number for f64 {
    #[inline(always)]
    fn over(self, other: Self) -> Self {
        self / other
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn share_of(self, whole: Self) -> Self {
        if whole > 0.0 { self / whole } else { 0.0 }
    }
}

impl<S: Simd> Number for Lanes<S> {
    #[inline(always)]
    fn over(self, other: Self) -> Self {
        self.like(self.s.div_f64s(self.x, other.x))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.like(self.s.sqrt_f64s(self.x))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.like(self.s.abs_f64s(self.x))
    }

    #[inline(always)]
    fn share_of(self, whole: Self) -> Self {
        let zero = self.number(0.0);
        whole.gt(zero).choose(self.over(whole), zero)
    }
}

impl<S: Simd> Mask<S> {
    /// A bit for each number, the first one lowest, here and in another mask.
    #[inline(always)]
    pub fn bits_with(self, other: Self) -> [u64; 2] {
        let s = self.s;
        let (bits, none) = (S::as_simd_f64s(&BITS).0[0], s.splat_f64s(0.0));
        let high = s.mul_f64s(bits, s.splat_f64s(f64::from(1 << WIDEST)));
        // Sums of different powers of two: exact.
        let sum = s.add_f64s(s.select_f64s(self.m, bits, none), s.select_f64s(other.m, high, none));
        let sum = s.reduce_sum_f64s(sum) as u64;
        [sum % (1 << WIDEST), sum >> WIDEST]
    }

    /// Takes from the first where true.
    #[inline(always)]
    pub fn choose(self, yes: Lanes<S>, no: Lanes<S>) -> Lanes<S> {
        yes.like(self.s.select_f64s(self.m, yes.x, no.x))
    }

    /// The same for complex numbers.
    #[inline(always)]
    pub fn choose_complex(self, yes: Complex<S>, no: Complex<S>) -> Complex<S> {
        Complex { re: self.choose(yes.re, no.re), im: self.choose(yes.im, no.im) }
    }

    /// Both.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self { s: self.s, m: self.s.and_m64s(self.m, other.m) }
    }

    /// One of them at least.
    #[inline(always)]
    pub fn or(self, other: Self) -> Self {
        Self { s: self.s, m: self.s.or_m64s(self.m, other.m) }
    }

    /// Either, not both.
    #[inline(always)]
    pub fn xor(self, other: Self) -> Self {
        Self { s: self.s, m: self.s.xor_m64s(self.m, other.m) }
    }

    /// True somewhere.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.s.first_true_m64s(self.m) < S::F64_LANES
    }

    /// True everywhere.
    #[inline(always)]
    pub fn all(self) -> bool {
        self.s.first_true_m64s(self.s.not_m64s(self.m)) >= S::F64_LANES
    }
}

impl<S: Simd> Not for Mask<S> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self { s: self.s, m: self.s.not_m64s(self.m) }
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.like(self.s.add_f64s(self.x, o.x))
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self.like(self.s.sub_f64s(self.x, o.x))
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.like(self.s.mul_f64s(self.x, o.x))
    }
}

impl<S: Simd> Mul<f64> for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: f64) -> Self {
        self * self.number(o)
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.like(self.s.neg_f64s(self.x))
    }
}

impl<S: Simd> Complex<S> {
    /// Of real numbers.
    #[inline(always)]
    pub fn real(re: Lanes<S>) -> Self {
        Self { re, im: re.number(0.0) }
    }

    /// The numbers of block `block` of two lists.
    #[inline(always)]
    pub fn load(s: S, re: &[f64], im: &[f64], block: usize) -> Self {
        Self { re: Lanes::load(s, re, block), im: Lanes::load(s, im, block) }
    }

    /// Times real numbers.
    #[inline(always)]
    pub fn times(self, x: Lanes<S>) -> Self {
        Self { re: self.re * x, im: self.im * x }
    }

    /// Square of the modulus.
    #[inline(always)]
    pub fn norm_sqr(self) -> Lanes<S> {
        self.re * self.re + self.im * self.im
    }

    /// Conjugate.
    #[inline(always)]
    pub fn conj(self) -> Self {
        Self { re: self.re, im: -self.im }
    }

    /// 1/z.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        let n = self.norm_sqr();
        Self { re: self.re.over(n), im: (-self.im).over(n) }
    }

    /// Quotient.
    #[inline(always)]
    pub fn over(self, o: Self) -> Self {
        let (n, p) = (o.norm_sqr(), self * o.conj());
        Self { re: p.re.over(n), im: p.im.over(n) }
    }

    /// Square root of numbers in the upper half-plane, in the upper half-plane, too: where [`super::outgoing_root`]
    /// says that the wave decays, or travels, away.
    #[inline(always)]
    pub fn outgoing_root(self) -> Self {
        let (a, b) = (self.re, self.im);
        let zero = a.number(0.0);
        let large = ((self.norm_sqr().sqrt() + a.abs()) * 0.5).sqrt();
        let small = b.over(large + large);
        let small = large.gt(zero).choose(small, zero);
        let forward = zero.gt(a);
        Self { re: forward.choose(small, large), im: forward.choose(large, small) }
    }
}

impl<S: Simd> Add for Complex<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { re: self.re + o.re, im: self.im + o.im }
    }
}

impl<S: Simd> Sub for Complex<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { re: self.re - o.re, im: self.im - o.im }
    }
}

impl<S: Simd> Mul for Complex<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self { re: self.re * o.re - self.im * o.im, im: self.re * o.im + self.im * o.re }
    }
}

impl<S: Simd> Neg for Complex<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { re: -self.re, im: -self.im }
    }
}
