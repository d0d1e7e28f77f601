//! Visits to the gauges of simulated sites: the alignment of their pictures, the changes that are found in them, and the readings, scored by the truth.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod days;
mod missions;
mod scores;
mod truth;
mod vary;
mod visits;

use anyhow::{Context, Error, Result, bail, ensure};
use benches::mapped_folder::MapPlan;
use benches::mission_runs::MissionSite;
use benches::thread_ms;
use clap::Parser;
use days::DayScores;
use gauges::{Dial, DialMarks, GaugeConfig, GaugeReading, read_gauge, read_slanted_gauge};
use picture_changes::{
    ChangedRegion, Homography, PictureAlignment, PictureChangesConfig, align_pictures, find_picture_changes,
    mapped_dial, mapped_marks,
};
use scores::Scores;
use sim::{CameraScene, SimulatedSite};
use site_files::SiteSource;
use std::path::PathBuf;
use std::sync::Arc;
use vary::Parameters;
use visits::{GaugePoint, Visit};

/// Pictures of gauges, visit after visit, in changing light.
///
/// Examples: cargo xtask bench picture_changes
///           cargo xtask bench picture_changes --sites b1 --visits 10 --shown-width-m 0.8
///           cargo xtask bench picture_changes --sites b1 --visits 12 --missions
///           cargo xtask bench picture_changes --days 14
#[derive(Parser)]
struct Arguments {
    /// Sites, separated by commas: names, generated:SEED, or buildings as FILE.glb.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant,twins")]
    sites: Vec<String>,
    /// Visits to each inspection point after the first one.
    #[arg(long, default_value_t = 60)]
    visits: u64,
    /// Days before and days after a gauge begins to drift or is stuck, with three visits a day; the histories of readings are scored, and not the pictures.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=366))]
    days: Option<u32>,
    /// Most inspection points of a site.
    #[arg(long, default_value_t = 4)]
    points: usize,
    /// Width of what a picture shows at the gauge, metres. A gauge is 0.1 m wide: at 0.4 m it has 160 of 640 pixels.
    #[arg(long, default_value_t = 0.4)]
    shown_width_m: f64,
    /// Angle from the direction that the gauge faces at which the robot stands, degrees; without it up to 11 degrees.
    #[arg(long)]
    aside_deg: Option<f64>,
    /// Take the poses from missions: the whole stack maps each site, and visits the gauges again and again.
    #[arg(long)]
    missions: bool,
    /// Length of the walk that makes the map of a site for missions, minutes.
    #[arg(long, default_value_t = 6.0)]
    minutes: f64,
    /// LiDAR columns per sweep of missions.
    #[arg(long, default_value_t = 500)]
    columns: u32,
    /// People who walk on the site during missions.
    #[arg(long, default_value_t = 0)]
    people: u32,
    /// Folder in which maps of sites are kept for the next time.
    #[arg(long, default_value = "target/bench-topomap")]
    work: PathBuf,
    /// Read dials as circles, without the mark in the middle of their scale.
    #[arg(long)]
    as_circle: bool,
    /// Fail if a bar is missed.
    #[arg(long)]
    bar: bool,
    /// Another value of a parameter, as NAME=VALUE; may be given again.
    #[arg(long, value_name = "NAME=VALUE")]
    vary: Vec<String>,
    /// Print the regions of false alarms and the reasons of pictures that are not aligned.
    #[arg(long)]
    verbose: bool,
}

/// What a gauge shows, as a share of its range, and how much a planted change is.
const READING_SHARE: f64 = 0.4;
const PLANTED_SHARE: f64 = 0.05;
/// Gauges of fewer pixels across need not be read.
const MIN_DIAL_PX: f64 = 150.0;
/// Radius of the scale of a gauge, and the height of its middle over that of its plate, metres.
const SCALE_RADIUS_M: f64 = 0.047;
const GAUGE_RADIUS_M: f64 = 0.05;
const GAUGE_UP_M: f64 = 0.035;
/// The scale of a gauge covers this angle, symmetric about the top, radians.
const SCALE_RAD: f64 = 1.5 * std::f64::consts::PI;

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if let Some(days) = arguments.days {
        return print_days(&arguments, days);
    }
    println!("{}", Scores::HEADER);
    let mut all = Scores::default();
    for name in &arguments.sites {
        let source: SiteSource = name.parse().map_err(Error::msg)?;
        let scores = site_scores(&source, &arguments).with_context(|| name.clone())?;
        println!("{}", scores.row(name));
        all.add(&scores);
    }
    println!("{}", all.row("all"));
    let missed = all.missed();
    missed.iter().for_each(|bar| println!("BAR MISSED: {bar}"));
    ensure!(missed.is_empty() || !arguments.bar, "{} bars are missed", missed.len());
    Ok(())
}

fn print_days(arguments: &Arguments, days: u32) -> Result<()> {
    let mut all = DayScores::default();
    for name in &arguments.sites {
        let source: SiteSource = name.parse().map_err(Error::msg)?;
        for_points(&source, arguments, |run| {
            all.add(&days::score(run, days)?);
            Ok(())
        })
        .with_context(|| name.clone())?;
    }
    println!("{}", all.table());
    Ok(())
}

