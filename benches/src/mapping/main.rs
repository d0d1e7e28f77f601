//! Loop closure on simulated walks: the true revisits that are closed, the wrong loops, and the time of each keyframe.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod components;
mod find_loops;
mod optimised_map;
mod recorded_walk;
mod whole_stack;

use anyhow::{Context, Error, Result};
use benches::loop_score::{self, JudgedLoop, Score};
use benches::stack_walk::WalkPlan;
use clap::Parser;
use find_loops::LoopFinderRun;
use geometry::Isometry;
use mapping::{LoopConfig, Verdict};
use optimised_map::MapError;
use site_files::SiteSource;
use std::path::PathBuf;
use vocab::Span;
use whole_stack::WholeStackRun;

/// Loops found on the simulated sites, compared with the ground truth.
///
/// Examples: cargo xtask bench mapping --sites b1,twins --seeds 1,2 --drifts 0,1
///           cargo xtask bench mapping --whole-stack --minutes 30
#[derive(Parser)]
struct Arguments {
    /// Sites, separated by commas.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant,twins")]
    sites: Vec<String>,
    /// Seeds, separated by commas; one walk each.
    #[arg(long, value_delimiter = ',', default_value = "1")]
    seeds: Vec<u64>,
    /// Factors of the drift that is added to the odometry: 0 adds none, 1 adds about 3 m over 500 m.
    #[arg(long, value_delimiter = ',', default_value = "0,1")]
    drifts: Vec<f64>,
    /// Length of a walk, minutes.
    #[arg(long, default_value_t = 11.0)]
    minutes: f64,
    /// LiDAR columns per sweep; 2000 is full resolution.
    #[arg(long, default_value_t = 500)]
    columns: u32,
    /// Number of people who walk on the site.
    #[arg(long, default_value_t = 4)]
    people: u32,
    /// Folder in which recorded walks are kept for later runs.
    #[arg(long, default_value = "target/bench-mapping")]
    work: PathBuf,
    /// Print one line for each verified pair of keyframes.
    #[arg(long)]
    pairs: bool,
    /// Also measure the components separately: place recognition by appearance, removal of people, and the time of each.
    #[arg(long)]
    components: bool,
    /// Run the whole stack instead of its loop finder, without added drift, and compare its finished map.
    #[arg(long, conflicts_with_all = ["pairs", "components", "drifts"])]
    whole_stack: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if arguments.whole_stack {
        return whole_stack_walks(&arguments);
    }
    std::fs::create_dir_all(&arguments.work)
        .with_context(|| format!("{} cannot be made", arguments.work.display()))?;
    print_header();
    for name in &arguments.sites {
        let source: SiteSource = name.parse().map_err(Error::msg)?;
        let site = source.load()?;
        for &seed in &arguments.seeds {
            let (columns, people) = (arguments.columns, arguments.people);
            let plan = WalkPlan { seed, columns, people, keep_ground_truth: true };
            let seconds = arguments.minutes * 60.0;
            let file = format!("{name}-{seed}-{}-{}-{}.walk", plan.columns, plan.people, arguments.minutes);
            let recorded = recorded_walk::keyframes(&site, &plan, seconds, &arguments.work.join(file))?;
            for &drift in &arguments.drifts {
                let found = find_loops::find(&recorded, drift, seed, LoopConfig::default());
                let truth: Vec<_> = recorded.iter().map(|keyframe| keyframe.site_from_base).collect();
                if arguments.pairs {
                    print_pairs(&found, &truth);
                }
                let judged: Vec<JudgedLoop> = found.decisions.iter().map(JudgedLoop::from).collect();
                let score = loop_score::score(&site, &truth, &judged);
                let case = format!("{name} {seed} {drift}");
                print(&case, &score, &found, &optimised_map::error(&recorded, &found)?);
                if arguments.components {
                    let revisits = loop_score::revisits(&site, &truth);
                    components::measure(&site, &recorded, &revisits, (&found.finder, &found.graph))
                        .print(&case);
                }
            }
        }
    }
    Ok(())
}

/// Runs the whole stack on each walk and prints one line for it.
fn whole_stack_walks(arguments: &Arguments) -> Result<()> {
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
        "revis.",
        "WRONG",
        "rejected",
        "unverified"
    );
    for name in &arguments.sites {
        let source: SiteSource = name.parse().map_err(Error::msg)?;
        let site = source.load()?;
        for &seed in &arguments.seeds {
            let (columns, people) = (arguments.columns, arguments.people);
            let plan = WalkPlan { seed, columns, people, keep_ground_truth: true };
            let walked = whole_stack::walk(&site, &plan, Span::from_secs_f64(arguments.minutes * 60.0))?;
            print_whole(site.name(), seed, &walked);
        }
    }
    Ok(())
}

fn print_whole(name: &str, seed: u64, walked: &WholeStackRun) {
    let score = &walked.score.loops;
    let sorted = |times: &[f64]| {
        let mut sorted = times.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted
    };
    let at = |sorted: &[f64], part: f64| {
        sorted.get(((sorted.len() as f64 * part) as usize).min(sorted.len().saturating_sub(1))).copied()
    };
    let (keyframes, loops) = (sorted(&walked.keyframe_ms), sorted(&walked.job_result_ms));
    let [median, p99, most] = [0.5, 0.99, 1.0].map(|part| at(&keyframes, part).unwrap_or_default());
    let [loop_median, loop_most] = [0.5, 1.0].map(|part| at(&loops, part).unwrap_or_default());
    println!(
        "{:<8} {seed:>5} {:>8.1} {:>7} {:>8.1} {:>9.1} {:>9} {:>7} {:>6.1} {:>9} {:>6} {:>6} {:>6} {:>9} {:>11}  {median:.1} {p99:.1} {most:.1}; {loop_median:.1} {loop_most:.1}",
        name,
        walked.score.distance_m,
        score.keyframes,
        walked.score.map_rmse_m * 1e3,
        walked.score.trajectory_rmse_m * 1e3,
        score.revisits,
        score.closed,
        100.0 * score.closed as f64 / score.revisits.max(1) as f64,
        score.accepted,
        score.wrong,
        walked.score.reanchorings,
        walked.score.wrong_reanchorings,
        score.rejected,
        walked.score.unverified,
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
        "NEES",
        "odom mm",
        "map mm"
    );
}

fn print(case: &str, score: &Score, found: &LoopFinderRun, map: &MapError) {
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
        score.translation_rmse_m * 1e3,
        score.rotation_rmse_rad * 1e3,
        score.nees,
        map.odometry * 1e3,
        map.closed * 1e3,
        times.join(" "),
        found.submap_bytes as f64 * 1e-6,
    );
}

fn print_pairs(found: &LoopFinderRun, truth: &[Isometry]) {
    for decision in &found.decisions {
        let judged = JudgedLoop::from(decision);
        let (place, turn) = loop_score::error(&judged, truth);
        let evidence = &decision.evidence;
        let truth = if loop_score::is_wrong(&judged, truth) { "wrong" } else { "right" };
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
