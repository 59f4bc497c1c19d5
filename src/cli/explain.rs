//! `explain`: the plan of a measurement, before it is made.

use gonio_embree::experiment::explain;
use gonio_embree::output::plan;
use gonio_embree::sample::Sample;

use super::measure::Options;
use super::{Failure, answer};

/// Plans, times some trees, and prints what came out.
pub fn run(options: &Options) -> Result<(), Failure> {
    let light = options.light()?;
    let description = options.description()?;
    let sample =
        Sample::new(&description, &light.wavelengths, light.coherence()).map_err(|e| Failure::Input(e.to_string()))?;
    let settings = options.settings()?;
    let explanation = explain(&sample, &light, &settings).map_err(|e| Failure::Cannot(e.to_string()))?;
    answer(&if options.json { plan::json(&explanation) + "\n" } else { plan::text(&explanation) })
}
