//! `cargo xtask fuzz`: gives every parser its half hour of fuzzing, in short slots, one program at a time, and keeps a record of what was run.
//!
//! The programs are those of `fuzz/`, built as cargo-fuzz builds them (libFuzzer, AddressSanitizer, debug assertions), which needs the nightly compiler
//! and nothing else. All that a run needs and leaves is in one folder, `target/fuzz`: the programs, the growing corpus, the inputs that were found, and
//! `runs.tsv`, a line for each slot. So a run can be stopped at any time and goes on where it was. `--record` adds these lines to `fuzz/runs.tsv`, one for each target,
//! which is part of the repository: so another machine goes on too.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::shell;

/// The only platform with all of libFuzzer and the sanitizer that is used here.
const TARGET_TRIPLE: &str = "x86_64-unknown-linux-gnu";

/// What cargo-fuzz passes to the compiler.
const RUSTFLAGS: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing -Zsanitizer=address -Cdebug-assertions -Ccodegen-units=1";

/// Parsers of files that people bring along come first: those are what somebody else may have made.
const FROM_OUTSIDE: [&str; 14] = [
    "pcd",
    "ply",
    "las",
    "laz",
    "e57",
    "ptx",
    "rosbag1",
    "rosbag2",
    "cdr",
    "recording",
    "site",
    "picture",
    "gauge",
    "site_changes",
];

/// Memory of a program with its sanitizer, MB, and time for one input, seconds. Beyond either, the input is a finding.
const LIMITS: [&str; 2] = ["-rss_limit_mb=512", "-timeout=10"];

/// Inputs that are kept in `fuzz/corpus` for each target, beside seeds and findings, at most. The tests replay them on every run.
const MAX_KEPT_INPUTS: usize = 50;
/// Longest input that is kept, bytes.
const MAX_KEPT_BYTES: u64 = 2048;

struct Options {
    /// Processor time that each target gets in all, minutes.
    minutes: f64,
    /// Time on the clock of one slot, seconds.
    slot_s: u32,
    /// Targets in rotation at a time.
    together: usize,
    /// The folder of the run.
    folder: PathBuf,
    /// Whether the programs that are there are used as they are.
    no_build: bool,
    /// Whether to choose the corpus for the tests instead of fuzzing.
    minimise: bool,
    /// Whether to add what was run to the record of the repository instead of fuzzing.
    record: bool,
    /// The only targets to run, if any are named.
    targets: Vec<String>,
}

impl Options {
    fn parse(arguments: &[OsString]) -> Result<Self> {
        use lexopt::prelude::*;
        let mut options = Self {
            minutes: 30.0,
            slot_s: 60,
            together: usize::MAX,
            folder: shell::target().join("fuzz"),
            no_build: false,
            minimise: false,
            record: false,
            targets: Vec::new(),
        };
        let mut parser = lexopt::Parser::from_args(arguments);
        while let Some(argument) = parser.next()? {
            match argument {
                Long("minutes") => options.minutes = parser.value()?.parse()?,
                Long("slot") => options.slot_s = parser.value()?.parse()?,
                Long("together") => options.together = parser.value()?.parse::<usize>()?.max(1),
                Long("folder") => options.folder = std::env::current_dir()?.join(parser.value()?),
                Long("no-build") => options.no_build = true,
                Long("minimise") => options.minimise = true,
                Long("record") => options.record = true,
                Value(target) => options.targets.push(target.string()?),
                other => return Err(other.unexpected().into()),
            }
        }
        Ok(options)
    }
}

