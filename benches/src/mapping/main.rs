//! Loop closure on simulated walks: which true revisits are found, which loops are wrong, what each keyframe costs.

#![allow(clippy::print_stdout, reason = "the table is the point")]

mod find;
mod map;
mod parts;
mod score;
mod walk;
mod whole;

use anyhow::{Context, Result};
use benches::stack_walk::Plan;
use clap::Parser;
use find::Found;
use geometry::Isometry;
use map::MapError;
use mapping::{LoopConfig, Verdict};
use score::{Judged, Score};
use sim::{Site, SiteName};
use std::path::PathBuf;
use std::sync::Arc;
use vocab::Span;
use whole::Whole;

/// Loops found on the simulated sites, judged by the truth.
///
/// Examples: cargo xtask bench mapping --sites b1,twins --seeds 1,2 --drifts 0,1
///           cargo xtask bench mapping --whole --minutes 30
#[derive(Parser)]
struct Arguments {
    /// Sites, separated by commas.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant,twins")]
    sites: Vec<String>,
    /// Seeds, separated by commas; one walk each.
    #[arg(long, value_delimiter = ',', default_value = "1")]
    seeds: Vec<u64>,
    /// Strengths of drift added to the odometry: 0 leaves it as it is, 1 adds some 3 m over 500 m.
    #[arg(long, value_delimiter = ',', default_value = "0,1")]
    drifts: Vec<f64>,
    /// Length of a walk, minutes.
    #[arg(long, default_value_t = 11.0)]
    minutes: f64,
    /// LiDAR columns per sweep; 2000 is full resolution.
    #[arg(long, default_value_t = 500)]
    columns: u32,
    /// People walking about.
    #[arg(long, default_value_t = 4)]
    people: u32,
    /// Folder where walks are kept for the next time.
    #[arg(long, default_value = "target/bench-mapping")]
    work: PathBuf,
    /// One line for each pair that was verified.
    #[arg(long)]
    pairs: bool,
    /// The parts by themselves too: recognition by looks alone, people, cost of each.
    #[arg(long)]
    parts: bool,
    /// The whole stack instead of its loop finder: the map that it hands over, with the odometry as it is.
    #[arg(long, conflicts_with_all = ["pairs", "parts", "drifts"])]
    whole: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if arguments.whole {
        return whole_walks(&arguments);
    }
    std::fs::create_dir_all(&arguments.work)
        .with_context(|| format!("{} cannot be made", arguments.work.display()))?;
    print_header();
    for name in &arguments.sites {
        let name: SiteName = name.parse()?;
        let site = Arc::new(Site::new(name));
        for &seed in &arguments.seeds {
            let (columns, people) = (arguments.columns, arguments.people);
            let plan = Plan { seed, columns, people, keep_truth: true };
            let seconds = arguments.minutes * 60.0;
            let file = format!("{name}-{seed}-{}-{}-{}.walk", plan.columns, plan.people, arguments.minutes);
            let recorded = walk::keyframes(&site, &plan, seconds, &arguments.work.join(file))?;
            for &drift in &arguments.drifts {
                let found = find::find(&recorded, drift, seed, LoopConfig::default());
                let truth: Vec<_> = recorded.iter().map(|keyframe| keyframe.site_from_base).collect();
                if arguments.pairs {
                    print_pairs(&found, &truth);
                }
                let judged: Vec<Judged> = found.decisions.iter().map(Judged::from).collect();
                let score = score::score(&site, &truth, &judged);
                let case = format!("{name} {seed} {drift}");
                print(&case, &score, &found, &map::error(&recorded, &found)?);
                if arguments.parts {
                    let revisits = score::revisits(&site, &truth);
                    parts::parts(&site, &recorded, &revisits, (&found.finder, &found.graph)).print(&case);
                }
            }
        }
    }
    Ok(())
}

/// Walks with the whole stack, one line each.
fn whole_walks(arguments: &Arguments) -> Result<()> {
    println!(
        "{:<8} {:>5} {:>8} {:>7} {:>8} {:>9} {:>9} {:>7} {:>6} {:>9} {:>6} {:>6} {:>6} {:>9} {:>11}  ms: keyframe median, p99, max; loop median, max",
        "site",
        "seed",
        "path m",
        "frames",
        "map mm",
        "track mm",
        "revisits",
        "closed",
        "%",
        "accepted",
        "WRONG",
        "ties",
        "WRONG",
        "rejected",
        "unverified"
    );
    for name in &arguments.sites {
        let name: SiteName = name.parse()?;
        let site = Arc::new(Site::new(name));
        for &seed in &arguments.seeds {
            let (columns, people) = (arguments.columns, arguments.people);
            let plan = Plan { seed, columns, people, keep_truth: true };
            let walked = whole::walk(&site, &plan, Span::from_secs_f64(arguments.minutes * 60.0))?;
            print_whole(name, seed, &walked);
        }
    }
    Ok(())
}

