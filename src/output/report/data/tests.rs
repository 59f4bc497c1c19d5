//! The payload, read again as the page reads it, against the result.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use super::*;
use crate::bsdf::{Derived, FacetValue, Ledger};
use crate::dome::Facet;

/// A dome of level 1 with one of its facets divided. Facets below the horizon were not hit; the second and the third
/// wavelength share their rays.
fn result() -> Bsdf {
    let coarse = Facet::all(1).filter(|f| f.code != 7);
    let mut facets: Vec<Facet> = coarse.chain(Facet { level: 1, code: 7 }.children()).collect();
    facets.sort_by_key(|f| f.code << (2 * (2 - f.level)));
    let value = |f: &Facet, w: usize| {
        let value = 1e-6 * f64::from(f.code + 1).powi(3) * [1.0, 7.3, 7.3][w];
        Estimate { value, se: value * [0.01, 1e-9, 1e-9][w] }
    };
    let of = |facet: Facet| {
        let up = facet.center().z > 0.0;
        let value = (0..3).map(|w| if up { value(&facet, w) } else { Estimate::default() }).collect();
        FacetValue { facet, trees: if up { u64::from(facet.code) + 1 } else { 0 }, value, mueller: Vec::new() }
    };
    let facets: Vec<FacetValue> = facets.into_iter().map(of).collect();
    let mut ledger = Ledger::default();
    for (i, (_, entry)) in ledger.entries_mut().into_iter().enumerate() {
        *entry = (0..3).map(|w| Estimate { value: 0.1 / (i + w + 1) as f64, se: 1e-4 }).collect();
    }
    let scattering = Scattering {
        incidence: Incidence { theta_deg: 35.0, phi_deg: 20.0 },
        straight_deg: vec![35.0, f64::NAN, 34.0],
        trees: 1000,
        segments: 5000,
        absorbed_by: vec![ledger.absorbed.clone()],
        ledger,
        deltas: None,
        facets,
        derived: Derived::default(),
    };
    Bsdf { wavelength_nm: vec![400.0, 550.0, 700.0], groups: vec!["</script><b>".into()], incidences: vec![scattering] }
}

fn bytes(v: &Value) -> Vec<u8> {
    STANDARD.decode(v.as_str().unwrap()).unwrap()
}

fn words(v: &Value) -> Vec<u32> {
    bytes(v).as_chunks::<4>().0.iter().map(|&c| u32::from_le_bytes(c)).collect()
}

/// Estimates of which the page knows codes.
fn estimates(packed: &Value, data: &Data<'_>) -> Vec<Estimate> {
    let values = bytes(&packed["values"]);
    let of = |(v, &e): (&[u8; 2], &u8)| {
        let value = data.values.number(u32::from(u16::from_le_bytes(*v)));
        Estimate { value, se: value * data.errors.number(u32::from(e)) }
    };
    values.as_chunks::<2>().0.iter().zip(&bytes(&packed["errors"])).map(of).collect()
}

fn close(read: Estimate, truth: Estimate, (value, error): (f64, f64)) {
    let se = if truth.value == 0.0 { 0.0 } else { truth.se.max(LEAST_ERROR * truth.value) };
    assert!((read.value - truth.value).abs() <= value * 1.000_001 * truth.value, "{read:?} {truth:?}");
    // The error is packed as a share of the value, so that the errors of both come together.
    assert!((read.se - se).abs() <= (error + value * 1.1) * se, "{read:?} {truth:?}");
}

#[test]
fn facets_come_back() {
    let bsdf = result();
    let data = Data::new(&bsdf);
    let json: Value = serde_json::from_str(&data.json()).unwrap();
    let (page, truth) = (&json["incidences"][0], &bsdf.incidences[0]);
    let keys: Vec<u32> = truth.facets.iter().map(|f| u32::from(f.facet.level) << 28 | f.facet.code).collect();
    assert_eq!(words(&page["facets"]), keys);
    assert_eq!(words(&page["hits"]), truth.facets.iter().map(|f| f.trees as u32).collect::<Vec<_>>());
    assert_eq!(json["columns"], serde_json::json!([0, 1, 1]));
    let (read, hit) = (estimates(&page["bsdf"], &data), truth.facets.iter().filter(|f| f.trees > 0));
    assert_eq!(read.len(), 2 * hit.clone().count());
    for (read, facet) in read.chunks(2).zip(hit) {
        for w in 0..3 {
            close(read[data.columns[w]], facet.value[w], data.rounding());
        }
    }
    assert!(data.rounding().0 < 1e-3 && data.rounding().1 < 0.04, "{:?}", data.rounding());
}

#[test]
fn scans_come_back_and_one_aperture_sees_the_mirror_direction() {
    let bsdf = result();
    let data = Data::new(&bsdf);
    let json: Value = serde_json::from_str(&data.json()).unwrap();
    let page = &json["incidences"][0];
    let count = page["readings"].as_u64().unwrap() as usize;
    assert_eq!((page["from_deg"].as_f64(), count), (Some(-89.0), 90));
    let angles_deg: Vec<f64> = (0..count).map(|i| -89.0 + APERTURE_DEG * i as f64).collect();
    for (name, below) in [("above", false), ("below", true)] {
        let arm = Arm { angles_deg: angles_deg.clone(), aperture_deg: APERTURE_DEG, below, turn_deg: 0.0 };
        let readings = bsdf.scan(&arm, 0).readings;
        let read = estimates(&page[name], &data);
        assert_eq!(read.len(), 3 * count);
        for (read, reading) in read.chunks(3).zip(&readings) {
            (0..3).for_each(|w| close(read[w], reading.value[w], data.rounding()));
        }
        // Nothing but the delta is below; it is seen once.
        let seen = readings.iter().filter(|r| r.value[0].value > 0.0).count();
        assert!(!below || seen == 1, "{seen}");
    }
}

#[test]
fn the_ledger_comes_back() {
    let bsdf = result();
    let json: Value = serde_json::from_str(&Data::new(&bsdf).json()).unwrap();
    let page = &json["incidences"][0];
    let read: Vec<f32> = words(&page["ledger"]).into_iter().map(f32::from_bits).collect();
    let s = &bsdf.incidences[0];
    let entries = s.ledger.entries().into_iter().map(|(_, e)| e).chain(&s.absorbed_by);
    let truth: Vec<f32> = entries.flatten().flat_map(|e| [e.value as f32, e.se as f32]).collect();
    assert_eq!(read, truth);
    assert_eq!(json["ledger"].as_array().unwrap().len() * 3 * 2 + 3 * 2, read.len());
    assert_eq!(page["straight_deg"], serde_json::json!([35.0, null, 34.0]));
}

#[test]
fn no_name_ends_the_element_that_holds_the_payload() {
    let bsdf = result();
    let text = Data::new(&bsdf).json();
    assert!(!text.contains('<'));
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["groups"][0], "</script><b>");
}
