//! The cases in which numbers go wrong first: each within its bound of what is true, and each in `docs/hard-cases.md`.
#![allow(clippy::print_stdout, reason = "figures are shown with --nocapture")]

use crate::common::hard::{Case, Tier};

fn check(tier: Tier) -> Vec<Case> {
    let cases: Vec<Case> = crate::common::hard::all(tier).into_iter().flat_map(|(_, cases)| cases).collect();
    for c in &cases {
        let other = |x: Option<f64>| x.map_or(f64::NAN, |x| c.error(x));
        println!(
            "{} | {} | {:e} | ours {:e}, float32 {:e}, naive {:e} | bound {:e}",
            c.name,
            c.quantity,
            c.truth,
            c.error(c.ours),
            other(c.single),
            other(c.naive.map(|n| n.1)),
            c.bound
        );
    }
    let wrong: Vec<&Case> = cases.iter().filter(|c| !c.holds()).collect();
    assert!(wrong.is_empty(), "{} of {} cases: {wrong:#?}", wrong.len(), cases.len());
    cases
}

#[test]
fn all_hard_cases_are_within_their_bounds_and_in_the_table() {
    let page = std::fs::read_to_string("docs/hard-cases.md").unwrap();
    for case in check(Tier::Quick) {
        let line = format!("| {} | {} |", case.name, case.quantity);
        assert!(page.contains(&line), "docs/hard-cases.md has no line for `{line}`");
    }
}

#[test]
#[ignore = "slow: cargo test --release hard_cases:: -- --ignored (ten seconds)"]
fn nothing_leaks_in_a_million_rays() {
    check(Tier::Slow);
}
