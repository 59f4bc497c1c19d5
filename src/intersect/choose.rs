//! Which backend works: the only place that tests what was compiled in.

use std::fmt;
use std::str::FromStr;

#[cfg(has_embree)]
use super::embree::Embree;
use super::grid::{self, Grid};
#[cfg(feature = "obvhs")]
use super::obvhs::Obvhs;
use super::proxy::Proxy;
use super::{Coherence, brute};
use crate::geometry::{Aabb, All, Nearest, Primitives, Query};

#[cfg(not(any(feature = "embree", feature = "obvhs")))]
compile_error!("gonio-embree needs a way to intersect rays: enable the feature `embree`, `obvhs` or both");

/// Who intersects rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// Whichever is the fastest for the scene ([`Backend::fit`]).
    Auto,
    /// Intel Embree, as installed on the machine.
    Embree,
    /// The crate obvhs.
    Obvhs,
    /// Cells of equal size; for packings of spheres only.
    Grid,
    /// Every primitive is asked.
    Brute,
}

impl Backend {
    /// The backends of this build that take any scene, fastest first.
    pub fn available() -> Vec<Self> {
        let mut out = Vec::new();
        if cfg!(has_embree) {
            out.push(Self::Embree);
        }
        if cfg!(feature = "obvhs") {
            out.push(Self::Obvhs);
        }
        out.push(Self::Brute);
        out
    }

    /// This one or, for [`Backend::Auto`], the fastest of this build for what is in `domain`.
    #[must_use]
    pub fn fit(self, primitives: &Primitives, domain: Aabb) -> Self {
        match self {
            Self::Auto if grid::is_best(primitives, domain) => Self::Grid,
            Self::Auto => Self::available()[0],
            chosen => chosen,
        }
    }

    /// Name on the command line and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Embree => "embree",
            Self::Auto => "auto",
            Self::Obvhs => "obvhs",
            Self::Grid => "grid",
            Self::Brute => "brute",
        }
    }

    /// Version of the library behind it, as built; that of this crate for `brute`.
    pub fn version(self) -> String {
        match self {
            #[cfg(has_embree)]
            Self::Embree => super::embree::header_version(),
            #[cfg(not(has_embree))]
            Self::Embree => "not built in".into(),
            Self::Obvhs => "0.4".into(),
            Self::Auto | Self::Grid | Self::Brute => env!("CARGO_PKG_VERSION").into(),
        }
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Backend {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "auto" => Ok(Self::Auto),
            "embree" => Ok(Self::Embree),
            "obvhs" => Ok(Self::Obvhs),
            "grid" => Ok(Self::Grid),
            "brute" => Ok(Self::Brute),
            _ => Err(format!("unknown backend `{s}`: expected auto, embree, obvhs, grid or brute")),
        }
    }
}

/// Why a backend cannot work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BackendError {
    /// It is not part of this build.
    NotBuiltIn(Backend),
    /// It does not take what is in the scene.
    NotForThis(Backend),
    /// Its library failed.
    Library(String),
}

impl fmt::Display for BackendError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotBuiltIn(b) => {
                let names: Vec<_> = Backend::available().iter().map(|b| b.name()).collect();
                write!(f, "backend `{b}` is not part of this build, which has {}", names.join(", "))?;
                match b {
                    Backend::Embree => f.write_str("; apt-get install libembree-dev libclang-dev, then build again"),
                    _ => write!(f, "; build with `--features {b}`"),
                }
            }
            Self::NotForThis(b) => {
                write!(f, "backend `{b}` is for spheres alone, many and everywhere alike; give --backend auto")
            }
            Self::Library(why) => f.write_str(why),
        }
    }
}

impl std::error::Error for BackendError {}

/// A built accelerator.
pub(super) enum Accelerator {
    #[cfg(has_embree)]
    Embree(Embree),
    #[cfg(feature = "obvhs")]
    Obvhs(Obvhs),
    Grid(Grid),
    Brute,
}

impl Accelerator {
    pub fn new(primitives: &std::sync::Arc<Primitives>, domain: Aabb, backend: Backend) -> Result<Self, BackendError> {
        let proxy = Proxy::new(primitives, domain);
        match backend.fit(primitives, domain) {
            #[cfg(has_embree)]
            Backend::Embree => Embree::new(primitives, proxy).map(Self::Embree).map_err(BackendError::Library),
            #[cfg(feature = "obvhs")]
            Backend::Obvhs => Ok(Self::Obvhs(Obvhs::new(primitives, proxy))),
            Backend::Grid if backend == Backend::Auto || grid::is_best(primitives, domain) => {
                Ok(Self::Grid(Grid::new(primitives, domain)))
            }
            Backend::Grid => Err(BackendError::NotForThis(Backend::Grid)),
            Backend::Auto => unreachable!("one has been chosen"),
            Backend::Brute => {
                let _ = proxy;
                Ok(Self::Brute)
            }
            #[cfg(not(all(has_embree, feature = "obvhs")))]
            missing => Err(BackendError::NotBuiltIn(missing)),
        }
    }

    pub fn nearest(
        &self,
        primitives: &Primitives,
        queries: &[Query],
        which: &[usize],
        coherence: Coherence,
        answers: &mut [Nearest],
    ) {
        let _ = coherence;
        match self {
            #[cfg(has_embree)]
            Self::Embree(e) => e.nearest(queries, which, coherence, answers),
            #[cfg(feature = "obvhs")]
            Self::Obvhs(o) => which.iter().for_each(|&i| o.propose(primitives, &queries[i], &mut answers[i])),
            Self::Grid(g) => g.nearest(primitives, queries, which, answers),
            Self::Brute => which.iter().for_each(|&i| brute::propose(primitives, &queries[i], &mut answers[i])),
        }
    }

    pub fn all(&self, primitives: &Primitives, query: &Query, found: &mut All) {
        match self {
            #[cfg(has_embree)]
            Self::Embree(e) => e.all(query, found),
            #[cfg(feature = "obvhs")]
            Self::Obvhs(o) => o.propose(primitives, query, found),
            Self::Grid(g) => g.propose(primitives, query, found),
            Self::Brute => brute::propose(primitives, query, found),
        }
    }
}
