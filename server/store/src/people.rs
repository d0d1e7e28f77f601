//! Leaves people and whatever else moved out of a map's clouds: points that the keyframes around looked through.
//!
//! Clouds pass through one after the other and wait only until those ahead have been seen, so memory holds a few metres of
//! the walk.

use crate::MapCloud;
use geometry::Isometry;
use mapping::dynamics::{VOTERS, moving_points};
use mapping::view::RangeImage;
use std::collections::VecDeque;

/// Keyframes farther along the walk than this are not asked, metres.
const REACH: f64 = 8.0;

/// What a keyframe saw.
#[derive(Debug)]
struct Witness {
    map_from_keyframe: Isometry,
    view: RangeImage,
    /// From the first keyframe, metres.
    walked: f64,
}

/// The stretch of the walk in hand.
#[derive(Debug, Default)]
pub(crate) struct Passage {
    witnesses: VecDeque<Witness>,
    /// Of the last witnesses, in order.
    waiting: VecDeque<MapCloud>,
}

impl Passage {
    /// Takes the next keyframe: what it adds to the map and what it saw. One whose pose is none is passed over.
    pub(crate) fn enter(&mut self, cloud: MapCloud, view: RangeImage) {
        let Some(map_from_keyframe) = geometry::isometry_from_pose(&cloud.map_from_keyframe) else {
            return;
        };
        let step = |last: &Witness| {
            let way = map_from_keyframe.translation.vector - last.map_from_keyframe.translation.vector;
            last.walked + way.norm()
        };
        let walked = self.witnesses.back().map_or(0.0, step);
        self.witnesses.push_back(Witness { map_from_keyframe, view, walked });
        self.waiting.push_back(cloud);
    }

    /// Whether nobody who is still to come has a vote on the first cloud that waits.
    pub(crate) fn is_ready(&self) -> bool {
        let own = self.own();
        let (Some(own_at), Some(last)) = (self.witnesses.get(own), self.witnesses.back()) else {
            return false;
        };
        last.walked - own_at.walked > REACH || self.witnesses.len() - own > VOTERS
    }

    /// The first cloud that waits, without what moved.
    pub(crate) fn leave(&mut self) -> Option<MapCloud> {
        let own = self.own();
        let mut cloud = self.waiting.pop_front()?;
        let moving = moving_points(&cloud.xyz, &self.voters(own));
        cloud.drop_points(&moving);
        self.forget();
        Some(cloud)
    }

    /// Index of the witness whose cloud waits first.
    fn own(&self) -> usize {
        self.witnesses.len() - self.waiting.len()
    }

    /// Those nearest along the walk, each with its pose in the keyframe `own`.
    fn voters(&self, own: usize) -> Vec<(Isometry, &RangeImage)> {
        let Some(of) = self.witnesses.get(own) else {
            return Vec::new();
        };
        let mut around: Vec<(f64, usize)> = (0..self.witnesses.len())
            .filter(|other| *other != own)
            .map(|other| ((self.witnesses[other].walked - of.walked).abs(), other))
            .filter(|(walked, _)| *walked <= REACH)
            .collect();
        around.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let keyframe_from_map = of.map_from_keyframe.inverse();
        around
            .iter()
            .take(VOTERS)
            .map(|&(_, other)| {
                let other = &self.witnesses[other];
                (keyframe_from_map * other.map_from_keyframe, &other.view)
            })
            .collect()
    }

    /// Forgets witnesses that none of those who wait, or come, will ask.
    fn forget(&mut self) {
        loop {
            let own = self.own();
            let at = self.witnesses.get(own).or(self.witnesses.back()).map_or(0.0, |witness| witness.walked);
            let old = self.witnesses.front().is_some_and(|first| at - first.walked > REACH);
            if own == 0 || !(old || own > VOTERS) {
                return;
            }
            self.witnesses.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::{KeyframeId, Pose, Vec3};

    /// A hall 20 m long and 6 m wide seen from `x`, with somebody at (5, 1.5) or nobody.
    fn hall(x: f64, somebody: bool) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        for column in 0..720 {
            for row in -10..=10 {
                let (sin, cos) = (f64::from(column) * std::f64::consts::TAU / 720.0).sin_cos();
                let wall = |at: f64, along: f64| if at / along > 0.0 { at / along } else { f64::INFINITY };
                let walls = [wall(20.0 - x, cos), wall(-1.0 - x, cos), wall(3.0, sin), wall(-3.0, sin)];
                let mut range = walls.into_iter().fold(f64::INFINITY, f64::min);
                let (along, off) = ((5.0 - x) * cos + 1.5 * sin, (5.0 - x) * sin - 1.5 * cos);
                if somebody && along > 0.0 && off.abs() < 0.2 {
                    range = range.min(along - (0.04 - off * off).sqrt());
                }
                points.push([range * cos, range * sin, range * f64::from(row) * 0.02].map(|c| c as f32));
            }
        }
        points
    }

    /// Walks down the hall in steps of 0.5 m; somebody is there for one keyframe, or all the time.
    fn persons_left(stays: bool) -> (usize, usize) {
        let mut passage = Passage::default();
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
            passage.enter(
                MapCloud {
                    keyframe: KeyframeId(step),
                    map_from_keyframe: Pose { position, ..Pose::IDENTITY },
                    intensity: vec![1.0; xyz.len()],
                    xyz,
                },
                view,
            );
            while passage.is_ready() {
                let cloud = passage.leave().expect("one that is ready");
                assert_eq!((cloud.keyframe, cloud.intensity.len()), (KeyframeId(given), cloud.xyz.len()));
                count(cloud, f64::from(given) * 0.5);
                given += 1;
            }
            assert!(passage.witnesses.len() <= 2 * VOTERS + 2, "memory is bounded");
        }
        while let Some(cloud) = passage.leave() {
            count(cloud, f64::from(given) * 0.5);
            given += 1;
        }
        assert_eq!(given, 40, "nobody is forgotten");
        (left, persons)
    }

    fn is_person(point: &[f32; 3], x: f64) -> bool {
        (f64::from(point[0]) + x - 5.0).hypot(f64::from(point[1]) - 1.5) < 0.25
    }

    #[test]
    fn who_passes_is_left_out_and_who_stays_is_kept() {
        let (left, persons) = persons_left(false);
        assert!(persons > 100 && left * 20 < persons, "{left} of {persons}");
        let (left, persons) = persons_left(true);
        assert!(left * 20 > persons * 19, "{left} of {persons}");
    }
}