pub(crate) fn command(arguments: &[OsString]) -> Result<ExitCode> {
    let options = Options::parse(arguments)?;
    let known = known_targets()?;
    if let Some(wrong) = options.targets.iter().find(|target| !known.contains(target)) {
        bail!("no target {wrong}; there are: {}", known.join(", "));
    }
    let is_wanted = |target: &&String| options.targets.is_empty() || options.targets.contains(target);
    let targets: Vec<String> = known.iter().filter(is_wanted).cloned().collect();
    fs::create_dir_all(&options.folder)
        .with_context(|| format!("could not make {}", options.folder.display()))?;
    if options.record {
        Record::move_to_repository(&options.folder)?;
        println!("{}", Record::read(&options.folder)?.table());
        return Ok(ExitCode::SUCCESS);
    }
    if !options.no_build {
        build(&options.folder, &targets)?;
    }
    if let Some(missing) = targets.iter().find(|target| !program(&options.folder, target).is_file()) {
        bail!("the program of {missing} is not built yet: run this without --no-build once");
    }
    if options.minimise {
        targets.iter().try_for_each(|target| minimise(&options.folder, target))?;
        return Ok(ExitCode::SUCCESS);
    }
    let found = campaign(&options, targets)?;
    println!("{}", Record::read(&options.folder)?.table());
    Ok(if found == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Names of the programs, those of files from outside first.
fn known_targets() -> Result<Vec<String>> {
    let folder = shell::root().join("fuzz/fuzz_targets");
    let entries = fs::read_dir(&folder).with_context(|| format!("could not list {}", folder.display()))?;
    let mut names = Vec::new();
    for entry in entries {
        names.extend(entry?.path().file_stem().map(|stem| stem.to_string_lossy().into_owned()));
    }
    names.sort_by_key(|name: &String| {
        let rank = FROM_OUTSIDE.iter().position(|outside| outside == name);
        (rank.unwrap_or(FROM_OUTSIDE.len()), name.clone())
    });
    Ok(names)
}

fn build(folder: &Path, targets: &[String]) -> Result<()> {
    let mut cargo = shell::program("cargo");
    cargo.arg("+nightly").args(["build", "--release", "--target", TARGET_TRIPLE]);
    cargo.args(targets.iter().flat_map(|target| ["--bin", target])).current_dir(shell::root().join("fuzz"));
    cargo.env("CARGO_TARGET_DIR", folder.join("build")).env("RUSTFLAGS", RUSTFLAGS);
    cargo.env("CARGO_INCREMENTAL", "0").env_remove("CARGO").env_remove("RUSTUP_TOOLCHAIN");
    shell::run(&mut cargo)
        .context("the programs could not be built; they need `rustup toolchain install nightly`")
}

fn program(folder: &Path, target: &str) -> PathBuf {
    folder.join("build").join(TARGET_TRIPLE).join("release").join(target)
}

/// Runs slots until every target has had its time. Returns the number of slots that ended with a finding.
fn campaign(options: &Options, targets: Vec<String>) -> Result<u32> {
    let mut found = 0;
    loop {
        let record = Record::read(&options.folder)?;
        let minutes = |target: &String| record.processor_s(target) / 60.0;
        let waiting: Vec<&String> =
            targets.iter().filter(|target| minutes(target) < options.minutes).collect();
        if waiting.is_empty() {
            return Ok(found);
        }
        for target in waiting.into_iter().take(options.together) {
            let slot = fuzz(options, target)?;
            let so_far = minutes(target) + slot.processor_s / 60.0;
            println!("{target:16} {so_far:6.1} of {:.1} minutes  {}", options.minutes, slot.end());
            found += slot.findings;
        }
    }
}

/// What one slot did, or several of a target.
#[derive(Clone, Debug, Default, PartialEq)]
struct Slot {
    target: String,
    clock_s: f64,
    processor_s: f64,
    executions: u64,
    /// Slots that ended with a finding.
    findings: u32,
}

impl Slot {
    fn end(&self) -> &'static str {
        if self.findings > 0 { "FOUND AN INPUT, see its log" } else { "nothing found" }
    }

    fn line(&self) -> String {
        let Self { target, clock_s, processor_s, executions, findings } = self;
        format!("{target}\t{clock_s:.2}\t{processor_s:.2}\t{executions}\t{findings}\n")
    }

    fn parse(line: &str) -> Option<Self> {
        let fields: Vec<&str> = line.split('\t').collect();
        let [target, clock_s, processor_s, executions, findings] = fields[..] else { return None };
        Some(Self {
            target: target.to_owned(),
            clock_s: clock_s.parse().ok()?,
            processor_s: processor_s.parse().ok()?,
            executions: executions.parse().ok()?,
            findings: findings.parse().ok()?,
        })
    }
}

/// Runs a target for one slot and notes it.
fn fuzz(options: &Options, target: &str) -> Result<Slot> {
    let folder = &options.folder;
    let (corpus, artifacts) = (folder.join("corpus").join(target), folder.join("artifacts").join(target));
    for needed in [&corpus, &artifacts, &folder.join("logs")] {
        fs::create_dir_all(needed).with_context(|| format!("could not make {}", needed.display()))?;
    }
    let (started, processor_before) = (Instant::now(), processor_s_of_children());
    let log = folder.join("logs").join(format!("{target}.log"));
    let output = File::create(&log).with_context(|| format!("could not write {}", log.display()))?;
    let mut run = niced(&program(folder, target))?;
    run.arg(format!("-max_total_time={}", options.slot_s)).arg("-print_final_stats=1").args(LIMITS);
    run.arg(format!("-artifact_prefix={}/", artifacts.display()));
    let dictionary = shell::root().join("fuzz/dictionaries").join(format!("{target}.dict"));
    if dictionary.exists() {
        run.arg(format!("-dict={}", dictionary.display()));
    }
    run.arg(&corpus).arg(shell::root().join("fuzz/corpus").join(target));
    let status = run.stdin(Stdio::null()).stdout(Stdio::null()).stderr(output).status();
    let status = status.with_context(|| format!("could not start the program of {target}"))?;
    // The log quotes inputs, which are no text.
    let text = String::from_utf8_lossy(&fs::read(&log).unwrap_or_default()).into_owned();
    let executions = text.lines().find_map(|line| line.strip_prefix("stat::number_of_executed_units:"));
    let slot = Slot {
        target: target.to_owned(),
        clock_s: started.elapsed().as_secs_f64(),
        processor_s: processor_s_of_children() - processor_before,
        executions: executions.and_then(|number| number.trim().parse().ok()).unwrap_or(0),
        findings: u32::from(!status.success()),
    };
    if slot.findings > 0 {
        let kept = folder.join("logs").join(format!("{target}.found-{}.log", now_s()));
        fs::rename(&log, &kept).with_context(|| format!("could not rename {}", log.display()))?;
    }
    let record = OpenOptions::new().create(true).append(true).open(folder.join(RECORD));
    record
        .and_then(|mut file| file.write_all(slot.line().as_bytes()))
        .context("could not write the record")?;
    Ok(slot)
}

/// A program of the lowest priority, with its temporary files in memory.
fn niced(program: &Path) -> Result<Command> {
    let memory = Path::new("/dev/shm");
    let temporary =
        if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() }.join("autoinspect-fuzz");
    fs::create_dir_all(&temporary).with_context(|| format!("could not make {}", temporary.display()))?;
    let mut command = shell::program("nice");
    command.args(["-n", "19"]).arg(program).env("TMPDIR", temporary);
    command
        .env("ASAN_OPTIONS", "detect_odr_violation=0:quarantine_size_mb=16:detect_leaks=0:abort_on_error=1");
    Ok(command)
}

