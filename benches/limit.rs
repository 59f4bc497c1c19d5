//! How near the whole simulation is to what the accelerator alone can do: the rays that a measurement searches for are
//! recorded, and shot again at the same bodies as Embree's own geometry, in single precision, with nothing else to do.
//! `cargo bench --bench limit`
#![allow(missing_docs, clippy::print_stdout)]

#[cfg(has_embree)]
mod limit {
    use std::time::Instant;

    use gonio_embree::experiment::{Settings, measure};
    use gonio_embree::geometry::Query;
    use gonio_embree::intersect::Scene;
    use gonio_embree::intersect::choose::Backend;
    use gonio_embree::intersect::embree::Bare;
    use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
    use gonio_embree::optics::field::{Field, Stokes};
    use gonio_embree::plan::{Options, Plan};
    use gonio_embree::sample::{Description, Sample};
    use gonio_embree::trace::{All, Batch, Detect, Exit, Kernel, Recorder, Unit, run};

    /// Rays that are recorded.
    const RAYS: usize = 1 << 19;
    const TREES: u32 = 1 << 13;

    /// Keeps the rays that are searched for.
    struct Rays(Vec<[f32; 8]>);

    impl<F: Field> Recorder<F> for Rays {
        fn exit(&mut self, _: &Exit<'_, F>) {}

        fn search(&mut self, queries: &[Query], which: &[usize]) {
            for query in which.iter().map(|&i| &queries[i]) {
                let [o, d] = [query.ray.origin, query.ray.dir].map(|v| v.as_vec3());
                // The start is on a face: Embree is told to begin a little behind it.
                self.0.push([o.x, o.y, o.z, 1e-4, d.x, d.y, d.z, query.limit as f32]);
            }
        }
    }

    impl<F: Field> Detect<F> for Rays {
        type Part = Vec<[f32; 8]>;

        fn begin(&mut self, _: usize) {}

        fn finish(&mut self, _: u64) -> Vec<[f32; 8]> {
            std::mem::take(&mut self.0)
        }
    }

    fn light(nm: usize) -> Light {
        Light {
            wavelengths: Wavelengths::from_nm((0..nm).map(|i| 400.0 + 20.0 * i as f64).collect()).unwrap(),
            incidences: vec![Incidence { theta_deg: 30.0, phi_deg: 0.0 }],
            polarization: Polarization::Unpolarized,
            source: SourceMode::Band,
        }
    }

    /// Rays of some trees, in the order in which they are searched for.
    fn record(sample: &Sample, light: &Light, options: &Options) -> Vec<[f32; 8]> {
        let scene = Scene::new(sample.primitives.clone(), sample.domain, Backend::Auto).unwrap();
        let plan = Plan::new(sample, light, options);
        let kernel = Kernel::new(sample, &scene, &plan, light);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let units: Vec<Unit> =
            (0..64).flat_map(|scramble| Unit::cut(Batch { seed: 1, incidence: 0, scramble }, TREES)).collect();
        let mut rays = Vec::new();
        run::<Stokes, All, _>(
            &kernel,
            light,
            &units,
            &pool,
            || Rays(Vec::new()),
            |_, part, _| {
                rays.extend(part);
                rays.len() < RAYS
            },
        );
        rays.truncate(RAYS);
        rays
    }

    pub fn case(name: &str, description: &Description, wavelengths: usize, options: Options) {
        // Some cases only: cargo bench --bench limit -- feather
        let mut wanted = std::env::args().skip(1).filter(|a| !a.starts_with("--")).peekable();
        if wanted.peek().is_some() && !wanted.any(|w| name.contains(&w)) {
            return;
        }
        let light = light(wavelengths);
        let start = Instant::now();
        let sample = Sample::new(description, &light.wavelengths, light.coherence()).unwrap();
        let built = start.elapsed().as_secs_f64();
        let rays = record(&sample, &light, &options);
        let bare = Bare::new(&sample.primitives);
        let settings = |threads| Settings { trees: 200_000, threads, options, ..Settings::default() };
        let (mut raw, mut whole, mut both) = (0.0f64, [0.0f64; 2], 0.0f64);
        // Alternating, and the best of each: what else the machine does passes by.
        for _ in 0..3 {
            let start = Instant::now();
            let hits = bare.shoot(&rays);
            raw = raw.max(rays.len() as f64 / start.elapsed().as_secs_f64());
            assert!(hits > 0);
            for threads in [1, 2] {
                let o = measure(&sample, &light, &settings(threads), |_| {}).unwrap();
                let s = &o.bsdf.incidences[0];
                let rate = s.trees as f64 / o.tracing_seconds;
                if threads == 2 {
                    both = both.max(rate);
                } else if rate > whole[0] {
                    whole = [rate, s.segments as f64 / o.tracing_seconds];
                }
            }
        }
        println!(
            "{name:42} {:8.2} {:8.2} {:8.2} {:6.2} {:6.2} {:7.2}",
            whole[0] / 1e6,
            whole[1] / 1e6,
            raw / 1e6,
            whole[1] / raw,
            both / whole[0],
            built
        );
    }
}

#[cfg(has_embree)]
fn main() {
    use gonio_embree::plan::{Limits, Name, Options, Wanted};
    use gonio_embree::sample::Description;

    println!(
        "{:42} {:>8} {:>8} {:>8} {:>6} {:>6} {:>7}",
        "one thread", "Mtree/s", "Mseg/s", "bare", "part", "2 thr", "build/s"
    );
    let of = |text: &str| Description::from_text(text).unwrap().0;
    let path = Options { limits: Limits { depth: 64, splits: Some(0), ..Limits::default() }, ..Options::default() };
    // The plan sees that indices do not vary, so that one field and the lengths in each medium say all; or every wavelength has a
    // field of its own.
    let phases = Options { wanted: Wanted::AUTO.with(Name::Phase, true), ..path };
    let all = Options { wanted: Wanted::ALL, ..path };
    for (name, matrix) in [("14,000 spheres n 1.5 in 1.33", "1.33"), ("14,000 spheres n 1.5 in 1.52", "1.52")] {
        let text = format!(
            "[sample]\nabove = \"m\"\nbelow = \"m\"\n[media]\nm = {matrix}\nglass = 1.5\n[[generate]]\nkind = \"packing\"\n\
             count = 14000\nradius = 1.0077\nsize = [100, 100, 20]\nmedium = \"glass\"\nseed = 1\n"
        );
        limit::case(&format!("{name}, 1 λ"), &of(&text), 1, path);
        limit::case(&format!("{name}, 20 λ"), &of(&text), 20, path);
        limit::case(&format!("{name}, 20 λ, phases"), &of(&text), 20, phases);
        limit::case(&format!("{name}, 20 λ, 20 fields"), &of(&text), 20, all);
    }
    let feather = "[media]\nplatelet = 2.0\ncore = 1.5\n[[generate]]\nkind = \"bricks\"\nmedium = \"platelet\"\ncore = \"core\"\n";
    limit::case("feather, 16 λ", &of(feather), 16, Options::default());
    let rough = "[[generate]]\nkind = \"rough\"\nrms = 0.5\nlength = 4\nsize = [100, 100]\npoints = [500, 500]\nmedium = \"glass\"\nseed = 1\n[media]\nglass = 1.5\n";
    limit::case("relief of 500,000 triangles, 1 λ", &of(rough), 1, Options::default());
    let web = Description::from_toml("assets/samples/web-random.toml".as_ref()).unwrap();
    limit::case("fibre web, 1 λ", &web, 1, Options::default());
}

#[cfg(not(has_embree))]
fn main() {
    println!("built without Embree: there is no limit to compare with");
}
