//! Zones of the site: they are kept in the frame of the map, and hold for paths and speeds in the frame of odometry.

use crate::Frames;
use geometry::Vector3;
use navigation::{GroundZones, ZoneArea, ZoneRule};
use vocab::Twist;

/// Parameters of [`MapZones`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZonesConfig {
    /// Factor on the cost of paths in a keep-out zone in which the robot stands: it leaves the zone by a short path. Chosen: a metre in the zone costs as much as ten
    /// outside; any factor far above 1 has this effect.
    pub leaving_cost_factor: f64,
    /// A speed limit holds this far before its zone, metres: a legged robot slows down within it. Chosen: more than the 0.4 m in which the legs stop from 0.9 m/s.
    pub look_ahead_m: f64,
}

impl Default for ZonesConfig {
    fn default() -> Self {
        Self { leaving_cost_factor: 10.0, look_ahead_m: 0.5 }
    }
}

/// A zone that holds now.
#[derive(Clone, Debug, PartialEq)]
pub struct MapZone {
    /// Corners and rule, map frame.
    pub area: ZoneArea,
    /// Lowest and greatest height of the base at which it holds, metres, map frame; none: all heights.
    pub height_m: Option<[f64; 2]>,
}

/// The zones that hold now.
#[derive(Clone, Debug, Default)]
pub struct MapZones {
    config: ZonesConfig,
    zones: Vec<MapZone>,
}

impl MapZones {
    /// Replaces all zones.
    pub fn set(&mut self, zones: Vec<MapZone>) {
        self.zones = zones;
    }

    /// Those that hold at the height of the robot, in the frame of odometry.
    pub fn in_odom(&self, frames: &Frames) -> GroundZones {
        let base = frames.map_from_base().translation.vector;
        let holds = |zone: &&MapZone| zone.height_m.is_none_or(|[low, high]| (low..=high).contains(&base.z));
        let to_odom = |corner: &[f64; 2]| {
            let corner = frames.to_odom(&Vector3::new(corner[0], corner[1], base.z));
            [corner.x, corner.y]
        };
        let areas = self.zones.iter().filter(holds).map(|MapZone { area, .. }| ZoneArea {
            corners_m: area.corners_m.iter().map(to_odom).collect(),
            rule: match area.rule {
                ZoneRule::KeepOut if area.contains([base.x, base.y]) => {
                    ZoneRule::Penalty(self.config.leaving_cost_factor)
                }
                rule => rule,
            },
        });
        GroundZones::new(areas.collect())
    }

    /// The velocity of a robot that walks by itself, no faster than the zones allow where it is and where it comes to next.
    pub fn limited(&self, velocity: Twist, zones: &GroundZones, frames: &Frames) -> Twist {
        let here = frames.odom_from_base.translation.vector;
        let course = frames.odom_from_base.rotation * Vector3::new(velocity.linear.x, velocity.linear.y, 0.0);
        let speed_m_s = course.xy().norm();
        if speed_m_s <= 0.0 {
            return velocity;
        }
        let next = here + course * (self.config.look_ahead_m / speed_m_s);
        let limits = [here, next].into_iter().filter_map(|at| zones.speed_limit_m_s([at.x, at.y]));
        let limit_m_s = limits.fold(speed_m_s, f64::min);
        let mut limited = velocity;
        limited.linear.x *= limit_m_s / speed_m_s;
        limited.linear.y *= limit_m_s / speed_m_s;
        limited
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Isometry, Rotation};
    use vocab::Vec3;

    fn frames(x: f64, y: f64, z: f64) -> Frames {
        // The frame of odometry is turned by a quarter and moved.
        let turn = Rotation::from_euler_angles(0.0, 0.0, std::f64::consts::FRAC_PI_2);
        let map_from_odom = Isometry::from_parts(Vector3::new(1.0, 2.0, 0.0).into(), turn);
        let map_from_base = Isometry::translation(x, y, z);
        Frames { map_from_odom, odom_from_base: map_from_odom.inverse() * map_from_base }
    }

    fn zones(rule: ZoneRule, height_m: Option<[f64; 2]>) -> MapZones {
        let corners_m = vec![[4.0, -1.0], [6.0, -1.0], [6.0, 1.0], [4.0, 1.0]];
        let zone = MapZone { area: ZoneArea { corners_m, rule }, height_m };
        MapZones { zones: vec![zone], ..MapZones::default() }
    }

    fn in_odom(frames: &Frames, x: f64, y: f64) -> [f64; 2] {
        let point = frames.to_odom(&Vector3::new(x, y, 0.0));
        [point.x, point.y]
    }

    #[test]
    fn zones_move_with_the_map_and_hold_on_their_floor() {
        let (zones, frames_here) = (zones(ZoneRule::KeepOut, Some([0.0, 1.0])), frames(0.0, 0.0, 0.5));
        let ground = zones.in_odom(&frames_here);
        assert!(ground.is_kept_out(in_odom(&frames_here, 5.0, 0.5)));
        assert!(!ground.is_kept_out(in_odom(&frames_here, 5.0, 1.5)));
        assert_eq!(zones.in_odom(&frames(0.0, 0.0, 3.5)), GroundZones::default(), "the floor above");
    }

    #[test]
    fn a_robot_in_a_keep_out_zone_may_leave_it() {
        let frames_inside = frames(5.0, 0.0, 0.5);
        let ground = zones(ZoneRule::KeepOut, None).in_odom(&frames_inside);
        assert_eq!(ground.cost_factor(in_odom(&frames_inside, 5.0, 0.5)), Some(10.0));
    }

    #[test]
    fn speed_is_limited_in_the_zone_and_just_before_it() {
        let speed = |x: f64, forward: f64| {
            let frames = frames(x, 0.0, 0.5);
            let zones = zones(ZoneRule::SpeedLimit(0.3), None);
            let velocity = Twist { linear: Vec3::new(forward, 0.0, 0.0), angular: Vec3::new(0.0, 0.0, 0.4) };
            let limited = zones.limited(velocity, &zones.in_odom(&frames), &frames);
            assert_eq!(limited.angular, velocity.angular);
            limited.linear.x
        };
        assert!((speed(5.0, 0.9) - 0.3).abs() < 1e-12 && (speed(3.6, 0.9) - 0.3).abs() < 1e-12);
        assert!((speed(3.0, 0.9) - 0.9).abs() < 1e-12 && (speed(6.1, 0.9) - 0.9).abs() < 1e-12);
        assert!((speed(6.1, -0.9) + 0.3).abs() < 1e-12, "backwards into it");
        assert_eq!(speed(5.0, 0.0), 0.0);
    }
}