fn site_scores(source: &SiteSource, arguments: &Arguments) -> Result<Scores> {
    let mut scores = Scores::default();
    for_points(source, arguments, |run| {
        scores.points += 1;
        run.score(arguments.visits, &mut scores)
    })?;
    Ok(scores)
}

/// Does something at each inspection point of a site.
fn for_points(
    source: &SiteSource,
    arguments: &Arguments,
    mut score: impl FnMut(&PointRun<'_>) -> Result<()>,
) -> Result<()> {
    let site = &source.load()?;
    let scene = CameraScene::new(Arc::clone(site));
    let parameters = Parameters::varied(&arguments.vary)?;
    let aside_rad = arguments.aside_deg.map(f64::to_radians);
    let Arguments { minutes, columns, people, points, visits, shown_width_m, .. } = *arguments;
    let points = if arguments.missions {
        let plan = MapPlan { seed: 1, minutes, columns, people };
        let mapped = MissionSite::new(source, &arguments.work, &plan)?;
        missions::gauge_points(&mapped, &scene, (points, visits), shown_width_m, (columns, people))?
    } else {
        visits::gauge_points(site, &scene, shown_width_m, aside_rad)
    };
    for point in points.into_iter().take(arguments.points) {
        let run = PointRun {
            site,
            scene: &scene,
            point: &point,
            parameters,
            as_circle: arguments.as_circle,
            verbose: arguments.verbose,
        };
        score(&run)?;
    }
    Ok(())
}

/// All visits to an inspection point.
struct PointRun<'a> {
    site: &'a SimulatedSite,
    scene: &'a CameraScene,
    point: &'a GaugePoint,
    parameters: Parameters,
    as_circle: bool,
    verbose: bool,
}

/// A gauge as a person marks it in a picture.
struct DescribedGauge {
    /// As a circle.
    dial: Dial,
    /// With the middle of its scale.
    marks: DialMarks,
}

