//! What became of each case: a line on standard error and, for `cargo xtask test crash`, a line of a table.

use super::options::CrashOptions;
use std::fs::OpenOptions;
use std::io::Write;
use std::time::Duration;

/// One kill or one damage.
#[derive(Default)]
pub struct CaseReport {
    /// Number of the case.
    pub case: usize,
    /// What was killed, or how the file was damaged.
    pub what: String,
    /// Keyframes that clients had seen and that are gone.
    pub lost_keyframes: u32,
    /// Time of a mapping session that is gone, seconds of the robot's clock.
    pub lost_s: f64,
    /// Time from the start of the process to its first answer.
    pub start: Option<Duration>,
    /// What went wrong.
    pub failure: Option<String>,
}

/// Collects the cases of one situation or of one kind of file.
pub struct CrashReport<'a> {
    options: &'a CrashOptions,
    situation: String,
    failures: Vec<String>,
}

impl<'a> CrashReport<'a> {
    pub fn new(options: &'a CrashOptions, situation: &str) -> Self {
        Self { options, situation: situation.to_owned(), failures: Vec::new() }
    }

    /// Prints a case, and writes it to the table.
    pub fn add(&mut self, case: &CaseReport) {
        let CaseReport { case: number, what, lost_keyframes, lost_s, start, failure } = case;
        let start_s = start.map_or_else(|| "-".to_owned(), |start| format!("{:.3}", start.as_secs_f64()));
        let outcome = failure.as_deref().unwrap_or("ok");
        let situation = &self.situation;
        eprintln!(
            "{situation} {number}: {what}, {lost_keyframes} keyframes and {lost_s:.2} s lost, started in {start_s} s: {outcome}"
        );
        if let Some(failure) = failure {
            self.failures.push(format!("{situation} {number} ({what}): {failure}"));
        }
        let Some(folder) = &self.options.report else { return };
        let one_line = failure.as_deref().unwrap_or_default().replace(['\n', '\t'], " ");
        let line =
            format!("{situation}\t{number}\t{what}\t{lost_keyframes}\t{lost_s:.3}\t{start_s}\t{one_line}\n");
        let file = OpenOptions::new().create(true).append(true).open(folder.join("cases.tsv"));
        file.and_then(|mut file| file.write_all(line.as_bytes())).expect("the report can be written");
    }

    /// Fails the test if a case has failed.
    pub fn finish(self) {
        let Self { options: CrashOptions { seed, .. }, situation, failures } = self;
        assert!(
            failures.is_empty(),
            "{} cases failed with seed {seed}; `cargo xtask test crash --seed {seed} --only {situation} --case NUMBER` repeats one:\n{}",
            failures.len(),
            failures.join("\n")
        );
    }
}
