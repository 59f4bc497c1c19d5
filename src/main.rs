//! scratch
#![allow(clippy::print_stdout)]
use gonio_embree::*;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let trees: f64 = std::env::args().nth(2).unwrap().parse().unwrap();
    let theta: f64 = std::env::args().nth(3).unwrap().parse().unwrap();
    let backend = std::env::args().nth(4).unwrap().parse().unwrap();
    let threads = std::env::args().nth(5).unwrap().parse().unwrap();
    let d = sample::Description::from_toml(path.as_ref()).unwrap_or_else(|e| panic!("{e}"));
    let light = light::Light {
        wavelengths: light::Wavelengths::from_nm((0..16).map(|i| 400.0 + 20.0 * i as f64).collect()).unwrap(),
        incidences: vec![light::Incidence { theta_deg: theta, phi_deg: 0.0 }],
        polarization: light::Polarization::Unpolarized,
        source: light::SourceMode::Band,
    };
    let s = sample::Sample::new(&d, &light.wavelengths, light.coherence_length()).unwrap_or_else(|e| panic!("{e}"));
    println!(
        "prims {} solids {} lonely {}",
        s.primitives.len(),
        s.solids.len(),
        s.solids.iter().filter(|s| s.lonely).count()
    );
    let set = experiment::Settings {
        trees: trees as u64,
        seed: 1,
        threads,
        backend,
        dome_level: 5,
        limits: plan::Limits::default(),
        effects: plan::Wanted::Auto,
    };
    let o = experiment::measure(&s, &light, &set, |_| {}).unwrap();
    let i = &o.bsdf.incidences[0];
    for e in &o.plan.effects {
        println!("{:14} {} {}", e.name, e.on, e.reason);
    }
    for (n, e) in i.ledger.entries() {
        println!("{n:14} {:.6} ± {:.1e}   {:.6} ± {:.1e}", e[0].value, e[0].se, e[8].value, e[8].se);
    }
    println!("sum-1 {:?}", i.ledger.sum().iter().map(|s| s - 1.0).fold(0.0f64, |a, b| a.max(b.abs())));
    println!(
        "segments/tree {:.2}  facets {}  stacks {:?}",
        i.segments as f64 / i.trees as f64,
        i.facets.len(),
        o.stacks.len()
    );
    println!(
        "{:.2} s ({:.2} tracing), {:.4} Mtrees/s {:.3} Mseg/s",
        o.seconds,
        o.tracing_seconds,
        i.trees as f64 / o.tracing_seconds / 1e6,
        i.segments as f64 / o.tracing_seconds / 1e6
    );
}
