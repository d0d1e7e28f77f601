//! Progress of an import, for people at a terminal or for the program that started it.

use crate::{output, texts};
use api::ImportStage;
use indicatif::ProgressBar;
use serde::Serialize;
use std::io::Read;
use std::{process, thread};

/// Reporter of the progress of one stage.
pub enum Progress {
    /// On a terminal.
    Bar(ProgressBar),
    /// As lines of JSON, at most one for each percent.
    Lines { stage: ImportStage, printed_percent: Option<u8> },
}

#[derive(Serialize)]
struct Line {
    stage: ImportStage,
    share: f32,
}

impl Progress {
    /// Starts a stage; `lines` selects JSON.
    pub fn new(lines: bool, stage: ImportStage) -> Self {
        if lines {
            return Self::Lines { stage, printed_percent: None };
        }
        Self::Bar(output::share_bar(texts::import_stage(stage)))
    }

    /// Shows the share that is done, 0 to 1.
    pub fn set_share(&mut self, share: f64) {
        match self {
            Self::Bar(bar) => bar.set_position((share * 1e3) as u64),
            Self::Lines { stage, printed_percent } => {
                let percent = (100.0 * share) as u8;
                if printed_percent.replace(percent) != Some(percent) {
                    let line = serde_json::to_string(&Line { stage: *stage, share: share as f32 });
                    if line.is_ok_and(|line| output::try_line(&line).is_err()) {
                        // The program that started this one has ended, so the result is not needed.
                        process::exit(1);
                    }
                }
            }
        }
    }

    /// Ends the stage.
    pub fn finish(self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

/// Makes this process the work of the program that started it: it has low CPU priority, is the first to be ended when memory runs out, and ends when its
/// standard input does, which means that the other program has ended. Otherwise it would write into a data directory that a new core has opened.
pub fn run_in_background() {
    lower_priority();
    let until_end_of_input = || {
        let mut buffer = [0; 64];
        while matches!(std::io::stdin().read(&mut buffer), Ok(1..)) {}
        process::exit(1);
    };
    // Without the thread, the process ends when it next prints its progress.
    let _ = thread::Builder::new().name("stdin".to_owned()).spawn(until_end_of_input);
}

fn lower_priority() {
    // If the system refuses, the process runs with normal priority.
    let _ = rustix::process::nice(10);
    let _ = std::fs::write("/proc/self/oom_score_adj", "1000");
}
