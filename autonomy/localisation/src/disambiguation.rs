//! Disambiguation: a path on which the scans of a robot decide between several poses. It is the information-gathering step of active localisation
//! (Fox, Burgard, Thrun, *Active Markov Localization for Mobile Robots*, 1998), with fits in place of likelihoods.
//!
//! Each hypothesis has surroundings of its own in the map. Keyframes show where the robot can walk from there, and what it would see. Where a
//! keyframe's cloud does not fit the surroundings of another hypothesis, the robot's scans will reject that hypothesis or this one.

use crate::localisation_map::LocalisationMap;
use crate::multi_hypothesis_tracker::MultiHypothesisConfig;
use geometry::{Isometry, Vector3};
use mapping::KeyframeDescriptor;
use mapping::range_image::Occupancy;
use nalgebra::Point3;
use ordered_float::OrderedFloat;
use pathfinding::directed::dijkstra::dijkstra_reach;
use registration::{MatchingConfig, score};

/// Parameters of [`plan_disambiguation`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisambiguationConfig {
    /// Greatest length of a step from one keyframe to the next, metres. Chosen: keyframes that still see the same surroundings
    /// ([`mapping::candidates::CandidateConfig::max_offset_m`]).
    pub max_step_m: f64,
    /// Greatest rise of a step for each metre of its horizontal length. Chosen: stairs, of up to 39 degrees.
    pub max_step_slope: f64,
    /// Rise that any step may have in addition, metres. Chosen: the height of a step of stairs.
    pub max_step_rise_m: f64,
    /// Greatest length of a path, metres. Chosen: half a minute of walking. More costs planning time, and the poses are known better after each part of a path.
    pub max_path_m: f64,
    /// Keyframes this near to each other have the same view, metres. Chosen: the distance between keyframes.
    pub same_view_m: f64,
    /// Number of points of a keyframe whose fit is compared. Chosen: a sixth of a keyframe's points, for time.
    pub points: usize,
    /// How they are matched: nearly as the pose tracker matches scans.
    pub matching: MatchingConfig,
    /// Fit difference, integrated along the path (fit x m), at which a hypothesis counts as rejected: [`MultiHypothesisConfig::rejection_margin`] over 0.7 m. That is
    /// 1.75 times what the tracker needs (its margin over `update_distance_m`), because scans differ less from the map than keyframes do.
    pub rejection_margin_fit_m: f64,
    /// Smaller fit differences count as zero: hypotheses that differ by less look alike. Chosen as a round number: less counts noise as a difference, more leaves
    /// hypotheses that could be told apart.
    pub min_fit_difference: f64,
    /// Least number of rejected hypotheses for a path, where a hypothesis may be rejected in part. Chosen: a path that tells less is not worth the walk.
    pub min_rejected: f64,
    /// Length that is added to every path, metres. It is the cost of starting a walk. Chosen: about 2 s of walking.
    pub start_cost_m: f64,
    /// Length that is added for each radian that the robot has to turn before it sets out, metres. The robot turns about as fast as it
    /// walks, and it has seen what lies behind it. Chosen: a radian takes 1.1 s at 0.9 rad/s, and the view behind is known.
    pub turn_cost_m_per_rad: f64,
    /// A path continues for up to this distance past the point that should decide, metres. A scan may differ less than keyframes do, and a robot that
    /// turns round there has to see the same surroundings again. Chosen as a round number: more lets the robot walk on although the scans tell nothing.
    pub overshoot_m: f64,
    /// Number of hypotheses from which paths are searched, the best. Chosen: planning takes in proportion to it.
    pub max_start_hypotheses: usize,
    /// A new path is planned after this distance, metres. The poses are known better by then. Chosen: some seconds of walking, in which planning is long done.
    pub replan_distance_m: f64,
}

impl Default for DisambiguationConfig {
    fn default() -> Self {
        Self {
            max_step_m: 2.5,
            max_step_slope: 0.8,
            max_step_rise_m: 0.2,
            max_path_m: 25.0,
            same_view_m: 1.0,
            points: 500,
            matching: MatchingConfig { noise_m: 0.02, front_facing_only: true, ..MatchingConfig::default() },
            rejection_margin_fit_m: MultiHypothesisConfig::default().rejection_margin * 0.7,
            min_fit_difference: 0.01,
            min_rejected: 0.25,
            start_cost_m: 2.0,
            turn_cost_m_per_rad: 2.0,
            overshoot_m: 8.0,
            max_start_hypotheses: 3,
            replan_distance_m: 3.0,
        }
    }
}

