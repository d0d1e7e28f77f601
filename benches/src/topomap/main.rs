//! Makes topological maps of simulated sites, which the whole stack has mapped, and checks them against the sites' solids and the walked path. Makes them of
//! other maps too, such as imported surveys, of which no truth is known.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod check;

use anyhow::{Context, Error, Result, ensure};
use benches::mapped_folder::{MapPlan, MappedFolder};
use benches::{quantile, thread_ms};
use check::{PathCover, SolidCheck};
use clap::Parser;
use geometry::Isometry;
use messages::RobotProfile;
use site_files::SiteSource;
use site_model::Traversal;
use std::path::{Path, PathBuf};
use store::TopomapSource;
use topomap::{GeneratedMap, TopomapConfig};

/// Topological maps, checked against the truth of simulated sites.
///
/// Examples: cargo xtask bench topomap
///           cargo xtask bench topomap --sites generated:11,generated:12
///           cargo xtask bench topomap --sites b1 --set merge_distance_m=1
#[derive(Parser)]
struct Arguments {
    /// Sites, separated by commas: names, generated:SEED, or buildings as FILE.glb.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant,twins")]
    sites: Vec<String>,
    /// Further maps: folders of `autoinspect map --out` or `import --out`.
    #[arg(long, value_delimiter = ',')]
    maps: Vec<PathBuf>,
    /// Walks on which those maps were made, in their frames: trajectories of whoever carried the scanner (TUM), one for each of the maps. Without one, the virtual
    /// viewpoints stand for it.
    #[arg(long, value_delimiter = ',')]
    walks: Vec<PathBuf>,
    /// Height above the floor at which the scanner was carried on those walks, metres.
    #[arg(long, default_value_t = 1.5)]
    walk_height_m: f64,
    /// Seed of the walk that makes the map.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Length of that walk, minutes.
    #[arg(long, default_value_t = 12.0)]
    minutes: f64,
    /// LiDAR columns per sweep; 2000 is full resolution.
    #[arg(long, default_value_t = 500)]
    columns: u32,
    /// Number of people who walk on the site meanwhile.
    #[arg(long, default_value_t = 4)]
    people: u32,
    /// Folder in which the maps of the sites are kept for the next time.
    #[arg(long, default_value = "target/bench-topomap")]
    work: PathBuf,
    /// Other values of parameters, separated by commas: NAME=VALUE.
    #[arg(long, value_delimiter = ',')]
    set: Vec<String>,
    /// Fail if a bar is missed.
    #[arg(long)]
    bar: bool,
    /// Print one line for each edge that touches a solid, and each stretch of the path without an edge.
    #[arg(long)]
    verbose: bool,
}

/// Greatest distance of the walked path from an edge, metres.
const MAX_COVER_M: f64 = 3.0;
/// Longest time to make a topological map, seconds.
const MAX_GENERATE_S: f64 = 3.0;
/// Number of nodes of b1.
const B1_NODES: std::ops::RangeInclusive<usize> = 30..=60;

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let config = config(&arguments.set)?;
    println!(
        "| map | walked, m | nodes | edges, m | stairs: found of true, wrong | docks | floors | pieces | blocked | edges through solids | room left by the body: worst, 5 % | path to edge: mean, worst, over 3 m | read, s | made, s |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut missed = Vec::new();
    let Arguments { seed, minutes, columns, people, .. } = arguments;
    let plan = MapPlan { seed, minutes, columns, people };
    for name in arguments.sites.iter().filter(|name| !name.is_empty()) {
        let source: SiteSource = name.parse().map_err(Error::msg)?;
        let folder = MappedFolder::of(&source, &arguments.work, &plan)?;
        let site = source.load()?;
        let check = SolidCheck { site: &site, site_from_map: folder.site_from_map };
        let inputs =
            RowInputs { docks: &folder.docks, check: Some(&check), ..RowInputs::new(name, &folder.path) };
        missed.extend(row(&inputs, &config, arguments.verbose)?);
    }
    for (index, map) in arguments.maps.iter().enumerate() {
        let name = map.file_name().unwrap_or_default().to_string_lossy();
        let mut inputs = RowInputs::new(&name, map);
        if let Some(walk) = arguments.walks.get(index) {
            inputs.walk = Some(carried_walk(walk, arguments.walk_height_m)?);
        }
        missed.extend(row(&inputs, &config, arguments.verbose)?);
    }
    for bar in &missed {
        println!("BAR MISSED: {bar}");
    }
    if missed.is_empty() {
        println!("all bars met");
    }
    ensure!(missed.is_empty() || !arguments.bar, "{} bars are missed", missed.len());
    Ok(())
}

