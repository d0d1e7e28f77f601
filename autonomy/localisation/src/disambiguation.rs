//! Where to walk so that places which look alike turn out to be different.
//!
//! Each place has surroundings of its own in the map: keyframes show where one can walk from there, and what is seen on the way. Where what
//! they saw would not fit about the other places, the robot will see which of them it is at. The shortest way that tells all apart wins, as
//! in active localisation (Fox, Burgard and Thrun, *Active Markov Localization for Mobile Robots*, 1998), with fits in place of
//! likelihoods.

use crate::localisation_map::LocalisationMap;
use geometry::{Isometry, Vector3};
use mapping::KeyframeDescriptor;
use mapping::range_image::Occupancy;
use registration::{MatchingConfig, score};

/// One walks from keyframe to keyframe, where nothing stands between them, in steps of so many metres at most that rise by so much a metre.
const STEP: f64 = 2.5;
const RISE: f64 = 0.8;
/// Ways are so long at most, metres; keyframes so near to each other look alike.
const FARTHEST: f64 = 25.0;
const APART: f64 = 1.0;
/// Points of each look, matched nearly as scans are.
const POINTS: usize = 500;
const MATCHING: MatchingConfig = MatchingConfig {
    gate_m: 0.1,
    kernel_width: 3.0,
    noise_m: 0.02,
    use_distributions: true,
    front_facing_only: true,
};
/// A place is told apart that fits so much worse over so many metres, nearly twice what it takes: scans differ less than keyframes do. What
/// fits less worse than the second is alike; all places together told apart by less than the third are not.
const TELLS: (f64, f64) = (0.2, 0.7);
const ALIKE: f64 = 0.01;
const NOISE: f64 = 0.25;
/// Metres that any way costs besides its length, and for each radian that a robot has to turn to set out on it: it turns about as fast as it walks,
/// and has seen what lies behind it.
const SETTING_OUT: f64 = 2.0;
const TURN: f64 = 2.0;
/// Where there is a way on past what ought to tell the places apart, it is followed so far, metres.
const BEYOND: f64 = 8.0;
/// Ways are looked for from so many places, the best.
const FROM: usize = 3;

/// A keyframe that one can walk to.
#[derive(Clone, Copy, Debug)]
struct Reached {
    keyframe: usize,
    /// Metres of way.
    metres: f64,
    /// The one before it on the way, by its number among the reached; none where the way begins.
    before: Option<usize>,
}

/// What a way is worth.
#[derive(Clone, Copy, Debug)]
struct Worth {
    /// Whether it tells all places apart.
    all: bool,
    /// How many, for each metre.
    rate: f64,
}

impl Worth {
    /// All have to be told apart in the end: whatever tells only some of them sooner is a way round.
    fn exceeds(&self, other: &Self) -> bool {
        (self.all, self.rate) > (other.all, other.rate)
    }
}

impl LocalisationMap {
    /// A way on which a robot that may be at any of these places (bases in the map, the likeliest first) sees which of them it is at: points in
    /// the frame of its base, the first of them next to it. Empty where nothing within 25 m tells any of them apart.
    ///
    /// Costs a fit of 500 points for each metre of walkable ground within 25 m of each of the first three places and for each of the other
    /// places; finding what is walkable is quadratic in the keyframes there.
    pub fn way_to_tell(&self, places: &[Isometry]) -> Vec<Vector3> {
        let mut best: Option<(Worth, Vec<Vector3>)> = None;
        for (number, place) in places.iter().enumerate().take(FROM) {
            let others: Vec<Isometry> = places
                .iter()
                .enumerate()
                .filter(|(other, _)| *other != number)
                .map(|(_, other)| other * place.inverse())
                .collect();
            let Some((worth, way)) = self.best_way(place, &others) else { continue };
            if best.as_ref().is_none_or(|(most, _)| worth.exceeds(most)) {
                best = Some((worth, way));
            }
        }
        best.map(|(_, way)| way).unwrap_or_default()
    }

    /// From one place, with where each of the others would put what is seen there, and what it is worth.
    fn best_way(&self, place: &Isometry, others: &[Isometry]) -> Option<(Worth, Vec<Vector3>)> {
        let reached = self.walkable(place);
        let mut looks: Vec<(Vector3, Vec<f64>)> = Vec::new();
        // How far each of the others has been told apart at each of the reached, when it is walked to.
        let mut told: Vec<Vec<f64>> = Vec::new();
        let mut best: Option<(Worth, usize)> = None;
        for (number, one) in reached.iter().enumerate() {
            let (pose, seen) = &self.keyframes()[one.keyframe];
            let at = pose.translation.vector;
            let look = looks.iter().position(|(look, _)| (look - at).norm() < APART).unwrap_or_else(|| {
                looks.push((at, self.worse(pose, seen, others)));
                looks.len() - 1
            });
            let (before, metres) = match one.before {
                Some(before) => (told[before].clone(), one.metres - reached[before].metres),
                None => (vec![0.0; others.len()], one.metres),
            };
            // A keyframe fits the map that it is part of a little better than any scan does; where the robot is now, all fit alike.
            let (alike, worse) = (&looks[0].1, &looks[look].1);
            let more = worse.iter().zip(alike).map(|(worse, alike)| (worse - alike - ALIKE).max(0.0));
            let sum = before.iter().zip(more);
            told.push(sum.map(|(before, more)| before + more * metres / (TELLS.0 * TELLS.1)).collect());
            let tells: f64 = told[number].iter().map(|told| told.min(1.0)).sum();
            if tells < NOISE {
                continue;
            }
            let cost = one.metres + SETTING_OUT + TURN * turn(&self.way(place, &reached, number));
            let worth = Worth { all: told[number].iter().all(|told| *told >= 1.0), rate: tells / cost };
            if best.is_none_or(|(most, _)| worth.exceeds(&most)) {
                best = Some((worth, number));
            }
        }
        best.map(|(worth, end)| (worth, self.way(place, &reached, beyond(&reached, end))))
    }

