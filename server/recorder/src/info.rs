//! Description of a recording for `autoinspect info`: its content, the missing inputs and their consequences.

use crate::containers::Topic;
use crate::selection::TopicRole;
use crate::texts;
use messages::Mounting;
use serde::Serialize;
use std::path::Path;
use vocab::Stamp;

/// Description of a recording.
#[derive(Clone, Debug, Serialize)]
pub struct RecordingInfo {
    /// Its file or folder.
    pub path: String,
    /// Kind of file, such as "MCAP" or "ROS 1 bag".
    pub format: String,
    /// Time from the first message to the last, s.
    pub duration: f64,
    /// Log time of the first message.
    pub start: Option<Stamp>,
    /// Log time of the last message.
    pub end: Option<Stamp>,
    /// Every topic, in the order of the file.
    pub topics: Vec<TopicInfo>,
    /// Its sensors, one sentence each.
    pub sensors: Vec<String>,
    /// Missing inputs with their consequence and remedy, one sentence each.
    pub missing: Vec<String>,
    /// Damage, and choices between several topics, one sentence each.
    #[serde(rename = "complaints")]
    pub warnings: Vec<String>,
}

/// Description of a topic.
#[derive(Clone, Debug, Serialize)]
pub struct TopicInfo {
    /// Its name.
    pub name: String,
    /// ROS type, e.g. `sensor_msgs/Imu`.
    pub type_name: String,
    /// Number of messages.
    pub count: u64,
    /// Mean rate of messages, Hz; `None` for fewer than two messages.
    pub hz: Option<f64>,
    /// Its role; `None` if it is not used.
    #[serde(rename = "meaning")]
    pub role: Option<TopicRole>,
}

/// Layout of the scans on a LiDAR topic, from its first message.
#[derive(Clone, Debug, Default)]
pub(crate) struct ScanLayout {
    /// Points in the first scan.
    pub points: usize,
    /// Whether points carry times.
    pub has_times: bool,
    /// Whether points carry the number of their channel.
    pub has_rings: bool,
    /// The sensor's frame.
    pub frame_id: String,
}

/// Input of [`describe`].
pub(crate) struct InfoSource<'a> {
    pub path: &'a Path,
    /// Kind of file, such as "MCAP".
    pub format: &'a str,
    /// Log times of the first and last message.
    pub span: Option<(Stamp, Stamp)>,
    /// Every topic with its role.
    pub topics: Vec<(&'a Topic, Option<TopicRole>)>,
    pub first_scan: Option<&'a ScanLayout>,
    pub mounting: Mounting,
    pub warnings: Vec<String>,
}

/// Describes a recording, for the terminal and for `--json`.
pub(crate) fn describe(source: InfoSource) -> RecordingInfo {
    let InfoSource { path, format, span, topics, first_scan, mounting, warnings } = source;
    let duration = span.map_or(0.0, |(start, end)| (end - start).secs_f64());
    let topics = topics.into_iter().map(|(topic, role)| TopicInfo {
        name: topic.name.clone(),
        type_name: topic.type_name.clone(),
        count: topic.count,
        hz: (topic.count > 1 && duration > 0.0).then(|| (topic.count - 1) as f64 / duration),
        role,
    });
    let topics: Vec<TopicInfo> = topics.collect();
    RecordingInfo {
        path: path.display().to_string(),
        format: format.to_owned(),
        duration,
        start: span.map(|(start, _)| start),
        end: span.map(|(_, end)| end),
        sensors: describe_sensors(&topics, first_scan),
        missing: find_missing(&topics, first_scan, &mounting),
        topics,
        warnings,
    }
}

fn describe_sensors(topics: &[TopicInfo], first_scan: Option<&ScanLayout>) -> Vec<String> {
    let used = topics.iter().filter_map(|topic| Some((topic, topic.role?)));
    used.filter(|(_, role)| !matches!(role, TopicRole::Tf | TopicRole::Truth | TopicRole::Journal))
        .map(|(topic, role)| {
            let rate = topic.hz.map_or("once".to_owned(), |hz| format!("{hz:.1} Hz"));
            let points = match (first_scan, role) {
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

fn find_missing(topics: &[TopicInfo], first_scan: Option<&ScanLayout>, mounting: &Mounting) -> Vec<String> {
    let has = |role| topics.iter().any(|topic| topic.role == Some(role));
    let mut missing = Vec::new();
    let packets = topics.iter().find(|topic| topic.type_name.to_ascii_lowercase().ends_with("scan"));
    let packets = packets.filter(|topic| topic.name.contains("packet"));
    if let Some(topic) = packets.filter(|_| !has(TopicRole::Lidar)) {
        missing.push(texts::only_packets(&topic.name, &topic.type_name));
    }
    let mut note = |is_missing: bool, text: &str| missing.extend(is_missing.then(|| text.to_owned()));
    note(!has(TopicRole::Lidar) && packets.is_none(), texts::NO_SCANS);
    note(first_scan.is_some_and(|scan| !scan.has_times), texts::NO_POINT_TIMES);
    note(!has(TopicRole::Imu), texts::NO_IMU);
    note(!has(TopicRole::Legs) && !has(TopicRole::External), texts::NO_ODOMETRY);
    note(has(TopicRole::Imu) && mounting.base_from_imu.is_none(), texts::NO_IMU_MOUNTING);
    note(has(TopicRole::External) && mounting.base_from_external.is_none(), texts::NO_ODOMETRY_MOUNTING);
    missing
}
