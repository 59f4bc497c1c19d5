//! The job file (TOML): options of measurements by the names of the command line, and what is varied.
//!
//! ```toml
//! [defaults]
//! trees = "1M"
//! output = "results/{name}.nc"
//!
//! [[measurement]]
//! mesh = "feather.obj"
//! incident = "0:80:5"
//!
//! [[measurement]]
//! name = "web-{flatten}-{seed}"
//! sample = "web.toml"
//! set.sample.below = "water"
//! vary.objects.fibre.flatten = [1.0, 0.5]
//! vary.seed = [1, 2, 3]
//! ```

use std::collections::BTreeSet;
use std::path::Path;

use toml::Spanned;
use toml::de::DeValue;

use crate::sample::problem::{Place, Problems};
use crate::sample::reader::{Source, Table};
use crate::units::LengthUnit;

/// A measurement of a job file.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// What it is called; no other has this name.
    pub name: String,
    /// What stands on the command line after `gonio-embree`.
    pub arguments: Vec<String>,
    /// What is varied, with the value it has here; the same keys in all measurements of one entry.
    pub varied: Vec<(String, String)>,
    /// Where it stands.
    pub place: Place,
}

/// Most measurements of a file.
const MOST: usize = 100_000;

/// Options of which one list excludes the other: what a measurement says itself counts for more than what is usual.
const EXCLUSIVE: [[&[&str]; 2]; 3] = [
    [&["trees"], &["target-error", "max-time", "max-rounds"]],
    [&["sample"], &["mesh", "unit", "sides", "patch", "medium"]],
    [&["source-mode"], &["coherence-length"]],
];

/// Something that is set in a file, with where it stands.
#[derive(Clone, Debug)]
struct Given {
    /// The name of an option, or keys of a sample file joined by dots.
    key: String,
    /// Alternatives, if it is varied; texts of an option that is repeated; else one.
    values: Vec<String>,
    at: usize,
}

/// One table of the file.
#[derive(Clone, Debug, Default)]
struct Entry {
    options: Vec<Given>,
    set: Vec<Given>,
    vary: Vec<Given>,
}

/// Reads a job file; paths in it are those of its directory.
///
/// # Errors
/// Everything that is wrong with it, as far as the file itself tells: whether options can be understood is not looked at.
pub fn read(path: &Path) -> Result<Vec<Job>, Problems> {
    let source = Source::read(path)?;
    let jobs = {
        let root = source.parse();
        if !source.is_clean() {
            return Err(source.into_problems());
        }
        let file = Table::new(&source, root.get_ref(), &root.span(), LengthUnit::Micrometre);
        let defaults = file.table("defaults").map(|t| Entry::new(&t)).unwrap_or_default();
        let mut jobs = Vec::new();
        for table in file.tables("measurement") {
            let entry = Entry::new(&table).over(&defaults);
            jobs.extend(entry.jobs(&table));
        }
        file.refuse_unknown_keys();
        if jobs.is_empty() && source.is_clean() {
            source.note(Place::file(path).problem("it asks for nothing; add a [[measurement]]"));
        }
        jobs
    };
    refuse_namesakes(&source, &jobs);
    source.into_problems().or(jobs)
}

fn refuse_namesakes(source: &Source, jobs: &[Job]) {
    let mut names = BTreeSet::new();
    let mut outputs = BTreeSet::new();
    for job in jobs {
        if !names.insert(&job.name) {
            let message = format!("two measurements are called `{}`; give them a name = \"...\"", job.name);
            source.note(job.place.problem(message));
        } else if !outputs.insert(job.output()) {
            let message = format!("two measurements are written to {}; put {{name}} into output", job.output());
            source.note(job.place.problem(message));
        }
    }
}

impl Job {
    /// Its result.
    pub fn output(&self) -> &str {
        self.arguments.last().map_or("", String::as_str)
    }
}

