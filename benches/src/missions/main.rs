//! Missions on simulated sites: the whole stack maps a site, the topological map is made from that map, and a robot among people visits nodes for pictures and goes
//! back to its dock. Scored by the truth.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod dockings;

use anyhow::{Context, Error, Result, ensure};
use benches::prior_map::PriorMapBuilder;
use benches::quantile;
use benches::stack_walk::{StackWalk, StepKind, WalkPlan};
use clap::Parser;
use geometry::{Isometry, RngTree, Rotation, Vector3, isometry_from_pose, pose_from_isometry};
use lockstep::Lockstep;
use messages::{
    Command, CommandKind, Input, LocalisationState, Principal, PriorMap, Publication, RobotProfile,
    StackEffect,
};
use sim::{SimConfig, Site as SimulatedSite, Start};
use site_files::SiteSource;
use site_model::{
    ActionRequest, EditId, FailurePolicy, Mission, MissionCommandKind, MissionEnd, MissionId, MissionStatus,
    Node, NodeId, NodeKind, Object, Parameters, PoseTolerance, RunId, RunState, Site, StartMode, Task,
    TaskFailure, TaskId, TaskOrder, TaskPlace, TaskState,
};
use std::collections::BTreeMap;
use std::sync::Arc;
use store::{MapFileOptions, TileFiles, TopomapSource, write_cloud, write_map_files};
use topomap::TopomapConfig;
use uuid::Uuid;
use vocab::{ClientId, CommandId, Span, Vec3};

/// Missions on simulated sites, a row for each site and seed.
///
/// Examples: cargo xtask bench missions
///           cargo xtask bench missions --sites b1 --seeds 20
///           cargo xtask bench missions --sites b1 --seeds 0 --dockings 8
#[derive(Parser)]
struct Arguments {
    /// Sites, separated by commas: names, generated:SEED, or buildings as FILE.glb.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant,twins")]
    sites: Vec<String>,
    /// Missions on each site.
    #[arg(long, default_value_t = 2)]
    seeds: u64,
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
    /// Number of people who walk on the site.
    #[arg(long, default_value_t = 4)]
    people: u32,
    /// Fail if a bar is missed.
    #[arg(long)]
    bar: bool,
    /// Print every task that was not done, and the run's states.
    #[arg(long)]
    verbose: bool,
}

/// Longest time for a mission, robot time.
const TIME_LIMIT_S: f64 = 2_400.0;
/// Bars: position and heading at a task, by the truth.
const POSITION_MAX_M: f64 = 0.10;
const HEADING_MAX_RAD: f64 = 0.0524;
/// Bars: shares of tasks that are done, and of missions that end in the dock.
const DONE_SHARE_MIN: f64 = 0.99;
const DOCKED_SHARE_MIN: f64 = 0.98;

const MISSION: MissionId = MissionId(Uuid::from_u128(1));
const RUN: RunId = RunId(Uuid::from_u128(2));

/// A site with its metric and its topological map.
struct MappedSite {
    site: Arc<SimulatedSite>,
    prior_map: Arc<PriorMap>,
    site_from_map: Isometry,
    graph: Site,
}