    /// To one of the keyframes that were reached from a place, in the frame of the base there.
    fn way(&self, place: &Isometry, reached: &[Reached], end: usize) -> Vec<Vector3> {
        let mut way = Vec::new();
        let mut next = Some(end);
        while let Some(number) = next {
            let base = self.keyframes()[reached[number].keyframe].0.translation.vector;
            way.push((place.inverse() * nalgebra::Point3::from(base)).coords);
            next = reached[number].before;
        }
        way.reverse();
        way
    }

    /// How much worse what a keyframe saw fits at each of the others.
    fn worse(&self, pose: &Isometry, seen: &KeyframeDescriptor, others: &[Isometry]) -> Vec<f64> {
        let stride = seen.points().len().div_ceil(POINTS).max(1);
        let points: Vec<[f32; 3]> = seen.points().step_by(stride).collect();
        let fit = |pose: &Isometry| score(self.surfaces(), &points, pose, &MATCHING);
        let here = fit(pose);
        others.iter().map(|other| here - fit(&(other * pose))).collect()
    }

    /// Keyframes that one can walk to, the nearest first (Dijkstra, 1959).
    fn walkable(&self, place: &Isometry) -> Vec<Reached> {
        let from = place.translation.vector;
        let base = |keyframe: usize| self.keyframes()[keyframe].0.translation.vector;
        let mut open: Vec<Reached> = (0..self.keyframes().len())
            .filter(|&keyframe| (base(keyframe) - from).norm() <= FARTHEST)
            .map(|keyframe| {
                let metres = self.step(keyframe, &from).unwrap_or(f64::INFINITY);
                Reached { keyframe, metres, before: None }
            })
            .collect();
        let mut reached: Vec<Reached> = Vec::new();
        while let Some(next) = (0..open.len()).min_by(|&a, &b| open[a].metres.total_cmp(&open[b].metres)) {
            let nearest = open.swap_remove(next);
            if nearest.metres > FARTHEST {
                break;
            }
            for other in &mut open {
                let Some(step) = self.step(nearest.keyframe, &base(other.keyframe)) else { continue };
                if nearest.metres + step < other.metres {
                    (other.metres, other.before) = (nearest.metres + step, Some(reached.len()));
                }
            }
            reached.push(nearest);
        }
        reached
    }

    /// Metres from a keyframe to a base next to it; none if one cannot walk there at once.
    fn step(&self, keyframe: usize, base: &Vector3) -> Option<f64> {
        let (pose, seen) = &self.keyframes()[keyframe];
        let off = base - pose.translation.vector;
        let metres = off.norm();
        if metres > STEP || off.z.abs() > RISE * off.xy().norm() + 0.2 {
            return None;
        }
        // Where the LiDAR would be there.
        let sensor = seen.sensor();
        let at = (pose.inverse() * nalgebra::Point3::from(*base)).coords.cast::<f32>()
            + Vector3::from(sensor.map(f64::from)).cast::<f32>();
        (seen.view().classify(&at.into()) != Occupancy::Occluded).then_some(metres)
    }
}

/// Where a way goes on past its end: a scan may differ less than keyframes do, and whoever turns round there has to see the same again.
fn beyond(reached: &[Reached], end: usize) -> usize {
    let leads_through = |number: usize| {
        let mut at = number;
        while at > end {
            match reached[at].before {
                Some(before) => at = before,
                None => return false,
            }
        }
        at == end
    };
    let farthest = reached[end].metres + BEYOND;
    // They are in the order of their metres.
    (end..reached.len())
        .rev()
        .find(|&number| reached[number].metres <= farthest && leads_through(number))
        .unwrap_or(end)
}

