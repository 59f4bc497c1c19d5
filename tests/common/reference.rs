//! The numbers in `tests/reference`, and estimates beside them.

use gonio_embree::dome::Estimate;
use serde_json::Value;

/// The cases of a table of `closed_forms.json`.
pub fn closed_forms(table: &str) -> Vec<Case> {
    let text = std::fs::read_to_string("tests/reference/closed_forms.json").unwrap();
    let all: Value = serde_json::from_str(&text).unwrap();
    let cases = all[table].get("cases").unwrap_or(&all[table]);
    cases.as_array().unwrap_or_else(|| panic!("there is no {table}")).iter().cloned().map(Case).collect()
}

/// One of them.
#[derive(Clone, Debug)]
pub struct Case(Value);

impl Case {
    /// A number, printed as one or in quotes.
    pub fn number(&self, key: &str) -> f64 {
        let value = &self.0[key];
        value.as_str().map_or_else(|| value.as_f64(), |s| s.parse().ok()).unwrap_or_else(|| panic!("{key}: {value}"))
    }

    /// A word.
    pub fn word(&self, key: &str) -> &str {
        self.0[key].as_str().unwrap_or_else(|| panic!("{key}: {}", self.0[key]))
    }
}

/// Most standard errors between an estimate and the truth: with 32 scrambles a right estimate is farther away once in
/// 2700 times.
const SIGMAS: f64 = 4.0;

/// Differences below this are rounding.
const ROUNDING: f64 = 1e-9;

/// Estimates beside their truths.
#[derive(Default)]
pub struct Comparisons {
    count: usize,
    worst: f64,
    largest_se: f64,
    wrong: Vec<String>,
}

impl Comparisons {
    /// Adds one.
    pub fn add(&mut self, what: &str, measured: Estimate, truth: f64) {
        self.within(what, measured, truth, 0.0);
    }

    /// Adds one that is known to be off by no more than `bias`.
    pub fn within(&mut self, what: &str, measured: Estimate, truth: f64, bias: f64) {
        let off = ((measured.value - truth).abs() - bias).max(0.0);
        let z = if off <= ROUNDING { 0.0 } else { off / measured.se };
        self.count += 1;
        self.worst = self.worst.max(z);
        self.largest_se = self.largest_se.max(measured.se);
        let agrees = z <= SIGMAS;
        if !agrees {
            self.wrong.push(format!("{what}: {:.6} ±{:.1e} for {truth:.6}, {z:.1} σ", measured.value, measured.se));
        }
    }

    /// All agree, and each is known to better than `se`.
    #[allow(clippy::print_stdout, reason = "shown with --nocapture")]
    pub fn judge(self, se: f64) {
        let Self { count, worst, largest_se, wrong } = self;
        println!("{count} comparisons, the worst {worst:.2} σ off; standard errors up to {largest_se:.1e}");
        assert!(count > 0 && wrong.is_empty(), "{} of {count} are wrong:\n{}", wrong.len(), wrong.join("\n"));
        assert!(largest_se < se, "standard errors up to {largest_se:e}: too little is known to tell");
    }
}

/// A CSV file of `tests/reference`: a row per line, numbers by name.
pub fn csv(file: &str) -> Vec<Row> {
    let text = std::fs::read_to_string(format!("tests/reference/{file}")).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').map(String::from).collect::<Vec<String>>());
    let names = lines.next().unwrap();
    lines.map(|fields| Row(names.iter().cloned().zip(fields).collect())).collect()
}

/// A row of a CSV file.
#[derive(Clone, Debug)]
pub struct Row(std::collections::HashMap<String, String>);

impl Row {
    /// A word.
    pub fn word(&self, name: &str) -> &str {
        self.0.get(name).unwrap_or_else(|| panic!("there is no column {name}"))
    }

    /// A number.
    pub fn number(&self, name: &str) -> f64 {
        self.word(name).parse().unwrap_or_else(|e| panic!("{name}: {e}"))
    }
}
