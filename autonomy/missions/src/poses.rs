//! Geometry of plain poses: distances on the floor, headings, and turns about the vertical.

use vocab::{Pose, Quat, Vec3};

/// Distance on the floor, metres.
pub(crate) fn floor_distance_m(a: &Pose, b: &Pose) -> f64 {
    (a.position.x - b.position.x).hypot(a.position.y - b.position.y)
}

/// Direction of the x axis of a pose on the floor, radians from the x axis of the map to the left. The quaternion is of length 1.
pub(crate) fn heading_rad(pose: &Pose) -> f64 {
    let Quat { w, x, y, z } = pose.orientation;
    (2.0 * (x * y + w * z)).atan2(1.0 - 2.0 * (y * y + z * z))
}

/// Smallest turn from one heading to another, radians, -π to π.
pub(crate) fn turn_between_rad(from_rad: f64, to_rad: f64) -> f64 {
    let (sin, cos) = (to_rad - from_rad).sin_cos();
    sin.atan2(cos)
}

/// Whether a robot that stands in `from` has the other pose ahead of it, and not behind.
pub(crate) fn is_ahead(from: &Pose, to: &Pose) -> bool {
    let (sin, cos) = heading_rad(from).sin_cos();
    let (dx, dy) = (to.position.x - from.position.x, to.position.y - from.position.y);
    cos * dx + sin * dy > 0.0
}

/// The point at a share of the straight line between two poses. Its heading is of no account: it is only passed.
pub(crate) fn point_between(a: &Pose, b: &Pose, share: f64) -> Pose {
    let between = |a: f64, b: f64| a + share * (b - a);
    let (from, to) = (a.position, b.position);
    Pose { position: Vec3::new(between(from.x, to.x), between(from.y, to.y), between(from.z, to.z)), ..*a }
}

/// A pose that is turned to the left about the vertical, where it is.
pub fn turned(pose: &Pose, turn_rad: f64) -> Pose {
    let (sin, cos) = (turn_rad / 2.0).sin_cos();
    let Quat { w, x, y, z } = pose.orientation;
    let orientation =
        Quat { w: cos * w - sin * z, x: cos * x - sin * y, y: cos * y + sin * x, z: cos * z + sin * w };
    Pose { orientation, ..*pose }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn a_turned_pose_has_the_heading_and_stays_where_it_is() {
        let pose = Pose { position: Vec3::new(1.0, 2.0, 3.0), ..Pose::IDENTITY };
        for turn_rad in [-3.0, -FRAC_PI_2, 0.0, 0.7, 3.1] {
            let turned = turned(&pose, turn_rad);
            assert!((heading_rad(&turned) - turn_rad).abs() < 1e-12, "{turn_rad}");
            assert_eq!(turned.position, pose.position);
        }
        // Turns about the vertical add up, and leave a pitch as it is.
        let pitched = Pose {
            orientation: Quat { w: 0.1_f64.cos(), x: 0.0, y: 0.1_f64.sin(), z: 0.0 },
            ..Pose::IDENTITY
        };
        let twice = turned(&turned(&pitched, 0.4), 0.5);
        assert!((heading_rad(&twice) - 0.9).abs() < 1e-12);
        let Quat { w, x, y, z } = twice.orientation;
        let down = 2.0 * (w * y - x * z);
        assert!((down - 0.2_f64.sin()).abs() < 1e-12, "the x axis still points down by 0.2 rad: {down}");
    }

    #[test]
    fn turns_are_the_short_way_round() {
        assert!((turn_between_rad(3.0, -3.0) - (2.0 * PI - 6.0)).abs() < 1e-12);
        assert!((turn_between_rad(-3.0, 3.0) + (2.0 * PI - 6.0)).abs() < 1e-12);
        assert!((turn_between_rad(0.5, 0.2) + 0.3).abs() < 1e-12);
    }

    #[test]
    fn what_is_behind_is_not_ahead() {
        let at = |x: f64| Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::IDENTITY };
        assert!(is_ahead(&at(0.0), &at(1.0)) && !is_ahead(&at(0.0), &at(-1.0)));
        assert!(!is_ahead(&turned(&at(0.0), PI), &at(1.0)));
        assert_eq!(point_between(&at(0.0), &at(4.0), 0.25).position.x, 1.0);
    }
}
