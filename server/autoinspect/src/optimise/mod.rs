//! `autoinspect optimise`: optimises a pose graph in a g2o file.

mod incremental;
mod problem;

use crate::failure::Failure;
use crate::{output, process, summaries, texts};
use clap::{Args, ValueEnum};
use factors::{
    BatchConfig, ChordalConfig, Method, RobustConfig, SolveError, Values, chordal, optimise,
    optimise_robustly,
};
use formats::g2o;
use incremental::{IncrementalSolution, UpdateTimes, solve_incrementally};
use problem::GraphProblem;
use serde::Serialize;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::time::Duration;

/// Find the best poses for a pose graph.
#[derive(Args, Debug)]
#[command(
    after_help = "GRAPH is a g2o file with SE(2) or SE(3) vertices and edges, and perhaps FIX. Without FIX the first pose is held.
Without vertices, or with --start chordal, the start is found from the edges.

EXAMPLES:
  autoinspect optimise m/graph.g2o --out better.g2o
  autoinspect optimise sphere2500.g2o --out s.g2o --method gauss-newton --json
  autoinspect optimise sphere2500.g2o --out s.g2o --incremental     one pose after the other, as on a robot
  autoinspect optimise loops.g2o --out clean.g2o --robust           some edges between distant poses may be wrong"
)]
pub struct OptimiseArgs {
    /// The graph.
    graph: PathBuf,
    /// The graph with the best poses; edges that --robust rejects are left out.
    #[arg(long)]
    out: PathBuf,
    /// Method of the solver.
    #[arg(long, value_enum, default_value_t = MethodName::LevenbergMarquardt)]
    method: MethodName,
    /// Initial values.
    #[arg(long, value_enum, default_value_t = Start::File)]
    start: Start,
    /// Take the poses one after the other in the order of their numbers, each with its edges to earlier ones.
    #[arg(long, conflicts_with_all = ["robust", "method", "start"])]
    incremental: bool,
    /// Reject edges between poses with non-consecutive numbers that disagree with the rest.
    #[arg(long)]
    robust: bool,
    /// Parametrisation of the rotational part of SE(3) information matrices, here and in OUT.
    #[arg(long, value_enum, default_value_t = InformationOf::RotationVector)]
    information: InformationOf,
    /// Repeat this many times and report the median time.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    repeats: u32,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MethodName {
    GaussNewton,
    LevenbergMarquardt,
    Dogleg,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Start {
    /// The file's vertices.
    File,
    /// Rotations, then positions, each from the edges by one linear solve.
    Chordal,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum InformationOf {
    /// The rotation vector, as in GTSAM and most published graphs.
    RotationVector,
    /// The quaternion's vector part, as in g2o.
    HalfAngle,
}

/// The result, for people and programs.
#[derive(Debug, Serialize)]
struct Report {
    poses: usize,
    edges: usize,
    chi2_initial: f64,
    chi2: f64,
    /// Number of factorisations, or of updates with --incremental.
    iterations: usize,
    /// Median over the repeats, CPU time of the solver alone.
    cpu_seconds: f64,
    /// Vertices of the rejected edges.
    rejected: Vec<[u64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step_ms: Option<UpdateTimes>,
    peak_memory_bytes: u64,
}

/// Result of a solver.
struct Solved {
    values: Values,
    iterations: usize,
    rejected: Vec<usize>,
    step_ms: Option<UpdateTimes>,
}

/// Runs `autoinspect optimise`.
pub fn run(args: &OptimiseArgs) -> Result<(), Failure> {
    let bytes = fs::read(&args.graph).map_err(|error| Failure::unreadable(&args.graph, error))?;
    let text = String::from_utf8_lossy(&bytes);
    let convention = match args.information {
        InformationOf::RotationVector => g2o::Information::RotationVector,
        InformationOf::HalfAngle => g2o::Information::HalfAngle,
    };
    let file = g2o::read_as(&text, convention).map_err(|error| Failure::unreadable(&args.graph, error))?;
    drop(bytes);
    let problem = GraphProblem::new(file)
        .map_err(|reason| Failure::usage(texts::cannot_optimise(&args.graph, &reason)))?;
    let refuse =
        |error: SolveError| Failure::usage(texts::cannot_optimise(&args.graph, &problem.explain(&error)));

    let mut times = Vec::new();
    let mut solved = None;
    for _ in 0..args.repeats {
        let before = process::thread_cpu_time();
        solved = Some(solve(args, &problem).map_err(refuse)?);
        times.push(process::thread_cpu_time() - before);
    }
    let Some(solved) = solved else { return Ok(()) };
    let initial = if problem.has_start {
        problem.graph.chi_squared(&problem.values).map_err(refuse)?
    } else {
        f64::NAN
    };
    let report = report(&problem, &solved, initial, &mut times).map_err(refuse)?;
    write(args, &problem, &solved, convention)?;
    output::print_human(args.json, &describe(&report));
    output::print_json(args.json, &report)
}

fn solve(args: &OptimiseArgs, problem: &GraphProblem) -> Result<Solved, SolveError> {
    if args.incremental {
        let IncrementalSolution { values, updates, step_ms } = solve_incrementally(problem)?;
        return Ok(Solved { values, iterations: updates, rejected: Vec::new(), step_ms });
    }
    let start = match args.start {
        Start::File if problem.has_start => problem.values.clone(),
        _ if args.robust => chordal(&problem.without_loops(), &problem.values, &ChordalConfig::default())?,
        _ => chordal(&problem.graph, &problem.values, &ChordalConfig::default())?,
    };
    if args.robust {
        let suspect = |id, _: &dyn factors::Factor| problem.is_loop(id);
        let found = optimise_robustly(&problem.graph, &start, suspect, &RobustConfig::default())?;
        let rejected = found.rejected.iter().map(|id| id.index()).collect();
        return Ok(Solved { values: found.values, iterations: found.iterations, rejected, step_ms: None });
    }
    let method = match args.method {
        MethodName::GaussNewton => Method::GaussNewton,
        MethodName::LevenbergMarquardt => Method::LevenbergMarquardt,
        MethodName::Dogleg => Method::Dogleg,
    };
    let found = optimise(&problem.graph, &start, &BatchConfig { method, ..BatchConfig::default() })?;
    Ok(Solved { values: found.values, iterations: found.iterations, rejected: Vec::new(), step_ms: None })
}

fn report(
    problem: &GraphProblem,
    solved: &Solved,
    chi2_initial: f64,
    times: &mut [Duration],
) -> Result<Report, SolveError> {
    times.sort_unstable();
    let squares = problem.graph.squared(&solved.values)?;
    let believed = squares.iter().filter(|(id, _)| !solved.rejected.contains(&id.index()));
    Ok(Report {
        poses: problem.ids.len(),
        edges: problem.edges(),
        chi2_initial,
        chi2: believed.map(|(_, square)| square).sum(),
        iterations: solved.iterations,
        cpu_seconds: times.get(times.len() / 2).map_or(0.0, Duration::as_secs_f64),
        rejected: solved.rejected.iter().filter_map(|&edge| problem.ends(edge)).collect(),
        step_ms: solved.step_ms,
        peak_memory_bytes: process::peak_memory(),
    })
}

fn write(
    args: &OptimiseArgs,
    problem: &GraphProblem,
    solved: &Solved,
    convention: g2o::Information,
) -> Result<(), Failure> {
    let graph = problem.result(&solved.values, &solved.rejected);
    let cannot = |error: std::io::Error| Failure::failed(texts::cannot_write(&args.out, &error));
    let mut out = BufWriter::new(File::create(&args.out).map_err(cannot)?);
    g2o::write_as(&mut out, &graph, convention).and_then(|()| out.flush()).map_err(cannot)
}

fn describe(report: &Report) -> String {
    let Report { poses, edges, chi2, iterations, cpu_seconds, .. } = *report;
    let mut lines = vec![summaries::optimised(poses, edges, chi2, iterations, cpu_seconds)];
    lines.extend(report.step_ms.map(|times| summaries::step_times(times.median, times.p99, times.max)));
    lines.extend(report.rejected.iter().map(|[from, to]| summaries::edge_rejected(*from, *to)));
    lines.join("\n")
}
