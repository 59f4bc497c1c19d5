//! Distances between colours: CIELAB (ISO/CIE 11664-4) and CIEDE2000 (ISO/CIE 11664-6).

/// L*, a*, b* of X, Y, Z beside a white.
pub fn lab(xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    const EDGE: f64 = 6.0 / 29.0;
    let root = |t: f64| if t > EDGE.powi(3) { t.cbrt() } else { t / (3.0 * EDGE * EDGE) + 4.0 / 29.0 };
    let [x, y, z] = std::array::from_fn(|i| root(xyz[i] / white[i]));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Distance of two colours in CIELAB.
pub fn delta_e_76(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(p, q)| (p - q).powi(2)).sum::<f64>().sqrt()
}

/// CIEDE2000 of two colours in CIELAB, with weights of 1 (Sharma, Wu, Dalal, Color Res. Appl. 30, 21 (2005), eqs. 2 to 22).
pub fn delta_e_2000(one: [f64; 3], two: [f64; 3]) -> f64 {
    let chroma = |c: [f64; 3]| c[1].hypot(c[2]);
    let damped = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let g = 0.5 * (1.0 - damped(0.5 * (chroma(one) + chroma(two))));
    let polar = |c: [f64; 3]| {
        let a = (1.0 + g) * c[1];
        let hue = if a == 0.0 && c[2] == 0.0 { 0.0 } else { c[2].atan2(a).to_degrees().rem_euclid(360.0) };
        (a.hypot(c[2]), hue)
    };
    let ((c1, h1), (c2, h2)) = (polar(one), polar(two));
    let grey = c1 * c2 == 0.0;
    let turn = if grey { 0.0 } else { (h2 - h1 + 180.0).rem_euclid(360.0) - 180.0 };
    let sin = |deg: f64| deg.to_radians().sin();
    let (dl, dc, dh) = (two[0] - one[0], c2 - c1, 2.0 * (c1 * c2).sqrt() * sin(0.5 * turn));
    let (l, c) = (0.5 * (one[0] + two[0]), 0.5 * (c1 + c2));
    let hue = mean_hue(h1, h2, grey);
    let cos = |deg: f64| deg.to_radians().cos();
    let t = 1.0 - 0.17 * cos(hue - 30.0) + 0.24 * cos(2.0 * hue) + 0.32 * cos(3.0 * hue + 6.0)
        - 0.20 * cos(4.0 * hue - 63.0);
    let bright = (l - 50.0).powi(2);
    let (sl, sc, sh) = (1.0 + 0.015 * bright / (20.0 + bright).sqrt(), 1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let rotation = -2.0 * damped(c) * sin(60.0 * (-((hue - 275.0) / 25.0).powi(2)).exp());
    let (l, c, h) = (dl / sl, dc / sc, dh / sh);
    (l * l + c * c + h * h + rotation * c * h).sqrt()
}

fn mean_hue(h1: f64, h2: f64, grey: bool) -> f64 {
    let sum = h1 + h2;
    match () {
        () if grey => sum,
        () if (h1 - h2).abs() <= 180.0 => 0.5 * sum,
        () if sum < 360.0 => 0.5 * (sum + 360.0),
        () => 0.5 * (sum - 360.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of table 1 of Sharma et al., the hard ones among them.
    #[test]
    fn pairs_have_their_published_distance() {
        for (one, two, expected) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, 3.1571, -77.2803], [50.0, 0.0, -82.7485], 2.8615),
            ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0000),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0009], 7.1792),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0011], 7.2195),
            ([50.0, 2.5, 0.0], [50.0, 0.0, -2.5], 4.3065),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([50.0, 2.5, 0.0], [61.0, -5.0, 29.0], 22.8977),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
            ([22.7233, 20.0904, -46.6940], [23.0331, 14.9730, -42.5619], 2.0373),
            ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
        ] {
            for distance in [delta_e_2000(one, two), delta_e_2000(two, one)] {
                assert!((distance - expected).abs() < 5e-5, "{one:?} {two:?}: {distance}, expected {expected}");
            }
        }
    }

    #[test]
    fn white_and_grey_have_no_chroma() {
        let white = [0.95, 1.0, 1.09];
        assert!(delta_e_76(lab(white, white), [100.0, 0.0, 0.0]) < 1e-12);
        let grey = lab(white.map(|x| 0.18 * x), white);
        assert!((grey[0] - 49.496).abs() < 1e-3 && grey[1].abs() < 1e-12 && grey[2].abs() < 1e-12);
        assert!(lab([0.0; 3], white).iter().all(|x| x.abs() < 1e-12), "dark colours take the straight branch");
    }
}
