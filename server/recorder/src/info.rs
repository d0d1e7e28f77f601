//! What a recording holds, what it lacks and what that costs: the answer of `autoinspect info`.

use crate::recording::Recording;
use crate::selection::TopicRole;
use serde::Serialize;
use std::path::Path;
use vocab::Stamp;

/// A recording in figures.
#[derive(Clone, Debug, Serialize)]
pub struct RecordingInfo {
    /// Where it is.
    pub path: String,
    /// Kind of file, for people: "MCAP", "ROS 1 bag".
    pub format: String,
    /// Seconds from the first message to the last.
    pub duration: f64,
    /// Log time of the first message.
    pub start: Option<Stamp>,
    /// Log time of the last message.
    pub end: Option<Stamp>,
    /// Every topic, in the order of the file.
    pub topics: Vec<TopicInfo>,
    /// What the sensors are like, one sentence each.
    pub sensors: Vec<String>,
    /// What is missing, what that costs and what to do, one sentence each.
    pub missing: Vec<String>,
    /// What is wrong or was decided, one sentence each.
    #[serde(rename = "complaints")]
    pub warnings: Vec<String>,
}

/// A topic in figures.
#[derive(Clone, Debug, Serialize)]
pub struct TopicInfo {
    /// Its name.
    pub name: String,
    /// ROS type, e.g. `sensor_msgs/Imu`.
    pub type_name: String,
    /// Messages.
    pub count: u64,
    /// Messages a second, on average; `None` for fewer than two.
    pub hz: Option<f64>,
    /// What it is used for, if it is.
    #[serde(rename = "meaning")]
    pub role: Option<TopicRole>,
}

pub(crate) fn describe(
    recording: &Recording,
    path: &Path,
    format: &str,
    span: Option<(Stamp, Stamp)>,
    notes: &[String],
) -> RecordingInfo {
    let duration = span.map_or(0.0, |(start, end)| (end - start).secs_f64());
    let topics: Vec<TopicInfo> = recording
        .topics()
        .map(|(topic, role)| TopicInfo {
            name: topic.name.clone(),
            type_name: topic.type_name.clone(),
            count: topic.count,
            hz: (topic.count > 1 && duration > 0.0).then(|| (topic.count - 1) as f64 / duration),
            role,
        })
        .collect();
    RecordingInfo {
        path: path.display().to_string(),
        format: format.to_owned(),
        duration,
        start: span.map(|(start, _)| start),
        end: span.map(|(_, end)| end),
        sensors: sensors(recording, &topics),
        missing: missing(recording, &topics),
        topics,
        warnings: recording.warnings().iter().chain(notes).cloned().collect(),
    }
}

fn sensors(recording: &Recording, topics: &[TopicInfo]) -> Vec<String> {
    let used = topics.iter().filter_map(|topic| Some((topic, topic.role?)));
    used.filter(|(_, role)| !matches!(role, TopicRole::Tf | TopicRole::Truth | TopicRole::Journal))
        .map(|(topic, role)| {
            let rate = topic.hz.map_or("once".to_owned(), |hz| format!("{hz:.1} Hz"));
            let points = match (&recording.first_scan, role) {
                (Some(scan), TopicRole::Lidar) => format!(
                    ", {} points a scan, {} point times, {} channels",
                    scan.points,
                    if scan.has_times { "with" } else { "without" },
                    if scan.has_rings { "with" } else { "without" },
                ),
                _ => String::new(),
            };
            format!("{} at {rate}{points}, from {}", role.name(), topic.name)
        })
        .collect()
}

fn missing(recording: &Recording, topics: &[TopicInfo]) -> Vec<String> {
    let has = |role| topics.iter().any(|topic| topic.role == Some(role));
    let mut missing = Vec::new();
    let packets = topics.iter().find(|topic| topic.type_name.to_ascii_lowercase().ends_with("scan"));
    let packets = packets.filter(|topic| topic.name.contains("packet"));
    if let Some(topic) = packets.filter(|_| !has(TopicRole::Lidar)) {
        missing.push(format!(
            "There are no LiDAR scans but raw packets on {} ({}), which are not decoded; record the driver's \
             sensor_msgs/PointCloud2 too.",
            topic.name, topic.type_name
        ));
    }
    let mut note = |absent: bool, text: &str| missing.extend(absent.then(|| text.to_owned()));
    note(
        !has(TopicRole::Lidar) && packets.is_none(),
        "There are no LiDAR scans, so no map can be made; record sensor_msgs/PointCloud2.",
    );
    if let Some(scan) = &recording.first_scan {
        note(
            !scan.has_times,
            "Points carry no time, so motion within a sweep is not taken out and fast turns blur the map; switch \
             the time field on in the LiDAR driver (t, time, timestamp or offset_time).",
        );
    }
    note(
        !has(TopicRole::Imu),
        "There is no IMU, so tilt comes from the first scan and fast turns are harder to follow; record \
         sensor_msgs/Imu at 100 Hz or more.",
    );
    note(
        !has(TopicRole::Legs) && !has(TopicRole::External),
        "There is no odometry beside the LiDAR, so long featureless corridors may shrink; record the robot's \
         nav_msgs/Odometry.",
    );
    let mounting = recording.mounting();
    note(
        has(TopicRole::Imu) && mounting.base_from_imu.is_none(),
        "Nothing says where the IMU sits, so it is taken to sit at the base without rotation; record /tf_static or \
         give a calibration.",
    );
    note(
        has(TopicRole::External) && mounting.base_from_external.is_none(),
        "Nothing says where the frame of the odometry sits, so it is taken to be the base; record /tf_static or \
         give a calibration.",
    );
    missing
}