/// What a row of the table is made of.
struct RowInputs<'a> {
    name: &'a str,
    folder: &'a Path,
    docks: &'a [Isometry],
    /// None: no truth is known.
    check: Option<&'a SolidCheck<'a>>,
    /// Poses of the base on the walk that made a survey, if that is known.
    walk: Option<Vec<Isometry>>,
}

impl<'a> RowInputs<'a> {
    fn new(name: &'a str, folder: &'a Path) -> Self {
        Self { name, folder, docks: &[], check: None, walk: None }
    }
}

/// The walk of whoever carried a scanner, as that of a base: lower by what the scanner was carried higher.
fn carried_walk(file: &Path, height_m: f64) -> Result<Vec<Isometry>> {
    let text = std::fs::read_to_string(file).with_context(|| format!("{} cannot be read", file.display()))?;
    let lower_m = height_m - RobotProfile::default().standing_height_m;
    let poses = text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')).map(|line| {
        let numbers: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        match numbers.as_deref() {
            // Only positions are looked at.
            Ok([_, x, y, z, ..]) => Ok(Isometry::translation(*x, *y, z - lower_m)),
            _ => anyhow::bail!("{}: '{line}' is no pose", file.display()),
        }
    });
    poses.collect()
}

/// Makes the topological map of a folder and prints its row. Returns a sentence for each bar that is missed.
fn row(inputs: &RowInputs<'_>, config: &TopomapConfig, verbose: bool) -> Result<Vec<String>> {
    let RowInputs { name, folder, docks, check, walk } = inputs;
    let docks: Vec<_> = docks.iter().map(geometry::pose_from_isometry).collect();
    let profile = RobotProfile::default();
    let begun = thread_ms();
    let source = TopomapSource::read(folder, &docks, &profile, *config)
        .with_context(|| format!("{} cannot be read", folder.display()))?;
    let read_s = (thread_ms() - begun) * 1e-3;
    let is_survey = source.path().is_empty() && walk.is_none();
    let path: Vec<Isometry> = match walk {
        Some(walk) => walk.clone(),
        // Of a survey, the virtual viewpoints stand for a path: they are spread over its ground.
        None if is_survey => source.keyframes().iter().map(|(_, pose)| *pose).collect(),
        None => source.path().iter().map(|(_, pose)| *pose).collect(),
    };
    let begun = thread_ms();
    let made = source.generate();
    let made_s = (thread_ms() - begun) * 1e-3;
    if verbose {
        for segment in &made.blocked {
            let (a, b) = (segment.from_m, segment.to_m);
            println!(
                "blocked: {:?} {:.2},{:.2},{:.2} - {:.2},{:.2},{:.2}",
                segment.by, a.x, a.y, a.z, b.x, b.y, b.z
            );
        }
    }
    let cover = PathCover::new(&path, &made, MAX_COVER_M, profile.standing_height_m, verbose && !is_survey);
    let length_m: f64 = check::edges(&made).map(|edge| (edge.to - edge.from).norm()).sum();
    let floors: std::collections::BTreeSet<i32> = made.nodes.iter().map(|node| node.floor).collect();
    let solids = check.map(|check| check.edges(&made, profile.standing_height_m, verbose));
    let (stairs, through, room) = match &solids {
        Some(found) => {
            let mut rooms = found.rooms_m.clone();
            rooms.sort_by(f64::total_cmp);
            (
                format!("{} of {}, {}", found.stairs_found, found.stairs_true, found.stairs_wrong),
                found.through.to_string(),
                format!("{:.2}, {:.2} m", quantile(&rooms, 0.0), quantile(&rooms, 0.05)),
            )
        }
        None => (format!("{}", stairs(&made)), "-".to_owned(), "-".to_owned()),
    };
    println!(
        "| {name} | {:.0} | {} | {}, {length_m:.0} | {stairs} | {} | {} | {} | {} | {through} | {room} | {:.2}, {:.2}, {:.1} % | {read_s:.2} | {made_s:.2} |",
        cover.walked_m,
        made.nodes.len(),
        made.edges.len(),
        made.docks.len(),
        floors.len(),
        made.pieces,
        made.blocked.len(),
        cover.mean_m,
        cover.worst_m,
        100.0 * cover.far_share,
    );
    let mut missed = Vec::new();
    let mut bar = |is_met: bool, sentence: String| missed.extend((!is_met).then_some(sentence));
    bar(made_s < MAX_GENERATE_S, format!("{name}: made in {made_s:.2} s"));
    bar(made.pieces == 1, format!("{name}: {} connected pieces", made.pieces));
    bar(
        is_survey || cover.worst_m <= MAX_COVER_M,
        format!("{name}: a walked place is {:.2} m from all reachable edges", cover.worst_m),
    );
    if let Some(found) = &solids {
        bar(found.through == 0, format!("{name}: {} edges lead through solids", found.through));
        bar(
            found.stairs_found == found.stairs_true && found.stairs_wrong == 0,
            format!("{name}: stairs are not right"),
        );
    }
    if *name == "b1" {
        bar(B1_NODES.contains(&made.nodes.len()), format!("{name}: {} nodes", made.nodes.len()));
    }
    Ok(missed)
}