/// A keyframe that the robot can walk to.
#[derive(Clone, Copy, Debug)]
struct ReachableKeyframe {
    keyframe: usize,
    /// Length of the shortest path, metres.
    distance_m: f64,
    /// Index of the keyframe before it on that path, among the reachable ones. `None` at the start of the path.
    previous: Option<usize>,
}

/// The value of a path.
#[derive(Clone, Copy, Debug)]
struct PathValue {
    /// Whether it rejects all other hypotheses.
    rejects_all: bool,
    /// Number of rejected hypotheses for each metre of its cost (equation 11).
    rejected_per_m: f64,
}

impl PathValue {
    /// All hypotheses but one have to be rejected in the end, so that a path that rejects only some of them sooner is a detour.
    fn exceeds(&self, other: &Self) -> bool {
        (self.rejects_all, self.rejected_per_m) > (other.rejects_all, other.rejected_per_m)
    }
}

/// A path on which the scans of the robot decide between these poses (base in the map, the most likely first). It consists of positions in the frame
/// of the robot's base, and the first of them is next to the base. The path is empty if no path rejects any of the poses.
///
/// It computes one fit for each metre of walkable path around each start hypothesis, and for each of the other hypotheses. The search for walkable
/// paths is quadratic in the keyframes there. On the simulated sites it takes 31 to 36 ms in the median and 84 ms at most.
pub fn plan_disambiguation(
    map: &LocalisationMap,
    hypotheses: &[Isometry],
    config: &DisambiguationConfig,
) -> Vec<Vector3> {
    let planner = Planner { map, config };
    let mut best: Option<(PathValue, Vec<Vector3>)> = None;
    for (number, start) in hypotheses.iter().enumerate().take(config.max_start_hypotheses) {
        let others: Vec<Isometry> = hypotheses
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != number)
            .map(|(_, other)| other * start.inverse())
            .collect();
        let Some((value, path)) = planner.best_path(start, &others) else { continue };
        if best.as_ref().is_none_or(|(most, _)| value.exceeds(most)) {
            best = Some((value, path));
        }
    }
    best.map(|(_, path)| path).unwrap_or_default()
}

struct Planner<'a> {
    map: &'a LocalisationMap,
    config: &'a DisambiguationConfig,
}

