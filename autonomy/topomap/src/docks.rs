//! Docks: a node on each, one in front of it, and the path between them.

use crate::TopomapInput;
use crate::corridor::Passage;
use crate::path::Sample;
use crate::path_graph::{LinkKind, PathGraph, PlaceKind};
use geometry::{Isometry, Vector3};

/// Adds the docks, before any path, so that paths that come to a dock end at it.
pub(crate) fn add_docks(graph: &mut PathGraph, input: &TopomapInput<'_>, passage: &Passage<'_>) {
    for (number, map_from_base) in input.docks.iter().enumerate() {
        let feet = map_from_base.translation.vector - Vector3::z() * input.robot.standing_height_m;
        let yaw = map_from_base.rotation.euler_angles().2;
        let dock = graph.add(Sample { feet, yaw }, PlaceKind::Dock(number));
        let Some(approach) = approach(map_from_base, &feet, passage) else { continue };
        // The robot has the same heading before the dock as on it.
        let approach = graph.add(Sample { feet: approach, yaw }, PlaceKind::DockApproach(number));
        graph.join(dock, approach, LinkKind::Dock);
    }
}

/// The place of the feet before a dock, ahead of the docked robot or behind it: where it has walked, or else where there is room. None if neither is free.
fn approach(map_from_base: &Isometry, feet: &Vector3, passage: &Passage<'_>) -> Option<Vector3> {
    let config = &passage.floor.config;
    let ahead = map_from_base.rotation * Vector3::x();
    let ahead = Vector3::new(ahead.x, ahead.y, 0.0).try_normalize(1e-6)?;
    let places = [1.0, -1.0].map(|side| {
        let at = feet + ahead * (side * config.dock_approach_m);
        let ground = passage.floor.ground(at.x, at.y, feet.z);
        Vector3::new(at.x, at.y, ground.unwrap_or(feet.z))
    });
    let is_walked = |at: &Vector3| passage.path.is_near(at, config.dock_radius_m);
    // The dock itself is an obstacle behind or before the robot, so only the place is checked and not the path onto the dock.
    let is_free = |at: &Vector3| passage.is_free(at, at);
    let walked = places.iter().find(|at| is_walked(at) && is_free(at));
    walked.or_else(|| places.iter().find(|at| is_free(at))).copied()
}

/// Joins the places before docks that no path has come to with the nearest path. Docks without a path near them are left out.
pub(crate) fn join_docks(graph: &mut PathGraph, passage: &Passage<'_>) {
    for place in 0..graph.places.len() {
        let is_alone = matches!(graph.places[place].kind, PlaceKind::DockApproach(_))
            && graph.links[place].values().all(|link| link.kind == LinkKind::Dock);
        if is_alone {
            let feet = graph.feet(place);
            let near = graph.near(&feet, passage.floor.config.dock_reach_m);
            let found = near.into_iter().find(|other| {
                *other != place
                    && graph.places[*other].kind == PlaceKind::Plain
                    && passage.is_free(&feet, &graph.feet(*other))
            });
            match found {
                Some(other) => graph.join(place, other, LinkKind::Walk),
                None => graph.detach(place),
            }
        }
    }
}
