//! The findings that the odometry publishes, by key: faults of a sensor or its setup, each with its remedy. All texts of this crate stand here, in English.

use crate::event::{Finding, FindingKind, Severity, milliseconds};
use crate::initial_alignment::{InitialAlignment, InitialAlignmentConfig};
use geometry::{Rotation, STANDARD_GRAVITY_M_S2, Vector3};
use vocab::Span;

/// Checks gravity, mounting and standstill at the start.
pub fn at_start(
    alignment: &InitialAlignment,
    base_from_imu: &Rotation,
    config: &InitialAlignmentConfig,
) -> Vec<Finding> {
    let mut found = Vec::new();
    let length = alignment.up.norm();
    if (length - STANDARD_GRAVITY_M_S2).abs() > config.gravity_tolerance_m_s2 {
        let remedy = if (length - 1.0).abs() < config.gravity_multiple_tolerance {
            "It seems to report multiples of gravity: have its driver report m/s²."
        } else {
            "Check the accelerometer's unit and range, and that it reports gravity too."
        };
        found.push(Finding {
            kind: FindingKind::GravityImplausible,
            severity: Severity::Error,
            what: format!("The accelerometer reads {length:.2} m/s² at rest instead of 9.81."),
            remedy: remedy.into(),
        });
    }
    let up_in_base = base_from_imu * alignment.up;
    let tilt = up_in_base.angle(&Vector3::z());
    if tilt > config.max_tilt_rad {
        let what = if tilt > config.upside_down_rad {
            "The IMU is mounted upside down"
        } else {
            "Gravity does not point down"
        };
        found.push(Finding {
            kind: FindingKind::MountingTilted,
            severity: Severity::Error,
            what: format!(
                "{what}: with the given mounting, up is {:.0} degrees away from the base's z axis.",
                tilt.to_degrees()
            ),
            remedy: "Correct the rotation of base_from_imu, or set the robot upright before starting.".into(),
        });
    }
    if !alignment.is_stationary {
        found.push(Finding {
            kind: FindingKind::NotStationary,
            severity: Severity::Info,
            what: "The robot moved at the start, so gravity and gyroscope bias are first guesses.".into(),
            remedy: "Let the robot stand still for a second when starting; the estimate improves by itself."
                .into(),
        });
    }
    found
}

/// The clocks of IMU and LiDAR have no common time.
pub fn clocks_apart(imu_ahead: Span) -> Finding {
    Finding {
        kind: FindingKind::ClocksApart,
        severity: Severity::Error,
        what: format!(
            "The IMU's clock is {} ms {} the LiDAR's; the IMU is not used.",
            milliseconds(imu_ahead).abs(),
            if imu_ahead > Span::ZERO { "ahead of" } else { "behind" }
        ),
        remedy: "Synchronise both sensors to one clock (PTP or the host's), then start again.".into(),
    }
}

/// The stamps of the IMU are `lag_s` seconds behind those of the LiDAR; negative if they are ahead.
pub fn imu_lag(lag_s: f64) -> Finding {
    Finding {
        kind: FindingKind::ImuLag,
        severity: Severity::Warning,
        what: format!(
            "The IMU's stamps are about {:.0} ms {} the LiDAR's.",
            lag_s.abs() * 1e3,
            if lag_s > 0.0 { "behind" } else { "ahead of" }
        ),
        remedy:
            "Synchronise both sensors to one clock (PTP or a trigger), or correct the offset in the driver."
                .into(),
    }
}

/// LiDAR and IMU measure rotations about different axes.
pub fn mounting_inconsistent(correlation: f64) -> Finding {
    Finding {
        kind: FindingKind::MountingInconsistent,
        severity: Severity::Error,
        what: format!(
            "LiDAR and IMU do not turn about the same axes (correlation {correlation:.2}): the given mounting of one is wrong."
        ),
        remedy: "Check the rotations of base_from_lidar and base_from_imu.".into(),
    }
}

/// The IMU reached the end of its range.
pub fn saturated() -> Finding {
    Finding {
        kind: FindingKind::ImuSaturated,
        severity: Severity::Warning,
        what: "The IMU reads the same extreme value again and again: the motion exceeds its range.".into(),
        remedy: "Set a larger range in the IMU's driver, or mount it on dampers away from impacts.".into(),
    }
}

/// The IMU is expected, and sends nothing.
pub fn silent_imu() -> Finding {
    silent("IMU", "Check its cable, power and driver.")
}

/// The LiDAR has sent scans, and sends nothing any more.
pub fn silent_lidar() -> Finding {
    silent("LiDAR", "Check its cable, power, address and driver.")
}

fn silent(source: &str, remedy: &str) -> Finding {
    Finding {
        kind: FindingKind::SourceSilent,
        severity: Severity::Warning,
        what: format!("The {source} is silent; the other sources carry on without it."),
        remedy: remedy.into(),
    }
}

/// No scan fitted the local map for long, so the map was begun anew.
pub fn tracking_lost() -> Finding {
    Finding {
        kind: FindingKind::TrackingLost,
        severity: Severity::Warning,
        what: "The scans did not fit what was seen before, so the odometry began a new local map: how far the robot \
               went meanwhile is a guess."
            .into(),
        remedy: "If nobody carried the robot, use the IMU and the legs as well, or walk more slowly through doors and turns."
            .into(),
    }
}

/// The scans do not say when each point was measured.
pub fn missing_times() -> Finding {
    Finding {
        kind: FindingKind::MissingPointTimes,
        severity: Severity::Warning,
        what: "The scans do not say when each point was measured, so motion during the sweep cannot be taken out."
            .into(),
        remedy: "Switch on per-point times in the LiDAR's driver, unless the scans are corrected already.".into(),
    }
}

/// Stamps of a source went backwards or repeated.
pub fn backwards(source: &str) -> Finding {
    Finding {
        kind: FindingKind::StampsBackwards,
        severity: Severity::Warning,
        what: format!("Stamps of the {source} went backwards or repeated; those messages are ignored."),
        remedy: "Check the clock of the sensor and that the recording is in order of time.".into(),
    }
}
