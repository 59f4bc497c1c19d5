//! At what height a fibre comes to rest on those that lie already.
//!
//! All fibres are level and have the same elliptic cross-section. Heights in units of the ratio of its axes make them
//! round cylinders of radius r; what meets, meets as before. Over a point at distances s and t from their axes two of
//! them touch when the axes are √(r² − s²) + √(r² − t²) apart in height. They touch first where that is largest over
//! what their outlines, two rectangles, have in common: where the axes cross, if they do. Otherwise, as it is a
//! concave function, at the border of that polygon, on each edge of which a search by sections finds it to within
//! rounding.

use glam::DVec2;

/// Half of a fibre's outline, seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Outline {
    /// Its middle, µm.
    pub center: DVec2,
    /// Unit vector along the axis.
    pub along: DVec2,
    /// Half of its length, µm.
    pub half_length: f64,
    /// Half of its width, µm.
    pub radius: f64,
}

impl Outline {
    /// Half the edges of the upright rectangle around it.
    fn reach(&self) -> DVec2 {
        self.half_length * self.along.abs() + self.radius * self.along.perp().abs()
    }

    fn corners(&self) -> [DVec2; 4] {
        let (a, b) = (self.half_length * self.along, self.radius * self.along.perp());
        [a + b, b - a, -a - b, a - b].map(|d| self.center + d)
    }

    /// Displacements by multiples of `period` after which it may meet `other`.
    pub fn meetings(&self, other: &Self, period: Option<DVec2>) -> impl Iterator<Item = DVec2> + use<> {
        let (between, reach) = (other.center - self.center, self.reach() + other.reach());
        let range = |i: usize| match period {
            Some(p) => {
                (((between[i] - reach[i]) / p[i]).ceil() as i32, ((between[i] + reach[i]) / p[i]).floor() as i32)
            }
            None => (0, 0),
        };
        let ((x0, x1), (y0, y1)) = (range(0), range(1));
        let near = period.is_some() || between.abs().cmplt(reach).all();
        let shift = move |x, y| period.unwrap_or_default() * DVec2::new(f64::from(x), f64::from(y));
        (y0..=y1).flat_map(move |y| (x0..=x1).map(move |x| shift(x, y))).filter(move |_| near)
    }

    /// The displacement after which it would share space with itself at the same height, if there is one.
    pub fn meets_itself(&self, period: DVec2) -> Option<DVec2> {
        let slack = 1.0 - 1e-12;
        let meets = |d: &DVec2| {
            d.dot(self.along).abs() < 2.0 * self.half_length * slack
                && d.perp_dot(self.along).abs() < 2.0 * self.radius * slack
        };
        self.meetings(self, Some(period)).find(|d| *d != DVec2::ZERO && meets(d))
    }

    /// How far apart in height two axes are when the cylinders touch, µm; `None` if they pass beside one another.
    pub fn clearance(&self, other: &Self) -> Option<f64> {
        if self.crosses(other) {
            return Some(self.radius + other.radius);
        }
        let common = self.common(other);
        let height = |p: DVec2| {
            let part = |o: &Self| (o.radius.powi(2) - (p - o.center).perp_dot(o.along).powi(2)).max(0.0).sqrt();
            part(self) + part(other)
        };
        let next = common.iter().cycle().skip(1);
        common.iter().zip(next).map(|(&p, &q)| largest(|x| height(p.lerp(q, x)))).reduce(f64::max)
    }

    /// Whether the axes cross.
    fn crosses(&self, other: &Self) -> bool {
        let sine = self.along.perp_dot(other.along);
        // Of hardly crossing ones the border is as high as the inside.
        if sine.abs() < 1e-9 {
            return false;
        }
        let between = other.center - self.center;
        let on_self = between.perp_dot(other.along) / sine;
        let on_other = between.perp_dot(self.along) / sine;
        on_self.abs() <= self.half_length && on_other.abs() <= other.half_length
    }

    /// The polygon both outlines have in common.
    fn common(&self, other: &Self) -> Vec<DVec2> {
        let mut polygon = other.corners().to_vec();
        for (normal, limit) in [(self.along, self.half_length), (self.along.perp(), self.radius)] {
            for normal in [normal, -normal] {
                polygon = keep(&polygon, |p| limit - (p - self.center).dot(normal));
            }
        }
        polygon
    }
}

/// The part of a convex polygon where `inside` is not negative.
fn keep(polygon: &[DVec2], inside: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let next = polygon.iter().cycle().skip(1);
    let pieces = polygon.iter().zip(next).flat_map(|(&p, &q)| {
        let (a, b) = (inside(p), inside(q));
        let cut = (a * b < 0.0).then(|| p.lerp(q, a / (a - b)));
        (a >= 0.0).then_some(p).into_iter().chain(cut)
    });
    pieces.collect()
}

