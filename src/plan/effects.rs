//! The effects: each on or off, with the reason and a bound.

use super::stacks::Marks;
use super::wanted::Wanted;
use crate::light::{Light, Polarization};
use crate::sample::{Matter, MediumId, Sample};
use crate::text::words;

/// Effects of light and matter, and two that are of geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Name {
    /// Waves between parallel faces.
    Interference,
    /// The state of polarization of every ray.
    Polarization,
    /// The phase of every ray.
    Phase,
    /// Indices that depend on the wavelength: refraction parts the wavelengths of a ray.
    Dispersion,
    /// Light that media take on its way.
    Absorption,
    /// Bodies within bodies: what a ray is inside of is followed.
    Priorities,
    /// The search for films.
    Finder,
}

words!(Name {
    Interference = "interference",
    Polarization = "polarization",
    Phase = "phase",
    Dispersion = "dispersion",
    Absorption = "absorption",
    Priorities = "priorities",
    Finder = "finder",
});

impl Name {
    /// How many there are.
    pub const COUNT: usize = 7;
    /// All of them.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Interference,
        Self::Polarization,
        Self::Phase,
        Self::Dispersion,
        Self::Absorption,
        Self::Priorities,
        Self::Finder,
    ];

    /// Whether people may switch it: the others follow from the sample, or from another effect.
    pub fn is_for_hands(&self) -> bool {
        !matches!(self, Self::Priorities | Self::Finder)
    }
}

/// An effect with the reason why it is simulated, or not.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Which.
    pub name: Name,
    /// Whether it is simulated.
    pub on: bool,
    /// Why.
    pub reason: String,
    /// What leaving it out changes at most: of the reflected light, and of the transmitted, no part changes by more than
    /// this share of it. 0 is a proof that it changes nothing; 1 says that nothing less is known.
    pub bound: f64,
    /// Whether a pilot may still find that it does not matter.
    pub open: bool,
}

impl Effect {
    fn new(name: Name, on: bool, reason: impl Into<String>) -> Self {
        Self { name, on, reason: reason.into(), bound: if on { 1.0 } else { 0.0 }, open: false }
    }

    fn open(self, open: bool) -> Self {
        Self { open, ..self }
    }

    /// As the user wants it.
    fn wanted(self, wanted: &Wanted) -> Self {
        let by_hand = wanted.by_hand(self.name).or((wanted.all() && !self.on).then_some(true));
        match by_hand {
            Some(on) if on != self.on => {
                let reason = format!("switched {} by hand: {}", if on { "on" } else { "off" }, self.reason);
                Self { on, reason, open: false, ..self }
            }
            Some(_) => self.open(false),
            None => Self { open: self.open && !wanted.all(), ..self },
        }
    }
}

/// All effects, in the order of [`Name::ALL`], as far as they can be judged before any ray is cast.
pub(super) fn judge(sample: &Sample, light: &Light, marks: &Marks, wanted: &Wanted) -> Vec<Effect> {
    let interference = interference(marks).wanted(wanted);
    let finder = Effect { name: Name::Finder, ..finder(marks, interference.on) };
    vec![
        interference,
        polarization(light).wanted(wanted),
        Effect::new(Name::Phase, false, "films are solved with their phases; rays are summed as intensities")
            .wanted(wanted),
        dispersion(sample).wanted(wanted),
        absorption(sample, light).wanted(wanted),
        priorities(sample),
        finder,
    ]
}

fn interference(marks: &Marks) -> Effect {
    if marks.any() {
        let reason = "some faces have a parallel neighbour within the coherence length";
        Effect::new(Name::Interference, true, reason)
    } else {
        Effect::new(Name::Interference, false, "no two faces are parallel within the coherence length")
    }
}

fn finder(marks: &Marks, interferes: bool) -> Effect {
    match (marks.count(), interferes) {
        (0, on) => Effect::new(Name::Finder, on, "there is no face where a film could begin"),
        (faces, true) => Effect::new(Name::Finder, true, format!("films may begin at {faces} faces")),
        (_, false) => Effect::new(Name::Finder, false, "without interference there are only single interfaces"),
    }
}

fn polarization(light: &Light) -> Effect {
    match light.polarization {
        Polarization::Mueller => Effect::new(Name::Polarization, true, "Mueller matrices are asked for"),
        _ => Effect::new(Name::Polarization, true, "interfaces polarize").open(true),
    }
}

/// Media in which light travels, with whether it ends there.
fn travelled(sample: &Sample) -> impl Iterator<Item = MediumId> + '_ {
    let of_solids = sample.solids.iter().filter_map(|s| match s.matter {
        Matter::Medium(id) => Some(id),
        _ => None,
    });
    of_solids.chain([sample.above, sample.below]).filter(|&id| !sample.media[usize::from(id.0)].is_opaque())
}

/// Indices that vary by more than this surely part the light.
const SURELY_DISPERSIVE: f64 = 2e-3;

fn dispersion(sample: &Sample) -> Effect {
    let table = |id: MediumId| &sample.media[usize::from(id.0)];
    let spread = |id: MediumId| {
        let n = table(id).index.iter().map(|n| n.re);
        n.clone().fold(f64::MIN, f64::max) - n.fold(f64::MAX, f64::min)
    };
    let worst = travelled(sample).map(|id| (spread(id), id)).max_by(|a, b| a.0.total_cmp(&b.0));
    match worst {
        Some((spread, id)) if spread > 0.0 => {
            let reason = format!("the index of `{}` varies by {}", table(id).name, digits(spread));
            Effect::new(Name::Dispersion, true, reason).open(spread < SURELY_DISPERSIVE)
        }
        _ => Effect::new(Name::Dispersion, false, "no index of a transparent medium depends on the wavelength"),
    }
}

/// Light that loses more than this on its way through the sample surely matters.
const SURELY_ABSORBED: f64 = 0.1;

fn absorption(sample: &Sample, light: &Light) -> Effect {
    let height = sample.cell.heights.1 - sample.cell.heights.0;
    let along = |id: MediumId| {
        let index = sample.media[usize::from(id.0)].index.iter().zip(light.wavelengths.um());
        let depth = index.map(|(n, um)| 2.0 * std::f64::consts::TAU / um * n.im * height);
        (depth.fold(0.0, f64::max), id)
    };
    let (depth, id) = travelled(sample).map(along).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, sample.above));
    let opaque = sample.has_opaque();
    if depth > 0.0 {
        let (name, lost) = (&sample.media[usize::from(id.0)].name, -100.0 * (-depth).exp_m1());
        let reason = format!("`{name}` takes {} % of light that crosses the height of the sample", digits(lost));
        Effect::new(Name::Absorption, true, reason).open(depth < SURELY_ABSORBED)
    } else if opaque {
        Effect::new(Name::Absorption, true, "opaque bodies absorb what they do not reflect")
    } else {
        Effect::new(Name::Absorption, false, "nothing absorbs")
    }
}

fn priorities(sample: &Sample) -> Effect {
    if sample.solids.iter().all(|s| s.lonely) {
        Effect::new(Name::Priorities, false, "every body is convex and has nothing in it")
    } else {
        Effect::new(Name::Priorities, true, "bodies are meshes, touch, overlap or contain others")
    }
}

fn digits(x: f64) -> String {
    crate::units::significant(x, 3)
}
