//! Runs GTSAM, in a Python environment in the work folder if none is given.

use crate::arguments::Arguments;
use crate::table;
use anyhow::{Context, Result};
use benches::{json, succeed};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// GTSAM's script and the Python that runs it; no Python if its environment could not be made.
pub struct Gtsam {
    python: Option<PathBuf>,
    script: PathBuf,
}

impl Gtsam {
    /// Uses the given Python, or makes an environment in the work folder.
    pub fn find(arguments: &Arguments) -> Self {
        let script = arguments.scripts.join("pgo_gtsam.py");
        let python = match &arguments.python {
            Some(python) => Some(python.clone()),
            None => make_environment(&arguments.work.join("python"))
                .map_err(|error| table::note(&format!("GTSAM skipped: {error:#}")))
                .ok(),
        };
        Self { python, script }
    }

    /// One run on one core; `None`, with a note, when it fails.
    pub fn run(&self, graph: &Path, mode: &str) -> Option<Value> {
        let mut command = Command::new("taskset");
        command.args(["-c", "0"]).arg(self.python.as_ref()?).arg(&self.script).arg(graph);
        command.args(["--mode", mode, "--repeats", "1"]).env("OMP_NUM_THREADS", "1");
        let outcome = json(&mut command);
        outcome.map_err(|error| table::note(&format!("GTSAM skipped: {error:#}"))).ok()
    }

    /// Writes the patrol, unless it exists.
    pub fn make_patrol(&self, arguments: &Arguments, out: &Path) -> Result<()> {
        if out.exists() {
            return Ok(());
        }
        let python = self.python.clone().context("it needs a Python with NumPy and SciPy")?;
        let mut command = Command::new(python);
        command.arg(arguments.scripts.join("make_patrol_graph.py")).arg(out);
        succeed(command.args(["--poses", &arguments.patrol.to_string()])).map(drop)
    }
}

fn make_environment(folder: &Path) -> Result<PathBuf> {
    let python = folder.join("bin/python");
    if !folder.join("complete").exists() {
        succeed(Command::new("python3").args(["-m", "venv"]).arg(folder))?;
        let mut install = Command::new(&python);
        succeed(install.args(["-m", "pip", "install", "--quiet", "gtsam==4.3.0", "numpy", "scipy"]))?;
        std::fs::write(folder.join("complete"), "")?;
    }
    Ok(python)
}
