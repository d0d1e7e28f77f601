//! The walk, and the minutes it is cut into.

use crate::Arguments;
use crate::plot::Minute;
use anyhow::{Context, Result};
use benches::stack_walk::{Plan, StackWalk, StepOf, located, made_keyframe, ties};
use geometry::{Isometry, Vector3, isometry_from_pose, so3};
use messages::{EdgeKind, Publication, StackEffect};
use sim::Site;
use std::sync::Arc;
use vocab::Span;

/// Walks the round for so many minutes and hands over each minute when it has passed.
pub fn walk(arguments: &Arguments, mut passed: impl FnMut(Minute)) -> Result<()> {
    let site = Arc::new(Site::new(arguments.site));
    let (seed, columns, people) = (arguments.seed, arguments.columns, arguments.people);
    let plan = Plan { seed, columns, people, keep_truth: false };
    let mut measured = Measured::default();
    let mut walk =
        StackWalk::new(&site, &arguments.route, &plan, &mut |of, ms, said| measured.hear(of, ms, said))?;
    let site_from_map = level(&walk.site_from_base()?);
    for number in 1..=arguments.minutes {
        let end = Span::from_secs_f64(60.0 * f64::from(number));
        walk.walk(end, &mut |of, ms, said| measured.hear(of, ms, said))?;
        let off_mm = measured.off_mm(&site_from_map, &walk.site_from_base()?);
        passed(Minute { rounds: walk.rounds(), off_mm, ..measured.minute(number)? });
    }
    Ok(())
}

/// The map's frame where it begins: heading and place of the base, z up.
fn level(site_from_base: &Isometry) -> Isometry {
    let forward = site_from_base.rotation * Vector3::x();
    let heading = so3::exp(&(Vector3::z() * forward.y.atan2(forward.x)));
    Isometry::from_parts(site_from_base.translation, heading)
}

/// What steps cost.
#[derive(Default)]
struct Measured {
    scan_ms: Vec<f64>,
    /// Of steps that made a keyframe, and of those that took a loop in.
    keyframe_ms: Vec<f64>,
    loop_ms: Vec<f64>,
    keyframes: u64,
    loops: usize,
    ties: usize,
    map_from_base: Option<Isometry>,
}

impl Measured {
    /// A sweep is worked on when the IMU has passed its end, so any sensor's step may be the dear one.
    fn hear(&mut self, of: StepOf, ms: f64, said: &[StackEffect]) {
        if of == StepOf::Sensor && located(said) {
            self.scan_ms.push(ms);
        }
        if of == StepOf::Sensor && made_keyframe(said) {
            self.keyframes += 1;
            self.keyframe_ms.push(ms);
        }
        if of == StepOf::Verified {
            self.loop_ms.push(ms);
        }
        self.ties += ties(said).count();
        for effect in said {
            match effect {
                StackEffect::Publish(Publication::Graph(graph)) => {
                    self.loops = graph.edges.iter().filter(|edge| edge.kind == EdgeKind::Loop).count();
                }
                StackEffect::Publish(Publication::Estimate(estimate)) => {
                    self.map_from_base = isometry_from_pose(&estimate.map_from_base);
                }
                _ => {}
            }
        }
    }

    /// How far the last estimate, which every tick gives, is from the truth, millimetres.
    fn off_mm(&self, site_from_map: &Isometry, site_from_base: &Isometry) -> f64 {
        self.map_from_base.map_or(f64::NAN, |map_from_base| {
            let found = site_from_map * map_from_base;
            (found.translation.vector - site_from_base.translation.vector).norm() * 1e3
        })
    }

    fn minute(&mut self, number: u32) -> Result<Minute> {
        let mut times = std::mem::take(&mut self.scan_ms);
        times.sort_by(f64::total_cmp);
        let last = times.len().checked_sub(1).context("no scan was used for a whole minute")?;
        let median = |mut times: Vec<f64>| {
            times.sort_by(f64::total_cmp);
            (
                times.get(times.len() / 2).copied().unwrap_or_default(),
                times.last().copied().unwrap_or_default(),
            )
        };
        Ok(Minute {
            number,
            rounds: 0,
            off_mm: f64::NAN,
            ties: std::mem::take(&mut self.ties),
            scans: times.len(),
            mean_ms: times.iter().sum::<f64>() / times.len() as f64,
            p99_ms: times[(times.len() * 99 / 100).min(last)],
            resident_mb: resident_mb()?,
            keyframes: self.keyframes,
            keyframe_ms: median(std::mem::take(&mut self.keyframe_ms)),
            loop_ms: median(std::mem::take(&mut self.loop_ms)),
            loops: self.loops,
        })
    }
}

/// Resident memory of this process, megabytes.
fn resident_mb() -> Result<f64> {
    let statm =
        std::fs::read_to_string("/proc/self/statm").context("memory is read from /proc/self/statm")?;
    let pages: f64 = statm.split(' ').nth(1).and_then(|pages| pages.parse().ok()).context("statm is odd")?;
    Ok(pages * rustix::param::page_size() as f64 * 1e-6)
}
