//! Pose-graph optimisation compared with GTSAM: published graphs in batch and pose by pose, and one large patrol.
//!
//! Both programs run on one core, one after the other, graph by graph. Times are medians of CPU time. The script computes the chi-squared of
//! GTSAM's result with the same residual as ours, which separates rotation and translation.

mod arguments;
mod gtsam;
mod table;

use anyhow::{Context, Result};
use arguments::Arguments;
use benches::json;
use clap::Parser;
use gtsam::Gtsam;
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use table::Row;

/// Chi-squared at the optimum of the published graphs.
const OPTIMA: [(&str, f64); 4] = [
    ("sphere2500", 1351.4019),
    ("parking-garage", 1.2683848),
    ("intel", 45.004233),
    ("smallGrid3D", 1035.8507),
];

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    std::fs::create_dir_all(&arguments.work)
        .with_context(|| format!("{} cannot be made", arguments.work.display()))?;
    let gtsam = Gtsam::find(&arguments);
    table::print_header();
    for name in &arguments.graphs {
        let path = arguments.data.join(format!("{name}.g2o"));
        let optimum = OPTIMA.iter().find(|(known, _)| known == name).map(|(_, optimum)| *optimum);
        for (mode, ours, theirs) in [
            ("batch", &["--method", "gauss-newton"][..], "gn"),
            ("pose by pose", &["--incremental"], "isam2"),
        ] {
            compare(&arguments, &gtsam, Case { name, path: &path, mode, ours, theirs, optimum })?;
        }
    }
    if arguments.patrol > 0 {
        let path = arguments.work.join("patrol.g2o");
        if let Err(error) = gtsam.make_patrol(&arguments, &path) {
            return table::note(&format!("patrol skipped: {error:#}"));
        }
        let ours = &["--method", "gauss-newton", "--start", "chordal"];
        compare(
            &arguments,
            &gtsam,
            Case { name: "patrol", path: &path, mode: "batch", ours, theirs: "gn", optimum: None },
        )?;
    }
    Ok(())
}

struct Case<'a> {
    name: &'a str,
    path: &'a Path,
    mode: &'static str,
    /// Arguments of our program.
    ours: &'a [&'a str],
    /// Mode of GTSAM's script.
    theirs: &'a str,
    optimum: Option<f64>,
}

fn compare(arguments: &Arguments, gtsam: &Gtsam, case: Case) -> Result<()> {
    let mut ours = Vec::new();
    let mut theirs = Vec::new();
    // The runs alternate, so that a busy machine slows both.
    for _ in 0..arguments.repeats {
        ours.push(run_ours(arguments, &case)?);
        theirs.extend(gtsam.run(case.path, case.theirs));
    }
    let median = |runs: &[Value], pointer: &str| {
        let mut values: Vec<f64> =
            runs.iter().filter_map(|run| run.pointer(pointer).and_then(Value::as_f64)).collect();
        values.sort_unstable_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    table::print(&Row {
        graph: case.name.to_owned(),
        mode: case.mode,
        ours: median(&ours, "/cpu_seconds"),
        gtsam: median(&theirs, "/cpu_seconds"),
        chi2: median(&ours, "/chi2"),
        gtsam_chi2: median(&theirs, "/error"),
        optimum: case.optimum,
        p99_ms: median(&ours, "/step_ms/p99"),
        gtsam_p99_ms: median(&theirs, "/p99_step_ms"),
        peak_mb: median(&ours, "/peak_memory_bytes").map(|bytes| bytes * 1e-6),
        gtsam_peak_mb: median(&theirs, "/peak_mb"),
    });
    Ok(())
}

fn run_ours(arguments: &Arguments, case: &Case) -> Result<Value> {
    let mut command = Command::new("taskset");
    command
        .args(["-c", "0"])
        .arg(&arguments.program)
        .arg("optimise")
        .arg(case.path)
        .args(case.ours)
        .arg("--json");
    json(command.arg("--out").arg(arguments.work.join("ours.g2o")))
}
