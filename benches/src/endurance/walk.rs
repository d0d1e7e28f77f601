//! The walk, and the minutes it is cut into.

use crate::Arguments;
use crate::plot::Minute;
use anyhow::{Context, Result};
use benches::stack_walk::{Plan, StackWalk, StepOf, located, made_keyframe};
use messages::{EdgeKind, Effect, Publication};
use sim::Site;
use std::sync::Arc;
use vocab::Span;

/// Walks the round for so many minutes and hands over each minute when it has passed.
pub fn walk(arguments: &Arguments, mut passed: impl FnMut(Minute)) -> Result<()> {
    let site = Arc::new(Site::new(arguments.site));
    let plan = Plan { seed: arguments.seed, columns: arguments.columns, people: arguments.people };
    let mut measured = Measured::default();
    let mut walk = StackWalk::new(&site, &plan, &mut |of, ms, said| measured.hear(of, ms, said))?;
    for number in 1..=arguments.minutes {
        let end = Span::from_secs_f64(60.0 * f64::from(number));
        walk.walk(end, &mut |of, ms, said| measured.hear(of, ms, said))?;
        passed(measured.minute(number)?);
    }
    Ok(())
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
}

impl Measured {
    /// A sweep is worked on when the IMU has passed its end, so any sensor's step may be the dear one.
    fn hear(&mut self, of: StepOf, ms: f64, said: &[Effect]) {
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
        for effect in said {
            if let Effect::Publish(Publication::Graph(graph)) = effect {
                self.loops = graph.edges.iter().filter(|edge| edge.kind == EdgeKind::Loop).count();
            }
        }
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
