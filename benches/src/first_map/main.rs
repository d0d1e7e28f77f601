//! Time from navigation until a browser shows the map of a robot that is mapping. The browser has just been started and its cache is empty. Platform,
//! simulator, browser and software renderer run on this machine.
//!
//! The page marks the event in the browser's timeline, which begins with the navigation. Build server and bundle in their release form
//! first: `cargo xtask web`. `cargo xtask bench` builds the program.

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

use anyhow::{Context, Result};
use clap::Parser;
use serde_json::Value;
use std::time::Duration;
use support::chromium::Chromium;
use support::server::Server;
use support::{wait_for, workspace_root};

/// Longest wait for a page.
const MAX_WAIT: Duration = Duration::from_secs(120);
/// The times of the page's marks, milliseconds since the navigation; null until all of them exist.
const MARKS: &str = "(() => { \
    const at = mark => performance.getEntriesByName('autoinspect: ' + mark)[0]?.startTime; \
    const all = ['client compiled', 'first frame begins', 'first map drawn'].map(at); \
    return all.every(time => time !== undefined) ? all : null; })()";

/// Seconds from navigation to the first map, in a freshly started browser each time.
///
/// Example: cargo xtask web && cargo xtask bench first_map --loads 6
#[derive(Parser)]
struct Arguments {
    /// Number of page loads.
    #[arg(long, default_value_t = 6)]
    loads: usize,
    /// The simulated site.
    #[arg(long, default_value = "b1")]
    site: String,
}

#[allow(clippy::print_stdout, reason = "the table is this program's output")]
fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let bundle = workspace_root().join("static/pkg/manifest.json");
    anyhow::ensure!(bundle.exists(), "there is no bundle in static/pkg; `cargo xtask web` makes it");
    let data = tempfile::tempdir()?;
    let server = Server::start(&arguments.site, data.path());
    start_mapping(&server)?;

    println!("{:>6}{:>12}{:>14}{:>12}", "load", "compiled s", "first frame s", "map s");
    let mut times = Vec::new();
    for load in 1..=arguments.loads {
        let browser = Chromium::start().context("there is no Chromium on this machine")?;
        let mut page = browser.open(1440, 900);
        page.go(&server.url());
        let [compiled, framed, drawn] =
            wait_for("the first map", MAX_WAIT, || seconds(&page.evaluate(MARKS)));
        println!("{load:>6}{compiled:>12.2}{framed:>14.2}{drawn:>12.2}");
        times.push(drawn);
    }
    times.sort_by(f64::total_cmp);
    println!("median {:.2} s, worst {:.2} s", times[times.len() / 2], times[times.len() - 1]);
    server.stop();
    Ok(())
}

/// Starts mapping.
fn start_mapping(server: &Server) -> Result<()> {
    let browser = Chromium::start().context("there is no Chromium on this machine")?;
    let mut page = browser.open(1440, 900);
    page.go(&server.url());
    page.click("button", "Map");
    page.click("button", "Start mapping");
    wait_for("a first map", MAX_WAIT, || page.status("Points in map").filter(|points| points != "0"));
    Ok(())
}

fn seconds(marks: &Value) -> Option<[f64; 3]> {
    let times: Option<Vec<f64>> = marks.as_array()?.iter().map(|time| Some(time.as_f64()? / 1e3)).collect();
    times?.try_into().ok()
}
