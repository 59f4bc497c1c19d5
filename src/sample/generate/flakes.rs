//! Flakes of an effect pigment: thin prisms, such as mica with a skin of titania all round, scattered in a slab.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DMat3, DVec3};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{Rng, RngExt, SeedableRng};

use super::super::description::{Body, Fill, Named, Object, Shape};
use super::super::fill::{named, read_fill};
use super::super::problem::Place;
use super::super::reader::Table;
use super::common::{Common, Setting};
use super::insertion::{Balls, PackingError, Slab};
use super::prism::{Form, Turned};
use super::sizes::Sizes;
use crate::units::{self, show_length, significant};

/// How far flakes are tilted out of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tilt {
    /// By this angle in the mean, radians: both components of the tilt are normal, so that it has the distribution of
    /// Rayleigh.
    Mean(f64),
    /// At random: all directions of the normal alike.
    Random,
}

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

/// Largest mean tilt, of which the distribution of Rayleigh has nothing beyond a right angle.
const LARGEST_TILT: f64 = 20.0;

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
            let is_free = |p: DVec3| !balls.any_near(p, |n| self.meets(&flake, &flakes[n], balls.placed()[n] - p));
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
                name: format!("{what} {}", i + 1),
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

impl Tilt {
    /// A turn: about the normal by any angle, then tilted to any side.
    fn draw(self, rng: &mut impl Rng) -> DMat3 {
        let [spin, side]: [f64; 2] = [TAU * rng.random::<f64>(), TAU * rng.random::<f64>()];
        let u: f64 = rng.random();
        let tilt = match self {
            Self::Mean(mean) => (mean / FRAC_PI_2.sqrt() * (-2.0 * (1.0 - u).ln()).sqrt()).min(FRAC_PI_2),
            // A flake has no upper side.
            Self::Random => u.acos(),
        };
        let axis = DVec3::new(-side.sin(), side.cos(), 0.0);
        DMat3::from_axis_angle(axis, tilt) * DMat3::from_rotation_z(spin)
    }
}

fn read_tilt(t: &Table<'_>) -> Option<Tilt> {
    let Some(value) = t.get("tilt") else { return Some(Tilt::Mean(0.0)) };
    let text = value.get_ref().as_str();
    if text == Some("random") {
        return Some(Tilt::Random);
    }
    let mean = match text {
        Some(text) => units::angle(text).ok(),
        None => Some(t.angle("tilt")?),
    };
    if let Some(mean) = mean.filter(|m| (0.0..=LARGEST_TILT.to_radians()).contains(m)) {
        return Some(Tilt::Mean(mean));
    }
    let found = mean.map_or_else(
        || format!("{:?}", text.unwrap_or_default()),
        |m| format!("{} deg", significant(m.to_degrees(), 4)),
    );
    let message = format!(
        "tilt = {found}: expected the mean angle out of the plane, from 0 to {LARGEST_TILT} such as \"5 deg\", or \"random\""
    );
    t.source().note(t.place_of("tilt").problem(message));
    None
}

#[cfg(test)]
mod tests {
    use super::super::super::description::{Description, Patch};
    use super::super::super::flat::Sample;
    use super::super::common::heights;
    use super::*;
    use crate::light::{Coherence, Wavelengths};

    fn flakes(tilt: Tilt, sides: usize) -> Flakes {
        let count = if tilt == Tilt::Random { 20 } else { 40 };
        Flakes {
            slab: Slab { size: DVec3::new(30.0, 26.0, 13.0), periodic: true },
            diameters: Sizes::spread(8.0, 0.2).draw(count, 2),
            thickness: 0.4,
            sides,
            tilt,
            fill: Fill::Diffuse(1.0),
            core: Some((0.06, Named { name: "water".into(), place: Place::default() })),
            common: Common { bottom: 2.0, seed: 8, ..Common::default() },
        }
    }