impl Entry {
    fn new(table: &Table<'_>) -> Self {
        let mut entry = Self::default();
        for (key, value) in table.named() {
            let at = value.span().start;
            match key {
                "set" => flatten(table, "set", value, &mut |key, value| {
                    let values = vec![literal(table, value)];
                    entry.set.push(Given { key, values, at: value.span().start });
                }),
                "vary" => flatten(table, "vary", value, &mut |key, value| {
                    let is_of_sample = key.contains('.');
                    let text = |v: &Spanned<DeValue<'_>>| match text(v) {
                        Some(text) if !is_of_sample => text,
                        _ => literal(table, v),
                    };
                    let list = value.get_ref().as_array().filter(|list| !list.is_empty());
                    let Some(list) = list else {
                        let message = format!("vary.{key}: expected a list of values such as [1, 2]");
                        return table.source().note(table.source().place(&value.span()).problem(message));
                    };
                    entry.vary.push(Given { key, values: list.iter().map(text).collect(), at: value.span().start });
                }),
                _ => match texts(value) {
                    Some(values) if REPEATED.contains(&key) => {
                        entry.options.push(Given { key: key.into(), values, at })
                    }
                    Some(values) => entry.options.push(Given { key: key.into(), values: vec![values.join(",")], at }),
                    None => {
                        let message = format!("{key}: expected a text, a number, true, false or a list of them");
                        table.source().note(table.source().place(&value.span()).problem(message));
                    }
                },
            }
        }
        // As they stand in the file.
        for list in [&mut entry.options, &mut entry.set, &mut entry.vary] {
            list.sort_by_key(|given| given.at);
        }
        entry
    }

    /// With `others` where nothing is said.
    fn over(self, others: &Self) -> Self {
        let all = self.set.iter().chain(&self.vary).chain(&self.options);
        let said: BTreeSet<String> = all.map(|given| given.key.clone()).collect();
        let excluded = |key: &str| {
            let by = |[a, b]: &[&[&str]; 2]| a.contains(&key) && b.iter().any(|other| said.contains(*other));
            said.contains(key) || EXCLUSIVE.iter().any(|pair| by(pair) || by(&[pair[1], pair[0]]))
        };
        let join = |own: Vec<Given>, others: &[Given]| -> Vec<Given> {
            others.iter().filter(|g| !excluded(&g.key)).cloned().chain(own).collect()
        };
        Self {
            options: join(self.options, &others.options),
            set: join(self.set, &others.set),
            vary: join(self.vary, &others.vary),
        }
    }

    fn option(&self, key: &str) -> Option<&str> {
        self.options.iter().find(|g| g.key == key).and_then(|g| g.values.first()).map(String::as_str)
    }

    /// All measurements it stands for: every combination of what is varied, the last of which changes fastest.
    fn jobs(&self, table: &Table<'_>) -> Vec<Job> {
        let count = self.vary.iter().map(|g| g.values.len()).try_fold(1usize, usize::checked_mul);
        let Some(count) = count.filter(|&n| n <= MOST) else {
            table.complain(format!("these are more than {MOST} measurements"));
            return Vec::new();
        };
        (0..count).map(|number| self.job(number, table.place())).collect()
    }

    fn job(&self, number: usize, place: &Place) -> Job {
        let (mut rest, mut varied) = (number, Vec::new());
        for given in self.vary.iter().rev() {
            varied.push((given.key.clone(), given.values[rest % given.values.len()].clone()));
            rest /= given.values.len();
        }
        varied.reverse();
        let value = |key: &str| varied.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str());
        let input = ["sample", "mesh"].into_iter().find_map(|key| value(key).or(self.option(key)));
        let stem = Path::new(input.unwrap_or("measurement")).file_stem().unwrap_or_default().to_string_lossy();
        let name = name(self.option("name").unwrap_or(&stem), &varied);
        let mut arguments = Vec::new();
        let is_varied = |key: &str| varied.iter().any(|(k, _)| k == key);
        let own = |key: &str| !matches!(key, "name" | "output") && !is_varied(key);
        for given in self.options.iter().filter(|g| own(&g.key)) {
            given.values.iter().for_each(|value| push(&mut arguments, &given.key, value));
        }
        for given in self.set.iter().filter(|g| !is_varied(&g.key)) {
            push(&mut arguments, "set", &format!("{}={}", given.key, given.values[0]));
        }
        for (key, value) in &varied {
            match key.contains('.') {
                true => push(&mut arguments, "set", &format!("{key}={value}")),
                false => push(&mut arguments, key, value),
            }
        }
        let output = self.option("output").map_or_else(|| format!("{name}.nc"), |o| o.replace("{name}", &name));
        arguments.extend(["--output".into(), output]);
        Job { name, arguments, varied, place: place.clone() }
    }
}

