//! Visits of missions: a robot with its whole stack in lockstep does one mission again and again, and where it stood at each picture, and believed to stand, is taken over.

use crate::visits::GaugePoint;
use anyhow::{Context, Result, ensure};
use benches::mission_runs::{MISSION, MissionDay, MissionSite, Plate};
use geometry::{Isometry, Vector3, isometry_from_pose};
use messages::CommandKind;
use sim::{CameraConfig, CameraScene, Face, SimConfig, Start};
use site_model::{MissionCommandKind, RunId, StartMode};
use std::sync::Arc;
use uuid::Uuid;

/// Longest time for a mission, robot time, seconds.
const TIME_LIMIT_S: f64 = 2_400.0;

/// The gauges that a node of the topological map sees, `points` at most, with the poses of `visits` missions after the first one. `columns`: of the LiDAR.
///
/// # Errors
/// When the robot is not localised on its dock, or a mission does not end with all pictures.
pub fn gauge_points(
    mapped: &MissionSite,
    scene: &CameraScene,
    (points, visits): (usize, u64),
    shown_width_m: f64,
    (columns, people): (u32, u32),
) -> Result<Vec<GaugePoint>> {
    let gauges: Vec<_> =
        scene.fixtures().iter().filter(|fixture| matches!(fixture.face, Face::Gauge { .. })).collect();
    let plates: Vec<Plate> = gauges
        .iter()
        .map(|fixture| Plate {
            site_m: fixture.site_from_plate.translation.vector,
            outward: fixture.site_from_plate.rotation * Vector3::z(),
        })
        .collect();
    let (_, seen) = mapped.with_plates(&plates, shown_width_m)?;
    let chosen: Vec<usize> = seen.into_iter().take(points).collect();
    let chosen_plates: Vec<Plate> = chosen.iter().map(|index| plates[*index]).collect();
    let (planned, _) = mapped.with_plates(&chosen_plates, shown_width_m)?;
    let cameras = CameraConfig::default();
    let mut found: Vec<GaugePoint> = chosen
        .iter()
        .zip(&planned.targets)
        .map(|(index, target)| {
            let head = target.site_from_node * nalgebra::Point3::from(cameras.base_from_head_m);
            let distance_m = (head.coords - target.site_m).norm();
            let view_m = 2.0 * distance_m * (0.5 * cameras.field_of_view_rad).tan();
            GaugePoint {
                fixture: gauges[*index].clone(),
                site_from_node: target.site_from_node,
                zoom: (view_m / shown_width_m).clamp(1.0, cameras.zoom_max),
                distance_m,
                poses: Vec::new(),
            }
        })
        .collect();
    let dock = mapped.site.docks().first().context("the site has no dock")?;
    let config = SimConfig {
        lidar_columns: columns,
        people,
        start: Some(Start { position: dock.position, yaw: dock.yaw }),
        ..SimConfig::new(Arc::clone(&mapped.site), 1)
    };
    let mut day = MissionDay::begin(config, mapped, planned.graph)?;
    for visit in 0..=visits {
        let run = RunId(Uuid::from_u128(1_000 + u128::from(visit)));
        let start = MissionCommandKind::Start { run, mission: MISSION, mode: StartMode::Queue };
        day.command(CommandKind::Mission(start));
        day.advance_until(TIME_LIMIT_S, |day| day.outcome(run).is_some());
    }
    for (call, estimate) in day.lockstep.calls().iter().zip(&day.places_of_calls) {
        let truth = isometry_from_pose(&call.truth.site_from_base).context("the truth is a pose")?;
        let estimate = estimate.as_ref().and_then(isometry_from_pose).context("the robot knows its pose")?;
        let parameters: serde_json::Value = serde_json::from_str(&call.parameters)?;
        let asked: [f64; 3] = serde_json::from_value(parameters["target_m"].clone())?;
        let target =
            planned.targets.iter().position(|target| (target.map_m - Vector3::from(asked)).norm() < 1e-3);
        let of: &mut Vec<[Isometry; 2]> = &mut found[target.context("a target of the mission")?].poses;
        of.push([truth, mapped.site_from_map * estimate]);
    }
    let least = found.iter().map(|point| point.poses.len()).min().unwrap_or(0) as u64;
    ensure!(
        least > visits,
        "only {least} of {} missions have taken all pictures: {:?}",
        visits + 1,
        day.notices
    );
    Ok(found)
}