/// What became of a mission.
#[derive(Default)]
struct Score {
    outcome: Option<RunState>,
    done: usize,
    tasks: usize,
    failures: Vec<TaskFailure>,
    /// At each call of an action.
    positions_m: Vec<f64>,
    headings_rad: Vec<f64>,
    is_docked: bool,
    /// Position (m) and heading (rad) from the docked pose at the end, by the truth.
    docked_error: Option<(f64, f64)>,
    took_s: f64,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if arguments.seeds == 0 {
        return measure_dockings(&arguments);
    }
    println!(
        "| site | seed | outcome | tasks done | position: mean, worst | heading: worst | in the dock | robot time | failures |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut scores = Vec::new();
    for name in &arguments.sites {
        let source: SiteSource = name.parse().map_err(Error::msg)?;
        let mapped = MappedSite::new(&source, &arguments).with_context(|| name.clone())?;
        for seed in 1..=arguments.seeds {
            let score = run(&mapped, seed, &arguments)?;
            print_row(name, seed, &score);
            scores.push(score);
        }
        if arguments.dockings > 0 {
            dockings::print(name, &mapped, &arguments)?;
        }
    }
    let missed = missed_bars(&scores);
    missed.iter().for_each(|bar| println!("BAR MISSED: {bar}"));
    if missed.is_empty() {
        println!("all bars met");
    }
    ensure!(missed.is_empty() || !arguments.bar, "{} bars are missed", missed.len());
    Ok(())
}

fn measure_dockings(arguments: &Arguments) -> Result<()> {
    for name in &arguments.sites {
        let source: SiteSource = name.parse().map_err(Error::msg)?;
        let mapped = MappedSite::new(&source, arguments).with_context(|| name.clone())?;
        dockings::print(name, &mapped, arguments)?;
    }
    Ok(())
}

/// Position (m) and heading (rad) of the robot from the nearest docked pose, by the truth.
fn docked_error(day: &mut Lockstep, site: &SimulatedSite) -> Option<(f64, f64)> {
    let truth = isometry_from_pose(&day.simulator().truth().site_from_base)?;
    let ahead = truth.rotation * Vector3::x();
    let errors = site.docks().iter().map(|dock| {
        let off_m = (truth.translation.vector - geometry::vec_from_plain(dock.position)).xy().norm();
        let turned = ahead.y.atan2(ahead.x) - dock.yaw;
        (off_m, turned.sin().atan2(turned.cos()).abs())
    });
    errors.min_by(|(a, _), (b, _)| a.total_cmp(b))
}

fn print_row(name: &str, seed: u64, score: &Score) {
    let worst = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let mean_m = score.positions_m.iter().sum::<f64>() / score.positions_m.len().max(1) as f64;
    println!(
        "| {name} | {seed} | {} | {} of {} | {:.1}, {:.1} cm | {:.2}° | {} | {:.0} s | {} |",
        score.outcome.map_or("not in time".to_owned(), |outcome| format!("{outcome:?}")),
        score.done,
        score.tasks,
        100.0 * mean_m,
        100.0 * worst(&score.positions_m),
        worst(&score.headings_rad).to_degrees(),
        match score.docked_error.filter(|_| score.is_docked) {
            Some((off_m, off_rad)) => format!("{:.1} cm, {:.2}°", 100.0 * off_m, off_rad.to_degrees()),
            None => "no".to_owned(),
        },
        score.took_s,
        score.failures.iter().map(|failure| format!("{failure:?}")).collect::<Vec<_>>().join("; "),
    );
}

fn missed_bars(scores: &[Score]) -> Vec<String> {
    let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
    let done = share(scores.iter().map(|it| it.done).sum(), scores.iter().map(|it| it.tasks).sum());
    let docked = share(scores.iter().filter(|score| score.is_docked).count(), scores.len());
    let mut positions_m: Vec<f64> = scores.iter().flat_map(|score| score.positions_m.clone()).collect();
    let mut headings_rad: Vec<f64> = scores.iter().flat_map(|score| score.headings_rad.clone()).collect();
    positions_m.sort_by(f64::total_cmp);
    headings_rad.sort_by(f64::total_cmp);
    let (position_m, heading_rad) = (quantile(&positions_m, 1.0), quantile(&headings_rad, 1.0));
    println!(
        "all: {:.1} % of tasks done, worst {:.1} cm and {:.2}°, {:.1} % in the dock",
        100.0 * done,
        100.0 * position_m,
        heading_rad.to_degrees(),
        100.0 * docked
    );
    let mut missed = Vec::new();
    let mut bar = |is_met: bool, sentence: &str| missed.extend((!is_met).then(|| sentence.to_owned()));
    bar(done >= DONE_SHARE_MIN, "99 % of tasks done");
    bar(docked >= DOCKED_SHARE_MIN, "98 % of missions end in the dock");
    bar(position_m <= POSITION_MAX_M, "within 10 cm at every task");
    bar(heading_rad <= HEADING_MAX_RAD, "within 3 degrees at every task");
    missed
}

impl MappedSite {
    /// Maps a site with the whole stack, and makes the topological map from that map.
    fn new(source: &SiteSource, arguments: &Arguments) -> Result<Self> {
        let site = source.load()?;
        let folder = tempfile::tempdir()?;
        let clouds = folder.path().join("clouds");
        std::fs::create_dir_all(&clouds)?;
        let Arguments { columns, people, minutes, .. } = *arguments;
        let plan = WalkPlan { seed: 1, columns, people, keep_ground_truth: true };
        let (mut builder, mut failed) = (PriorMapBuilder::default(), None);
        let mut observer = |_: StepKind, _: f64, effects: &[StackEffect]| {
            builder.insert(effects);
            for effect in effects {
                if let StackEffect::Publish(Publication::Keyframe(keyframe)) = effect {
                    failed = write_cloud(&clouds, keyframe).err().or(failed.take());
                }
            }
        };
        let mut walk = StackWalk::new(&site, "round", &plan, &mut observer)?;
        walk.walk_until(Span::from_secs_f64(60.0 * minutes), &mut observer)?;
        let (finished, truth) = walk.finish(&mut observer)?;
        if let Some(error) = failed {
            return Err(error.into());
        }
        let tiles = TileFiles::new(folder.path().join("tiles"));
        write_map_files(folder.path(), &tiles, &finished, MapFileOptions::default())?;
        let prior_map = builder.build(&finished)?;
        let mut positions = Vec::new();
        for node in &finished.graph.nodes {
            let found = isometry_from_pose(&node.map_from_keyframe).context("a keyframe has no pose")?;
            let place = truth.interpolate(node.stamp).context("no ground truth was kept")?;
            positions.push((place.translation.vector, found.translation.vector));
        }
        let alignment = geometry::umeyama(&positions, false).context("the walk was too short")?;
        let site_from_map = alignment.truth_from_estimate;
        // As the robot records them where it was charged.
        let docks = site.docks().iter().map(|dock| {
            let at = geometry::vec_from_plain(dock.position) + Vector3::z() * sim::STANDING_HEIGHT;
            let heading = Rotation::from_euler_angles(0.0, 0.0, dock.yaw);
            pose_from_isometry(&(site_from_map.inverse() * Isometry::from_parts(at.into(), heading)))
        });
        let docks: Vec<_> = docks.collect();
        let profile = RobotProfile::default();
        let made = TopomapSource::read(folder.path(), &docks, &profile, TopomapConfig::default())?.generate();
        let mut graph = Site::default();
        let edit = made.replacement(&graph, prior_map.map, EditId(Uuid::from_u128(3))).edit;
        graph.apply(&edit, edit.id).map_err(|error| anyhow::anyhow!("{error:?}"))?;
        Ok(Self { site, prior_map: Arc::new(prior_map), site_from_map, graph })
    }

