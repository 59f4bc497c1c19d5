//! Interlocking bricks with cores: the platelets of a hummingbird's barbule (Schramm, Gondek and Meyer 1997,
//! section 4).

use glam::DVec3;

use super::super::description::{Body, Fill, Named, Object, Shape};
use super::super::problem::Place;
use super::super::reader::Table;

/// Layers of touching bricks on a periodic patch, alternate layers shifted.
#[derive(Clone, Debug, PartialEq)]
pub struct Bricks {
    /// Number of layers.
    pub layers: usize,
    /// Bricks along x and y.
    pub count: [usize; 2],
    /// Edge lengths of a brick, µm.
    pub size: DVec3,
    /// Thickness of the shell around the core in x, y and z, µm.
    pub shell: DVec3,
    /// By which parts of a brick every other layer is shifted along x and y, 0 to 1.
    pub shift: [f64; 2],
    /// Height of the lower face of the lowest layer, µm.
    pub bottom: f64,
    /// Medium of the shell.
    pub medium: Named,
    /// Medium of the core.
    pub core: Named,
}

/// A box and which of the two media fills it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Smallest coordinates, µm.
    pub min: DVec3,
    /// Largest coordinates, µm.
    pub max: DVec3,
    /// Whether it is the core of a brick.
    pub is_core: bool,
}

impl Default for Bricks {
    /// The paper's: 7 layers of 1500 × 2000 × 172 nm with cores of 98 nm, a shell of 37 nm all round; a patch of
    /// 4 × 3 bricks.
    fn default() -> Self {
        let named = |name: &str| Named { name: name.into(), place: Place::default() };
        Self {
            layers: 7,
            count: [4, 3],
            size: DVec3::new(1.5, 2.0, 0.172),
            shell: DVec3::splat(0.037),
            shift: [0.5, 0.0],
            bottom: 0.0,
            medium: named("platelet"),
            core: named("core"),
        }
    }
}

impl Bricks {
    /// Reads the parameters; what is not given is the paper's.
    pub(super) fn read(t: &Table<'_>) -> Option<Self> {
        let base = Self::default();
        let named = |key, default: &Named| {
            t.text(key).map_or_else(|| default.clone(), |name| Named { name: name.into(), place: t.place_of(key) })
        };
        let (medium, core) = (named("medium", &base.medium), named("core", &base.core));
        let layers = t.integer("layers", 1..10_001).map_or(base.layers, |n| n as usize);
        let count = t.numbers::<2>("count", "two numbers such as [4, 3]").unwrap_or(base.count.map(|n| n as f64));
        let size = t.point("size").unwrap_or(base.size);
        let shell = t.point("shell").unwrap_or(base.shell);
        let shift = t.numbers::<2>("shift", "two parts of a brick such as [0.5, 0.5]").unwrap_or(base.shift);
        let bottom = t.length("bottom").unwrap_or(base.bottom);
        if count.iter().any(|n| *n < 1.0 || *n > 1e4 || n.fract() != 0.0) || count[0] * count[1] * layers as f64 > 1e6 {
            t.complain(format!(
                "count = {count:?} in {layers} layers: expected whole numbers, at most 10^6 bricks in all"
            ));
            return None;
        }
        let made = Self { layers, count: count.map(|n| n as usize), size, shell, shift, bottom, medium, core };
        if let Err(why) = made.check() {
            t.complain(why);
            return None;
        }
        Some(made)
    }

