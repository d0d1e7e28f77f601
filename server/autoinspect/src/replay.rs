//! `autoinspect replay`: checks that a journal replays bit for bit.

use crate::failure::Failure;
use crate::{output, summaries};
use clap::Args;
use recorder::{ReadError, Recording, TopicSelection};
use serde::Serialize;
use stack::Stack;
use std::path::PathBuf;

/// Step the stack through a journal and print the fingerprint of all its effects.
#[derive(Args, Debug)]
#[command(
    after_help = "A journal is a recording made by `up` or by `map --journal`. A run that `up` recorded in several segments is replayed from its
boot. The same build and journal give the same
fingerprint, in any process.

EXAMPLES:
  autoinspect replay data/recordings/2026-11-21T10-36-22.000Z              all segments of a run
  autoinspect replay data/recordings/2026-11-21T10-36-22.000Z/000000.mcap  the same
  autoinspect replay journal.mcap --json"
)]
pub struct ReplayArgs {
    /// The journal: a file, the folder of a run, or its first segment.
    file: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Result of a replay.
#[derive(Debug, Serialize)]
struct Replayed {
    inputs: u64,
    effects: u64,
    /// BLAKE3 of all effects with their instants.
    fingerprint: String,
}

/// Runs `autoinspect replay`.
pub fn run(args: &ReplayArgs) -> Result<(), Failure> {
    let recording = Recording::open_run(&args.file, &TopicSelection::default()).map_err(Failure::usage)?;
    let mut inputs = 0;
    let mut broken: Option<ReadError> = None;
    // Stops at the first unreadable input, because the state after it would be wrong.
    let log = recording.journal().map_err(Failure::usage)?.map_while(|input| match input {
        Ok(input) => {
            inputs += 1;
            Some(input)
        }
        Err(error) => {
            broken = Some(error);
            None
        }
    });
    let digest = lockstep::replay(log, &mut Stack::new());
    if let Some(error) = broken {
        return Err(Failure::usage(error));
    }
    let replayed = Replayed { inputs, effects: digest.effects(), fingerprint: digest.hex() };
    output::print_human(
        args.json,
        &summaries::replayed(replayed.inputs, replayed.effects, &replayed.fingerprint),
    );
    output::print_json(args.json, &replayed)
}