    /// The graph with a mission of pictures at random nodes.
    fn with_mission(&self, seed: u64, tasks: usize) -> Result<Site> {
        let mut graph = self.graph.clone();
        let mut rng = RngTree::new(seed).child("mission").rng();
        let is_place =
            |kind: NodeKind| !matches!(kind, NodeKind::Dock | NodeKind::DockApproach | NodeKind::Portal);
        let mut nodes: Vec<NodeId> =
            graph.nodes().filter(|node| is_place(node.kind)).map(|node| node.id).collect();
        let mut chosen = Vec::new();
        while chosen.len() < tasks && !nodes.is_empty() {
            let index = (rng.uniform() * nodes.len() as f64) as usize;
            chosen.push(nodes.swap_remove(index.min(nodes.len() - 1)));
        }
        // As an operator makes them where something is looked at: with the tolerance of pictures.
        for node in &chosen {
            let node = graph.node(*node).context("a node of the graph")?.clone();
            let tolerance = PoseTolerance::default();
            put(&mut graph, Object::Node(Node { kind: NodeKind::Inspection, tolerance, ..node }))?;
        }
        let photo = ActionRequest { action: "photo".to_owned(), parameters: Parameters::new() };
        let task = |(number, node): (usize, &NodeId)| Task {
            id: TaskId(Uuid::from_u128(100 + number as u128)),
            place: TaskPlace::Node { node: *node, request: Some(photo.clone()) },
            on_unreachable: FailurePolicy::default(),
            on_action_failure: FailurePolicy::default(),
        };
        let mission = Mission {
            id: MISSION,
            name: "Round".to_owned(),
            tasks: chosen.iter().enumerate().map(task).collect(),
            order: TaskOrder::Shortest { keep_first: false, keep_last: false },
            order_constraints: Vec::new(),
            end: MissionEnd::NearestDock,
        };
        put(&mut graph, Object::Mission(mission))?;
        Ok(graph)
    }
}

fn put(graph: &mut Site, object: Object) -> Result<()> {
    let id = EditId(Uuid::from_u128(4));
    let edit = graph.put(id, object);
    graph.apply(&edit, id).map_err(|error| anyhow::anyhow!("{error:?}"))?;
    Ok(())
}

/// Runs a mission from the dock.
fn run(mapped: &MappedSite, seed: u64, arguments: &Arguments) -> Result<Score> {
    let dock = mapped.site.docks().first().context("the site has no dock")?;
    let start =
        Start { position: Vec3::new(dock.position.x, dock.position.y, dock.position.z), yaw: dock.yaw };
    let config = SimConfig {
        lidar_columns: arguments.columns,
        people: arguments.people,
        start: Some(start),
        ..SimConfig::new(Arc::clone(&mapped.site), seed)
    };
    let mut day = Lockstep::new(config, None, false);
    day.keep_map(Arc::clone(&mapped.prior_map));
    let graph = mapped.with_mission(seed, arguments.tasks)?;
    day.give_site(graph.clone());
    command(&mut day, 1, CommandKind::Localise { map: mapped.prior_map.map, at: None });
    let mut state = RunWatch::default();
    state.advance_until(&mut day, 120.0, |state| state.is_localised);
    ensure!(state.is_localised, "not localised at the dock within 120 s");
    state.advance_until(&mut day, 2.0, |_| false);
    let begun = day.now();
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Queue };
    command(&mut day, 2, CommandKind::Mission(start));
    state.advance_until(&mut day, TIME_LIMIT_S, |state| state.outcome().is_some());
    let mut score = state.score(graph.mission(MISSION).map_or(0, |mission| mission.tasks.len()));
    score.docked_error = docked_error(&mut day, &mapped.site);
    score.took_s = (day.now() - begun).secs_f64();
    for call in day.calls() {
        let truth = isometry_from_pose(&call.truth.site_from_base).context("the truth is a pose")?;
        // Which node it is for is known by the nearest one of the mission.
        let nodes = graph.mission(MISSION).into_iter().flat_map(|mission| &mission.tasks);
        let errors = nodes.filter_map(|task| match task.place {
            TaskPlace::Node { node, .. } => {
                let map_from_node = isometry_from_pose(&graph.node(node)?.map_from_node)?;
                let error = (mapped.site_from_map * map_from_node).inverse() * truth;
                let ahead = error.rotation * Vector3::x();
                Some((error.translation.vector.xy().norm(), ahead.y.atan2(ahead.x).abs()))
            }
            TaskPlace::InspectionPoint(_) => None,
        });
        let nearest = errors.min_by(|(a, _), (b, _)| a.total_cmp(b)).context("the mission has nodes")?;
        score.positions_m.push(nearest.0);
        score.headings_rad.push(nearest.1);
    }
    if arguments.verbose {
        println!("{:?}", state.tasks);
        for block in day.site().edge_blocks() {
            let edge = graph.edge(block.edge);
            let ends = edge.and_then(|edge| Some([graph.node(edge.from)?, graph.node(edge.to)?]));
            let ends = ends.map(|ends| ends.map(|node| (node.name.as_str(), node.map_from_node.position)));
            println!("blocked {} times: {ends:?}: {}", block.failures, block.reason);
        }
    }
    Ok(score)
}