impl Planner<'_> {
    /// The best path from one hypothesis, with its value. Each of `others` transforms points from this hypothesis to another one.
    fn best_path(&self, start: &Isometry, others: &[Isometry]) -> Option<(PathValue, Vec<Vector3>)> {
        let config = self.config;
        let reachable = self.reachable_keyframes(start);
        // Positions of the views compared so far, with the fit differences there.
        let mut views: Vec<(Vector3, Vec<f64>)> = Vec::new();
        // For each reachable keyframe and other hypothesis, how much of the margin the path there integrates (equation 10).
        let mut rejected: Vec<Vec<f64>> = Vec::new();
        let mut best: Option<(PathValue, usize)> = None;
        for (number, end) in reachable.iter().enumerate() {
            let (pose, descriptor) = &self.map.keyframes()[end.keyframe];
            let position = pose.translation.vector;
            let is_same_view =
                |(view, _): &(Vector3, Vec<f64>)| (view - position).norm() < config.same_view_m;
            let view = views.iter().position(is_same_view).unwrap_or_else(|| {
                views.push((position, self.fit_differences(pose, descriptor, others)));
                views.len() - 1
            });
            let (before, step_m) = match end.previous {
                Some(previous) => {
                    (rejected[previous].clone(), end.distance_m - reachable[previous].distance_m)
                }
                None => (vec![0.0; others.len()], end.distance_m),
            };
            // A keyframe fits the map that it is part of a little better than any scan does. At the start all hypotheses fit alike, so that
            // the difference there is subtracted.
            let (at_start, here) = (&views[0].1, &views[view].1);
            let differences = here
                .iter()
                .zip(at_start)
                .map(|(here, at_start)| (here - at_start - config.min_fit_difference).max(0.0));
            let sums = before.iter().zip(differences);
            let shares =
                sums.map(|(before, difference)| before + difference * step_m / config.rejection_margin_fit_m);
            rejected.push(shares.collect());
            let count: f64 = rejected[number].iter().map(|share| share.min(1.0)).sum();
            if count < config.min_rejected {
                continue;
            }
            let turn_rad = self.initial_turn_rad(&self.path_to(start, &reachable, number));
            let cost_m = end.distance_m + config.start_cost_m + config.turn_cost_m_per_rad * turn_rad;
            let value = PathValue {
                rejects_all: rejected[number].iter().all(|share| *share >= 1.0),
                rejected_per_m: count / cost_m,
            };
            if best.is_none_or(|(most, _)| value.exceeds(&most)) {
                best = Some((value, number));
            }
        }
        best.map(|(value, end)| {
            let end = extend_path(&reachable, end, config.overshoot_m);
            (value, self.path_to(start, &reachable, end))
        })
    }

    /// Positions from the start to a reachable keyframe, in the frame of the base at the start.
    fn path_to(&self, start: &Isometry, reachable: &[ReachableKeyframe], end: usize) -> Vec<Vector3> {
        let mut path = Vec::new();
        let mut next = Some(end);
        while let Some(number) = next {
            let position = self.map.keyframes()[reachable[number].keyframe].0.translation.vector;
            path.push((start.inverse() * Point3::from(position)).coords);
            next = reachable[number].previous;
        }
        path.reverse();
        path
    }

    /// Fit of a keyframe's cloud at its own pose minus its fit at each of the other hypotheses.
    fn fit_differences(
        &self,
        pose: &Isometry,
        descriptor: &KeyframeDescriptor,
        others: &[Isometry],
    ) -> Vec<f64> {
        let stride = descriptor.points().len().div_ceil(self.config.points).max(1);
        let points: Vec<[f32; 3]> = descriptor.points().step_by(stride).collect();
        let fit = |pose: &Isometry| score(self.map.surfaces(), &points, pose, &self.config.matching);
        let own = fit(pose);
        others.iter().map(|other| own - fit(&(other * pose))).collect()
    }

    /// Keyframes that the robot can walk to, the nearest first (Dijkstra, 1959).
    fn reachable_keyframes(&self, start: &Isometry) -> Vec<ReachableKeyframe> {
        let keyframes = self.map.keyframes();
        let origin = start.translation.vector;
        let position = |keyframe: usize| keyframes[keyframe].0.translation.vector;
        let near: Vec<usize> = (0..keyframes.len())
            .filter(|&keyframe| (position(keyframe) - origin).norm() <= self.config.max_path_m)
            .collect();
        // Nodes are keyframes; the robot's own position is none.
        let steps = |from: &Option<usize>| {
            let step = |&to: &usize| {
                let step_m = match *from {
                    None => self.step_length_m(to, &origin),
                    Some(from) => self.step_length_m(from, &position(to)),
                };
                step_m.map(|step_m| (Some(to), OrderedFloat(step_m)))
            };
            near.iter().filter_map(step).collect::<Vec<_>>()
        };
        let mut reachable: Vec<ReachableKeyframe> = Vec::new();
        // Index of each keyframe among the reachable ones.
        let mut indices: Vec<Option<usize>> = vec![None; keyframes.len()];
        for reached in dijkstra_reach(&None, steps) {
            let distance_m = reached.total_cost.into_inner();
            if distance_m > self.config.max_path_m {
                break;
            }
            let Some(keyframe) = reached.node else { continue };
            let previous = reached.parent.flatten().and_then(|parent| indices[parent]);
            indices[keyframe] = Some(reachable.len());
            reachable.push(ReachableKeyframe { keyframe, distance_m, previous });
        }
        reachable
    }

    /// Distance from a keyframe to a position of the base next to it, metres. `None` if the robot cannot walk there in one step, because it is too
    /// far, too steep, or behind an object that the keyframe saw.
    fn step_length_m(&self, keyframe: usize, base: &Vector3) -> Option<f64> {
        let config = self.config;
        let (pose, descriptor) = &self.map.keyframes()[keyframe];
        let offset = base - pose.translation.vector;
        let distance_m = offset.norm();
        if distance_m > config.max_step_m
            || offset.z.abs() > config.max_step_slope * offset.xy().norm() + config.max_step_rise_m
        {
            return None;
        }
        // Position of the LiDAR if the base were there.
        let sensor = descriptor.sensor();
        let at = (pose.inverse() * Point3::from(*base)).coords.cast::<f32>()
            + Vector3::from(sensor.map(f64::from)).cast::<f32>();
        (descriptor.view().classify(&at.into()) != Occupancy::Occluded).then_some(distance_m)
    }

    /// Angle that the base has to turn at the start of a path in its own frame, radians. It is the direction of the first position that is not next
    /// to the base.
    fn initial_turn_rad(&self, path: &[Vector3]) -> f64 {
        let ahead = path.iter().find(|at| at.xy().norm() >= self.config.same_view_m);
        ahead.map_or(0.0, |at| at.y.atan2(at.x).abs())
    }
}