fn stairs(made: &GeneratedMap) -> usize {
    made.edges.iter().filter(|edge| edge.traversal == Traversal::Stairs).count() / 2
}

/// The usual parameters with other values for some.
fn config(values: &[String]) -> Result<TopomapConfig> {
    let mut config = TopomapConfig::default();
    for value in values {
        let (name, value) = value.split_once('=').context("--set expects NAME=VALUE")?;
        let value: f64 = value.parse()?;
        let field = match name {
            "lasting_s" => &mut config.lasting_s,
            "half_width_share" => &mut config.half_width_share,
            "half_stance_share" => &mut config.half_stance_share,
            "max_ground_gap_m" => &mut config.max_ground_gap_m,
            "max_line_end_height_m" => &mut config.max_line_end_height_m,
            "tread_m" => &mut config.tread_m,
            "walked_within_m" => &mut config.walked_within_m,
            "sample_m" => &mut config.sample_m,
            "merge_distance_m" => &mut config.merge_distance_m,
            "min_stairs_slope" => &mut config.min_stairs_slope,
            "stairs_window_m" => &mut config.stairs_window_m,
            "node_spacing_m" => &mut config.node_spacing_m,
            "max_deviation_m" => &mut config.max_deviation_m,
            "node_merge_m" => &mut config.node_merge_m,
            "min_loop_m" => &mut config.min_loop_m,
            "min_dead_end_m" => &mut config.min_dead_end_m,
            "max_range_m" => &mut config.max_range_m,
            "survey_cover_m" => &mut config.survey_cover_m,
            "ceiling_share" => &mut config.ceiling_share,
            "min_ceiling_height_m" => &mut config.min_ceiling_height_m,
            "ceiling_reach_m" => &mut config.ceiling_reach_m,
            "max_survey_detour" => &mut config.max_survey_detour,
            "survey_inflation_m" => &mut config.survey_inflation_m,
            "survey_tight_cost" => &mut config.survey_tight_cost,
            "max_survey_shift_m" => &mut config.max_survey_shift_m,
            "min_obstacle_points" => {
                config.min_obstacle_points = value as usize;
                continue;
            }
            "min_blocking_points" => {
                config.min_blocking_points = value as usize;
                continue;
            }
            "min_survey_ground_neighbours" => {
                config.min_survey_ground_neighbours = value as usize;
                continue;
            }
            "min_ground_neighbours" => {
                config.min_ground_neighbours = value as usize;
                continue;
            }
            _ => anyhow::bail!("there is no parameter {name} to set"),
        };
        *field = value;
    }
    Ok(config)
}