/// Processor time of all children that have ended, seconds.
fn processor_s_of_children() -> f64 {
    /// Of Linux, on all its platforms.
    const TICKS_PER_S: f64 = 100.0;
    let text = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name of the program, in parentheses, may contain anything.
    let fields: Vec<&str> = text.rsplit_once(')').map_or("", |(_, rest)| rest).split_whitespace().collect();
    // `cutime` and `cstime`, fields 16 and 17 of proc(5).
    let ticks = fields.get(13..15).unwrap_or_default().iter().filter_map(|ticks| ticks.parse::<f64>().ok());
    ticks.sum::<f64>() / TICKS_PER_S
}

fn now_s() -> u64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.unwrap_or_default().as_secs()
}

/// Name of the record in the folder of the run.
const RECORD: &str = "runs.tsv";

/// All slots that were run, in the repository's record and after it.
struct Record(Vec<Slot>);

impl Record {
    /// Reads the repository's record and that of a folder.
    fn read(folder: &Path) -> Result<Self> {
        let mut slots = Self::of_file(&Self::of_repository())?;
        slots.extend(Self::of_file(&folder.join(RECORD))?);
        Ok(Self(slots))
    }

    fn of_repository() -> PathBuf {
        shell::root().join("fuzz").join(RECORD)
    }

