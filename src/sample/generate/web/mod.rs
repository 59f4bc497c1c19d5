//! The fibre web of a sheet of paper (Schramm, Gondek and Meyer 1997, section 5.2): straight level fibres, hollow,
//! compressed across the sheet, that lie on one another.

mod angles;
mod rest;

use glam::{DVec2, DVec3};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

pub use self::angles::Deviation;
pub(super) use self::angles::normal;
use self::angles::{Angles, LARGEST};
use self::rest::{Outline, Pile};
use super::super::description::{Body, Fibre, Fill, Named, Object};
use super::super::fill::read_fill;
use super::super::problem::Place;
use super::super::reader::Table;
use super::common::{Common, Setting, named_or, read_footprint};
use crate::units::{self, show_length, significant};

/// Fibres that lie on one another.
///
/// With no deviation at all they lie side by side along x, in layers one above the other; else they are laid down one by
/// one, each at a random place: it sinks from above until it touches one that lies already, and stays there, level.
#[derive(Clone, Debug, PartialEq)]
pub struct Web {
    /// Number of layers.
    pub layers: usize,
    /// Fibres per layer.
    pub fibres: usize,
    /// Length of a fibre, µm.
    pub length: f64,
    /// Half its width, µm.
    pub radius: f64,
    /// Half the width of the hollow, µm, and what fills it.
    pub lumen: Option<(f64, Named)>,
    /// Thickness over width, at most 1.
    pub flatten: f64,
    /// Deviation from x.
    pub deviation: Deviation,
    /// Edge lengths of the patch, µm.
    pub size: DVec2,
    /// Material of the walls.
    pub fill: Fill,
    /// Seed, repetition, height and priority.
    pub common: Common,
}

/// Most fibres of a web.
const MOST_FIBRES: usize = 20_000;

/// A fibre may be so many times longer than the patch.
const MOST_PERIODS: f64 = 20.0;

impl Web {
    /// Reads the table; what is not given is the paper's.
    pub(super) fn read(t: &Table<'_>, setting: Setting) -> Option<Self> {
        let common = Common::read(t, setting);
        let layers = t.integer("layers", 1..MOST_FIBRES as i64 + 1).unwrap_or(10) as usize;
        let fibres = t.integer("fibres", 1..MOST_FIBRES as i64 + 1).unwrap_or(10) as usize;
        let radius = t.positive_length("radius").unwrap_or(10.0);
        let flatten = t.number("flatten").unwrap_or(1.0);
        let lumen = read_lumen(t, radius);
        let deviation = read_deviation(t);
        let fill = read_fill(t);
        let given = t.positive_length("length");
        let size = read_footprint(t);
        let (deviation, common) = (deviation?, common?);
        if size.is_none() && (t.get("size").is_some() || deviation != Deviation::Mean(0.0)) {
            return t.missing_if_absent("size", "[\"3 mm\", \"3 mm\"]");
        }
        let along = size.map(|s| s.x).filter(|_| deviation == Deviation::Mean(0.0) && common.periodic);
        let length = given.or(along).unwrap_or(2000.0);
        let size = size.unwrap_or_else(|| DVec2::new(length, 2.0 * radius * fibres as f64));
        let web = Self { layers, fibres, length, radius, lumen: lumen?, flatten, deviation, size, fill: fill?, common };
        web.check().map_err(|why| t.complain(why)).ok()?;
        Some(web)
    }