/// Adds an option; one that is `true` stands alone, one that is `false` not at all.
fn push(arguments: &mut Vec<String>, key: &str, value: &str) {
    match value {
        "false" => {}
        "true" => arguments.push(format!("--{key}")),
        _ => arguments.push(format!("--{key}={value}")),
    }
}

/// A name with the values of what is varied: where it says so in braces, else behind it.
fn name(pattern: &str, varied: &[(String, String)]) -> String {
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_string();
    let mut name = pattern.to_string();
    for (key, value) in varied {
        let value = plain(&stem_of(value));
        let placed = name.replace(&format!("{{{key}}}"), &value).replace(&format!("{{{}}}", last(key)), &value);
        // What the name is made of tells already.
        let told = placed != name || matches!(key.as_str(), "sample" | "mesh") && name.contains(&value);
        name = if told { placed } else { format!("{name}-{}_{value}", last(key)) };
    }
    name
}

/// A file without its directory and ending.
fn stem_of(value: &str) -> String {
    let is_file = [".toml", ".obj"].iter().any(|end| value.ends_with(end));
    let stem = Path::new(value).file_stem().filter(|_| is_file);
    stem.map_or_else(|| value.into(), |s| s.to_string_lossy().into_owned())
}

/// What can stand in the name of a file.
fn plain(text: &str) -> String {
    let fine = |c: char| if c.is_alphanumeric() || matches!(c, '.' | '+' | '-' | ',') { c } else { '_' };
    text.trim_matches('"').chars().map(fine).collect()
}

/// Calls `each` with everything in nested tables, keys joined by dots.
fn flatten(
    table: &Table<'_>,
    what: &str,
    value: &Spanned<DeValue<'_>>,
    each: &mut dyn FnMut(String, &Spanned<DeValue<'_>>),
) {
    fn walk(prefix: &str, value: &Spanned<DeValue<'_>>, each: &mut dyn FnMut(String, &Spanned<DeValue<'_>>)) {
        match value.get_ref().as_table() {
            None => each(prefix.into(), value),
            Some(inner) => inner.iter().for_each(|(key, value)| {
                let key: &str = key.get_ref();
                let path = if prefix.is_empty() { key.to_string() } else { format!("{prefix}.{key}") };
                walk(&path, value, each);
            }),
        }
    }
    if value.get_ref().is_table() {
        return walk("", value, each);
    }
    let message = format!("{what}: expected a table such as {what}.objects.fibre.radius = ...");
    table.source().note(table.source().place(&value.span()).problem(message));
}

/// A value of a sample file, as it is written there; texts that can be told from all else need no quotes.
fn literal(table: &Table<'_>, value: &Spanned<DeValue<'_>>) -> String {
    match value.get_ref() {
        DeValue::String(s) if s.parse::<toml_edit::Value>().is_err() => s.to_string(),
        _ => table.source().slice(&value.span()).to_string(),
    }
}

/// Options that may be repeated; lists of all others are lists of numbers.
const REPEATED: [&str; 1] = ["medium"];

/// The value of an option, once or several times.
fn texts(value: &Spanned<DeValue<'_>>) -> Option<Vec<String>> {
    let Some(list) = value.get_ref().as_array() else { return text(value).map(|text| vec![text]) };
    list.iter().map(text).collect()
}

