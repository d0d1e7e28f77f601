//! What an action has found: the JSON of its result, the same for all actions. Files are not in it; it names them by their content.

use crate::GaugeReport;
use serde::{Deserialize, Serialize};
use vocab::{BlobHash, CameraAim, Covariance6, MapId, Pose, Stamp, Vec3};

/// Result of an action. What an action does not have is left out of the JSON.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ActionReport {
    /// When it was done.
    pub at: ReportTime,
    /// Where the robot was, by its own estimate; none if it did not know.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<ReportPlace>,
    /// What was gathered, the most important file first. Each is on the disk, and served under `/api/v1/blobs/{blob}`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<ReportFile>,
    /// The camera, for pictures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraReport>,
    /// What was measured.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<Reading>,
    /// What became of the gauge of the inspection point; none if it has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gauge: Option<GaugeReport>,
}

/// When something was done, on both clocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReportTime {
    /// The robot's clock.
    pub robot_time: Stamp,
    /// UTC, nanoseconds since 1970, as the robot's computer has it.
    pub utc_ns: i64,
    /// Whether that clock follows a time server.
    pub is_synchronised: bool,
}

/// Where the robot was, by its own estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReportPlace {
    /// The saved map; none in a map under construction.
    pub map: Option<MapId>,
    /// The base in that map.
    pub map_from_base: Pose,
    /// Of `map_from_base`.
    pub covariance: Covariance6,
    /// How far that is to be trusted.
    pub quality: LocalisationQuality,
}

/// How far the robot's pose is to be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LocalisationQuality {
    /// No saved map is in use: the pose is that of a map under construction or of odometry.
    NoSavedMap,
    /// The robot searches for its pose in the saved map.
    Lost,
    /// The pose is known.
    Good,
    /// The pose is known, and something speaks against it.
    Degraded,
}

/// A file that an action has gathered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReportFile {
    /// For people, with an ending: `photo.jpg`.
    pub name: String,
    /// What it is, such as `image/jpeg`.
    pub media_type: String,
    /// BLAKE3 of its bytes.
    pub blob: BlobHash,
    /// Its length.
    pub bytes: u64,
}

/// The camera at the time of a picture: a pinhole model without distortion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraReport {
    /// Where the head pointed, frame of the base.
    pub aim: CameraAim,
    /// Columns and rows.
    pub size_px: [u32; 2],
    /// Focal length, pixels, along both axes.
    pub focal_px: f64,
    /// Principal point, pixels from the outer corner of the top left pixel.
    pub centre_px: [f64; 2],
    /// The camera in the base: x right, y down, z ahead.
    pub base_from_camera: Pose,
    /// What was aimed at, metres, map frame; none where the aim was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target_m: Option<Vec3>,
    /// What the map shows between camera and target; none where nothing was aimed at, or no map could be looked at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line_of_sight: Option<LineOfSight>,
}

/// What a saved map shows between the camera and its target. Doors that have opened since, and people, are not in a map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LineOfSight {
    /// From the camera to the target, metres.
    pub distance_m: f64,
    /// From the camera to the first thing that stands in the way, metres; none: the view is free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obstacle_at_m: Option<f64>,
}

/// A number that was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// What it is, such as `temperature`.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its standard deviation, if that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_deviation: Option<f64>,
    /// Its unit, such as `°C`.
    pub unit: String,
}

/// A gamma spectrum, as it is stored: JSON in a file of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GammaSpectrum {
    /// Time for which it was measured, seconds.
    pub live_time_s: f64,
    /// Energy at the lower edge of the first channel, keV.
    pub first_kev: f64,
    /// Width of a channel, keV.
    pub channel_kev: f64,
    /// Events by channel.
    pub counts: Vec<u32>,
}

impl GammaSpectrum {
    /// Events in channels whose middle lies in a range of energies, keV.
    pub fn counts_between(&self, low_kev: f64, high_kev: f64) -> u64 {
        let middle = |channel: usize| self.first_kev + (channel as f64 + 0.5) * self.channel_kev;
        let inside = self.counts.iter().enumerate().filter(|(channel, _)| {
            let energy = middle(*channel);
            (low_kev..high_kev).contains(&energy)
        });
        inside.map(|(_, count)| u64::from(*count)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_without_files_and_camera_is_short_and_reads_back() {
        let reading =
            Reading { name: "temperature".into(), value: 21.5, standard_deviation: None, unit: "°C".into() };
        let report = ActionReport { readings: vec![reading], ..ActionReport::default() };
        let json = serde_json::to_string(&report).expect("plain data");
        assert!(!json.contains("files") && !json.contains("camera") && !json.contains("null"), "{json}");
        assert_eq!(serde_json::from_str::<ActionReport>(&json).expect("reads"), report);
    }

    #[test]
    fn events_are_counted_by_the_middle_of_their_channel() {
        let spectrum =
            GammaSpectrum { live_time_s: 1.0, first_kev: 0.0, channel_kev: 3.0, counts: vec![1, 2, 4, 8] };
        assert_eq!(spectrum.counts_between(3.0, 9.0), 6);
        assert_eq!(spectrum.counts_between(0.0, 12.0), 15);
    }
}
