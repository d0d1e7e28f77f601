//! Runs stages one after the other, measures the time of each, and prints a table at the end.

use std::time::{Duration, Instant};

use anyhow::{Result, anyhow};

/// Result of a stage.
enum Outcome {
    Passed,
    Failed(String),
    Skipped(String),
}

struct Stage {
    name: &'static str,
    duration: Duration,
    outcome: Outcome,
}

/// Report of a stage that ran.
#[derive(Default)]
pub(crate) struct StageReport {
    /// Counts of the stage's tests; zero if it counts none.
    pub(crate) tests: Tests,
    /// Parts that did not run, each with its reason.
    pub(crate) skipped: Vec<String>,
}

/// Counts of single tests.
#[derive(Clone, Copy, Default)]
pub(crate) struct Tests {
    pub(crate) passed: usize,
    pub(crate) failed: usize,
    pub(crate) skipped: usize,
}

pub(crate) struct Stages {
    started: Instant,
    stages: Vec<Stage>,
    tests: Tests,
    skipped: Vec<String>,
}

impl Stages {
    pub(crate) fn new() -> Self {
        Self { started: Instant::now(), stages: Vec::new(), tests: Tests::default(), skipped: Vec::new() }
    }

    /// Runs one stage, also if an earlier one failed, so that one run shows all failures.
    pub(crate) fn run(&mut self, name: &'static str, stage: impl FnOnce() -> Result<StageReport>) {
        eprintln!("\n── {name}");
        let (result, duration) = timed(stage);
        self.add(name, result, duration);
    }

    /// Runs two independent stages at the same time, because long parts of each use one core only. The first one runs on another thread.
    pub(crate) fn run_together(
        &mut self,
        (first_name, first): (&'static str, impl FnOnce() -> Result<StageReport> + Send),
        (second_name, second): (&'static str, impl FnOnce() -> Result<StageReport>),
    ) {
        eprintln!("\n── {first_name}, {second_name}");
        let (first, second) = std::thread::scope(|scope| {
            let first = scope.spawn(|| timed(first));
            let second = timed(second);
            let first = first.join().unwrap_or_else(|_| (Err(anyhow!("the stage panicked")), Duration::ZERO));
            (first, second)
        });
        self.add(first_name, first.0, first.1);
        self.add(second_name, second.0, second.1);
    }

    fn add(&mut self, name: &'static str, result: Result<StageReport>, duration: Duration) {
        let outcome = match result {
            Ok(report) => {
                self.tests.passed += report.tests.passed;
                self.tests.failed += report.tests.failed;
                self.tests.skipped += report.tests.skipped;
                self.skipped.extend(report.skipped);
                match report.tests.failed {
                    0 => Outcome::Passed,
                    failed => Outcome::Failed(format!("{failed} tests failed")),
                }
            }
            Err(error) => {
                eprintln!("{error:#}");
                Outcome::Failed(format!("{error:#}"))
            }
        };
        self.stages.push(Stage { name, duration, outcome });
    }

    /// Records that a stage is left out, with the reason.
    pub(crate) fn skip(&mut self, name: &'static str, reason: &str) {
        eprintln!("\n── {name}: skipped, {reason}");
        self.stages.push(Stage {
            name,
            duration: Duration::ZERO,
            outcome: Outcome::Skipped(reason.to_owned()),
        });
    }

    /// Prints the table, the selection and the summary; true if nothing failed.
    pub(crate) fn finish(self, selection: &str) -> bool {
        println!("\n{:<28} {:>8}  result", "stage", "seconds");
        for stage in &self.stages {
            let result = match &stage.outcome {
                Outcome::Passed => "passed".to_owned(),
                Outcome::Failed(why) => format!("FAILED: {}", why.lines().next().unwrap_or_default()),
                Outcome::Skipped(why) => format!("skipped: {why}"),
            };
            println!("{:<28} {:>8.1}  {result}", stage.name, stage.duration.as_secs_f64());
        }
        println!("{:<28} {:>8.1}", "in all", self.started.elapsed().as_secs_f64());
        for skipped in &self.skipped {
            println!("{skipped}");
        }
        let count =
            |wanted: fn(&Outcome) -> bool| self.stages.iter().filter(|stage| wanted(&stage.outcome)).count();
        let failed_stages = count(|outcome| matches!(outcome, Outcome::Failed(_)));
        println!("{selection}");
        println!("{} of {} stages failed; tests and stages together:", failed_stages, self.stages.len());
        // A stage counts as one check in addition to its tests, so that a failed build is counted too.
        println!(
            "{} passed, {} failed, {} skipped",
            self.tests.passed + count(|outcome| matches!(outcome, Outcome::Passed)),
            self.tests.failed + failed_stages,
            self.tests.skipped + self.skipped.len() + count(|outcome| matches!(outcome, Outcome::Skipped(_))),
        );
        failed_stages == 0
    }
}

fn timed(stage: impl FnOnce() -> Result<StageReport>) -> (Result<StageReport>, Duration) {
    let started = Instant::now();
    (stage(), started.elapsed())
}
