//! A robot that walks its rounds by a known map on another day: furniture stands elsewhere, doors are open or shut, people walk about.

use crate::Arguments;
use crate::known::KnownSite;
use anyhow::{Context, Result};
use benches::stack_walk::{Plan, StackWalk, StepOf};
use geometry::{isometry_from_pose, so3};
use messages::{LocalisationState, Publication, StackEffect};
use sim::Site;
use std::sync::Arc;
use vocab::{Pose, Span, Stamp};

/// Names of the columns. A pose is *told* while the robot says that it knows its place without any doubt.
pub fn print_header() {
    println!(
        "{:<8}{:>5}{:>9}{:>8}{:>9}{:>10}{:>10}{:>8}{:>9}{:>6}{:>10}{:>8}{:>8}",
        "site",
        "day",
        "path m",
        "told %",
        "rmse mm",
        "worst mm",
        "yaw deg",
        "found s",
        "unsure",
        "lost",
        "median ms",
        "p99 ms",
        "max ms"
    );
}

/// Poses that were told after scans, with what the robot said of its place then.
#[derive(Default)]
struct Told {
    state: LocalisationState,
    poses: Vec<(Stamp, Pose, bool)>,
    found: Option<Stamp>,
    unsure: u32,
    lost: u32,
    scan_ms: Vec<f64>,
}

impl Told {
    fn hear(&mut self, of: StepOf, ms: f64, effects: &[StackEffect]) {
        let mut scanned = false;
        for effect in effects {
            match effect {
                StackEffect::Publish(Publication::Localisation(state)) => self.change(*state),
                StackEffect::Publish(Publication::Scan(_)) => scanned = true,
                _ => {}
            }
        }
        if of != StepOf::Sensor || !scanned {
            return;
        }
        self.scan_ms.push(ms);
        for effect in effects {
            if let StackEffect::Publish(Publication::Estimate(estimate)) = effect {
                let sure = matches!(self.state, LocalisationState::Localised { degradation: None, .. });
                if sure && self.found.is_none() {
                    self.found = Some(estimate.stamp);
                }
                self.poses.push((estimate.stamp, estimate.map_from_base, sure));
            }
        }
    }

    fn change(&mut self, state: LocalisationState) {
        let was = std::mem::replace(&mut self.state, state);
        match (was, state) {
            (LocalisationState::Localised { .. }, LocalisationState::Relocalising { .. }) => self.lost += 1,
            (
                LocalisationState::Localised { degradation: None, .. },
                LocalisationState::Localised { degradation: Some(_), .. },
            ) => self.unsure += 1,
            _ => {}
        }
    }
}

/// Walks one day.
pub fn run(known: &KnownSite, arguments: &Arguments, day: u64) -> Result<()> {
    let seed = 100 * arguments.seed + day;
    let name = known.site.name();
    let site = Arc::new(Site::with_changes(name, seed, arguments.moved));
    let plan = Plan { seed, columns: arguments.columns, people: arguments.day_people, keep_truth: true };
    let mut told = Told::default();
    let mut hear = |of, ms, effects: &[StackEffect]| told.hear(of, ms, effects);
    let mut walk = StackWalk::localised(&site, "round", &plan, Arc::clone(&known.known), None, &mut hear)?;
    walk.walk(Span::from_secs_f64(arguments.day_minutes * 60.0), &mut hear)?;
    let truth = walk.truth();
    let (mut squares, mut turns, mut worst, mut count) = (0.0, 0.0, 0.0_f64, 0_usize);
    for (stamp, pose, _) in told.poses.iter().filter(|(_, _, sure)| *sure) {
        let pose = isometry_from_pose(pose).context("the stack told no pose")?;
        let site_from_base = truth.at(*stamp).context("no truth was kept")?;
        let off = site_from_base.inverse() * known.site_from_map * pose;
        let (metres, radians) = (off.translation.vector.norm(), so3::log(&off.rotation).z);
        (squares, turns, worst, count) =
            (squares + metres * metres, turns + radians * radians, worst.max(metres), count + 1);
    }
    let path: f64 = truth
        .every(0.5)
        .windows(2)
        .map(|w| (w[0].1.translation.vector - w[1].1.translation.vector).norm())
        .sum();
    let begun = told.poses.first().map(|(stamp, ..)| *stamp);
    let found = begun.zip(told.found).map_or(f64::NAN, |(begun, found)| (found - begun).secs_f64());
    told.scan_ms.sort_by(f64::total_cmp);
    let at = |share: f64| {
        told.scan_ms
            .get((share * (told.scan_ms.len().max(1) - 1) as f64) as usize)
            .copied()
            .unwrap_or(f64::NAN)
    };
    let mean = |sum: f64| (sum / count.max(1) as f64).sqrt();
    println!(
        "{:<8}{:>5}{:>9.0}{:>8.2}{:>9.1}{:>10.1}{:>10.3}{:>8.1}{:>9}{:>6}{:>10.2}{:>8.2}{:>8.1}",
        name,
        day,
        path,
        100.0 * count as f64 / told.poses.len().max(1) as f64,
        1e3 * mean(squares),
        1e3 * worst,
        mean(turns).to_degrees(),
        found,
        told.unsure,
        told.lost,
        at(0.5),
        at(0.99),
        at(1.0)
    );
    Ok(())
}