    /// The slots that a file notes; none if there is no file.
    fn of_file(path: &Path) -> Result<Vec<Slot>> {
        match fs::read_to_string(path) {
            Ok(text) => Ok(Self::parse(&text).0),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
            Err(error) => Err(error).with_context(|| format!("could not read {}", path.display())),
        }
    }

    /// Adds the slots of a folder to the repository's record, and removes them there.
    fn move_to_repository(folder: &Path) -> Result<()> {
        let (of_folder, of_repository) = (folder.join(RECORD), Self::of_repository());
        let sums = Self::read(folder)?.sums();
        fs::write(&of_repository, sums.iter().map(Slot::line).collect::<String>())
            .with_context(|| format!("could not write {}", of_repository.display()))?;
        if of_folder.exists() {
            fs::remove_file(&of_folder)
                .with_context(|| format!("could not remove {}", of_folder.display()))?;
        }
        Ok(())
    }

    fn parse(text: &str) -> Self {
        Self(text.lines().filter_map(Slot::parse).collect())
    }

    /// One slot for each target, with the sums of all of it, in the order of the names.
    fn sums(&self) -> Vec<Slot> {
        let mut sums: BTreeMap<&str, Slot> = BTreeMap::new();
        for slot in &self.0 {
            let sum = sums.entry(&slot.target).or_default();
            sum.target.clone_from(&slot.target);
            sum.clock_s += slot.clock_s;
            sum.processor_s += slot.processor_s;
            sum.executions += slot.executions;
            sum.findings += slot.findings;
        }
        sums.into_values().collect()
    }

    fn processor_s(&self, target: &str) -> f64 {
        self.0.iter().filter(|slot| slot.target == target).map(|slot| slot.processor_s).sum()
    }

    /// A table in Markdown with a line for each target and one for all.
    fn table(&self) -> String {
        let mut rows: BTreeMap<&str, (f64, f64, u64, u32)> = BTreeMap::new();
        for slot in &self.0 {
            for name in [slot.target.as_str(), "~"] {
                let row = rows.entry(name).or_default();
                row.0 += slot.clock_s / 60.0;
                row.1 += slot.processor_s / 60.0;
                row.2 += slot.executions;
                row.3 += slot.findings;
            }
        }
        let mut text = "| target | minutes on the clock | minutes of processor time | executions | slots that ended with a finding |\n\
            | --- | ---: | ---: | ---: | ---: |\n"
            .to_owned();
        for (name, (clock, processor, executions, found)) in rows {
            let name = if name == "~" { "all".to_owned() } else { format!("`{name}`") };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "| {name} | {clock:.1} | {processor:.1} | {executions} | {found} |");
        }
        text
    }
}

