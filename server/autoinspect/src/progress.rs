//! How far a map that is made of others' data is, for people at a terminal or for a program that waits.

use crate::output;
use api::ImportStage;
use indicatif::ProgressBar;
use serde::Serialize;
use std::process;

/// One stage's progress.
pub enum Progress {
    /// On a terminal.
    Bar(ProgressBar),
    /// As lines of JSON, a hundred at most.
    Lines { stage: ImportStage, told: Option<u8> },
}

#[derive(Serialize)]
struct Line {
    stage: ImportStage,
    share: f32,
}

impl Progress {
    /// Of a stage that begins.
    pub fn new(lines: bool, stage: ImportStage) -> Self {
        if lines {
            return Self::Lines { stage, told: None };
        }
        Self::Bar(output::share_bar(match stage {
            ImportStage::Reading => "reading",
            ImportStage::Looking => "looking about",
            ImportStage::Writing => "writing",
        }))
    }

    /// It is so far now, 0 to 1.
    pub fn is(&mut self, share: f64) {
        match self {
            Self::Bar(bar) => bar.set_position((share * 1e3) as u64),
            Self::Lines { stage, told } => {
                let percent = (100.0 * share) as u8;
                if told.replace(percent) != Some(percent) {
                    let line = serde_json::to_string(&Line { stage: *stage, share: share as f32 });
                    if line.is_ok_and(|line| output::try_line(&line).is_err()) {
                        // Whoever waited has gone: there is nobody left to work for.
                        process::exit(1);
                    }
                }
            }
        }
    }

    /// The stage is over.
    pub fn ends(self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

/// Everything else on this computer comes first: its processor, and its memory should that run out.
pub fn lower_priority() {
    // Where the system does not let it, it competes.
    let _ = rustix::process::nice(10);
    let _ = std::fs::write("/proc/self/oom_score_adj", "1000");
}
