//! Flakes of an effect pigment: thin prisms, such as mica with a skin of titania all round, scattered in a slab.

mod tilt;

use glam::DVec3;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

pub use self::tilt::Tilt;
use self::tilt::read_tilt;

use super::super::description::{Body, Fill, Named, Object, Shape};
use super::super::fill::{named, read_fill};
use super::super::problem::Place;
use super::super::reader::Table;
use super::common::{Common, Setting};
use super::insertion::{Balls, PackingError, Slab};
use super::prism::{Form, Turned};
use super::sizes::Sizes;
use crate::units::{show_length, significant};

/// Flakes at random places in a slab.
#[derive(Clone, Debug, PartialEq)]
pub struct Flakes {
    /// The slab; all flakes lie in it as a whole.
    pub slab: Slab,
    /// Diameters of the circles through their corners, without the skin, µm, the largest first.
    pub diameters: Vec<f64>,
    /// Thickness without the skin, µm.
    pub thickness: f64,
    /// Corners of their outline.
    pub sides: usize,
    /// Distribution of their tilt.
    pub tilt: Tilt,
    /// Material of the outside.
    pub fill: Fill,
    /// Thickness of the skin (µm) and what it covers, if there is a skin.
    pub core: Option<(f64, Named)>,
    /// Seed, height and priority.
    pub common: Common,
}

/// Largest number of flakes.
const MOST_FLAKES: usize = 100_000;

/// Tries per flake before the slab counts as full.
const TRIES: usize = 20_000;

/// Beyond this share of the volume flakes are not even tried.
const DENSEST: f64 = 0.6;

const ADVICE: &str = "wide flakes hinder one another; use fewer or smaller ones, less `tilt` or a thicker slab";

impl Flakes {
    /// Reads the table.
    pub(super) fn read(t: &Table<'_>, setting: Setting) -> Option<Self> {
        let diameters = Sizes::read(t, "diameter", "20");
        let size = t.point("size").or_else(|| t.missing_if_absent("size", "[200, 200, 20]"));
        let count = t.integer("count", 1..MOST_FLAKES as i64 + 1);
        let share = t.number("fraction");
        let thickness = if t.get("thickness").is_some() { t.positive_length("thickness") } else { Some(0.4) };
        let sides = if t.get("sides").is_some() { t.integer("sides", 3..65) } else { Some(6) };
        let tilt = read_tilt(t);
        let fill = read_fill(t);
        let coating = if t.get("coating").is_some() { t.positive_length("coating") } else { Some(0.06) };
        let core = named(t, "core");
        let common = Common::read(t, setting);
        if core.is_none() && t.get("coating").is_some() {
            return t.missing_if_absent("core", "\"mica\"");
        }
        let (sizes, size, common) = (diameters?, size?, common?);
        let (thickness, sides, coating) = (thickness?, sides? as usize, coating?);
        let mut flakes = Self {
            slab: Slab { size, periodic: common.periodic },
            diameters: Vec::new(),
            thickness,
            sides,
            tilt: tilt?,
            fill: fill?,
            core: core.map(|c| (coating, c)),
            common,
        };
        flakes.diameters = flakes.draw(&sizes, count, share).map_err(|why| t.complain(why)).ok()?;
        Some(flakes)
    }

    /// As many diameters as are asked for, by number or by volume.
    fn draw(&self, sizes: &Sizes, count: Option<i64>, share: Option<f64>) -> Result<Vec<f64>, String> {
        let seed = self.common.seed;
        let wanted = self.slab.size.element_product();
        match (count, share) {
            (Some(n), None) => Ok(sizes.draw(n as usize, seed)),
            (None, Some(f)) if f > 0.0 && f < 1.0 => {
                let volumes = |all: &[f64]| all.iter().map(|&d| self.outside(d).volume()).sum::<f64>();
                let mean = volumes(&sizes.draw(1000, seed)) / 1000.0;
                let expected = f * wanted / mean;
                if !(0.5..=MOST_FLAKES as f64).contains(&expected) {
                    return Err(format!(
                        "fraction = {f} is {} flakes: expected 1 to {MOST_FLAKES}",
                        significant(expected, 2)
                    ));
                }
                Ok(sizes.draw(expected.round() as usize, seed))
            }
            _ => Err("expected either `count`, such as 100, or `fraction`, the share of the volume from 0 to 1".into()),
        }
    }

    fn inside(&self, diameter: f64) -> Form {
        Form { sides: self.sides, radius: 0.5 * diameter, half: 0.5 * self.thickness }
    }

    /// With the skin, if there is one.
    fn outside(&self, diameter: f64) -> Form {
        let inside = self.inside(diameter);
        self.core.as_ref().map_or(inside, |(skin, _)| inside.within(*skin))
    }