/// Replaces what `fuzz/corpus` keeps of a target, beside seeds and findings, by inputs of the run's corpus that cover the most with the fewest and shortest.
fn minimise(folder: &Path, target: &str) -> Result<()> {
    let (corpus, kept) = (folder.join("corpus").join(target), shell::root().join("fuzz/corpus").join(target));
    if !corpus.is_dir() {
        println!("{target:16} has no corpus yet");
        return Ok(());
    }
    let least = folder.join("minimised").join(target);
    if least.exists() {
        fs::remove_dir_all(&least).with_context(|| format!("could not remove {}", least.display()))?;
    }
    for needed in [&least, &kept] {
        fs::create_dir_all(needed).with_context(|| format!("could not make {}", needed.display()))?;
    }
    let mut merge = niced(&program(folder, target))?;
    merge.arg("-set_cover_merge=1").args(LIMITS).arg(&least).arg(&corpus).arg(&kept);
    shell::run(merge.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()))?;
    for entry in fs::read_dir(&kept)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if !name.starts_with("seed-") && !name.starts_with("found-") {
            fs::remove_file(&path).with_context(|| format!("could not remove {}", path.display()))?;
        }
    }
    let mut inputs = Vec::new();
    for entry in fs::read_dir(&least)? {
        let entry = entry?;
        inputs.push((entry.metadata()?.len(), entry.path()));
    }
    inputs.sort();
    let short: Vec<&PathBuf> =
        inputs.iter().filter(|(length, _)| *length <= MAX_KEPT_BYTES).map(|(_, path)| path).collect();
    for path in spread(&short, MAX_KEPT_INPUTS) {
        let to = kept.join(path.file_name().unwrap_or_default());
        fs::copy(path, &to).with_context(|| format!("could not write {}", to.display()))?;
    }
    println!(
        "{target:16} {} inputs cover as much as all, {} of them are kept",
        inputs.len(),
        short.len().min(MAX_KEPT_INPUTS)
    );
    Ok(())
}

/// At most `count` of these, evenly spread from the first to the last: the inputs are sorted by length, and long ones reach other code than short ones.
fn spread<T>(all: &[T], count: usize) -> impl Iterator<Item = &T> {
    let count = count.min(all.len());
    (0..count).map(move |number| &all[number * all.len() / count])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_are_noted_and_added_up() {
        let slot = |target: &str, processor_s, findings| Slot {
            target: target.to_owned(),
            clock_s: 60.0,
            processor_s,
            executions: 1000,
            findings,
        };
        let slots = [slot("pcd", 30.0, 0), slot("pcd", 18.0, 1), slot("las", 12.0, 0)];
        let text: String = slots.iter().map(Slot::line).collect();
        // A line that was being written when the run was ended.
        let record = Record::parse(&format!("{text}pcd\t60."));
        assert_eq!(record.0, slots);
        assert_eq!(record.processor_s("pcd"), 48.0);
        let sums = [slot("las", 12.0, 0), Slot { clock_s: 120.0, executions: 2000, ..slot("pcd", 48.0, 1) }];
        assert_eq!(record.sums(), sums);
        let table = record.table();
        assert!(table.contains("| `pcd` | 2.0 | 0.8 | 2000 | 1 |"), "{table}");
        assert!(table.ends_with("| all | 3.0 | 1.0 | 3000 | 1 |\n"), "{table}");
    }

    #[test]
    fn kept_inputs_are_spread_over_all_lengths() {
        let all: Vec<u32> = (0..100).collect();
        assert_eq!(spread(&all, 4).copied().collect::<Vec<_>>(), [0, 25, 50, 75]);
        assert_eq!(spread(&all[..2], 4).count(), 2);
        assert_eq!(spread::<u32>(&[], 4).count(), 0);
    }

    #[test]
    fn time_of_children_is_counted() {
        let before = processor_s_of_children();
        let status =
            Command::new("sh").args(["-c", "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done"]).status();
        assert!(status.unwrap().success());
        assert!(processor_s_of_children() > before);
    }

    #[test]
    fn files_from_outside_come_first() {
        let known = known_targets().unwrap();
        assert_eq!(known[..FROM_OUTSIDE.len()], FROM_OUTSIDE);
        assert!(known.len() >= 26, "{known:?}");
    }
}
