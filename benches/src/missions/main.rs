//! Missions on simulated sites: the whole stack maps a site, the topological map is made from that map, and a robot among people visits nodes for pictures and goes
//! back to its dock. Scored by the truth.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod dockings;
mod results;

use anyhow::{Context, Error, Result, ensure};
use benches::mapped_folder::MapPlan;
use benches::mission_runs::{MissionScore, MissionSite, MissionTotals, PictureScore, run_mission};
use clap::Parser;
use results::Results;
use site_files::SiteSource;
use std::path::PathBuf;

/// Missions on simulated sites, a row for each site and seed.
///
/// Examples: cargo xtask bench missions
///           cargo xtask bench missions --seeds 20 --bar
///           cargo xtask bench missions --sites b1 --seeds 0 --dockings 8
#[derive(Parser)]
struct Arguments {
    /// Sites, separated by commas: names, generated:SEED, or buildings as FILE.glb.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant,twins")]
    sites: Vec<String>,
    /// Missions on each site.
    #[arg(long, default_value_t = 2)]
    seeds: u64,
    /// The first seed.
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Dockings on each site with the dock as the map has it, as many with a dock that was moved, and with contacts that fail.
    #[arg(long, default_value_t = 0)]
    dockings: u64,
    /// Tasks of each mission.
    #[arg(long, default_value_t = 6)]
    tasks: usize,
    /// Length of the walk that makes the map, minutes.
    #[arg(long, default_value_t = 12.0)]
    minutes: f64,
    /// LiDAR columns per sweep; 2000 is full resolution.
    #[arg(long, default_value_t = 500)]
    columns: u32,
    /// LiDAR columns per sweep of the walk that makes the map, if not as many.
    #[arg(long)]
    map_columns: Option<u32>,
    /// Number of people who walk on the site.
    #[arg(long, default_value_t = 4)]
    people: u32,
    /// Folder in which the maps of the sites are kept for the next time.
    #[arg(long, default_value = "target/bench-topomap")]
    work: PathBuf,
    /// File in which the scores of missions are kept. Those that are in it are not run again, so that a long benchmark can be continued. Remove it when the
    /// program has changed.
    #[arg(long)]
    results: Option<PathBuf>,
    /// Fail if a bar is missed.
    #[arg(long)]
    bar: bool,
    /// Print contacts, failures, blocks and notices of each mission.
    #[arg(long)]
    verbose: bool,
}

impl Arguments {
    /// What decides a mission.
    fn key(&self, name: &str, seed: u64) -> String {
        let Self { tasks, minutes, columns, people, .. } = self;
        let map_columns = self.map_columns.unwrap_or(*columns);
        format!(
            "{name}, seed {seed}, {tasks} tasks, {columns} columns, {people} people, map of {minutes} min and {map_columns} columns"
        )
    }

    fn mapped(&self, name: &str) -> Result<MissionSite> {
        let source: SiteSource = name.parse().map_err(Error::msg)?;
        let columns = self.map_columns.unwrap_or(self.columns);
        let plan = MapPlan { seed: 1, minutes: self.minutes, columns, people: self.people };
        MissionSite::new(&source, &self.work, &plan).with_context(|| name.to_owned())
    }
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if arguments.seeds == 0 {
        return measure_dockings(&arguments);
    }
    println!(
        "| site | seed | outcome | tasks done | position: mean, worst | heading: worst | target off the centre: worst | contacts with solids, with people | people walked into it | in the dock | robot time | failures |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut results = Results::open(arguments.results.as_deref())?;
    let sites = arguments.sites.iter().map(|name| Ok((name, arguments.mapped(name)?)));
    let sites = sites.collect::<Result<Vec<_>>>()?;
    let mut all: Vec<(&str, Vec<MissionScore>)> =
        sites.iter().map(|(name, _)| (name.as_str(), Vec::new())).collect();
    // A seed after the other, so that what was done before an interruption is of all sites.
    for seed in arguments.first..arguments.first + arguments.seeds {
        for ((name, mapped), (_, scores)) in sites.iter().zip(&mut all) {
            let key = arguments.key(name, seed);
            let score = match results.get(&key) {
                Some(score) => score,
                None => results.keep(
                    key,
                    run_mission(mapped, seed, arguments.tasks, arguments.columns, arguments.people)
                        .with_context(|| format!("{name}, seed {seed}"))?,
                )?,
            };
            print_row(name, seed, &score);
            if arguments.verbose {
                score.details.iter().for_each(|line| println!("    {line}"));
            }
            scores.push(score);
        }
    }
    if arguments.dockings > 0 {
        for (name, mapped) in &sites {
            dockings::print(name, mapped, &arguments)?;
        }
    }
    println!("\n{}", MissionTotals::HEADER);
    for (name, scores) in &all {
        println!("{}", MissionTotals::of(scores).row(name));
    }
    let totals = MissionTotals::of(all.iter().flat_map(|(_, scores)| scores));
    println!("{}", totals.row("all"));
    let missed = totals.missed();
    missed.iter().for_each(|bar| println!("BAR MISSED: {bar}"));
    if missed.is_empty() {
        println!("all bars met");
    }
    ensure!(missed.is_empty() || !arguments.bar, "{} bars are missed", missed.len());
    Ok(())
}

fn measure_dockings(arguments: &Arguments) -> Result<()> {
    for name in &arguments.sites {
        dockings::print(name, &arguments.mapped(name)?, arguments)?;
    }
    Ok(())
}

fn print_row(name: &str, seed: u64, score: &MissionScore) {
    let worst = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let pictures = &score.pictures;
    let mean_m = pictures.iter().map(|it| it.position_m).sum::<f64>() / pictures.len().max(1) as f64;
    println!(
        "| {name} | {seed} | {} | {} of {} | {:.1}, {:.1} cm | {:.2}° | {:.1} % | {}, {} | {} | {} | {:.0} s | {} |",
        score.outcome.map_or("not in time".to_owned(), |outcome| format!("{outcome:?}")),
        score.done,
        score.tasks,
        100.0 * mean_m,
        100.0 * worst(&mut pictures.iter().map(|it| it.position_m)),
        worst(&mut pictures.iter().map(|it| it.heading_rad)).to_degrees(),
        100.0 * worst(&mut pictures.iter().map(PictureScore::off_centre_or_infinite)),
        score.solids_touched,
        score.people_touched,
        score.people_walked_into_it,
        match score.docked {
            Some((off_m, off_rad)) => format!("{:.1} cm, {:.2}°", 100.0 * off_m, off_rad.to_degrees()),
            None => "no".to_owned(),
        },
        score.duration_s,
        score.failures.iter().map(|failure| format!("{failure:?}")).collect::<Vec<_>>().join("; "),
    );
}