fn command(day: &mut Lockstep, number: u128, kind: CommandKind) {
    let by = Principal::operator(ClientId(Uuid::from_u128(9)));
    day.give(Input::Command(Command { id: CommandId(Uuid::from_u128(number)), by, kind }));
}

/// What the stack publishes meanwhile.
#[derive(Default)]
struct RunWatch {
    is_localised: bool,
    is_charging: bool,
    missions: Arc<MissionStatus>,
    /// The last state and failure of each task.
    tasks: BTreeMap<TaskId, (TaskState, Option<TaskFailure>)>,
}

impl RunWatch {
    /// Lets time pass until `is_done`, at most this long.
    fn advance_until(&mut self, day: &mut Lockstep, seconds_max: f64, is_done: impl Fn(&Self) -> bool) {
        let end = day.now() + Span::from_secs_f64(seconds_max);
        while day.now() < end && !is_done(self) {
            let until = (day.now() + Span::from_millis(500)).min(end);
            day.advance(until, &mut |_, effect| match effect {
                StackEffect::Publish(Publication::Localisation(state)) => {
                    self.is_localised =
                        matches!(state, LocalisationState::Localised { degradation: None, .. });
                }
                StackEffect::Publish(Publication::Battery(battery)) => self.is_charging = battery.charging,
                StackEffect::Publish(Publication::Missions(status)) => {
                    for task in status.runs.iter().flat_map(|run| &run.tasks) {
                        self.tasks.insert(task.task, (task.state, task.failure.clone()));
                    }
                    self.missions = Arc::clone(status);
                }
                _ => {}
            });
        }
    }

    fn outcome(&self) -> Option<RunState> {
        self.missions.ended.iter().find(|ended| ended.run == RUN).map(|ended| ended.outcome)
    }

    fn score(&self, tasks: usize) -> Score {
        let outcome = self.outcome();
        // The state of the last task is that of the run's end.
        let done = match outcome {
            Some(RunState::Succeeded) => tasks,
            _ => self.tasks.values().filter(|(state, _)| *state == TaskState::Succeeded).count(),
        };
        let failed = self.tasks.values().filter(|(state, _)| *state == TaskState::Failed);
        Score {
            outcome,
            done,
            tasks,
            failures: failed.filter_map(|(_, failure)| failure.clone()).collect(),
            is_docked: self.is_charging,
            ..Score::default()
        }
    }
}