impl PointRun<'_> {
    fn score(&self, visits: u64, scores: &mut Scores) -> Result<()> {
        let [min, max] = truth::range(self.point);
        let value = min + READING_SHARE * (max - min);
        let first = visits::visit(self.scene, self.point, 0, value)?;
        let gauge = self.described_gauge(&first)?;
        let mut before = first.clone();
        for number in 1..=visits {
            let after = visits::visit(self.scene, self.point, number, value)?;
            self.score_unchanged(&before, &after, scores);
            let sign = if number % 2 == 0 { 1.0 } else { -1.0 };
            let planted_value = value + sign * PLANTED_SHARE * (max - min);
            let planted = visits::visit(self.scene, self.point, number, planted_value)?;
            scores.planted += 1;
            let found = self.align(&before, &planted).map(|found| self.changes(&before, &planted, &found));
            let is_flagged = found.is_some_and(|found| self.is_any_on_plate(&found, &before));
            scores.flagged += usize::from(is_flagged);
            if self.verbose && !is_flagged {
                self.explain_miss(number, &before, &planted);
            }
            self.score_reading(&first, &gauge, &after, scores);
            before = after;
        }
        Ok(())
    }

    fn score_unchanged(&self, before: &Visit, after: &Visit, scores: &mut Scores) {
        scores.pairs += 1;
        let begun = thread_ms();
        let Some(found) = self.align(before, after) else { return };
        scores.align_ms.push(thread_ms() - begun);
        let error = truth::mapping_error(self.site, self.point, [before, after], &found.after_from_before);
        scores.plate_px.push(error.plate_px);
        scores.middle_px.push(error.middle_px);
        scores.within_stated += usize::from(error.plate_px <= found.residual_px);
        let begun = thread_ms();
        let changes = self.changes(before, after, &found);
        scores.changes_ms.push(thread_ms() - begun);
        scores.false_anywhere += usize::from(!changes.is_empty());
        scores.false_on_plate += usize::from(self.is_any_on_plate(&changes, before));
        if self.verbose && !changes.is_empty() {
            println!("false alarm at {}: {changes:?}", self.point.fixture.tag);
        }
    }

    /// Prints what of a planted change is found with half the limits.
    fn explain_miss(&self, number: u64, before: &Visit, planted: &Visit) {
        let Some(found) = self.align(before, planted) else { return };
        let config = PictureChangesConfig {
            min_area_px: self.parameters.changes.min_area_px / 2,
            min_total_strength: 0.5 * self.parameters.changes.min_total_strength,
            ..self.parameters.changes
        };
        let weak = find_picture_changes(&before.picture, &planted.picture, &found, &config);
        println!(
            "missed at {}, visit {number}, residual {:.2} px; with half the limits: {weak:?}",
            self.point.fixture.tag, found.residual_px
        );
    }

    /// The mapping from the first picture to a later one, without the poses of the camera, as on the robot.
    fn mapping(&self, first: &Visit, after: &Visit) -> Option<Homography> {
        let found = align_pictures(&first.picture, &after.picture, None, &self.parameters.alignment);
        found.ok().map(|found| found.after_from_before)
    }

    /// What is read of a gauge in a picture to which that of its description is mapped so. None where nothing can be read.
    fn read(&self, gauge: &DescribedGauge, mapping: &Homography, after: &Visit) -> Option<GaugeReading> {
        let config = GaugeConfig::default();
        if self.as_circle {
            read_gauge(&after.picture, &mapped_dial(&gauge.dial, mapping)?, &config).ok()
        } else {
            read_slanted_gauge(&after.picture, &mapped_marks(&gauge.marks, mapping)?, &config).ok()
        }
    }

    /// Reads the gauge as it was described in the picture of the first visit.
    fn score_reading(&self, first: &Visit, gauge: &DescribedGauge, after: &Visit, scores: &mut Scores) {
        let [min, max] = truth::range(self.point);
        let mapping = self.mapping(first, after);
        let mapped = mapping.as_ref().and_then(|mapping| mapped_dial(&gauge.dial, mapping));
        if mapped.is_some_and(|dial| 2.0 * dial.radius_px * GAUGE_RADIUS_M / SCALE_RADIUS_M < MIN_DIAL_PX) {
            scores.too_small += 1;
            return;
        }
        let reading = mapping.and_then(|mapping| self.read(gauge, &mapping, after));
        let error = match reading {
            Some(GaugeReading::Read { value, .. }) => Some((value - after.value).abs() / (max - min)),
            _ => None,
        };
        if self.verbose && error.is_none_or(|error| error > 0.015) {
            println!("reading at {}: {reading:?} of {}", self.point.fixture.tag, after.value);
        }
        scores.readings.push(error);
    }

    fn align(&self, before: &Visit, after: &Visit) -> Option<PictureAlignment> {
        let predicted = Homography::predicted(&before.estimated, &after.estimated, self.point.distance_m);
        let config = &self.parameters.alignment;
        let found = align_pictures(&before.picture, &after.picture, predicted.as_ref(), config);
        if let (true, Err(error)) = (self.verbose, &found) {
            println!("not aligned at {}: {error}", self.point.fixture.tag);
        }
        found.ok()
    }

    fn changes(&self, before: &Visit, after: &Visit, found: &PictureAlignment) -> Vec<ChangedRegion> {
        find_picture_changes(&before.picture, &after.picture, found, &self.parameters.changes)
    }

    /// Whether a region is on the plate of the gauge, by the truth.
    fn is_any_on_plate(&self, regions: &[ChangedRegion], visit: &Visit) -> bool {
        let half_m = self.point.fixture.face.half_m();
        let corners = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]
            .map(|[x, y]| self.on_picture(visit, [x * half_m[0], y * half_m[1]]));
        let edge = |axis: usize, pick: fn(f64, f64) -> f64| {
            corners.iter().flatten().map(|px| px[axis]).reduce(pick).unwrap_or_default()
        };
        regions.iter().any(|region| {
            (0..2).all(|axis| {
                region.max_px[axis] as f64 >= edge(axis, f64::min)
                    && region.min_px[axis] as f64 <= edge(axis, f64::max)
            })
        })
    }

    /// The gauge as a person marks it in a picture: the centre, the ends and the middle of its scale.
    fn described_gauge(&self, visit: &Visit) -> Result<DescribedGauge> {
        let end = |turn_rad: f64| {
            let (sin, cos) = turn_rad.sin_cos();
            self.on_picture(visit, [SCALE_RADIUS_M * sin, GAUGE_UP_M + SCALE_RADIUS_M * cos])
        };
        let centre_px = self.on_picture(visit, [0.0, GAUGE_UP_M]).context("the gauge is in the picture")?;
        let marks = [end(-0.5 * SCALE_RAD), end(0.5 * SCALE_RAD), end(0.0)];
        let [Some(start), Some(finish), Some(top)] = marks else { bail!("the scale is outside the picture") };
        let start_rad = Dial::direction_rad(centre_px, start);
        let sweep_rad =
            (Dial::direction_rad(centre_px, finish) - start_rad).rem_euclid(std::f64::consts::TAU);
        let distance = |[x, y]: [f64; 2]| (x - centre_px[0]).hypot(y - centre_px[1]);
        let radius_px = 0.5 * (distance(start) + distance(top));
        let range = truth::range(self.point);
        let dial = Dial { centre_px, axis_px: centre_px, radius_px, start_rad, sweep_rad, range };
        let marks = DialMarks { centre_px, start_px: start, middle_px: top, end_px: finish, range };
        Ok(DescribedGauge { dial, marks })
    }

    /// Where a point of the plate is in the picture of a visit.
    fn on_picture(&self, visit: &Visit, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let point = self.point.fixture.site_from_plate * nalgebra::Point3::new(x, y, 0.0);
        truth::project(&visit.truth, &point.coords)
    }
}
