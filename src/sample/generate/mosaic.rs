//! Layers of flat platelets of unequal size, each layer laid by itself: as in the iridescent feathers of many birds and
//! the skin of fish.

use glam::DVec3;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{Rng, RngExt, SeedableRng};

use super::super::description::{Body, Fill, Named, Object, Shape};
use super::super::fill::{named, read_fill};
use super::super::problem::Place;
use super::super::reader::Table;
use super::common::{Common, Setting};
use super::sizes::{Sizes, read_spread};
use crate::units::show_length;

/// Layers of rows of platelets.
#[derive(Clone, Debug, PartialEq)]
pub struct Mosaic {
    /// Number of layers.
    pub layers: usize,
    /// Platelets in a row (along x), and rows.
    pub count: [usize; 2],
    /// Mean edge lengths of a platelet along x and y, and its thickness, µm.
    pub size: DVec3,
    /// Standard deviation of the edges along x and y, over their mean.
    pub spread: f64,
    /// Distance of neighbours in a layer, µm.
    pub gap: f64,
    /// Distance of layers, µm.
    pub spacing: f64,
    /// Material of the outside.
    pub fill: Fill,
    /// Thickness of the shell (µm) and what it surrounds, if the platelets have cores.
    pub core: Option<(f64, Named)>,
    /// Seed, height and priority.
    pub common: Common,
}

/// Most platelets.
const MOST: f64 = 1e6;

impl Mosaic {
    /// Reads the table.
    pub(super) fn read(t: &Table<'_>, setting: Setting) -> Option<Self> {
        let layers = t.integer("layers", 1..10_001).map_or(7, |n| n as usize);
        let count = t.numbers::<2>("count", "two numbers such as [4, 3]").unwrap_or([4.0, 3.0]);
        let size = t.point("size").or_else(|| t.missing_if_absent("size", "[\"1500 nm\", \"1000 nm\", \"100 nm\"]"));
        let spread = read_spread(t);
        let gap = t.length("gap").unwrap_or(0.0);
        let spacing = t.length("spacing").unwrap_or(0.0);
        let fill = read_fill(t);
        let shell = if t.get("shell").is_some() { t.positive_length("shell") } else { None };
        let core = named(t, "core");
        let common = Common::read(t, setting);
        let core = match (shell, core) {
            (Some(shell), Some(core)) => Some((shell, core)),
            (None, Some(_)) => return t.missing_if_absent("shell", "\"37 nm\""),
            (Some(_), None) => return t.missing_if_absent("core", "\"air\""),
            (None, None) => None,
        };
        if count.iter().any(|n| *n < 1.0 || n.fract() != 0.0) || count[0] * count[1] * layers as f64 > MOST {
            t.complain(format!(
                "count = {count:?} in {layers} layers: expected whole numbers, at most 10^6 platelets in all"
            ));
            return None;
        }
        let count = count.map(|n| n as usize);
        let mosaic =
            Self { layers, count, size: size?, spread: spread?, gap, spacing, fill: fill?, core, common: common? };
        mosaic.check().map_err(|why| t.complain(why)).ok()?;
        Some(mosaic)
    }

