//! Backend in pure Rust: the compressed wide BVH of the crate `obvhs` (Ylitie, Karras and Laine, *Efficient
//! Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, HPG 2017).

use std::time::Duration;

use glam::{UVec2, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::Ray;
use obvhs::{BvhBuildParams, traverse};

use super::proxy::{Patches, Proxy};
use crate::geometry::{Kind, PrimId, Primitives, Query, Sink};

/// A built hierarchy.
pub struct Obvhs {
    bvh: CwBvh,
    proxy: Proxy,
    /// The first boxes are theirs.
    patches: Patches,
}

impl Obvhs {
    /// Builds over the bounded primitives.
    pub fn new(primitives: &Primitives, proxy: Proxy) -> Self {
        let patches = Patches::new(primitives);
        let aabb = |[min, max]: [[f32; 3]; 2]| Aabb::new(Vec3A::from(min), Vec3A::from(max));
        let of_patches = (0..patches.count()).map(|i| proxy.around(patches.bounds(primitives, i)));
        let others = (primitives.count(Kind::Triangle)..primitives.bounded_count())
            .map(|id| proxy.bounds(primitives, PrimId(id as u32)));
        let boxes: Vec<Aabb> = of_patches.chain(others).map(aabb).collect();
        let bvh = build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        Self { bvh, proxy, patches }
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
            let id = self.bvh.primitive_indices[state.primitive_id as usize] as usize;
            if id < self.patches.count() {
                for i in self.patches.triangles(id) {
                    primitives.propose_triangle(query, i, PrimId(i as u32), sink);
                }
            } else {
                let prim = primitives.count(Kind::Triangle) + id - self.patches.count();
                primitives.propose(query, PrimId(prim as u32), sink);
            }
            ray.tmax = self.proxy.reach(sink.horizon(), &proxy);
        });
    }
}
