//! Times of the questions that people ask of a year of results: lists, filters and pages over HTTP, and the list of changes in a browser. Platform, simulator and browser run on this
//! machine. The results are written into a new data folder before the platform starts.

#[path = "../../../tests/support/mod.rs"]
#[allow(
    dead_code,
    unreachable_pub,
    missing_docs,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "this module belongs to the browser tests, which fail by panicking and use all of it"
)]
mod support;

mod http;
mod results;

use anyhow::{Context, Result};
use clap::Parser;
use results::{Year, point, run};
use std::path::Path;
use std::time::Instant;
use support::chromium::Chromium;
use support::server::Server;
use support::{wait_for, workspace_root};

/// How long each answer may take, milliseconds.
const BAR_MS: f64 = 200.0;

/// Lists, filters and opens a year of results.
///
/// Example: cargo xtask bench year --bar
#[derive(Parser)]
struct Arguments {
    /// Number of results, each a picture with readings.
    #[arg(long, default_value_t = 100_000)]
    results: u64,
    /// Number of changes of the scene.
    #[arg(long, default_value_t = 20_000)]
    changes: u64,
    /// How often each question is asked.
    #[arg(long, default_value_t = 15)]
    times: usize,
    /// Fails if an answer takes longer than 200 ms.
    #[arg(long)]
    bar: bool,
}

#[allow(clippy::print_stdout, reason = "the table is this program's output")]
fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let year = Year { results: arguments.results, changes: arguments.changes };
    let data = tempfile::tempdir()?;
    let began = Instant::now();
    let picture = year.write(data.path())?;
    println!(
        "{} results and {} changes of the scene, {:.0} MB, written in {:.0} s",
        year.results,
        year.changes,
        size_mb(&data.path().join("ledger.db")),
        began.elapsed().as_secs_f64()
    );
    let began = Instant::now();
    let server = Server::start("b1", data.path());
    println!("the platform answers {:.1} s after its start\n", began.elapsed().as_secs_f64());

    println!("| question | answer | median | longest |");
    println!("| --- | --- | --- | --- |");
    let mut longest_ms = 0.0_f64;
    for (question, path) in questions(&year, &picture) {
        let mut times_ms = Vec::new();
        let mut bytes = 0;
        for _ in 0..arguments.times {
            let began = Instant::now();
            bytes = http::get(server.port, &path).with_context(|| question.to_owned())?.len();
            times_ms.push(began.elapsed().as_secs_f64() * 1e3);
        }
        longest_ms =
            longest_ms.max(print_row(question, &format!("{:.0} kB", bytes as f64 / 1e3), &mut times_ms));
    }
    if workspace_root().join("static/pkg/manifest.json").exists() {
        longest_ms = longest_ms.max(look_through_changes(&server, &arguments)?);
    } else {
        println!(
            "\nThere is no bundle in static/pkg, so the client was not measured; `cargo xtask web` makes it."
        );
    }
    server.stop();
    println!("\nlongest {longest_ms:.0} ms, bar {BAR_MS:.0} ms");
    anyhow::ensure!(!arguments.bar || longest_ms <= BAR_MS, "an answer took longer than {BAR_MS:.0} ms");
    Ok(())
}

/// Prints a row and returns the longest time.
#[allow(clippy::print_stdout, reason = "the table is this program's output")]
fn print_row(question: &str, answer: &str, times_ms: &mut [f64]) -> f64 {
    times_ms.sort_by(f64::total_cmp);
    let (median, longest) = (times_ms[times_ms.len() / 2], times_ms[times_ms.len() - 1]);
    println!("| {question} | {answer} | {median:.1} ms | {longest:.1} ms |");
    longest
}

/// What people ask, and the paths that answer.
fn questions(year: &Year, picture: &str) -> Vec<(&'static str, String)> {
    let (first_ns, last_ns) = year.span_ns();
    let middle_ns = i64::midpoint(first_ns, last_ns);
    let middle_of_point = year.results / 2;
    vec![
        ("the newest runs", "/api/v1/runs?limit=100".to_owned()),
        (
            "runs that failed in a month in the middle",
            format!(
                "/api/v1/runs?limit=100&state=failed&from_ns={middle_ns}&to_ns={}",
                middle_ns + 30 * results::DAY_NS
            ),
        ),
        ("the results of a run", format!("/api/v1/runs/{}/results?limit=100", run(year.runs() / 2))),
        (
            "the newest results of a point",
            format!("/api/v1/inspection-points/{}/results?limit=100", point(3)),
        ),
        (
            "results of a point from the middle of the year",
            format!("/api/v1/inspection-points/{}/results?limit=100&before={middle_of_point}", point(3)),
        ),
        ("a picture", format!("/api/v1/blobs/{picture}")),
        ("the newest changes", "/api/v1/scene-changes?limit=100".to_owned()),
        (
            "new changes of 0.5 m and more that appeared",
            "/api/v1/scene-changes?limit=100&kind=appeared&review=new&min_size_m=0.5".to_owned(),
        ),
        (
            "changes from the middle of the year on",
            format!("/api/v1/scene-changes?limit=100&from_ns={middle_ns}"),
        ),
        ("a change", format!("/api/v1/site/scene-changes/{}", results::change_id(year.changes / 2))),
        ("open alerts", "/api/v1/alerts?state=open&limit=100".to_owned()),
        ("the report of a run", format!("/api/v1/runs/{}/report", run(year.runs() / 2))),
    ]
}

/// Measures from now on how long the client computes for each frame.
const TIME_FRAMES: &str = "(() => { \
    const request = window.requestAnimationFrame.bind(window); \
    window.framesMs = []; \
    window.requestAnimationFrame = draw => request(time => { \
        const began = performance.now(); draw(time); window.framesMs.push(performance.now() - began); }); \
    return true; })()";
/// The longest frame since the last question, milliseconds.
const LONGEST_FRAME_MS: &str = "Math.max(0, ...window.framesMs.splice(0))";

/// The list of changes in a browser: how long the client computes for the frames after a press. How fast a frame is drawn is the computer's matter, and the same with few changes. Returns the longest
/// time, milliseconds.
fn look_through_changes(server: &Server, arguments: &Arguments) -> Result<f64> {
    const FILTERS: [&str; 6] = ["Removed", "From 0.3 m", "Moved", "Any size", "Appeared", "Any kind"];
    let browser = Chromium::start().context("there is no Chromium on this machine")?;
    let mut page = browser.open(1440, 900);
    page.go(&server.url());
    page.click("button", "Runs");
    page.click("button", "Changes");
    wait_for("the changes", std::time::Duration::from_secs(120), || {
        page.all("button").into_iter().any(|(name, _)| name.contains(" m · ")).then_some(())
    });
    page.evaluate(TIME_FRAMES);
    let mut times_ms = Vec::new();
    for round in 0..arguments.times {
        page.click("button", FILTERS[round % FILTERS.len()]);
        page.wait_for_pictures();
        times_ms.push(page.evaluate(LONGEST_FRAME_MS).as_f64().unwrap_or(f64::INFINITY));
    }
    Ok(print_row("a filter of the list of changes, in a browser", "a frame", &mut times_ms))
}

fn size_mb(path: &Path) -> f64 {
    std::fs::metadata(path).map_or(0.0, |about| about.len() as f64 / 1e6)
}
