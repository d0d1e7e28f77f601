//! The role of each topic: guessed from its type and name, or chosen by the caller.

use crate::containers::{MessageEncoding, Topic};
use crate::topics;
use formats::ros::{self, RosMessage};
use serde::Serialize;

/// The role of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TopicRole {
    /// LiDAR sweeps.
    Lidar,
    /// Inertial samples.
    Imu,
    /// Leg or wheel odometry.
    Legs,
    /// Visual or other odometry.
    External,
    /// State of the battery.
    Battery,
    /// Static transforms.
    Tf,
    /// Ground truth.
    Truth,
    /// Inputs of the stack other than sensor messages.
    Journal,
}

impl TopicRole {
    /// The role's name in messages for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lidar => "LiDAR",
            Self::Imu => "IMU",
            Self::Legs => "legs",
            Self::External => "odometry",
            Self::Battery => "battery",
            Self::Tf => "mounting",
            Self::Truth => "truth",
            Self::Journal => "journal",
        }
    }

    fn accepts(self, type_name: &str) -> bool {
        match self {
            Self::Lidar => [ros::PointCloud2::TYPE, topics::RANGE_IMAGE_SCHEMA].contains(&type_name),
            Self::Imu => type_name == ros::Imu::TYPE,
            Self::Legs | Self::External => type_name == ros::Odometry::TYPE,
            Self::Battery => type_name == ros::BatteryState::TYPE,
            Self::Tf => is_tf(type_name),
            Self::Truth => [ros::PoseStamped::TYPE, ros::Odometry::TYPE].contains(&type_name),
            Self::Journal => false,
        }
    }
}

/// Topics named by the caller. For a role without one, the topic is guessed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs, reason = "the fields are named after the roles")]
pub struct TopicSelection {
    pub lidar: Option<String>,
    pub imu: Option<String>,
    pub legs: Option<String>,
    pub external: Option<String>,
    pub battery: Option<String>,
    pub truth: Option<String>,
}

impl TopicSelection {
    /// Adds a choice in the form `lidar=/points`.
    ///
    /// # Errors
    /// A sentence for people if the text has another form.
    pub fn choose(&mut self, text: &str) -> Result<(), String> {
        let explain =
            || format!("'{text}' is not PURPOSE=TOPIC with lidar, imu, legs, external, battery or truth");
        let (purpose, topic) = text.split_once('=').ok_or_else(explain)?;
        let slot = match purpose.trim().to_ascii_lowercase().as_str() {
            "lidar" => &mut self.lidar,
            "imu" => &mut self.imu,
            "legs" => &mut self.legs,
            "external" | "odometry" | "visual" => &mut self.external,
            "battery" => &mut self.battery,
            "truth" => &mut self.truth,
            _ => return Err(explain()),
        };
        *slot = Some(topic.trim().to_owned());
        Ok(())
    }

    pub(crate) fn named(&self) -> impl Iterator<Item = (TopicRole, &str)> {
        [
            (TopicRole::Lidar, &self.lidar),
            (TopicRole::Imu, &self.imu),
            (TopicRole::Legs, &self.legs),
            (TopicRole::External, &self.external),
            (TopicRole::Battery, &self.battery),
            (TopicRole::Truth, &self.truth),
        ]
        .into_iter()
        .filter_map(|(role, topic)| topic.as_deref().map(|topic| (role, topic)))
    }
}

/// Whether a topic of this type can have a role.
pub(crate) fn can_serve(topic: &Topic, role: TopicRole) -> bool {
    match topic.encoding {
        MessageEncoding::ScanFile(_) => role == TopicRole::Lidar,
        _ => role.accepts(&topic.type_name),
    }
}

/// Guesses the role of a topic from its type and name.
pub(crate) fn guess_role(topic: &Topic) -> Option<TopicRole> {
    let name = topic.name.to_ascii_lowercase();
    let named = |words: &[&str]| words.iter().any(|word| name.contains(word));
    let truth = named(&["truth", "mocap", "/gt"]);
    match topic.type_name.as_str() {
        _ if topic.name == topics::INPUT => Some(TopicRole::Journal),
        _ if matches!(topic.encoding, MessageEncoding::ScanFile(_)) => Some(TopicRole::Lidar),
        ros::PointCloud2::TYPE | topics::RANGE_IMAGE_SCHEMA => Some(TopicRole::Lidar),
        ros::Imu::TYPE => Some(TopicRole::Imu),
        ros::BatteryState::TYPE => Some(TopicRole::Battery),
        ros::Odometry::TYPE if truth => Some(TopicRole::Truth),
        ros::Odometry::TYPE if named(&["leg", "wheel", "joint"]) => Some(TopicRole::Legs),
        ros::Odometry::TYPE => Some(TopicRole::External),
        ros::PoseStamped::TYPE if truth => Some(TopicRole::Truth),
        name if is_tf(name) && topic.name.ends_with("tf_static") => Some(TopicRole::Tf),
        _ => None,
    }
}

fn is_tf(type_name: &str) -> bool {
    // Old ROS 1 recordings use the type of the package tf, which has the same layout.
    type_name == ros::TfMessage::TYPE || type_name == "tf/tfMessage"
}
