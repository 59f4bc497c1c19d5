//! Primitives in double precision: the truth about where light meets matter.
//!
//! Every backend of [`crate::intersect`] only *proposes* primitives; what is decided here (distance, order,
//! side, normal) is therefore the same for all of them, bit for bit. Lengths are micrometres, directions are
//! unit vectors, normals point out of the solid.
//!
//! Three rules replace the usual small offsets along the ray:
//!
//! 1. **Identity.** Each geometric surface has a [`SurfaceId`]. Faces that lie in one plane share one id and
//!    one plane equation, so coincident faces are met at bit-equal distances and are one interface. A ray that
//!    starts on a surface ignores that plane, or takes only the *other* root of that sphere or cylinder.
//! 2. **Order.** Crossings are ordered by ([distance](f64), [`SurfaceId`]); a ray that passes an interface
//!    without being bent continues after that pair, not after a distance.
//! 3. **Parity.** Convex solids are met as intervals (enter, leave), triangles by exact signs of edge
//!    functions, so a closed body is always entered and left in pairs.
//!
//! To add a shape: give it a file with its interval (or crossing), its bounds and its normal, a list in
//! [`Primitives`], and an arm in each `match` on [`Kind`]; the tests in `tests/all/backends.rs` then cover it.

mod aabb;
mod cuboid;
mod cylinder;
mod layer;
mod pairs;
mod plane;
mod primitives;
mod query;
mod sphere;
mod triangle;

pub use aabb::Aabb;
pub use cuboid::Cuboid;
pub use cylinder::Cylinder;
pub use layer::Layer;
pub use pairs::Pairs;
pub use plane::{COINCIDENT, Plane};
pub use primitives::{Builder, Kind, PrimId, Primitives, Shape};
pub use query::{All, Crossing, Hit, Nearest, Order, Query, Ray, Sink, SurfaceId};
pub use sphere::{Chord, Sphere};
pub use triangle::{Shear, Triangle};
