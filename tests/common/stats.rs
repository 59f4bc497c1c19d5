//! Distributions for tests: p-values from series and continued fractions.

/// ln Γ(x), Lanczos.
pub fn ln_gamma(x: f64) -> f64 {
    const C: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let t = x + 7.5;
    let sum = C[1..].iter().enumerate().fold(C[0], |s, (i, c)| s + c / (x + i as f64 + 1.0));
    0.5 * std::f64::consts::TAU.ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

/// Upper tail of the χ² distribution with `dof` degrees of freedom.
pub fn chi2_tail(chi2: f64, dof: f64) -> f64 {
    let (a, x) = (dof / 2.0, chi2 / 2.0);
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-16 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - front * sum;
    }
    // Lentz.
    let mut b = x + 1.0 - a;
    let mut c = 1e300;
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..1000 {
        let an = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        let delta = c * d;
        h *= delta;
        if (delta - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * h
}

/// Regularised incomplete beta function I_x(a, b).
pub fn beta_inc(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_inc(b, a, 1.0 - x);
    }
    let front = (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (1.0 - x).ln()).exp() / a;
    let (mut c, mut d) = (1.0, 1.0 / (1.0 - (a + b) * x / (a + 1.0)));
    let mut h = d;
    for i in 1..1000 {
        let m = f64::from(i);
        for numerator in [
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)),
        ] {
            d = 1.0 / (1.0 + numerator * d);
            c = 1.0 + numerator / c;
            h *= c * d;
        }
        if (c * d - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * h
}

/// Two-sided p-value of Student's t.
pub fn student_two_sided(t: f64, dof: f64) -> f64 {
    beta_inc(dof / 2.0, 0.5, dof / (dof + t * t))
}

/// Mean, squared standard error and degrees of freedom.
pub fn moments(x: &[f64]) -> (f64, f64, f64) {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    (mean, x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0) / n, n - 1.0)
}

/// Student's test that a sample has this mean: p-value.
pub fn student(x: &[f64], truth: f64) -> f64 {
    let (mean, variance, dof) = moments(x);
    student_two_sided((mean - truth) / variance.sqrt(), dof)
}

/// Welch's test that two samples have one mean: p-value.
pub fn welch(a: &[f64], b: &[f64]) -> f64 {
    let ((ma, va, na), (mb, vb, nb)) = (moments(a), moments(b));
    let v = va + vb;
    student_two_sided((ma - mb) / v.sqrt(), v * v / (va * va / na + vb * vb / nb))
}

/// Upper tail of the F distribution.
pub fn f_tail(f: f64, d1: f64, d2: f64) -> f64 {
    beta_inc(d2 / 2.0, d1 / 2.0, d2 / (d2 + d1 * f))
}

/// Hotelling's T² test that the rows of `samples` have mean `truth`: p-value. There must be more rows than
/// columns.
pub fn hotelling(samples: &[Vec<f64>], truth: &[f64]) -> f64 {
    let (n, k) = (samples.len() as f64, truth.len());
    assert!(samples.len() > k + 1);
    let mean: Vec<f64> = (0..k).map(|j| samples.iter().map(|s| s[j]).sum::<f64>() / n).collect();
    let mut cov = vec![vec![0.0; k]; k];
    for s in samples {
        for i in 0..k {
            for j in 0..k {
                cov[i][j] += (s[i] - mean[i]) * (s[j] - mean[j]) / (n - 1.0);
            }
        }
    }
    let d: Vec<f64> = mean.iter().zip(truth).map(|(m, t)| m - t).collect();
    let x = solve(cov, d.clone());
    let t2 = n * d.iter().zip(&x).map(|(a, b)| a * b).sum::<f64>();
    let k = k as f64;
    f_tail(t2 * (n - k) / (k * (n - 1.0)), k, n - k)
}

/// Solves a symmetric positive definite system by Cholesky.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for i in 0..n {
        for j in 0..=i {
            let s = a[i][j] - (0..j).map(|k| a[i][k] * a[j][k]).sum::<f64>();
            a[i][j] = if i == j { s.sqrt() } else { s / a[j][j] };
        }
    }
    for i in 0..n {
        b[i] = (b[i] - (0..i).map(|k| a[i][k] * b[k]).sum::<f64>()) / a[i][i];
    }
    for i in (0..n).rev() {
        b[i] = (b[i] - (i + 1..n).map(|k| a[k][i] * b[k]).sum::<f64>()) / a[i][i];
    }
    b
}

#[test]
fn tails_have_tabulated_values() {
    assert!((chi2_tail(18.307, 10.0) - 0.05).abs() < 1e-5);
    assert!((chi2_tail(2.0, 2.0) - (-1f64).exp()).abs() < 1e-12);
    assert!((student_two_sided(2.0423, 30.0) - 0.05).abs() < 1e-5);
    assert!((f_tail(2.9782, 10.0, 10.0) - 0.05).abs() < 1e-5);
}
