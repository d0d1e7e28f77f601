//! Scores of missions in a file, a line of JSON each, so that a long benchmark can be continued.

use anyhow::{Context, Result};
use benches::mission_runs::MissionScore;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::Path;

/// A line of the file.
#[derive(Serialize, Deserialize)]
struct Line {
    mission: String,
    score: MissionScore,
}

/// The scores that are known.
pub(super) struct Results {
    known: BTreeMap<String, MissionScore>,
    file: Option<File>,
}

impl Results {
    /// Those of a file, which is made if it is not there. Without a file, scores are not kept.
    pub(super) fn open(path: Option<&Path>) -> Result<Self> {
        let Some(path) = path else { return Ok(Self { known: BTreeMap::new(), file: None }) };
        let text = if path.exists() { std::fs::read_to_string(path)? } else { String::new() };
        let line = |line| serde_json::from_str::<Line>(line).map(|line| (line.mission, line.score));
        let known = text.lines().map(line).collect::<Result<_, _>>();
        let known = known.with_context(|| format!("{} cannot be read; remove it", path.display()))?;
        let file = OpenOptions::new().create(true).append(true).open(path)?;
        Ok(Self { known, file: Some(file) })
    }

    pub(super) fn get(&self, mission: &str) -> Option<MissionScore> {
        self.known.get(mission).cloned()
    }

    /// Keeps a score, and returns it.
    pub(super) fn keep(&mut self, mission: String, score: MissionScore) -> Result<MissionScore> {
        if let Some(file) = &mut self.file {
            let line = Line { mission, score: score.clone() };
            writeln!(file, "{}", serde_json::to_string(&line)?)?;
        }
        Ok(score)
    }
}
