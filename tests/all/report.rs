//! `report`: a result as a page.

use std::fs;
use std::path::Path;

use gonio_embree::experiment::{Settings, measure};
use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
use gonio_embree::output::{EffectUsed, Measured, Provenance, StackHits, UsedBackend, Validity, netcdf, report};
use gonio_embree::sample::{Description, Sample};

use crate::desk::{Desk, errors};

/// A result as large as that of the README: 17 incidences and 16 wavelengths, but with names nobody should use.
fn nasty() -> Measured {
    let incidences = (0..17).map(|i| Incidence { theta_deg: 5.0 * f64::from(i), phi_deg: 0.0 }).collect();
    let light = Light {
        wavelengths: Wavelengths::from_nm((0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect()).unwrap(),
        incidences,
        polarization: Polarization::Unpolarized,
        source: SourceMode::Line,
    };
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/samples/morpho.toml");
    let description = Description::from_toml(&file).unwrap();
    let sample = Sample::new(&description, &light.wavelengths, light.coherence()).unwrap();
    let bsdf = measure(&sample, &light, &Settings { trees: 200, ..Settings::default() }, |_| {}).unwrap().bsdf;
    let name = |at: &str| format!("{at}</script><script>alert('{at}')</script>&\"{at}\"<!--");
    let provenance = Provenance {
        version: name("version"),
        command: name("command"),
        seed: 1,
        polarization: name("polarization"),
        source_mode: name("source"),
        sample_files: vec![name("file")],
        sample_sha256: name("hash"),
        backend: UsedBackend { name: name("backend"), version: name("library") },
        effects: vec![EffectUsed { name: name("effect"), on: true, reason: name("reason"), bound: 0.01 }],
        validity: Validity {
            smallest_feature_um: Some(1.0),
            small_feature_flux: 0.5,
            edge_flux: 0.5,
            edges: name("edges"),
        },
        stacks: vec![StackHits {
            layers: 12,
            media: vec![name("medium")],
            thickness_um: vec![[0.1, 0.2]],
            hits: 1234,
            flux_share: 0.5,
        }],
        incomplete: None,
    };
    Measured { bsdf, provenance }
}

#[test]
fn names_from_the_file_do_not_get_into_the_page_as_they_are() {
    let page = report::html(&nasty());
    assert!(!page.contains("alert('"), "a name runs as a script");
    for at in ["command", "polarization", "source", "file", "hash", "backend", "effect", "reason", "medium"] {
        let safe = format!(
            "{at}&lt;/script&gt;&lt;script&gt;alert(&#39;{at}&#39;)&lt;/script&gt;&amp;&quot;{at}&quot;&lt;!--"
        );
        assert!(page.contains(&safe), "{at} is missing");
    }
    let count = |text: &str| page.matches(text).count();
    assert_eq!(count("<script"), count("</script>"));
    assert!(!page.contains("{{"), "a place was left open");
}

#[test]
fn the_page_asks_for_nothing_and_is_light_enough_to_mail() {
    let measured = nasty();
    let page = report::html(&measured);
    let lower = page.to_lowercase();
    for call in
        ["http:", "https:", "//cdn", "src=", "url(", "@import", "import(", "fetch(", "xmlhttprequest", "sendbeacon"]
    {
        assert!(!lower.contains(call), "{call} in the page");
    }
    assert!(page.contains("default-src 'none'"), "the browser is not told to refuse what is not in the page");
    assert!(page.len() < 1_500_000, "{} bytes", page.len());
    assert_eq!(page, report::html(&measured), "the same result gives another page");
}

#[test]
fn what_is_doubtful_is_told() {
    let page = report::html(&nasty());
    for text in [
        "ray optics is in doubt for up to 50.0 % of the light",
        "films end near where up to 50.0 % of the light met them",
        "and 11 more",
        "100 nm to 200 nm",
    ] {
        assert!(page.contains(text), "{text}");
    }
}

#[test]
fn the_command_writes_a_page_beside_the_result() {
    let desk = Desk::of("report", "writes");
    let measured = nasty();
    fs::write(desk.0.join("a.nc"), netcdf::to_bytes(&measured).unwrap()).unwrap();
    let output = desk.run(&["a.nc"]);
    assert!(output.status.success() && output.stdout.is_empty(), "{}", errors(&output));
    assert!(errors(&output).starts_with("wrote a.html ("), "{}", errors(&output));
    let output = desk.run(&["a.nc", "-o", "b.html", "--quiet"]);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", errors(&output));
    assert_eq!(desk.names(), ["a.html", "a.nc", "b.html"]);
    let page = fs::read_to_string(desk.0.join("b.html")).unwrap();
    assert_eq!(page, fs::read_to_string(desk.0.join("a.html")).unwrap());
    assert_eq!(page, report::html(&measured));
}

#[test]
fn what_cannot_be_reported_is_said() {
    let desk = Desk::of("report", "refuses");
    fs::write(desk.0.join("text.nc"), "no result").unwrap();
    for (args, told) in [
        (&["none.nc"][..], "error: none.nc: cannot be read"),
        (&["text.nc"], "error: text.nc: "),
        (&["text.nc", "-o", "text.nc"], "error: -o text.nc: this is the result itself; name another file"),
    ] {
        let output = desk.run(args);
        assert_eq!(output.status.code(), Some(2), "{}", errors(&output));
        assert!(errors(&output).starts_with(told), "{}", errors(&output));
    }
    assert_eq!(desk.names(), ["text.nc"]);
    fs::write(desk.0.join("a.nc"), netcdf::to_bytes(&nasty()).unwrap()).unwrap();
    let output = desk.run(&["a.nc", "-o", "none/a.html"]);
    assert_eq!(output.status.code(), Some(3), "{}", errors(&output));
}