    fn check(&self) -> Result<(), PackingError> {
        let wrong = |why: String| Err(PackingError::DoesNotFit(why));
        let size = self.slab.size;
        if size.min_element() <= 0.0 {
            return wrong("the slab's edges must be positive".into());
        }
        let widest = self.diameters.first().map_or(0.0, |&d| 2.0 * self.outside(d).reach());
        if self.slab.periodic && widest > size.x.min(size.y) {
            return wrong(format!(
                "flakes up to {} wide in a patch of {} x {} would meet their own repetitions; make `size` larger",
                show_length(widest),
                show_length(size.x),
                show_length(size.y)
            ));
        }
        let volume: f64 = self.diameters.iter().map(|&d| self.outside(d).volume()).sum();
        let share = volume / size.element_product();
        if share > DENSEST {
            return wrong(format!("the flakes would fill {share:.3} of the slab: {ADVICE}"));
        }
        Ok(())
    }

    /// Flakes and their centres. Each is turned before a place is sought for it, so that those that find a place easily
    /// are no more frequent.
    fn places(&self) -> Result<Vec<(Turned, DVec3)>, PackingError> {
        self.check()?;
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.common.seed);
        let forms: Vec<Form> = self.diameters.iter().map(|&d| self.outside(d)).collect();
        let radii: Vec<f64> = forms.iter().map(Form::reach).collect();
        let mut balls = Balls::new(&self.slab, &radii);
        let mut flakes: Vec<Turned> = Vec::with_capacity(forms.len());
        for form in forms {
            let flake = Turned::new(form, self.tilt.draw(&mut rng));
            let span = self.slab.size - DVec3::Z * 2.0 * flake.half_height();
            if span.z < 0.0 {
                return Err(self.too_thick(&flake));
            }
            let low = DVec3::new(-0.5 * span.x, -0.5 * span.y, flake.half_height());
            let is_free = |p: DVec3| !balls.any_near(p, 0, |b| self.meets(&flake, &flakes[b.number()], b.place - p));
            let mut places = (0..TRIES).map(|_| low + span * DVec3::new(rng.random(), rng.random(), rng.random()));
            let Some(p) = places.find(|&p| is_free(p)) else {
                let volume: f64 = flakes.iter().map(|f| f.form.volume()).sum();
                let fraction = volume / self.slab.size.element_product();
                return Err(PackingError::Jammed { what: "flake", placed: flakes.len(), fraction, advice: ADVICE });
            };
            balls.push(p);
            flakes.push(flake);
        }
        Ok(flakes.into_iter().zip(balls.placed().iter().copied()).collect())
    }

    /// Whether two flakes share space, by any way around the patch.
    fn meets(&self, a: &Turned, b: &Turned, by: DVec3) -> bool {
        let around = if self.slab.periodic { -1..=1 } else { 0..=0 };
        let mut images = around.clone().flat_map(|x| around.clone().map(move |y| DVec3::new(x.into(), y.into(), 0.0)));
        images.any(|image| !a.is_apart(b, by + image * self.slab.size))
    }

    fn too_thick(&self, flake: &Turned) -> PackingError {
        let tilt = flake.turn.z_axis.z.abs().min(1.0).acos().to_degrees();
        PackingError::DoesNotFit(format!(
            "a flake {} wide, tilted by {tilt:.1}°, is {} high, and the slab {}: make the slab thicker, `tilt` less or \
             the flakes smaller",
            show_length(2.0 * flake.form.radius),
            show_length(2.0 * flake.half_height()),
            show_length(self.slab.size.z)
        ))
    }

    /// What it is, in a line.
    pub fn title(&self) -> String {
        let [smallest, largest] =
            [self.diameters.last(), self.diameters.first()].map(|d| d.map_or_else(String::new, |d| significant(*d, 4)));
        format!(
            "{} flakes of {} corners, {smallest} to {largest} um wide and {} um thick without their skin, in a slab {} um high",
            self.diameters.len(),
            self.sides,
            self.thickness,
            self.slab.size.z
        )
    }

    /// The flakes, each with its core.
    ///
    /// # Errors
    /// When they do not fit.
    pub fn objects(&self, place: &Place) -> Result<Vec<Object>, PackingError> {
        let mut objects = Vec::new();
        for (i, (flake, center)) in self.places()?.into_iter().enumerate() {
            let at = center + DVec3::Z * self.common.bottom;
            let object = |what: &str, form: Form, fill: Fill, nesting: u32| Object {
                name: format!("{what} {}", i + 1).into(),
                body: Body::Solid(Shape::Mesh(form.mesh(flake.turn).map(|p| p + at)), fill),
                priority: self.common.priority,
                nesting,
                place: place.clone(),
            };
            objects.push(object("flake", flake.form, self.fill.clone(), 0));
            if let Some((_, core)) = &self.core {
                objects.push(object("core", self.inside(self.diameters[i]), Fill::Medium(core.clone()), 1));
            }
        }
        Ok(objects)
    }
}

#[cfg(test)]
mod tests;