/// Radians that a base has to turn to set out on a way in its own frame: towards the first point that is not next to it.
fn turn(way: &[Vector3]) -> f64 {
    let ahead = way.iter().find(|at| at.xy().norm() >= APART);
    ahead.map_or(0.0, |at| at.y.atan2(at.x).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Rotation, so3};

    /// Walls seen from above, each from one corner to another.
    type Walls = Vec<[[f64; 2]; 2]>;

    /// A corridor along x with a room to the left of it at 4 m and at 24 m, each with a door 1 m wide, alike but for what stands in the corridor
    /// 8 m beyond the second door: nothing that is seen from inside says which room it is.
    fn site() -> Walls {
        let mut walls =
            vec![[[-10.0, -1.5], [44.0, -1.5]], [[-10.0, -1.5], [-10.0, 1.5]], [[44.0, -1.5], [44.0, 1.5]]];
        let doors = [4.0, 24.0];
        let mut from = -10.0;
        for door in doors {
            walls.push([[from, 1.5], [door - 0.5, 1.5]]);
            from = door + 0.5;
            let [west, east, north] = [door - 3.0, door + 5.0, 8.5];
            walls.extend([
                [[west, 1.7], [west, north]],
                [[east, 1.7], [east, north]],
                [[west, north], [east, north]],
            ]);
            walls.extend([[[west, 1.7], [door - 0.5, 1.7]], [[door + 0.5, 1.7], [east, 1.7]]]);
            for side in [-0.5, 0.5] {
                walls.push([[door + side, 1.5], [door + side, 1.7]]);
            }
            walls.push([[east - 2.0, north - 1.0], [east - 1.0, north - 1.0]]);
        }
        walls.push([[from, 1.5], [44.0, 1.5]]);
        walls.extend([[[31.0, -1.5], [31.0, 0.3]], [[32.0, -1.5], [32.0, 0.3]], [[31.0, 0.3], [32.0, 0.3]]]);
        walls
    }

    fn range(walls: &Walls, from: [f64; 2], along: [f64; 2]) -> Option<f64> {
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let meet = |[a, b]: &[[f64; 2]; 2]| {
            let (wall, off) = ([b[0] - a[0], b[1] - a[1]], [a[0] - from[0], a[1] - from[1]]);
            let turn = cross(along, wall);
            let (range, share) = (cross(off, wall) / turn, cross(off, along) / turn);
            (range > 0.0 && (0.0..=1.0).contains(&share)).then_some(range)
        };
        walls.iter().filter_map(meet).min_by(f64::total_cmp)
    }

    /// What is seen from there, base frame: walls up to 2 m over the LiDAR, and the floor half a metre under the base.
    fn keyframe(walls: &Walls, x: f64, y: f64, yaw: f64) -> (Isometry, KeyframeDescriptor) {
        let turn = so3::exp(&(Vector3::z() * yaw));
        let mut points = Vec::new();
        for column in 0..720 {
            let (sin, cos) = (f64::from(column) * 0.5).to_radians().sin_cos();
            let ray = turn * Vector3::new(cos, sin, 0.0);
            let Some(range) = range(walls, [x, y], [ray.x, ray.y]) else { continue };
            for row in -10..=10 {
                let up = (f64::from(row) * 2.0).to_radians().tan();
                let range = if up * range < -0.5 { -0.5 / up } else { range };
                points.push([range * cos, range * sin, range * up].map(|c| c as f32));
            }
        }
        let pose = Isometry::from_parts(Vector3::new(x, y, 0.0).into(), turn);
        (pose, KeyframeDescriptor::of_cloud(&points, &Rotation::identity(), [0.0; 3]))
    }

    /// Walked up and down the corridor and into both rooms.
    fn guide() -> LocalisationMap {
        let walls = site();
        let mut keyframes = Vec::new();
        for step in 0..34 {
            keyframes.push(keyframe(&walls, -8.0 + 1.5 * f64::from(step), 0.6, 0.0));
        }
        for door in [4.0, 24.0] {
            for step in 0..5 {
                keyframes.push(keyframe(&walls, door, 1.0 + 1.3 * f64::from(step), 1.57));
            }
        }
        LocalisationMap::new(keyframes)
    }

    fn at(x: f64, y: f64, yaw: f64) -> Isometry {
        Isometry::from_parts(Vector3::new(x, y, 0.0).into(), so3::exp(&(Vector3::z() * yaw)))
    }

    #[test]
    fn out_of_one_of_two_rooms_that_are_alike_it_leads_through_the_door() {
        let guide = guide();
        let places = [at(4.0, 6.0, 0.4), at(24.0, 6.0, 0.4)];
        let way: Vec<Vector3> = guide
            .way_to_tell(&places)
            .iter()
            .map(|at| (places[0] * nalgebra::Point3::from(*at)).coords)
            .collect();
        let Some(end) = way.last() else { panic!("there is no way") };
        assert!((way[0] - places[0].translation.vector).norm() <= STEP, "{way:?}");
        assert!(end.y < 2.5, "{way:?}");
        assert!(way.windows(2).all(|pair| (pair[1] - pair[0]).norm() <= STEP), "{way:?}");
        assert!(way.iter().all(|at| at.y < 1.2 || (at.x - 4.0).abs() < 0.1), "not through the wall: {way:?}");
    }

    #[test]
    fn where_nothing_differs_there_is_no_way() {
        let guide = guide();
        let one = at(4.0, 6.0, 0.4);
        assert_eq!(guide.way_to_tell(&[one]), Vec::<Vector3>::new());
        assert_eq!(guide.way_to_tell(&[one, one]), Vec::<Vector3>::new());
        assert_eq!(guide.way_to_tell(&[]), Vec::<Vector3>::new());
    }
}
