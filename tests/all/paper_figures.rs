//! What the figures of the paper must show (`examples/figures`), with few rays here and with all of them in the slow tier. A
//! statement of standard errors fails by chance as often as it says: once in 22 times for two of them, but seeds are fixed.
#![allow(dead_code, clippy::print_stdout)]

#[path = "../../examples/figures/christiansen.rs"]
mod christiansen;
#[path = "../../examples/figures/feather.rs"]
mod feather;
#[path = "../../examples/figures/figure.rs"]
mod figure;
#[path = "../../examples/figures/morpho.rs"]
mod morpho;
#[path = "../../examples/figures/paper.rs"]
mod paper;

use figure::{Effort, Figure, Result};

fn check(draw: fn(Effort) -> Result<Figure>, effort: Effort) {
    let figure = draw(effort).unwrap();
    figure.finds.iter().for_each(|line| println!("{line}"));
    let failed: Vec<&str> = figure.claims.iter().filter(|c| !c.holds).map(|c| &c.what[..]).collect();
    assert!(!figure.claims.is_empty() && failed.is_empty(), "{failed:#?}\n{:#?}", figure.finds);
    let png = gonio_embree::plot::png(&figure.svg).unwrap();
    assert!(png.len() > 10_000, "{} has next to nothing in it", figure.title);
}

macro_rules! figures {
    ($($quick:ident, $full:ident: $draw:path;)*) => {$(
        #[test]
        fn $quick() {
            check($draw, Effort::Quick);
        }

        #[test]
        #[ignore = "slow: cargo test --release paper_figures:: -- --ignored (minutes)"]
        fn $full() {
            check($draw, Effort::Full);
        }
    )*};
}

figures! {
    figure_3, figure_3_in_full: morpho::colours;
    figure_4, figure_4_in_full: christiansen::indices;
    figure_5, figure_5_in_full: christiansen::filter;
    figure_6, figure_6_in_full: feather::films_and_plates;
    figure_7, figure_7_in_full: feather::bricks;
    figure_10, figure_10_in_full: paper::webs;
    figure_11, figure_11_in_full: paper::coating;
}