fn text(value: &Spanned<DeValue<'_>>) -> Option<String> {
    let digits = |text: &str| text.chars().filter(|&c| c != '_').collect::<String>();
    match value.get_ref() {
        DeValue::String(s) => Some(s.to_string()),
        DeValue::Integer(i) if i.radix() == 10 => Some(digits(i.as_str())),
        DeValue::Float(f) => Some(digits(f.as_str())),
        DeValue::Boolean(b) => Some(b.to_string()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jobs(text: &str) -> Result<Vec<Job>, String> {
        let dir = std::env::temp_dir().join(format!("gonio-jobs-{}-{}", std::process::id(), text.len()));
        std::fs::create_dir_all(&dir).unwrap();
        let path = dir.join("jobs.toml");
        std::fs::write(&path, text).unwrap();
        let read = read(&path).map_err(|e| e.to_string());
        std::fs::remove_dir_all(&dir).unwrap();
        read
    }

    #[test]
    fn options_are_those_of_the_command_line() {
        let all = jobs(
            r#"
[defaults]
trees = "1M"
seed = 1
output = "night/{name}.nc"

[[measurement]]
mesh = "dir/feather.obj"
incident = [0, 20.5]
medium = ["ink=1.5", "melanin=m.yml"]
seed = 2

[[measurement]]
name = "web"
sample = "web.toml"
set.sample.below = "water"
set.objects.fibre = { radius = 2, name = "5" }
"#,
        )
        .unwrap();
        assert_eq!(all[0].name, "feather");
        let told =
            "--trees=1M --mesh=dir/feather.obj --incident=0,20.5 --medium=ink=1.5 --medium=melanin=m.yml --seed=2";
        assert_eq!(all[0].arguments.join(" "), format!("{told} --output night/feather.nc"));
        let told = "--trees=1M --seed=1 --sample=web.toml --set=sample.below=water --set=objects.fibre.radius=2";
        assert_eq!(all[1].arguments.join(" "), format!("{told} --set=objects.fibre.name=\"5\" --output night/web.nc"));
    }

    #[test]
    fn what_is_varied_makes_a_measurement_per_combination() {
        let all = jobs(
            r#"
[[measurement]]
sample = "web.toml"
vary.objects.fibre.flatten = [1.0, 0.5]
vary.seed = [1, 2, 3]
vary.polarization = ["s"]

[[measurement]]
name = "{sample}-at-{incident}"
vary = { sample = ["a/x.toml", "y.toml"], incident = ["0:80:40"] }
"#,
        )
        .unwrap();
        let names: Vec<&str> = all.iter().map(|j| j.name.as_str()).collect();
        assert_eq!(names[0], "web-flatten_1.0-seed_1-polarization_s");
        assert_eq!(names[5], "web-flatten_0.5-seed_3-polarization_s");
        assert_eq!(names[6..], ["x-at-0_80_40", "y-at-0_80_40"]);
        let expected = "--sample=web.toml --set=objects.fibre.flatten=0.5 --seed=3 --polarization=s --output web-flatten_0.5-seed_3-polarization_s.nc";
        assert_eq!(all[5].arguments.join(" "), expected);
        assert_eq!(all[5].varied[0], ("objects.fibre.flatten".into(), "0.5".into()));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        for (text, told) in [
            ("", "asks for nothing"),
            (
                "[[measurement]]\nmesh = \"a.obj\"\n[[measurement]]\nmesh = \"a.obj\"",
                "jobs.toml:3: two measurements are called `a`",
            ),
            (
                "[defaults]\noutput = \"x.nc\"\n[[measurement]]\nmesh = \"a.obj\"\n[[measurement]]\nmesh = \"b.obj\"",
                "put {name} into output",
            ),
            ("[[measurement]]\nvary.seed = 1", "jobs.toml:2: vary.seed: expected a list"),
            ("[[measurement]]\nset = 1", "jobs.toml:2: set: expected a table"),
            ("[[measurement]]\ntrees = 2026-01-01", "trees: expected a text"),
            ("[[measurment]]\ntrees = 2", "did you mean `measurement`?"),
            ("[defaults]\n[[measurement]]\nmesh = ", "jobs.toml:3:"),
        ] {
            let error = jobs(text).unwrap_err();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
