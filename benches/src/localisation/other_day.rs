//! Localisation in a prior map on another day: furniture was moved, doors have other angles, other people walk on the site.

use crate::arguments::Arguments;
use anyhow::{Context, Result};
use benches::mapped_site::MappedSite;
use benches::quantile;
use benches::stack_walk::{StackWalk, StepKind, WalkPlan};
use geometry::{isometry_from_pose, so3};
use messages::{LocalisationState, Publication, StackEffect};
use std::sync::Arc;
use vocab::{Pose, Span, Stamp};

/// Prints the names of the columns. A pose is *claimed* while the robot is localised without any degradation.
pub fn print_header() {
    println!(
        "{:<8}{:>5}{:>9}{:>11}{:>9}{:>10}{:>10}{:>8}{:>9}{:>6}{:>10}{:>8}{:>8}",
        "site",
        "day",
        "path m",
        "claimed %",
        "rmse mm",
        "worst mm",
        "yaw deg",
        "found s",
        "degraded",
        "lost",
        "median ms",
        "p99 ms",
        "max ms"
    );
}

/// Published poses after scans, with the state of localisation at that time.
#[derive(Default)]
struct PublishedPoses {
    state: LocalisationState,
    poses: Vec<PublishedPose>,
    /// Time of the first claimed pose.
    localised_at: Option<Stamp>,
    /// Number of changes from localised to degraded.
    degraded: u32,
    /// Number of times that localisation was lost.
    lost: u32,
    /// CPU time of steps that take a scan, milliseconds.
    scan_ms: Vec<f64>,
}

/// A pose after a scan.
struct PublishedPose {
    stamp: Stamp,
    map_from_base: Pose,
    is_claimed: bool,
}

impl PublishedPoses {
    fn update(&mut self, kind: StepKind, ms: f64, effects: &[StackEffect]) {
        let mut scanned = false;
        for effect in effects {
            match effect {
                StackEffect::Publish(Publication::Localisation(state)) => self.set_state(*state),
                StackEffect::Publish(Publication::Scan(_)) => scanned = true,
                _ => {}
            }
        }
        if kind != StepKind::Sensor || !scanned {
            return;
        }
        self.scan_ms.push(ms);
        for effect in effects {
            if let StackEffect::Publish(Publication::Estimate(estimate)) = effect {
                let is_claimed = matches!(self.state, LocalisationState::Localised { degradation: None, .. });
                if is_claimed && self.localised_at.is_none() {
                    self.localised_at = Some(estimate.stamp);
                }
                let (stamp, map_from_base) = (estimate.stamp, estimate.map_from_base);
                self.poses.push(PublishedPose { stamp, map_from_base, is_claimed });
            }
        }
    }

    fn set_state(&mut self, state: LocalisationState) {
        let was = std::mem::replace(&mut self.state, state);
        match (was, state) {
            (LocalisationState::Localised { .. }, LocalisationState::Relocalising { .. }) => self.lost += 1,
            (
                LocalisationState::Localised { degradation: None, .. },
                LocalisationState::Localised { degradation: Some(_), .. },
            ) => self.degraded += 1,
            _ => {}
        }
    }
}

/// Walks for one day.
pub fn run(mapped: &MappedSite, arguments: &Arguments, day: u64) -> Result<()> {
    let seed = 100 * arguments.seed + day;
    let name = mapped.site.name();
    let site = Arc::new(mapped.site.on_another_day(seed, arguments.changed_share));
    let plan =
        WalkPlan { seed, columns: arguments.columns, people: arguments.day_people, keep_ground_truth: true };
    let mut published = PublishedPoses::default();
    let mut observer = |kind, ms, effects: &[StackEffect]| published.update(kind, ms, effects);
    let mut walk =
        StackWalk::localised(&site, "round", &plan, Arc::clone(&mapped.prior_map), None, &mut observer)?;
    walk.walk_until(Span::from_secs_f64(arguments.day_minutes * 60.0), &mut observer)?;
    let truth = walk.ground_truth();
    let (mut squares, mut turns, mut worst, mut count) = (0.0, 0.0, 0.0_f64, 0_usize);
    for pose in published.poses.iter().filter(|pose| pose.is_claimed) {
        let map_from_base = isometry_from_pose(&pose.map_from_base).context("the stack published no pose")?;
        let site_from_base = truth.interpolate(pose.stamp).context("no ground truth was kept")?;
        let off = site_from_base.inverse() * mapped.site_from_map * map_from_base;
        let (metres, radians) = (off.translation.vector.norm(), so3::log(&off.rotation).z);
        (squares, turns, worst, count) =
            (squares + metres * metres, turns + radians * radians, worst.max(metres), count + 1);
    }
    let path: f64 = truth
        .sample(0.5)
        .windows(2)
        .map(|w| (w[0].1.translation.vector - w[1].1.translation.vector).norm())
        .sum();
    let begun = published.poses.first().map(|pose| pose.stamp);
    let found =
        begun.zip(published.localised_at).map_or(f64::NAN, |(begun, found)| (found - begun).secs_f64());
    published.scan_ms.sort_by(f64::total_cmp);
    let mean = |sum: f64| (sum / count.max(1) as f64).sqrt();
    println!(
        "{:<8}{:>5}{:>9.0}{:>11.2}{:>9.1}{:>10.1}{:>10.3}{:>8.1}{:>9}{:>6}{:>10.2}{:>8.2}{:>8.1}",
        name,
        day,
        path,
        100.0 * count as f64 / published.poses.len().max(1) as f64,
        1e3 * mean(squares),
        1e3 * worst,
        mean(turns).to_degrees(),
        found,
        published.degraded,
        published.lost,
        quantile(&published.scan_ms, 0.5),
        quantile(&published.scan_ms, 0.99),
        quantile(&published.scan_ms, 1.0)
    );
    Ok(())
}