    /// The search for overlaps of meshes knows nothing of separating axes.
    #[test]
    fn flakes_never_overlap() {
        for (tilt, sides) in [(Tilt::Mean(0.0), 6), (Tilt::Mean(0.2), 6), (Tilt::Random, 5), (Tilt::Random, 3)] {
            let flakes = flakes(tilt, sides);
            let objects = flakes.objects(&Place::default()).unwrap();
            let places = || flakes.places().unwrap().into_iter().map(|(_, p)| p).collect::<Vec<DVec3>>();
            assert_eq!(places(), places(), "the same seed gives the same flakes");
            let [low, high] = heights(&objects).unwrap();
            assert!(low >= 2.0 - 1e-9 && high <= 15.0 + 1e-9, "{low} {high}");
            assert_eq!(objects.len(), 2 * flakes.diameters.len());
            let patch = Some(Patch { size: flakes.slab.size.truncate(), center: glam::DVec2::ZERO });
            let description = Description { patch, objects, ..Description::default() };
            let light = Wavelengths::from_nm(vec![500.0]).unwrap();
            Sample::new(&description, &light, Coherence::Endless).unwrap();
        }
    }

    /// Flakes that are apart have a plane between them, flakes with a common point have none.
    #[test]
    fn separating_axes_tell_what_a_raster_tells() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut counts = [0, 0];
        for case in 0..400 {
            let form = Form { sides: 3 + case % 5, radius: 3.0, half: 0.6 };
            let [a, b] = [0, 1].map(|_| Turned::new(form, Tilt::Random.draw(&mut rng)));
            let by = DVec3::new(rng.random(), rng.random(), rng.random()) * 4.0;
            let inside = |t: &Turned, p: DVec3| {
                let local = t.turn.transpose() * p;
                let apothem = 3.0 * (0.5 * TAU / form.sides as f64).cos();
                let side = |i: usize| TAU * (i as f64 + 0.5) / form.sides as f64;
                local.z.abs() < 0.6
                    && (0..form.sides).all(|i| local.x * side(i).cos() + local.y * side(i).sin() < apothem)
            };
            let steps = || (-15..=15).map(|i| f64::from(i) / 5.0);
            let slices = || (-5..=5).map(|i| f64::from(i) * 0.119);
            let common = steps().any(|x| {
                steps().any(|y| {
                    slices().any(|z| {
                        let p = a.turn * DVec3::new(x, y, z);
                        inside(&a, p) && inside(&b, p - by)
                    })
                })
            });
            let apart = a.is_apart(&b, by);
            assert!(!(common && apart), "case {case}");
            counts[usize::from(apart)] += 1;
            // What a raster misses of an overlap is small.
            assert!(apart || common || by.length() > 0.5, "case {case}");
        }
        assert!(counts[0] > 50 && counts[1] > 50, "{counts:?}");
    }

    /// 4000 flakes: 4.5 standard errors are a false alarm in 7 of a million tests.
    #[test]
    fn tilts_are_as_asked() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        for (tilt, mean) in [(Tilt::Mean(0.1), 0.1), (Tilt::Mean(0.34), 0.34), (Tilt::Random, 1.0)] {
            let all: Vec<f64> = (0..4000).map(|_| tilt.draw(&mut rng).z_axis.z.acos()).collect();
            let found = all.iter().sum::<f64>() / 4000.0;
            let variance = all.iter().map(|x| (x - found).powi(2)).sum::<f64>() / 4000.0;
            assert!((found - mean).abs() < 4.5 * (variance / 4000.0).sqrt(), "{tilt:?}: {found}");
        }
    }

    #[test]
    fn the_skin_is_as_thick_everywhere() {
        let (inside, skin) = (Form { sides: 6, radius: 5.0, half: 0.2 }, 0.06);
        let outside = inside.within(skin);
        let apothem = |f: Form| f.radius * (0.5 * TAU / 6.0).cos();
        assert!((apothem(outside) - apothem(inside) - skin).abs() < 1e-12);
        assert!((outside.half - inside.half - skin).abs() < 1e-12);
        assert!((outside.mesh(DMat3::IDENTITY).volume() - outside.volume()).abs() < 1e-9);
    }
}
