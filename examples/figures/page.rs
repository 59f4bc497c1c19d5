//! The page that compares all figures with the paper.

use std::path::Path;

use gonio_embree::output::atomic;

use super::figure::{Figure, Result};

const HEAD: &str = "# The paper's figures

Morgan Schramm, Jay Gondek and Gary Meyer, *Light Scattering Simulations using Complex Subsurface Models* (Graphics Interface
1997), figure by figure: what the paper says, what this program measures on the samples in `assets/samples`, and whether the
two agree. Bands around curves are two standard errors. This page and all pictures on it are made by

```sh
cargo run --release --example figures
```

Figures 1 and 2 of the paper are drawings, figures 8 and 9 measurements of real paper.
";

/// Writes it.
pub fn write(path: &Path, figures: &[(&str, Figure)]) -> Result<()> {
    let mut text = String::from(HEAD);
    for (number, figure) in figures {
        let finds: String = figure.finds.iter().map(|line| format!("- {line}\n")).collect();
        let claims: String =
            figure.claims.iter().map(|c| format!("- [{}] {}\n", if c.holds { "x" } else { " " }, c.what)).collect();
        let verdict = &figure.verdict;
        text += &format!(
            "\n## Figure {number}: {}\n\n![{}](figures/figure-{number}.svg)\n\n[PNG](figures/figure-{number}.png), \
             [numbers](figures/figure-{number}.csv). {}\n\n**The paper says:** {}\n\n**Here:**\n\n{finds}\n\
             **Tested:**\n\n{claims}\n**Do they agree?** {verdict}\n",
            figure.title, figure.title, figure.made_of, figure.says
        );
    }
    Ok(atomic::write(path, text.as_bytes())?)
}