    /// Whether the numbers describe a web.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self) -> Result<(), String> {
        let all = self.layers.saturating_mul(self.fibres);
        if all > MOST_FIBRES {
            return Err(format!(
                "layers = {} of fibres = {}: at most {MOST_FIBRES} fibres are taken in all",
                self.layers, self.fibres
            ));
        }
        if !(self.flatten > 0.0 && self.flatten <= 1.0) {
            return Err(format!(
                "flatten = {}: expected the thickness over the width, above 0 and at most 1",
                self.flatten
            ));
        }
        if self.common.periodic {
            self.check_patch()?;
        }
        if self.is_oriented() { self.check_rows() } else { Ok(()) }
    }

    /// Whether the patch is so wide that few repetitions of a fibre meet another one.
    fn check_patch(&self) -> Result<(), String> {
        let ([length, radius], size) = ([self.length, self.radius].map(show_length), show(self.size));
        if !self.is_oriented() && self.length > MOST_PERIODS * self.size.min_element() {
            return Err(format!(
                "fibres of {length} in a patch of {size}: at most {MOST_PERIODS} times its edges are taken; make `size` \
                 larger or `length` shorter"
            ));
        }
        if 2.0 * self.radius > self.size.min_element() {
            return Err(format!("fibres of radius {radius} are wider than the patch of {size}; make `size` larger"));
        }
        Ok(())
    }

    fn check_rows(&self) -> Result<(), String> {
        let needed = 2.0 * self.radius * self.fibres as f64;
        if needed > self.size.y * (1.0 + 1e-12) {
            return Err(format!(
                "{} fibres side by side need {}, and the patch is {}; make `size` larger or `fibres` fewer",
                self.fibres,
                show_length(needed),
                show(self.size)
            ));
        }
        if self.common.periodic && self.length > self.size.x {
            return Err(format!(
                "fibres of length {} along x would meet their own repetitions in a patch of {}: make `length` that of \
                 the patch (they then have no ends) or less",
                show_length(self.length),
                show(self.size)
            ));
        }
        Ok(())
    }

    fn is_oriented(&self) -> bool {
        self.deviation == Deviation::Mean(0.0)
    }

    /// The axes of all fibres, in the order they are laid.
    ///
    /// # Errors
    /// When a fibre would meet its own repetition.
    pub fn axes(&self) -> Result<Vec<[DVec3; 2]>, String> {
        let outlines = if self.is_oriented() { self.rows() } else { self.scattered()? };
        let mut pile = Pile::new(self.common.periodic.then_some(self.size), self.flatten);
        let thickness = 2.0 * self.flatten * self.radius;
        let axis = |(i, outline): (usize, Outline)| {
            let z = match self.is_oriented() {
                true => self.common.bottom + (0.5 + (i / self.fibres) as f64) * thickness,
                false => pile.lay(outline, self.common.bottom),
            };
            [-1.0, 1.0].map(|s| (outline.center + s * outline.half_length * outline.along).extend(z))
        };
        Ok(outlines.into_iter().enumerate().map(axis).collect())
    }

    /// Side by side, all layers alike.
    fn rows(&self) -> Vec<Outline> {
        let pitch = self.size.y / self.fibres as f64;
        let row = |k: usize| {
            let center = DVec2::new(0.0, (0.5 + k as f64) * pitch - 0.5 * self.size.y);
            Outline { center, along: DVec2::X, half_length: 0.5 * self.length, radius: self.radius }
        };
        (0..self.layers).flat_map(|_| (0..self.fibres).map(row)).collect()
    }

    fn scattered(&self) -> Result<Vec<Outline>, String> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.common.seed);
        let angles = Angles::new(self.deviation);
        let one = |number: usize| {
            let part = DVec2::new(rng.random(), rng.random()) - 0.5;
            let along = DVec2::from_angle(angles.draw(&mut rng));
            let fibre =
                Outline { center: part * self.size, along, half_length: 0.5 * self.length, radius: self.radius };
            if !self.common.periodic || fibre.meets_itself(self.size).is_none() {
                return Ok(fibre);
            }
            let enough = self.length + 2.0 * self.radius;
            Err(format!(
                "fibre {} of length {} at {:.1}° to x would meet its own repetition in a patch of {}: make both edges \
                 of `size` {} or more, or `length` shorter",
                number + 1,
                show_length(self.length),
                along.to_angle().to_degrees(),
                show(self.size),
                show_length(enough)
            ))
        };
        (0..self.layers * self.fibres).map(one).collect()
    }

    /// What it is, in a line.
    pub fn title(&self) -> String {
        let directions = match self.deviation {
            Deviation::Random => "in all directions".into(),
            Deviation::Mean(0.0) => "along x, side by side".into(),
            Deviation::Mean(mean) => format!("along x to {} degrees in the mean", significant(mean.to_degrees(), 4)),
        };
        format!(
            "{} fibres {} um long, {} um wide and {} um thick, {directions}",
            self.layers * self.fibres,
            self.length,
            2.0 * self.radius,
            2.0 * self.radius * self.flatten
        )
    }

    /// The fibres.
    ///
    /// # Errors
    /// When a fibre would meet its own repetition.
    pub fn objects(&self, place: &Place) -> Result<Vec<Object>, String> {
        // As long as the patch: every fibre joins its own repetition, and has no ends.
        let endless = self.is_oriented() && self.common.periodic && self.length == self.size.x;
        let fibre = |(i, [from, to]): (usize, [DVec3; 2])| {
            let flatten = (self.flatten < 1.0).then_some((DVec3::Z, self.flatten));
            let lumen = self.lumen.clone();
            let fibre = Fibre { from, to, radius: self.radius, lumen, flatten, caps: !endless };
            let shape = fibre.into();
            Object {
                name: format!("fibre {}", i + 1).into(),
                body: Body::Solid(shape, self.fill.clone()),
                priority: self.common.priority,
                nesting: 0,
                place: place.clone(),
            }
        };
        Ok(self.axes()?.into_iter().enumerate().map(fibre).collect())
    }
}

fn show(size: DVec2) -> String {
    format!("{} x {}", show_length(size.x), show_length(size.y))
}

/// The hollow: half as wide as the fibre and full of air, unless it is said otherwise; `inner_radius = 0` is none.
fn read_lumen(t: &Table<'_>, radius: f64) -> Option<Option<(f64, Named)>> {
    let inner = match t.get("inner_radius") {
        Some(_) => t.length("inner_radius")?,
        None => 0.5 * radius,
    };
    let medium = named_or(t, "inner_medium", "air");
    if !(0.0..radius).contains(&inner) {
        let [inner, radius] = [inner, radius].map(show_length);
        t.complain(format!("inner_radius = {inner}: expected 0 or more, and less than radius = {radius}"));
        return None;
    }
    Some((inner > 0.0).then_some((inner, medium)))
}

fn read_deviation(t: &Table<'_>) -> Option<Deviation> {
    let Some(value) = t.get("deviation") else { return Some(Deviation::Mean(0.0)) };
    let text = value.get_ref().as_str();
    if text == Some("random") {
        return Some(Deviation::Random);
    }
    let mean = match text {
        Some(text) => units::angle(text).ok(),
        None => Some(t.angle("deviation")?),
    };
    if let Some(mean) = mean.filter(|m| (0.0..=LARGEST).contains(m)) {
        return Some(Deviation::Mean(mean));
    }
    let found = mean.map_or_else(
        || format!("{:?}", text.unwrap_or_default()),
        |m| format!("{} deg", significant(m.to_degrees(), 4)),
    );
    let message = format!(
        "deviation = {found}: expected the mean angle to x, from 0 to 44 such as \"15 deg\", or \"random\" (then it is 45)"
    );
    t.source().note(t.place_of("deviation").problem(message));
    None
}

#[cfg(test)]
mod tests;
