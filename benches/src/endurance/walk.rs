//! The walks of the two phases, divided into minutes.

use crate::arguments::Arguments;
use crate::measure::{Measurement, Minute};
use crate::step_times::StepTimes;
use anyhow::Result;
use benches::prior_map::PriorMapBuilder;
use benches::stack_walk::{StackWalk, StepKind, WalkPlan};
use geometry::{Isometry, Vector3, so3};
use messages::{PriorMap, StackEffect};
use sim::SimulatedSite;
use std::sync::Arc;
use vocab::Span;

/// A finished walk.
pub struct Walked {
    pub minutes: Vec<Minute>,
    /// CPU times of the steps.
    pub step_times: StepTimes,
}

/// A finished mapping walk.
pub struct Mapped {
    pub minutes: Vec<Minute>,
    /// CPU times of the steps.
    pub step_times: StepTimes,
    /// The map with its pose in the site, if it is kept.
    pub prior_map: Option<PlacedMap>,
}

/// A map and the pose of its frame in the site.
pub struct PlacedMap {
    pub prior_map: Arc<PriorMap>,
    pub site_from_map: Isometry,
}

/// Walks and maps. `print` is called at the end of every minute.
///
/// # Errors
/// When the site has no such route, or a minute passes without an estimate.
pub fn map(arguments: &Arguments, keep_map: bool, print: impl Fn(&Minute)) -> Result<Mapped> {
    let site = Arc::new(SimulatedSite::new(arguments.site));
    let (mut measurement, mut builder) = (Measurement::default(), PriorMapBuilder::default());
    let mut observer = |kind: StepKind, ms: f64, effects: &[StackEffect]| {
        measurement.update(kind, ms, effects);
        if keep_map {
            builder.insert(effects);
        }
    };
    let mut walk = StackWalk::new(&site, &arguments.route, &plan(arguments, arguments.seed), &mut observer)?;
    let site_from_map = level(&walk.site_from_base()?);
    let mut minutes = Vec::new();
    for number in 1..=arguments.minutes {
        let mut observer = |kind: StepKind, ms: f64, effects: &[StackEffect]| {
            measurement.update(kind, ms, effects);
            if keep_map {
                builder.insert(effects);
            }
        };
        walk.walk_until(end_of(number), &mut observer)?;
        let error_mm = measurement.position_error_mm(&site_from_map, &walk.site_from_base()?);
        let minute = measurement.end_minute(number, walk.rounds(), error_mm)?;
        print(&minute);
        minutes.push(minute);
    }
    let prior_map = if keep_map {
        let (finished, _) = walk.finish(&mut |_, _, effects| builder.insert(effects))?;
        Some(PlacedMap { prior_map: Arc::new(builder.build(&finished)?), site_from_map })
    } else {
        None
    };
    Ok(Mapped { minutes, step_times: measurement.into_step_times(), prior_map })
}

/// Walks the same route localised in a map, with another seed. `print` is called at the end of every minute.
///
/// # Errors
/// The errors of [`map`].
pub fn localise(arguments: &Arguments, map: PlacedMap, print: impl Fn(&Minute)) -> Result<Walked> {
    let site = Arc::new(SimulatedSite::new(arguments.site));
    let plan = plan(arguments, arguments.seed + 1);
    let mut measurement = Measurement::default();
    let mut walk = StackWalk::localised(
        &site,
        &arguments.route,
        &plan,
        map.prior_map,
        None,
        &mut |kind, ms, effects| {
            measurement.update(kind, ms, effects);
        },
    )?;
    let mut minutes = Vec::new();
    for number in 1..=arguments.minutes {
        walk.walk_until(end_of(number), &mut |kind, ms, effects| measurement.update(kind, ms, effects))?;
        let error_mm = measurement.position_error_mm(&map.site_from_map, &walk.site_from_base()?);
        let minute = measurement.end_minute(number, walk.rounds(), error_mm)?;
        print(&minute);
        minutes.push(minute);
    }
    Ok(Walked { minutes, step_times: measurement.into_step_times() })
}

fn plan(arguments: &Arguments, seed: u64) -> WalkPlan {
    let Arguments { columns, people, .. } = *arguments;
    WalkPlan { seed, columns, people, keep_ground_truth: false }
}

fn end_of(minute: u32) -> Span {
    Span::from_secs_f64(60.0 * f64::from(minute))
}

/// The frame of the map at the beginning of the walk: position and heading of the base, z up.
fn level(site_from_base: &Isometry) -> Isometry {
    let forward = site_from_base.rotation * Vector3::x();
    let heading = so3::exp(&(Vector3::z() * forward.y.atan2(forward.x)));
    Isometry::from_parts(site_from_base.translation, heading)
}
