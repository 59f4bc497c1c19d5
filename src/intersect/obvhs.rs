//! Backend in pure Rust: the compressed wide BVH of the crate `obvhs` (Ylitie, Karras and Laine, *Efficient
//! Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, HPG 2017).

use std::time::Duration;

use glam::{UVec2, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::Ray;
use obvhs::{BvhBuildParams, traverse};

use super::proxy::Proxy;
use crate::geometry::{PrimId, Primitives, Query, Sink};

/// A built hierarchy.
pub struct Obvhs {
    bvh: CwBvh,
    proxy: Proxy,
}

impl Obvhs {
    /// Builds over the bounded primitives.
    pub fn new(primitives: &Primitives, proxy: Proxy) -> Self {
        let boxes: Vec<Aabb> = (0..primitives.bounded_count() as u32)
            .map(|id| {
                let [min, max] = proxy.bounds(primitives, PrimId(id));
                Aabb::new(Vec3A::from(min), Vec3A::from(max))
            })
            .collect();
        let bvh = build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        Self { bvh, proxy }
    }

    /// Offers the crossings of the primitives whose boxes the ray meets.
    #[inline]
    pub fn propose(&self, primitives: &Primitives, query: &Query, sink: &mut impl Sink) {
        if self.bvh.nodes.is_empty() {
            return;
        }
        let proxy = self.proxy.ray(&query.ray);
        let reach = self.proxy.reach(sink.horizon(), &proxy);
        let mut ray = Ray::new(Vec3A::from(proxy.origin), Vec3A::from(proxy.dir), 0.0, reach);
        let mut state = self.bvh.new_traversal(ray.direction);
        let mut node;
        traverse!(self.bvh, node, state, node.intersect_ray(&ray, state.oct_inv4), {
            let id = self.bvh.primitive_indices[state.primitive_id as usize];
            primitives.propose(query, PrimId(id), sink);
            ray.tmax = self.proxy.reach(sink.horizon(), &proxy);
        });
    }
}
