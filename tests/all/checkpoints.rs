//! Work that is broken off goes on from where it was, and work that is done in parts makes the same whole, to the last bit.

use gonio_embree::experiment::sealed::{Kind, key_of, seal, unseal};
use gonio_embree::experiment::{Experiment, Goal, Mismatch, Origin, Outcome, Settings, State, Target};
use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
use gonio_embree::output::netcdf;
use gonio_embree::sample::{Description, Sample};

struct Case {
    sample: Sample,
    light: Light,
    settings: Settings,
}

impl Case {
    fn new(file: &str, polarization: Polarization, settings: Settings) -> Self {
        let light = Light {
            wavelengths: Wavelengths::from_nm(vec![450.0, 550.0, 650.0]).unwrap(),
            incidences: [0.0, 40.0, 70.0].map(|theta_deg| Incidence { theta_deg, phi_deg: 0.0 }).to_vec(),
            polarization,
            source: SourceMode::Band,
        };
        let description = Description::from_toml(file.as_ref()).unwrap();
        let sample = Sample::new(&description, &light.wavelengths, light.coherence()).unwrap();
        Self { sample, light, settings: Settings { threads: 2, dome_level: 3, ..settings } }
    }

    fn experiment(&self) -> Experiment<'_> {
        Experiment::new(&self.sample, &self.light, &self.settings).unwrap()
    }

    /// The bytes of the result.
    fn bytes(&self, outcome: Outcome) -> Vec<u8> {
        let origin = Origin { command: String::new(), files: Vec::new(), sha256: String::new() };
        netcdf::to_bytes(&outcome.into_measured(&self.sample, &self.light, &self.settings, origin)).unwrap()
    }

    fn undisturbed(&self) -> Vec<u8> {
        let experiment = self.experiment();
        let mut state = experiment.start();
        experiment.advance(&mut state, |_, _| true);
        self.bytes(experiment.outcome(&state, None))
    }

    fn part(&self, batches: std::ops::Range<u32>) -> State {
        let experiment = self.experiment();
        let mut state = experiment.start_part(batches);
        experiment.advance(&mut state, |_, _| true);
        assert!(state.is_finished());
        copy(&state)
    }

    fn whole(&self, parts: Vec<State>) -> Vec<u8> {
        let (state, incidences) = State::join(parts, false).unwrap();
        assert_eq!(incidences, [0, 1, 2]);
        self.bytes(self.experiment().outcome(&state, None))
    }
}

/// As it comes back from a file.
fn copy(state: &State) -> State {
    let key = key_of(&["some work"]);
    unseal(Kind::Checkpoint, &key, &seal(Kind::Checkpoint, &key, state)).unwrap()
}

fn cases() -> Vec<Case> {
    let trees = |trees| Settings { trees, ..Settings::default() };
    let goal = Goal { target: Some(Target::Whole(0.1)), max_seconds: None, max_rounds: Some(3.0) };
    vec![
        Case::new("assets/samples/morpho-1.toml", Polarization::Unpolarized, trees(3000)),
        Case::new("tests/samples/good/spheres.toml", Polarization::Mueller, trees(1001)),
        Case::new("tests/samples/good/spheres.toml", Polarization::Unpolarized, trees(7)),
        Case::new(
            "tests/samples/good/spheres.toml",
            Polarization::P,
            Settings { goal: Some(goal), ..Settings::default() },
        ),
    ]
}

/// Broken off after every few units, in the middle of batches and rounds.
#[test]
fn interrupted_work_gives_the_same_bytes() {
    let mut all_stops = 0;
    for (i, case) in cases().into_iter().enumerate() {
        let (mut state, mut stops) = (case.experiment().start(), 0_u32);
        while !state.is_finished() {
            // As a new process would: it plans again.
            let experiment = case.experiment();
            let mut left = 3_u32.pow(stops);
            experiment.advance(&mut state, |_, _| {
                left -= 1;
                left > 0
            });
            state = copy(&state);
            stops += 1;
        }
        all_stops += stops;
        assert!(case.bytes(case.experiment().outcome(&state, None)) == case.undisturbed(), "case {i}");
    }
    // How many units are done by then depends on the threads.
    assert!(all_stops > 4, "{all_stops}");
}

#[test]
fn parts_make_the_same_whole() {
    for case in cases().into_iter().filter(|c| c.settings.goal.is_none()) {
        let all = State::batches(case.settings.trees, 3);
        let undisturbed = case.undisturbed();
        // Cut between incidences, within them, and into the smallest parts.
        for cuts in [vec![0, all], vec![0, all / 3, all], vec![0, 1, all / 2 + 1, all - 1, all]] {
            let mut parts: Vec<State> = cuts.windows(2).map(|w| case.part(w[0]..w[1])).collect();
            parts.reverse();
            assert!(case.whole(parts) == undisturbed, "{cuts:?}");
        }
    }
}

#[test]
fn parts_that_do_not_fit_are_refused() {
    let spheres = |trees| {
        let settings = Settings { trees, ..Settings::default() };
        Case::new("tests/samples/good/spheres.toml", Polarization::Unpolarized, settings)
    };
    let (case, other) = (spheres(320), spheres(20));
    let part = |from, to| case.part(from..to);
    let join = |parts| State::join(parts, false).map(|_| ());
    assert_eq!(join(vec![part(0, 40), part(50, 96)]), Err(Mismatch::Missing(40..50)));
    assert_eq!(join(vec![part(0, 40)]), Err(Mismatch::Missing(40..96)));
    assert_eq!(join(vec![part(0, 40), part(30, 96)]), Err(Mismatch::Twice(30..40)));
    assert_eq!(join(Vec::new()), Err(Mismatch::Foreign));
    assert_eq!(join(vec![case.experiment().start_part(0..96)]), Err(Mismatch::Foreign));
    assert_eq!(join(vec![other.part(0..10), part(10, 96)]), Err(Mismatch::Foreign));
}

/// What is there counts: whole incidences, and some batches of others.
#[test]
fn a_part_of_a_measurement_is_better_than_nothing() {
    let settings = Settings { trees: 3200, ..Settings::default() };
    let case = Case::new("tests/samples/good/spheres.toml", Polarization::Unpolarized, settings);
    let (state, incidences) = State::join(vec![case.part(0..40)], true).unwrap();
    assert_eq!((incidences.as_slice(), state.trees()), (&[0, 1][..], 4000));
    let bsdf = case.experiment().outcome(&state, Some(&incidences)).bsdf;
    let trees: Vec<u64> = bsdf.incidences.iter().map(|s| s.trees).collect();
    assert_eq!(trees, [3200, 800]);
    let reflected = |s: &gonio_embree::bsdf::Scattering| s.ledger.reflected[0];
    let (whole, some) = (reflected(&bsdf.incidences[0]), reflected(&bsdf.incidences[1]));
    assert!(whole.se > 0.0 && some.se > 0.0 && some.value < 1.0);
}
