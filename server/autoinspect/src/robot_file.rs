//! The part of a calibration file that describes the robot: body, limits and keyframe policy, for robots that are known from a recording only.
//!
//! Missing entries keep the values of the default profile. The guide page on the robot profile documents every entry.

use crate::failure::Failure;
use crate::texts;
use messages::{RobotProfile, SpeedLimits};
use serde::Deserialize;
use vocab::{Aabb, CameraHead, Span};

/// Entries of `robot` in a calibration file. Lengths are metres, times seconds, angles degrees.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotFile {
    name: Option<String>,
    footprint_radius_m: Option<f64>,
    clearance_height_m: Option<f64>,
    step_height_m: Option<f64>,
    autonomous_limits: Option<Limits>,
    manual_limits: Option<Limits>,
    manual_watchdog_s: Option<f64>,
    self_filter: Option<SelfFilter>,
    keyframe_distance_m: Option<f64>,
    keyframe_rotation_deg: Option<f64>,
    camera_head: Option<HeadEntry>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Limits {
    // Files of earlier programs have the aliases.
    #[serde(alias = "forward_mps")]
    forward_m_s: f64,
    #[serde(alias = "sideways_mps")]
    sideways_m_s: f64,
    #[serde(alias = "turn_degps")]
    turn_deg_s: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SelfFilter {
    min_m: [f32; 3],
    max_m: [f32; 3],
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct HeadEntry {
    base_from_head_m: [f64; 3],
    pan_max_deg: f64,
    tilt_min_deg: f64,
    tilt_max_deg: f64,
    zoom_max: f64,
    field_of_view_deg: f64,
}

impl HeadEntry {
    /// None if it is of no camera.
    fn head(self) -> Option<CameraHead> {
        let is_place = self.base_from_head_m.iter().all(|metres| metres.is_finite());
        let is_reach = (0.0..=180.0).contains(&self.pan_max_deg)
            && -90.0 <= self.tilt_min_deg
            && self.tilt_min_deg <= self.tilt_max_deg
            && self.tilt_max_deg <= 90.0;
        let is_optics = self.zoom_max.is_finite()
            && self.zoom_max >= 1.0
            && self.field_of_view_deg > 0.0
            && self.field_of_view_deg < 180.0;
        (is_place && is_reach && is_optics).then(|| CameraHead {
            base_from_head_m: self.base_from_head_m,
            pan_max_rad: self.pan_max_deg.to_radians(),
            tilt_min_rad: self.tilt_min_deg.to_radians(),
            tilt_max_rad: self.tilt_max_deg.to_radians(),
            zoom_max: self.zoom_max,
            field_of_view_rad: self.field_of_view_deg.to_radians(),
        })
    }
}

impl RobotFile {
    /// Replaces the given entries of a profile. An error names the entry that is no positive number.
    pub fn apply(&self, profile: &mut RobotProfile) -> Result<(), Failure> {
        if let Some(name) = &self.name {
            name.clone_into(&mut profile.name);
        }
        for (entry, given, known) in [
            ("footprint_radius_m", self.footprint_radius_m, &mut profile.footprint_radius_m),
            ("clearance_height_m", self.clearance_height_m, &mut profile.clearance_height_m),
            ("step_height_m", self.step_height_m, &mut profile.step_height_m),
            ("keyframe_distance_m", self.keyframe_distance_m, &mut profile.keyframe_distance_m),
        ] {
            if let Some(given) = given {
                *known = positive(entry, given)?;
            }
        }
        if let Some(degrees) = self.keyframe_rotation_deg {
            profile.keyframe_rotation_rad = positive("keyframe_rotation_deg", degrees)?.to_radians();
        }
        if let Some(seconds) = self.manual_watchdog_s {
            profile.manual_watchdog = Span::from_secs_f64(positive("manual_watchdog_s", seconds)?);
        }
        for (entry, given, known) in [
            ("autonomous_limits", self.autonomous_limits, &mut profile.autonomous_limits),
            ("manual_limits", self.manual_limits, &mut profile.manual_limits),
        ] {
            if let Some(given) = given {
                *known = SpeedLimits {
                    forward_m_s: positive(entry, given.forward_m_s)?,
                    sideways_m_s: positive(entry, given.sideways_m_s)?,
                    turn_rad_s: positive(entry, given.turn_deg_s)?.to_radians(),
                };
            }
        }
        if let Some(SelfFilter { min_m: min, max_m: max }) = self.self_filter {
            let is_box =
                min.iter().zip(&max).all(|(min, max)| min.is_finite() && max.is_finite() && min < max);
            if !is_box {
                return Err(Failure::usage(texts::SELF_FILTER_IS_NO_BOX));
            }
            profile.self_filter = Some(Aabb { min, max });
        }
        if let Some(entry) = self.camera_head {
            profile.camera_head = entry.head().ok_or_else(|| Failure::usage(texts::CAMERA_HEAD_IS_NONE))?;
        }
        Ok(())
    }
}

fn positive(entry: &str, value: f64) -> Result<f64, Failure> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(Failure::usage(texts::robot_entry_not_positive(entry, value)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn applied(text: &str) -> Result<RobotProfile, Failure> {
        let file: RobotFile = serde_json::from_str(text).expect("JSON");
        let mut profile = RobotProfile::default();
        file.apply(&mut profile).map(|()| profile)
    }

    #[test]
    fn given_entries_replace_those_of_the_default_profile_and_the_others_stay() {
        let profile = applied(
            r#"{"footprint_radius_m": 0.5, "keyframe_rotation_deg": 30, "manual_watchdog_s": 0.3,
                "manual_limits": {"forward_m_s": 0.6, "sideways_m_s": 0.2, "turn_deg_s": 45},
                "self_filter": {"min_m": [-0.5, -0.3, -0.4], "max_m": [0.5, 0.3, 0.2]},
                "camera_head": {"base_from_head_m": [0.4, 0, 0.3], "pan_max_deg": 90, "tilt_min_deg": -30,
                    "tilt_max_deg": 45, "zoom_max": 8, "field_of_view_deg": 70}}"#,
        )
        .expect("right");
        let usual = RobotProfile::default();
        assert_eq!(profile.footprint_radius_m, 0.5);
        assert_eq!(profile.step_height_m, usual.step_height_m);
        assert!((profile.keyframe_rotation_rad - 30_f64.to_radians()).abs() < 1e-12);
        assert_eq!(profile.manual_watchdog, Span::from_millis(300));
        assert_eq!(profile.autonomous_limits, usual.autonomous_limits);
        assert!((profile.manual_limits.turn_rad_s - 45_f64.to_radians()).abs() < 1e-12);
        assert_eq!(profile.self_filter.map(|body| body.max), Some([0.5, 0.3, 0.2]));
        let head = profile.camera_head;
        assert_eq!((head.base_from_head_m, head.zoom_max), ([0.4, 0.0, 0.3], 8.0));
        let angles = [head.pan_max_rad, head.tilt_min_rad, head.tilt_max_rad, head.field_of_view_rad];
        assert_eq!(angles, [90.0_f64, -30.0, 45.0, 70.0].map(f64::to_radians));
    }

    #[test]
    fn limits_with_the_names_of_earlier_programs_are_read() {
        let limits = |names: [&str; 3]| {
            let [forward, sideways, turn] = names;
            applied(&format!(r#"{{"manual_limits": {{"{forward}": 0.6, "{sideways}": 0.2, "{turn}": 45}}}}"#))
                .expect("right")
        };
        let earlier = limits(["forward_mps", "sideways_mps", "turn_degps"]);
        assert_eq!(earlier, limits(["forward_m_s", "sideways_m_s", "turn_deg_s"]));
    }

    #[test]
    fn a_wrong_entry_is_named() {
        let Err(failure) = applied(r#"{"step_height_m": -0.2}"#) else { panic!("no step") };
        assert!(failure.to_string().contains("step_height_m"), "{failure}");
        assert!(applied(r#"{"self_filter": {"min_m": [0, 0, 0], "max_m": [0, 1, 1]}}"#).is_err());
        assert!(serde_json::from_str::<RobotFile>(r#"{"step_hight_m": 0.2}"#).is_err());
        let head = |tilt_max_deg: f64, zoom_max: f64| {
            applied(&format!(
                r#"{{"camera_head": {{"base_from_head_m": [0, 0, 0], "pan_max_deg": 0, "tilt_min_deg": 0,
                    "tilt_max_deg": {tilt_max_deg}, "zoom_max": {zoom_max}, "field_of_view_deg": 60}}}}"#
            ))
        };
        assert!(head(0.0, 1.0).is_ok(), "a camera that cannot be aimed");
        assert!(head(-1.0, 1.0).is_err() && head(0.0, 0.5).is_err());
    }
}