/// The farthest keyframe within `overshoot_m` of path past `end` to which the path through `end` leads.
fn extend_path(reachable: &[ReachableKeyframe], end: usize, overshoot_m: f64) -> usize {
    let leads_through_end = |number: usize| {
        let mut at = number;
        while at > end {
            match reachable[at].previous {
                Some(previous) => at = previous,
                None => return false,
            }
        }
        at == end
    };
    let farthest_m = reachable[end].distance_m + overshoot_m;
    // They are ordered by distance.
    (end..reachable.len())
        .rev()
        .find(|&number| reachable[number].distance_m <= farthest_m && leads_through_end(number))
        .unwrap_or(end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{at, rooms_keyframes};

    fn plan(map: &LocalisationMap, hypotheses: &[Isometry]) -> Vec<Vector3> {
        plan_disambiguation(map, hypotheses, &DisambiguationConfig::default())
    }

    #[test]
    fn the_path_out_of_one_of_two_equal_rooms_leads_through_its_door() {
        let map = LocalisationMap::new(rooms_keyframes());
        let hypotheses = [at(4.0, 6.0, 0.4), at(24.0, 6.0, 0.4)];
        let path: Vec<Vector3> =
            plan(&map, &hypotheses).iter().map(|at| (hypotheses[0] * Point3::from(*at)).coords).collect();
        let Some(end) = path.last() else { panic!("there is no path") };
        let max_step_m = DisambiguationConfig::default().max_step_m;
        assert!((path[0] - hypotheses[0].translation.vector).norm() <= max_step_m, "{path:?}");
        assert!(end.y < 2.5, "{path:?}");
        assert!(path.windows(2).all(|pair| (pair[1] - pair[0]).norm() <= max_step_m), "{path:?}");
        assert!(path.iter().all(|at| at.y < 1.2 || (at.x - 4.0).abs() < 0.1), "through a wall: {path:?}");
    }

    #[test]
    fn a_path_has_to_reject_by_more_than_the_tracker_needs() {
        let tracker = MultiHypothesisConfig::default();
        let expected = 1.75 * tracker.rejection_margin * tracker.update_distance_m;
        assert!((DisambiguationConfig::default().rejection_margin_fit_m - expected).abs() < 1e-12);
    }

    #[test]
    fn there_is_no_path_where_nothing_differs() {
        let map = LocalisationMap::new(rooms_keyframes());
        let one = at(4.0, 6.0, 0.4);
        assert_eq!(plan(&map, &[one]), Vec::<Vector3>::new());
        assert_eq!(plan(&map, &[one, one]), Vec::<Vector3>::new());
        assert_eq!(plan(&map, &[]), Vec::<Vector3>::new());
    }

    #[test]
    fn a_path_is_extended_along_itself_and_not_along_another_one() {
        let keyframe = |distance_m: f64, previous: Option<usize>| ReachableKeyframe {
            keyframe: 0,
            distance_m,
            previous,
        };
        // Two branches from the start: 0, 1, 3, 5 and 2, 4.
        let reachable = [
            keyframe(1.0, None),
            keyframe(2.0, Some(0)),
            keyframe(2.5, None),
            keyframe(4.0, Some(1)),
            keyframe(4.5, Some(2)),
            keyframe(6.0, Some(3)),
        ];
        assert_eq!(extend_path(&reachable, 1, 8.0), 5);
        assert_eq!(extend_path(&reachable, 1, 3.0), 3);
        assert_eq!(extend_path(&reachable, 2, 8.0), 4);
        assert_eq!(extend_path(&reachable, 5, 8.0), 5);
    }
}
