//! How long missions are expected to run.

use crate::features::missions::{MissionPlanConfig, PlanConditions, PlanOrder, plan_mission};
use site_model::{MissionId, Site};
use std::collections::BTreeMap;
use vocab::{Span, Stamp};

/// How long each mission is expected to run, from the dock at which missions begin. A mission without tasks, or of which no place exists, has none.
pub fn expected_durations(site: &Site) -> BTreeMap<MissionId, Span> {
    // By the time of a schedule, the edges that are blocked now are tried again.
    let conditions = PlanConditions { now: Some(Stamp::from_nanos(i64::MAX)), ..PlanConditions::default() };
    let planned = site.missions().map(|mission| {
        plan_mission(site, mission.clone(), PlanOrder::Dragged, &conditions, &MissionPlanConfig::default())
    });
    let walkable = planned.filter(|plan| plan.start.is_some() && !plan.stops.is_empty());
    walkable.map(|plan| (plan.mission.id, Span::from_secs_f64(plan.time_s))).collect()
}
