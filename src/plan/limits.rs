//! How far rays are followed, and how finely.

/// Finest level of the dome if nobody chooses it.
pub const DOME_LEVEL: u8 = 5;

/// How far rays are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Interfaces a ray may meet; beyond, its power counts as lost.
    pub depth: u32,
    /// Footprints (or heights of the sample, if it is higher than wide) a ray may walk sideways; beyond, its power has
    /// left through the side.
    pub walk: f64,
    /// At how many interfaces of a tree both branches are followed; none: a pilot finds out what is best.
    pub splits: Option<u32>,
    /// Of a beam that a curved face gives less than this share of the power, it is decided by lot whether the ray takes it:
    /// what such faces reflect is spread over the dome, and following little of it through a thick sample takes as long as
    /// following all the rest.
    pub least_share: f64,
    /// A branch of less power than this is not followed after a split; its power counts as lost beyond the depth.
    pub faintest: f64,
    /// By how much the direction of a wavelength may differ from that of the ray it shares with others, rad; beyond,
    /// refraction parts them. With 0 every wavelength has a ray of its own.
    pub spread: f64,
}

impl Limits {
    /// Interfaces of a tree at which both branches are followed if no pilot has found out.
    pub const USUAL_SPLITS: u32 = 1;

    /// An eighth of the width of the facets of a dome of this level, rad: what one can hardly see.
    pub fn spread_for(dome_level: u8) -> f64 {
        let facets = 20.0 * f64::from(4u32.pow(dome_level.into()));
        0.125 * (4.0 * std::f64::consts::PI / facets).sqrt()
    }

    /// Those of trees all of whose branches are followed, unless they have less power than `faintest`.
    pub fn whole_trees(faintest: f64) -> Self {
        Self { splits: Some(u32::MAX), least_share: 0.0, faintest, ..Self::default() }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            depth: 10_000,
            walk: 100.0,
            splits: None,
            least_share: 1e-2,
            faintest: 0.0,
            spread: Self::spread_for(DOME_LEVEL),
        }
    }
}
