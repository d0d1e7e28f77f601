//! `autoinspect replay`: checks that a journal replays bit for bit.

use crate::failure::Failure;
use crate::{output, summaries, texts};
use clap::Args;
use messages::{Publication, StackEffect};
use recorder::{ReadError, Recording, TopicSelection};
use serde::Serialize;
use stack::Stack;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use vocab::Stamp;

/// Step the stack through a journal and print the fingerprint of all its effects.
#[derive(Args, Debug)]
#[command(
    after_help = "A journal is a recording made by `up` or by `map --journal`. A run that `up` recorded in several segments is replayed from its
boot. The same build and journal give the same
fingerprint, in any process.

EXAMPLES:
  autoinspect replay data/recordings/2026-11-21T10-36-22.000Z              all segments of a run
  autoinspect replay data/recordings/2026-11-21T10-36-22.000Z/000000.mcap  the same
  autoinspect replay journal.mcap --json
  autoinspect replay journal.mcap --effects effects.jsonl                  what the robot decided, a line each"
)]
pub struct ReplayArgs {
    /// The journal: a file, the folder of a run, or its first segment.
    file: PathBuf,
    /// Write every effect as a line of JSON into this file, without jobs, point clouds and pose graphs.
    #[arg(long, value_name = "FILE")]
    effects: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// A line of the file of effects.
#[derive(Serialize)]
struct EffectLine<'a> {
    /// Nanoseconds of the robot's clock.
    at_ns: i64,
    effect: &'a StackEffect,
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
    let mut effects = args.effects.as_deref().map(EffectFile::create).transpose()?;
    let mut unwritten = None;
    let digest = lockstep::replay_with(log, &mut Stack::new(), |at, step| {
        if let Some(file) = effects.as_mut().filter(|_| unwritten.is_none()) {
            unwritten = file.write(at, step).err();
        }
    });
    if let Some(error) = unwritten {
        return Err(error);
    }
    if let Some(file) = effects {
        file.finish()?;
    }
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

/// The file of effects, a line each.
struct EffectFile<'a> {
    path: &'a Path,
    writer: BufWriter<File>,
}

impl<'a> EffectFile<'a> {
    fn create(path: &'a Path) -> Result<Self, Failure> {
        let file = File::create(path).map_err(|error| Self::failed(path, &error))?;
        Ok(Self { path, writer: BufWriter::new(file) })
    }

    fn write(&mut self, at: Stamp, effects: &[StackEffect]) -> Result<(), Failure> {
        for effect in effects.iter().filter(|effect| is_small(effect)) {
            let line = EffectLine { at_ns: at.nanos(), effect };
            serde_json::to_writer(&mut self.writer, &line)
                .map_err(|error| Self::failed(self.path, &error.into()))?;
            self.writer.write_all(b"\n").map_err(|error| Self::failed(self.path, &error))?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<(), Failure> {
        self.writer.flush().map_err(|error| Self::failed(self.path, &error))
    }

    fn failed(path: &Path, error: &io::Error) -> Failure {
        Failure::failed(texts::cannot_write(path, error))
    }
}

/// Whether an effect holds neither a job's data nor a cloud nor a graph.
fn is_small(effect: &StackEffect) -> bool {
    !matches!(
        effect,
        StackEffect::StartJob { .. }
            | StackEffect::Publish(
                Publication::Scan(_)
                    | Publication::Keyframe(_)
                    | Publication::Graph { .. }
                    | Publication::GraphDelta(_)
            )
    )
}