/// The largest value of a concave function between 0 and 1, by golden sections.
fn largest(f: impl Fn(f64) -> f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (mut a, mut b) = (0.0, 1.0);
    let (mut p, mut q) = (1.0 - GOLDEN, GOLDEN);
    let (mut at_p, mut at_q) = (f(p), f(q));
    for _ in 0..64 {
        if at_p < at_q {
            (a, p, at_p) = (p, q, at_q);
            q = a + GOLDEN * (b - a);
            at_q = f(q);
        } else {
            (b, q, at_q) = (q, p, at_p);
            p = b - GOLDEN * (b - a);
            at_p = f(p);
        }
    }
    at_p.max(at_q).max(f(0.0)).max(f(1.0))
}

/// Fibres that lie already, the highest first.
#[derive(Debug)]
pub(super) struct Pile {
    lying: Vec<(f64, Outline)>,
    period: Option<DVec2>,
    /// Thickness over width.
    ratio: f64,
}

impl Pile {
    pub fn new(period: Option<DVec2>, ratio: f64) -> Self {
        Self { lying: Vec::new(), period, ratio }
    }

    /// Lets a fibre sink from above until it touches one that lies already, or `floor`: the height of its axis, µm.
    pub fn lay(&mut self, fibre: Outline, floor: f64) -> f64 {
        let mut height = floor + self.ratio * fibre.radius;
        for (below, other) in &self.lying {
            // Nothing is higher than a crossing of the axes, and those that follow lie even lower.
            let highest = below + self.ratio * (fibre.radius + other.radius);
            if highest <= height {
                break;
            }
            for shift in fibre.meetings(other, self.period) {
                let image = Outline { center: other.center - shift, ..*other };
                height = fibre.clearance(&image).map_or(height, |c| height.max(below + self.ratio * c));
                if height >= highest {
                    break;
                }
            }
        }
        let at = self.lying.partition_point(|(z, _)| *z > height);
        self.lying.insert(at, (height, fibre));
        height
    }
}

#[cfg(test)]
mod tests {
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    use super::*;

    fn outline(x: f64, y: f64, degrees: f64) -> Outline {
        let along = DVec2::from_angle(degrees.to_radians());
        Outline { center: DVec2::new(x, y), along, half_length: 10.0, radius: 1.0 }
    }

    #[test]
    fn special_positions() {
        let first = outline(0.0, 0.0, 0.0);
        assert_eq!(first.clearance(&outline(3.0, 2.0, 90.0)), Some(2.0));
        let beside = first.clearance(&outline(3.0, 1.2, 0.0)).unwrap();
        assert!((beside - 1.6).abs() < 1e-12, "3, 4, 5: {beside}");
        assert_eq!(first.clearance(&outline(0.0, 2.1, 0.0)), None);
        assert_eq!(first.clearance(&outline(20.5, 0.0, 0.0)), None);
        // Its end reaches 0.4 beyond the axis' mantle line: it lies on the end's rim.
        let on_rim = first.clearance(&outline(0.0, 10.6, 90.0)).unwrap();
        assert!((on_rim - (1.0 + 0.8)).abs() < 1e-12, "{on_rim}");
    }

    /// The largest of √ + √ over a fine raster of the plane never exceeds the clearance, and comes close to it.
    #[test]
    fn no_point_of_a_raster_is_higher() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let mut compared = 0;
        for _ in 0..300 {
            let mut number = |w: f64| w * (rng.random::<f64>() - 0.5);
            let (a, b) = (outline(0.0, 0.0, number(360.0)), outline(number(30.0), number(30.0), number(360.0)));
            let height = |p: DVec2| {
                let part = |o: &Outline| {
                    let (s, t) = ((p - o.center).dot(o.along), (p - o.center).perp_dot(o.along));
                    (s.abs() <= o.half_length && t.abs() <= o.radius).then(|| (1.0 - t * t).sqrt())
                };
                Some(part(&a)? + part(&b)?)
            };
            let steps = (-800..=800).map(|i| 0.0125 * f64::from(i));
            let across = |s: f64| (-80..=80).map(move |i| s * a.along + 0.0125 * f64::from(i) * a.along.perp());
            let highest = steps.flat_map(across).filter_map(height).reduce(f64::max);
            let clearance = a.clearance(&b);
            if let Some(highest) = highest {
                compared += 1;
                let clearance = clearance.unwrap();
                assert!(clearance >= highest - 1e-12 && clearance < highest + 0.15, "{clearance} {highest}");
            }
        }
        assert!(compared > 50, "{compared}");
    }
}