fn print_whole(name: SiteName, seed: u64, walked: &Whole) {
    let score = &walked.score;
    let sorted = |times: &[f64]| {
        let mut sorted = times.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted
    };
    let at = |sorted: &[f64], part: f64| {
        sorted.get(((sorted.len() as f64 * part) as usize).min(sorted.len().saturating_sub(1))).copied()
    };
    let (keyframes, loops) = (sorted(&walked.keyframe_ms), sorted(&walked.loop_ms));
    let [median, p99, most] = [0.5, 0.99, 1.0].map(|part| at(&keyframes, part).unwrap_or_default());
    let [loop_median, loop_most] = [0.5, 1.0].map(|part| at(&loops, part).unwrap_or_default());
    println!(
        "{:<8} {seed:>5} {:>8.1} {:>7} {:>8.1} {:>9.1} {:>9} {:>7} {:>6.1} {:>9} {:>6} {:>6} {:>6} {:>9} {:>11}  {median:.1} {p99:.1} {most:.1}; {loop_median:.1} {loop_most:.1}",
        name.to_string(),
        walked.distance,
        score.keyframes,
        walked.error * 1e3,
        walked.track_error * 1e3,
        score.revisits,
        score.closed,
        100.0 * score.closed as f64 / score.revisits.max(1) as f64,
        score.accepted,
        score.wrong,
        walked.ties,
        walked.wrong_ties,
        score.rejected,
        walked.unverified,
    );
}

fn print_header() {
    println!(
        "{:<12} {:>6} {:>9} {:>7} {:>6} {:>9} {:>6} {:>5} {:>8} {:>8} {:>8} {:>7} {:>9} {:>9}  ms: take in (p99) verify (p99) judge (p99)",
        "walk",
        "frames",
        "revisits",
        "closed",
        "%",
        "accepted",
        "WRONG",
        "held",
        "rejected",
        "err mm",
        "err mrad",
        "honesty",
        "odom mm",
        "map mm"
    );
}

fn print(case: &str, score: &Score, found: &Found, map: &MapError) {
    let times = [&found.insert_keyframe, &found.verify, &found.judge].map(|times| {
        let mut sorted = times.clone();
        sorted.sort_by(f64::total_cmp);
        let mean = sorted.iter().sum::<f64>() / sorted.len().max(1) as f64;
        let high = sorted.get(sorted.len() * 99 / 100).copied().unwrap_or_default();
        format!("{mean:.1} ({high:.1})")
    });
    println!(
        "{case:<12} {:>6} {:>9} {:>7} {:>6.1} {:>9} {:>6} {:>5} {:>8} {:>8.1} {:>8.2} {:>7.1} {:>9.1} {:>9.1}  {}  {:.0} MB",
        score.keyframes,
        score.revisits,
        score.closed,
        100.0 * score.closed as f64 / score.revisits.max(1) as f64,
        score.accepted,
        score.wrong,
        score.held,
        score.rejected,
        score.place_error * 1e3,
        score.turn_error * 1e3,
        score.honesty,
        map.odometry * 1e3,
        map.closed * 1e3,
        times.join(" "),
        found.submap_bytes as f64 * 1e-6,
    );
}

fn print_pairs(found: &Found, truth: &[Isometry]) {
    for decision in &found.decisions {
        let judged = Judged::from(decision);
        let (place, turn) = score::error(&judged, truth);
        let evidence = &decision.evidence;
        let truth = if score::is_wrong(&judged, truth) { "wrong" } else { "right" };
        let verdict = match decision.verdict {
            Verdict::Rejected(rejection) => format!("{rejection:?}"),
            other => format!("{other:?}"),
        };
        println!(
            "pair {:>4} {:>4} {truth} {verdict:<12} {:<18} err {place:>7.3} m {turn:>6.3} overlap {:.2} {:.2} residual {:.3} free space {:.3} {:.3} runner-up {:.2} degenerate {} conditioning {:.4} score {:.2} squared {:>8.1} agree {}",
            decision.edge.from.0,
            decision.edge.to.0,
            format!("{:?}", evidence.source),
            evidence.overlap[0],
            evidence.overlap[1],
            evidence.residual_m,
            evidence.free_space_violation[0],
            evidence.free_space_violation[1],
            evidence.runner_up_ratio,
            evidence.degenerate_directions,
            evidence.conditioning,
            evidence.score,
            evidence.mahalanobis_squared.unwrap_or(-1.0),
            decision.agreeing,
        );
    }
}
