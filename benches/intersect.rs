//! Raw rate of each backend and packet width on 14,000 packed spheres, against each other in one run.
//! `cargo bench --bench intersect`
#![allow(missing_docs, clippy::print_stdout)]

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use gonio_embree::geometry::{Aabb, Builder, Nearest, Primitives, Query, Ray, Shape, Sphere};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::intersect::{Coherence, Scene};
use gonio_embree::sample::generate::packing::Packing;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

const RAYS: usize = 1 << 18;

fn spheres() -> Builder {
    let packing =
        Packing { count: 14_000, radius: 0.010_077, size: DVec3::new(1.0, 1.0, 0.2), periodic: false, seed: 1 };
    let mut builder = Builder::default();
    for (i, center) in packing.centers().unwrap().into_iter().enumerate() {
        builder.add(Shape::Sphere(Sphere { center, radius: packing.radius }), i as u32);
    }
    builder
}

fn direction(rng: &mut Xoshiro256PlusPlus) -> DVec3 {
    let z = 2.0 * rng.random::<f64>() - 1.0;
    let (s, c) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * c, r * s, z)
}

fn scattered(primitives: &Primitives) -> Vec<Query> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    (0..RAYS)
        .map(|_| {
            let p = DVec3::new(rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5, 0.2 * rng.random::<f64>());
            primitives.query(Ray { origin: p, dir: direction(&mut rng) })
        })
        .collect()
}

fn coherent(primitives: &Primitives) -> Vec<Query> {
    let dir = DVec3::new(0.5, 0.0, -0.75f64.sqrt());
    (0..RAYS as u32)
        .map(|i| {
            // Morton order.
            let part = |k: u32| (0..9).fold(0, |a, b| a | (i >> (2 * b + k) & 1) << b);
            let (x, y) = (f64::from(part(0)) / 512.0 - 0.5, f64::from(part(1)) / 512.0 - 0.5);
            primitives.query(Ray { origin: DVec3::new(x, y, 0.3), dir })
        })
        .collect()
}

fn rate(mut work: impl FnMut()) -> f64 {
    work();
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        work();
        best = best.min(start.elapsed().as_secs_f64());
    }
    RAYS as f64 / best / 1e6
}

fn main() {
    let primitives = Arc::new(spheres().finish());
    for (name, queries, coherence) in [
        ("coherent", coherent(&primitives), Coherence::Coherent),
        ("scattered", scattered(&primitives), Coherence::Scattered),
    ] {
        println!("{name}: Mrays/s, one thread");
        for backend in [Backend::Embree, Backend::Obvhs] {
            let Ok(scene) = Scene::new(primitives.clone(), Aabb::INFINITE, backend) else { continue };
            let mut answers = vec![Nearest::none(0.0); 1024];
            let which: Vec<usize> = (0..1024).collect();
            let r = rate(|| {
                for q in queries.chunks(1024) {
                    scene.nearest(q, &which, coherence, &mut answers);
                    black_box(&answers);
                }
            });
            println!("  {:12} {r:6.2}", backend.name());
        }
        widths(&primitives, &queries, coherence);
    }
}

#[cfg(has_embree)]
fn widths(primitives: &Arc<Primitives>, queries: &[Query], coherence: Coherence) {
    use gonio_embree::intersect::embree::{Embree, Width};
    use gonio_embree::intersect::proxy::Proxy;
    let embree = Embree::new(primitives, Proxy::new(primitives, Aabb::INFINITE)).unwrap();
    let mut answers: Vec<Nearest> = Vec::new();
    let which: Vec<usize> = (0..1024).collect();
    for width in [Width::One, Width::Four, Width::Eight, Width::Sixteen] {
        let r = rate(|| {
            for q in queries.chunks(1024) {
                answers.clear();
                answers.extend(q.iter().map(|q| Nearest::none(q.limit)));
                embree.nearest_by(width, q, &which, coherence, &mut answers);
                black_box(&answers);
            }
        });
        println!("  embree/{width:?} {r:6.2}");
    }
}

#[cfg(not(has_embree))]
fn widths(_: &Arc<Primitives>, _: &[Query], _: Coherence) {}