    /// Whether the numbers describe bricks.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self) -> Result<(), String> {
        if self.size.min_element() <= 0.0 {
            return Err(format!("size = {}: all edges must be greater than 0", self.size));
        }
        if self.shell.min_element() < 0.0 || (2.0 * self.shell).cmpge(self.size).any() {
            return Err(format!(
                "shell = {}: expected 0 or more, and less than half of size = {}",
                self.shell, self.size
            ));
        }
        if !self.shift.iter().all(|s| (0.0..=1.0).contains(s)) {
            return Err(format!("shift = {:?}: expected parts of a brick from 0 to 1", self.shift));
        }
        Ok(())
    }

    /// Edge lengths of the patch, µm.
    pub fn patch(&self) -> [f64; 2] {
        [self.size.x * self.count[0] as f64, self.size.y * self.count[1] as f64]
    }

    /// All shells and cores; bricks that reach over the edge of the patch are cut there and go on at the other.
    pub fn parts(&self) -> Vec<Part> {
        let mut parts = Vec::new();
        for layer in 0..self.layers {
            let z = self.bottom + layer as f64 * self.size.z;
            let top = self.bottom + (layer + 1) as f64 * self.size.z;
            let [shift_x, shift_y] = if layer % 2 == 1 { self.shift } else { [0.0, 0.0] };
            for y in pieces(self.count[1], self.size.y, shift_y, self.shell.y) {
                for x in pieces(self.count[0], self.size.x, shift_x, self.shell.x) {
                    parts.push(Part {
                        min: DVec3::new(x.shell[0], y.shell[0], z),
                        max: DVec3::new(x.shell[1], y.shell[1], top),
                        is_core: false,
                    });
                    let core = |x: [f64; 2], y: [f64; 2]| Part {
                        min: DVec3::new(x[0], y[0], z + self.shell.z),
                        max: DVec3::new(x[1], y[1], top - self.shell.z),
                        is_core: true,
                    };
                    parts.extend(x.core.zip(y.core).map(|(x, y)| core(x, y)));
                }
            }
        }
        parts
    }

    /// The same as objects of a sample.
    pub fn objects(&self, place: &Place) -> Vec<Object> {
        let mut numbers = [0, 0];
        self.parts()
            .into_iter()
            .map(|part| {
                let (what, medium) = if part.is_core { ("core", &self.core) } else { ("brick", &self.medium) };
                let number = &mut numbers[usize::from(part.is_core)];
                *number += 1;
                let shape = Shape::Cuboid { min: part.min, max: part.max };
                Object {
                    name: format!("{what} {number}").into(),
                    body: Body::Solid(shape, Fill::Medium(medium.clone())),
                    priority: 0,
                    nesting: u32::from(part.is_core),
                    place: place.clone(),
                }
            })
            .collect()
    }

    /// What it is, in a line.
    pub fn title(&self) -> String {
        let shift = match self.shift {
            [0.5, 0.0] => "half a brick".into(),
            [x, y] => format!("{x} of a brick along x and {y} along y"),
        };
        format!(
            "{} layers of bricks {} x {} x {} um, alternate layers shifted by {shift}",
            self.layers, self.size.x, self.size.y, self.size.z
        )
    }
}

/// The extent of a brick, or of a piece of one, along one axis.
struct Piece {
    shell: [f64; 2],
    core: Option<[f64; 2]>,
}

/// Bricks along one axis, centred on 0; the one that reaches over the end is cut in two.
fn pieces(count: usize, length: f64, shift: f64, shell: f64) -> Vec<Piece> {
    let half = 0.5 * length * count as f64;
    let piece = |from: f64, to: f64| {
        let clip = |x: f64| x.clamp(-half, half);
        let (a, b) = (clip(from), clip(to));
        let (c, d) = (clip(from + shell), clip(to - shell));
        (b - a > 1e-9 * length).then(|| Piece { shell: [a, b], core: (d - c > 1e-9 * length).then_some([c, d]) })
    };
    let at = |k: i64| length * (k as f64 + shift) - half;
    (-1..count as i64).filter_map(|k| piece(at(k), at(k + 1))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bricks_fill_the_patch() {
        let bricks = Bricks::default();
        let volume = |core| {
            let of = |p: &Part| (p.max - p.min).element_product();
            bricks.parts().iter().filter(|p| p.is_core == core).map(of).sum::<f64>()
        };
        let [w, d] = bricks.patch();
        assert!((volume(false) - w * d * 7.0 * 0.172).abs() < 1e-9);
        assert!((volume(true) - 4.0 * 3.0 * 7.0 * 1.426 * 1.926 * 0.098).abs() < 1e-9);
        // Three shifted layers with one brick cut in two, in each of three rows.
        assert_eq!(bricks.parts().iter().filter(|p| !p.is_core).count(), 84 + 9);
        // Shifted both ways, one row is cut in two as well; nothing is lost.
        let both = Bricks { shift: [0.5, 0.5], ..Bricks::default() };
        assert_eq!(both.parts().iter().filter(|p| !p.is_core).count(), 4 * 12 + 3 * 5 * 4);
        let volume: f64 = both.parts().iter().filter(|p| p.is_core).map(|p| (p.max - p.min).element_product()).sum();
        assert!((volume - 4.0 * 3.0 * 7.0 * 1.426 * 1.926 * 0.098).abs() < 1e-9);
    }
}
