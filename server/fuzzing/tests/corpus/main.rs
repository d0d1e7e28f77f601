//! Replays the inputs that the fuzzer found worth keeping, those that once broke a parser, and seeds made by the program's own writers.
//!
//! A failure of a replay names the input. `UPDATE_SEEDS=1` writes the seeds into `fuzz/corpus`, from where the fuzzer starts.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may panic at the first error, and prints what it replays"
)]

mod bags;
mod clouds;
mod messages;
mod pictures;
mod sites;
mod stored;

use fuzzing::{FuzzTarget, TARGETS};
use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// Largest kept corpus of all targets together, bytes.
const MAX_CORPUS_BYTES: u64 = 2 << 20;
/// Prefix of the names of seeds.
const SEED: &str = "seed-";

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus")
}

/// Seeds by target: name and bytes.
fn seeds() -> BTreeMap<&'static str, Vec<(String, Vec<u8>)>> {
    let mut seeds = BTreeMap::new();
    for (target, name, bytes) in [
        clouds::seeds(),
        bags::seeds(),
        messages::seeds(),
        pictures::seeds(),
        sites::seeds(),
        stored::seeds(),
    ]
    .into_iter()
    .flatten()
    {
        seeds.entry(target).or_insert_with(Vec::new).push((format!("{SEED}{name}"), bytes));
    }
    seeds
}

/// Runs a target; returns whether it went well.
fn replay(target: &FuzzTarget, name: &str, bytes: &[u8]) -> bool {
    let went_well = catch_unwind(AssertUnwindSafe(|| (target.run)(bytes))).is_ok();
    if !went_well {
        println!("{} breaks at {name}", target.name);
    }
    went_well
}

#[test]
fn no_kept_input_breaks_a_parser() {
    let (mut files, mut total, mut broken) = (0, 0, 0);
    for target in &TARGETS {
        let Ok(entries) = fs::read_dir(corpus().join(target.name)) else {
            panic!("{} has no corpus", target.name);
        };
        for entry in entries {
            let path = entry.unwrap().path();
            let bytes = fs::read(&path).unwrap();
            (files, total) = (files + 1, total + bytes.len() as u64);
            broken += u32::from(!replay(target, &path.display().to_string(), &bytes));
        }
    }
    println!("{files} inputs, {total} bytes");
    assert_eq!(broken, 0);
    assert!(total <= MAX_CORPUS_BYTES, "{total} bytes: minimise the corpus (docs/benchmarks/fuzzing.md)");
}

#[test]
fn every_target_has_seeds_that_it_reads() {
    let seeds = seeds();
    let update = std::env::var_os("UPDATE_SEEDS").is_some();
    for target in &TARGETS {
        let seeds = seeds.get(target.name).unwrap_or_else(|| panic!("{} has no seed", target.name));
        let folder = corpus().join(target.name);
        for (name, bytes) in seeds {
            assert!(replay(target, name, bytes));
            if update {
                fs::create_dir_all(&folder).unwrap();
                fs::write(folder.join(name), bytes).unwrap();
            }
        }
    }
    assert_eq!(seeds.len(), TARGETS.len(), "seeds of a target that does not exist");
}

#[test]
fn every_target_has_a_program_for_the_fuzzer() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
    let manifest = fs::read_to_string(fuzz.join("Cargo.toml")).unwrap();
    for FuzzTarget { name, .. } in TARGETS {
        let program = fs::read_to_string(fuzz.join("fuzz_targets").join(format!("{name}.rs"))).unwrap();
        assert!(program.contains(&format!("fuzzing::{name}(")), "{program}");
        assert!(manifest.contains(&format!("name = \"{name}\"\n")), "{name}");
    }
    assert_eq!(fs::read_dir(fuzz.join("fuzz_targets")).unwrap().count(), TARGETS.len());
}

/// A flaw in the functions under test must not pass as a replay that went well.
#[test]
fn a_broken_parser_is_detected() {
    let target = FuzzTarget { name: "broken", run: |bytes| assert!(bytes.is_empty()) };
    assert!(replay(&target, "nothing", &[]) && !replay(&target, "something", &[1]));
}
