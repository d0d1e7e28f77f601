//! Removes points of people and other moving objects from a map's clouds: points that neighbouring keyframes saw through.
//!
//! Clouds pass through one after the other. A cloud waits only until the keyframes that vote on it have been seen, so
//! memory holds a few metres of the walk.

use crate::map_cloud::MapCloud;
use geometry::Isometry;
use mapping::dynamic_points::{DynamicPointsConfig, dynamic_points};
use mapping::range_image::RangeImage;
use std::collections::VecDeque;

/// What a keyframe saw.
#[derive(Debug)]
struct KeyframeView {
    map_from_keyframe: Isometry,
    view: RangeImage,
    /// Distance along the walk from the first keyframe, metres.
    distance_m: f64,
}

/// A queue of keyframe clouds from which moving points are removed.
#[derive(Debug, Default)]
pub(crate) struct DynamicPointFilter {
    config: DynamicPointsConfig,
    /// Views of the pending keyframes and of those before them that still vote.
    views: VecDeque<KeyframeView>,
    /// Clouds of the last views, in order.
    pending: VecDeque<MapCloud>,
}

impl DynamicPointFilter {
    /// Inserts the next keyframe: its points for the map, and everything it saw. A keyframe with an invalid pose is skipped.
    pub(crate) fn insert(&mut self, cloud: MapCloud, view: RangeImage) {
        let Some(map_from_keyframe) = geometry::isometry_from_pose(&cloud.map_from_keyframe) else {
            return;
        };
        let distance_of = |last: &KeyframeView| {
            let step = map_from_keyframe.translation.vector - last.map_from_keyframe.translation.vector;
            last.distance_m + step.norm()
        };
        let distance_m = self.views.back().map_or(0.0, distance_of);
        self.views.push_back(KeyframeView { map_from_keyframe, view, distance_m });
        self.pending.push_back(cloud);
    }

    /// Whether all keyframes that vote on the first pending cloud have been inserted.
    pub(crate) fn is_ready(&self) -> bool {
        let front = self.front_view();
        let (Some(first), Some(last)) = (self.views.get(front), self.views.back()) else {
            return false;
        };
        last.distance_m - first.distance_m > self.config.max_walk_distance_m
            || self.views.len() - front > self.config.max_voters
    }

    /// Removes the first pending cloud from the queue and drops its moving points.
    pub(crate) fn pop(&mut self) -> Option<MapCloud> {
        let front = self.front_view();
        let mut cloud = self.pending.pop_front()?;
        let moving = dynamic_points(&cloud.xyz, &self.voters(front), &self.config);
        cloud.drop_points(&moving);
        self.drop_unused_views();
        Some(cloud)
    }

    /// Index of the view that belongs to the first pending cloud.
    fn front_view(&self) -> usize {
        self.views.len() - self.pending.len()
    }

    /// The views nearest along the walk to the view `index`, each with its pose in that keyframe.
    fn voters(&self, index: usize) -> Vec<(Isometry, &RangeImage)> {
        let Some(of) = self.views.get(index) else {
            return Vec::new();
        };
        let mut others: Vec<(f64, usize)> = (0..self.views.len())
            .filter(|other| *other != index)
            .map(|other| ((self.views[other].distance_m - of.distance_m).abs(), other))
            .filter(|(distance_m, _)| *distance_m <= self.config.max_walk_distance_m)
            .collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let keyframe_from_map = of.map_from_keyframe.inverse();
        others
            .iter()
            .take(self.config.max_voters)
            .map(|&(_, other)| {
                let other = &self.views[other];
                (keyframe_from_map * other.map_from_keyframe, &other.view)
            })
            .collect()
    }

    /// Drops views that have no vote on any pending or later cloud.
    fn drop_unused_views(&mut self) {
        loop {
            let front = self.front_view();
            let at = self.views.get(front).or(self.views.back()).map_or(0.0, |view| view.distance_m);
            let is_far = self
                .views
                .front()
                .is_some_and(|first| at - first.distance_m > self.config.max_walk_distance_m);
            if front == 0 || !(is_far || front > self.config.max_voters) {
                return;
            }
            self.views.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::{KeyframeId, Pose, Vec3};

    /// A hall 20 m long and 6 m wide seen from `x`, with or without a person at (5, 1.5).
    fn hall(x: f64, person: bool) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        for column in 0..720 {
            for row in -10..=10 {
                let (sin, cos) = (f64::from(column) * std::f64::consts::TAU / 720.0).sin_cos();
                let wall = |at: f64, along: f64| if at / along > 0.0 { at / along } else { f64::INFINITY };
                let walls = [wall(20.0 - x, cos), wall(-1.0 - x, cos), wall(3.0, sin), wall(-3.0, sin)];
                let mut range = walls.into_iter().fold(f64::INFINITY, f64::min);
                let (along, off) = ((5.0 - x) * cos + 1.5 * sin, (5.0 - x) * sin - 1.5 * cos);
                if person && along > 0.0 && off.abs() < 0.2 {
                    range = range.min(along - (0.04 - off * off).sqrt());
                }
                points.push([range * cos, range * sin, range * f64::from(row) * 0.02].map(|c| c as f32));
            }
        }
        points
    }

    /// Walks through the hall in steps of 0.5 m; the person is there for one keyframe or for all. Returns points of the person that are left, and
    /// those that were seen.
    fn points_left(stays: bool) -> (usize, usize) {
        let mut filter = DynamicPointFilter::default();
        let (mut persons, mut left) = (0, 0);
        let mut count = |cloud: MapCloud, x: f64| {
            left += cloud.xyz.iter().filter(|p| is_person(p, x)).count();
        };
        let mut given = 0_u32;
        for step in 0..40_u32 {
            let x = f64::from(step) * 0.5;
            let xyz = hall(x, stays || step == 6);
            persons += xyz.iter().filter(|p| is_person(p, x)).count();
            let view = RangeImage::new(&xyz, [0.0; 3]);
            let position = Vec3::new(x, 0.0, 0.0);
            filter.insert(
                MapCloud {
                    keyframe: KeyframeId(step),
                    map_from_keyframe: Pose { position, ..Pose::IDENTITY },
                    intensity: vec![1.0; xyz.len()],
                    xyz,
                },
                view,
            );
            while filter.is_ready() {
                let cloud = filter.pop().expect("one that is ready");
                assert_eq!((cloud.keyframe, cloud.intensity.len()), (KeyframeId(given), cloud.xyz.len()));
                count(cloud, f64::from(given) * 0.5);
                given += 1;
            }
            assert!(filter.views.len() <= 2 * filter.config.max_voters + 2, "memory is bounded");
        }
        while let Some(cloud) = filter.pop() {
            count(cloud, f64::from(given) * 0.5);
            given += 1;
        }
        assert_eq!(given, 40, "every keyframe comes back");
        (left, persons)
    }

    fn is_person(point: &[f32; 3], x: f64) -> bool {
        (f64::from(point[0]) + x - 5.0).hypot(f64::from(point[1]) - 1.5) < 0.25
    }

    #[test]
    fn a_person_who_passes_is_removed_and_one_who_stays_is_kept() {
        let (left, persons) = points_left(false);
        assert!(persons > 100 && left * 20 < persons, "{left} of {persons}");
        let (left, persons) = points_left(true);
        assert!(left * 20 > persons * 19, "{left} of {persons}");
    }
}