    /// Whether the numbers describe platelets.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self) -> Result<(), String> {
        if self.size.min_element() <= 0.0 {
            return Err(format!("size = {}: all edges must be greater than 0", self.size));
        }
        for (what, length) in [("gap", self.gap), ("spacing", self.spacing)] {
            if length < 0.0 {
                return Err(format!("{what} = {}: expected 0 or more", show_length(length)));
            }
        }
        match &self.core {
            Some((shell, _)) if 2.0 * shell >= self.size.min_element() => Err(format!(
                "shell = {}: expected less than half of the smallest edge, {}",
                show_length(*shell),
                show_length(self.size.min_element())
            )),
            _ => Ok(()),
        }
    }

    /// Edge lengths of the patch, µm.
    pub fn patch(&self) -> [f64; 2] {
        [0, 1].map(|i| self.count[i] as f64 * (self.size[i] + self.gap))
    }

    /// Smallest and largest coordinates of the platelets. Those that reach over the edge of the patch stick out there:
    /// their repetitions come in at the other.
    pub fn platelets(&self) -> Vec<[DVec3; 2]> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.common.seed);
        let mut platelets = Vec::new();
        for layer in 0..self.layers {
            let z = self.common.bottom + layer as f64 * (self.size.z + self.spacing);
            for [y0, y1] in self.pieces(1, &mut rng) {
                let row = self.pieces(0, &mut rng);
                platelets
                    .extend(row.iter().map(|[x0, x1]| [DVec3::new(*x0, y0, z), DVec3::new(*x1, y1, z + self.size.z)]));
            }
        }
        platelets
    }

    /// Pieces along one axis of the patch, from a random place on; their sum is that of equal ones.
    fn pieces(&self, axis: usize, rng: &mut impl Rng) -> Vec<[f64; 2]> {
        let (count, mean, period) = (self.count[axis], self.size[axis], self.patch()[axis]);
        let sizes = Sizes::spread(mean, self.spread);
        let drawn: Vec<f64> = (0..count).map(|_| sizes.one(rng)).collect();
        let scale = mean * count as f64 / drawn.iter().sum::<f64>();
        let start = period * rng.random::<f64>();
        let mut at = 0.0;
        let piece = |size: f64| {
            let from = (start + at) % period - 0.5 * period;
            at += scale * size + self.gap;
            [from, from + scale * size]
        };
        drawn.into_iter().map(piece).collect()
    }

    /// What it is, in a line.
    pub fn title(&self) -> String {
        format!(
            "{} layers of platelets {} x {} x {} um in the mean, edges spread by {}",
            self.layers, self.size.x, self.size.y, self.size.z, self.spread
        )
    }

    /// The platelets, each with its core where one fits.
    pub fn objects(&self, place: &Place) -> Vec<Object> {
        let mut objects = Vec::new();
        for (i, [min, max]) in self.platelets().into_iter().enumerate() {
            let object = |what: &str, [min, max]: [DVec3; 2], fill: Fill, nesting: u32| Object {
                name: format!("{what} {}", i + 1).into(),
                body: Body::Solid(Shape::Cuboid { min, max }, fill),
                priority: self.common.priority,
                nesting,
                place: place.clone(),
            };
            objects.push(object("platelet", [min, max], self.fill.clone(), 0));
            if let Some((shell, core)) = &self.core
                && (max - min).min_element() > 2.0 * shell * (1.0 + 1e-6)
            {
                objects.push(object("core", [min + *shell, max - *shell], Fill::Medium(core.clone()), 1));
            }
        }
        objects
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::description::{Description, Patch};
    use super::super::super::flat::Sample;
    use super::super::common::heights;
    use super::*;
    use crate::light::{Coherence, Wavelengths};

    fn mosaic(gap: f64) -> Mosaic {
        Mosaic {
            layers: 5,
            count: [6, 4],
            size: DVec3::new(1.5, 1.0, 0.1),
            spread: 0.25,
            gap,
            spacing: 0.05,
            fill: Fill::Diffuse(1.0),
            core: Some((0.02, Named { name: "water".into(), place: Place::default() })),
            common: Common { seed: 3, bottom: 1.0, ..Common::default() },
        }
    }

    #[test]
    fn platelets_fill_their_layers_and_keep_their_gaps() {
        for gap in [0.0, 0.03] {
            let mosaic = mosaic(gap);
            assert_eq!(mosaic, mosaic.clone());
            let all = mosaic.platelets();
            assert_eq!(all, mosaic.platelets(), "the same seed gives the same mosaic");
            let [w, d] = mosaic.patch();
            for (i, [a, b]) in all.iter().enumerate() {
                for (x, y) in (-1..=1).flat_map(|x| (-1..=1).map(move |y| (f64::from(x), f64::from(y)))) {
                    let by = DVec3::new(x * w, y * d, 0.0);
                    for (j, [p, q]) in all.iter().enumerate().filter(|(j, _)| *j != i || by != DVec3::ZERO) {
                        let apart = (*a - (*q + by)).max(*p + by - *b).max_element();
                        assert!(apart >= gap - 1e-9, "{i} and {j}: {apart}");
                    }
                }
            }
            let area: f64 = all.iter().map(|[a, b]| (*b - *a).truncate().element_product()).sum();
            assert!((area - 120.0 * 1.5).abs() < 1e-9, "the mean is exact: {area}");
            let objects = mosaic.objects(&Place::default());
            let [low, high] = heights(&objects).unwrap();
            assert!(low == 1.0 && (high - 1.7).abs() < 1e-12, "{high}");
            let patch = Some(Patch { size: mosaic.patch().into(), center: glam::DVec2::ZERO });
            let description = Description { patch, objects, ..Description::default() };
            Sample::new(&description, &Wavelengths::from_nm(vec![500.0]).unwrap(), Coherence::Endless).unwrap();
        }
    }
}
