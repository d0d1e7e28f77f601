//! `cargo xtask test crash`: kills the program at random moments and damages its files, many times, and prints what became of it.
//!
//! The cases are tests of `autoinspect` (`tests/cli/crash`). This command runs them with many kills and all damages, and makes tables of their reports.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs;
use std::process::{ExitCode, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::shell;

/// Situations in which the program is killed, as the tests call them.
const SITUATIONS: [&str; 5] = ["mapping", "saving", "localising", "importing", "idle"];

/// The situation of missions, as the tests call it.
const MISSIONS: &str = "missions";

/// The situation of damaged files, as the tests call it.
const DAMAGE: &str = "damage";

/// Kills in all situations of [`SITUATIONS`] together.
const KILLS: usize = 300;

/// Kills during missions.
const MISSION_KILLS: usize = 100;

/// Options of the command line.
#[derive(Debug, PartialEq, Eq)]
struct Options {
    /// In all situations together, missions apart; or in the only one.
    kills: Option<usize>,
    seed: u64,
    /// The only situation to run, if one is wanted.
    only: Option<String>,
    /// The only case of it, to repeat that.
    case: Option<usize>,
}

impl Options {
    /// # Errors
    /// On an unknown option or situation, and on a case without a situation.
    fn parse(arguments: &[OsString]) -> Result<Self> {
        let mut options = Self { kills: None, seed: 1, only: None, case: None };
        let mut arguments = arguments.iter().map(|argument| argument.to_string_lossy().into_owned());
        while let Some(name) = arguments.next() {
            let value = arguments.next().with_context(|| format!("{name} needs a value"))?;
            let number = || value.parse::<u64>().with_context(|| format!("{name} needs a number"));
            match name.as_str() {
                "--kills" => options.kills = Some(usize::try_from(number()?)?),
                "--seed" => options.seed = number()?,
                "--case" => options.case = Some(usize::try_from(number()?)?),
                "--only" if [MISSIONS, DAMAGE].contains(&&*value) || SITUATIONS.contains(&&*value) => {
                    options.only = Some(value)
                }
                "--only" => {
                    bail!("no situation {value}; there are: {}, {MISSIONS}, {DAMAGE}", SITUATIONS.join(", "))
                }
                _ => bail!("`cargo xtask test crash` does not know {name}"),
            }
        }
        if options.case.is_some() && options.only.is_none() {
            bail!("--case needs --only SITUATION");
        }
        Ok(options)
    }

    /// Kills in each situation.
    fn kills_of_a_situation(&self) -> usize {
        let kills = self.kills.unwrap_or(KILLS);
        match self.only {
            Some(_) => kills,
            None => kills.div_ceil(SITUATIONS.len()),
        }
    }

    /// Kills during missions.
    fn mission_kills(&self) -> usize {
        match self.only {
            Some(_) => self.kills.unwrap_or(MISSION_KILLS),
            None => MISSION_KILLS,
        }
    }

    /// Part of the names of the tests to run.
    fn filter(&self) -> String {
        match self.only.as_deref() {
            Some(MISSIONS) => format!("crash::nightly::{MISSIONS}"),
            only => format!("crash::{}", only.unwrap_or_default()),
        }
    }
}

pub(crate) fn command(arguments: &[OsString]) -> Result<ExitCode> {
    let options = Options::parse(arguments)?;
    let report = shell::target().join("crash");
    if report.exists() {
        fs::remove_dir_all(&report).with_context(|| format!("could not remove {}", report.display()))?;
    }
    fs::create_dir_all(&report).with_context(|| format!("could not make {}", report.display()))?;
    let started = Instant::now();
    let mut tests = shell::cargo();
    // The whole workspace, so that features are those of the other tests and nothing is compiled again.
    tests.args(["test", "--quiet", "--workspace", "--exclude", "benches", "--test", "cli", "--"]);
    tests.args([&options.filter(), "--nocapture"]).stdin(Stdio::null());
    tests.env("AUTOINSPECT_CRASH_KILLS", options.kills_of_a_situation().to_string());
    tests.env("AUTOINSPECT_CRASH_MISSION_KILLS", options.mission_kills().to_string());
    tests.env("AUTOINSPECT_CRASH_SEED", options.seed.to_string());
    tests.env("AUTOINSPECT_CRASH_DAMAGES", "all").env("AUTOINSPECT_CRASH_REPORT", &report);
    if let Some(case) = options.case {
        tests.env("AUTOINSPECT_CRASH_CASE", case.to_string());
    }
    let status = tests.status().context("could not start the tests")?;
    let cases = fs::read_to_string(report.join("cases.tsv")).unwrap_or_default();
    let summary = Summary::read(&cases);
    println!("{}", summary.table());
    println!("seed {}, {:.0} s in all", options.seed, started.elapsed().as_secs_f64());
    for failure in &summary.failures {
        println!("FAILED {failure}");
    }
    if let Some(failure) = summary.failures.first() {
        let (situation, rest) = failure.split_once(' ').unwrap_or_default();
        let case = rest.split(':').next().unwrap_or_default();
        let seed = options.seed;
        println!("repeat with: cargo xtask test crash --seed {seed} --only {situation} --case {case}");
    }
    if summary.situations.is_empty() && summary.damages.is_empty() {
        bail!("the tests did not run");
    }
    Ok(if status.success() && summary.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// One line of a table.
#[derive(Debug, Default, PartialEq)]
struct Row {
    cases: usize,
    failures: usize,
    /// Keyframes that clients had seen and that are gone.
    lost_keyframes: u32,
    /// The longest time of a mapping session that is gone, seconds of the robot's clock.
    most_lost_s: f64,
    /// Seconds from the start of the process to its first answer.
    slowest_start_s: f64,
}

/// What the tests report, for two tables.
#[derive(Debug, Default)]
struct Summary {
    situations: BTreeMap<String, Row>,
    /// By the kind of file.
    damages: BTreeMap<String, Row>,
    failures: Vec<String>,
}

impl Summary {
    /// Reads the lines of the tests: situation, case, what, lost keyframes, lost seconds, seconds of the start, failure; with tabs between them.
    fn read(lines: &str) -> Self {
        let mut summary = Self::default();
        for line in lines.lines() {
            let fields: Vec<&str> = line.split('\t').collect();
            let [situation, case, what, lost_keyframes, lost_s, start_s, failure] = fields[..] else {
                continue;
            };
            let row = match what.rsplit_once(": ") {
                Some((file, _)) if situation == DAMAGE => summary.damages.entry(file.to_owned()),
                _ => summary.situations.entry(situation.to_owned()),
            };
            let row = row.or_default();
            row.cases += 1;
            row.lost_keyframes += lost_keyframes.parse::<u32>().unwrap_or_default();
            row.most_lost_s = row.most_lost_s.max(lost_s.parse().unwrap_or_default());
            row.slowest_start_s = row.slowest_start_s.max(start_s.parse().unwrap_or_default());
            if !failure.is_empty() {
                row.failures += 1;
                summary.failures.push(format!("{situation} {case}: {what}: {failure}"));
            }
        }
        summary
    }

    /// Both tables, in Markdown.
    fn table(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        if !self.situations.is_empty() {
            text.push_str(
                "| situation | kills | failures | keyframes lost | most time lost, s | slowest start, s |\n",
            );
            text.push_str("| --- | ---: | ---: | ---: | ---: | ---: |\n");
        }
        for (situation, row) in &self.situations {
            let Row { cases, failures, lost_keyframes, most_lost_s, slowest_start_s } = row;
            let _ = writeln!(
                text,
                "| {situation} | {cases} | {failures} | {lost_keyframes} | {most_lost_s:.2} | {slowest_start_s:.2} |"
            );
        }
        if !self.damages.is_empty() {
            text.push_str(
                "\n| file | damages | failures | slowest start, s |\n| --- | ---: | ---: | ---: |\n",
            );
        }
        for (file, row) in &self.damages {
            let Row { cases, failures, slowest_start_s, .. } = row;
            let _ = writeln!(text, "| {file} | {cases} | {failures} | {slowest_start_s:.2} |");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(arguments: &str) -> Result<Options> {
        Options::parse(&arguments.split_whitespace().map(OsString::from).collect::<Vec<_>>())
    }

    #[test]
    fn options_are_read_from_the_command_line() {
        let all = parse("").unwrap();
        assert_eq!((all.kills_of_a_situation(), all.mission_kills()), (60, 100));
        assert_eq!(all.filter(), "crash::");
        assert_eq!(parse("--kills 7 --only missions").unwrap().mission_kills(), 7);
        let one = parse("--kills 40 --seed 7 --only saving --case 12").unwrap();
        assert_eq!((one.kills_of_a_situation(), one.filter()), (40, "crash::saving".to_owned()));
        assert_eq!((one.seed, one.case), (7, Some(12)));
        for wrong in ["--kills", "--kills many", "--case 3", "--only sleeping", "saving"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn reports_become_rows_and_failures() {
        let lines = "mapping\t0\tcore at 3 keyframes\t1\t0.25\t0.110\t\n\
            mapping\t1\tplatform at 0 keyframes\t0\t0.50\t-\tit is gone\n\
            damage\t4\tmap: tiles.json: zeroed\t0\t0.000\t0.020\t\n";
        let summary = Summary::read(lines);
        let row = Row { cases: 2, failures: 1, lost_keyframes: 1, most_lost_s: 0.5, slowest_start_s: 0.11 };
        assert_eq!(summary.situations["mapping"], row);
        assert_eq!(summary.damages["map: tiles.json"].cases, 1);
        assert_eq!(summary.failures, ["mapping 1: platform at 0 keyframes: it is gone"]);
        assert!(summary.table().contains("| mapping | 2 | 1 | 1 | 0.50 | 0.11 |"), "{}", summary.table());
    }
}
