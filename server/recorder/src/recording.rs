//! One interface to every kind of recording: its content, the mounting of the sensors, and its messages in order.

use crate::containers::{self, Container, MessageEncoding, MessageOrder, RawMessage, Topic};
use crate::decode;
use crate::error::{OpenError, ReadError};
use crate::frames;
use crate::info::{self, InfoSource, RecordingInfo, ScanLayout};
use crate::selection::{self, TopicRole, TopicSelection};
use crate::texts;
use crate::writer::SEGMENT_KEY;
use formats::ros::{Imu, Odometry, RosMessage, TfMessage, TransformStamped};
use messages::{Input, Mounting, Sensor};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vocab::{Pose, Stamp};

/// An opened recording: the topics and their roles. Messages are read from the file when needed.
pub struct Recording {
    path: PathBuf,
    format: String,
    container: Arc<dyn Container>,
    /// Role of each topic of the container; `None` if it is not used.
    roles: Vec<Option<TopicRole>>,
    mounting: Mounting,
    first_scan: Option<ScanLayout>,
    notes: Vec<String>,
}

impl Recording {
    /// As [`Recording::open`], but the first segment of a run is opened with all that follow it.
    ///
    /// # Errors
    /// As [`Recording::open`].
    pub fn open_run(path: &Path, topics: &TopicSelection) -> Result<Self, OpenError> {
        Self::of_container(path, containers::open_run(path)?, topics)
    }

    /// Opens an MCAP file, a rosbag2 folder or database, a ROS 1 bag, a folder of scans or a single scan.
    ///
    /// # Errors
    /// When there is nothing to read, the kind is unknown, or a named topic is missing or of a wrong type.
    pub fn open(path: &Path, topics: &TopicSelection) -> Result<Self, OpenError> {
        Self::of_container(path, containers::open(path)?, topics)
    }

    fn of_container(
        path: &Path,
        (format, container): (String, Arc<dyn Container>),
        topics: &TopicSelection,
    ) -> Result<Self, OpenError> {
        let mut recording = Self {
            path: path.to_owned(),
            format,
            roles: vec![None; container.topics().len()],
            container,
            mounting: Mounting::default(),
            first_scan: None,
            notes: Vec::new(),
        };
        recording.assign(topics)?;
        recording.mounting = recording.find_mounting();
        Ok(recording)
    }

    /// Description of the recording, for the terminal and for `--json`.
    pub fn info(&self) -> RecordingInfo {
        info::describe(InfoSource {
            path: &self.path,
            format: &self.format,
            span: self.container.span(),
            topics: self.topics().collect(),
            first_scan: self.first_scan.as_ref(),
            mounting: self.mounting,
            warnings: self.container.warnings().iter().chain(&self.notes).cloned().collect(),
        })
    }

    /// Mounting of the sensors, from static transforms. The base is `base_link` (or a similar name) if there is one,
    /// else the LiDAR.
    pub fn mounting(&self) -> Mounting {
        self.mounting
    }

    /// Checks that there are LiDAR scans, without which no map can be made.
    ///
    /// # Errors
    /// One sentence that names the topics of the recording.
    pub fn require_scans(&self) -> Result<(), OpenError> {
        if self.topic_of(TopicRole::Lidar).is_some() {
            return Ok(());
        }
        let kinds: Vec<String> = self
            .container
            .topics()
            .iter()
            .filter(|topic| topic.count > 0)
            .map(|topic| format!("{} ({})", topic.name, topic.type_name))
            .collect();
        let problem = match kinds.is_empty() {
            true => texts::NO_MESSAGES.to_owned(),
            false => texts::no_scans_among(&texts::list_of(&kinds)),
        };
        Err(OpenError::Nothing { path: self.path.clone(), problem })
    }

    /// Sensor messages in the order of arrival, each with its log time. Memory does not grow with the
    /// length of the recording. After an error the iteration continues with the next message.
    pub fn inputs(&self) -> Inputs {
        let roles = self.roles.clone();
        let wanted = self.wanted(|role| !matches!(role, TopicRole::Tf | TopicRole::Truth));
        Inputs {
            messages: self.container.messages(&wanted, MessageOrder::LogTime),
            latest: vec![None; roles.len()],
            container: self.container.clone(),
            roles,
            dropped_points: 0,
        }
    }

    /// The inputs of the stack, bit for bit and in the same order.
    ///
    /// # Errors
    /// When the recording was not written by the platform, its journal has an unknown version, or it does not begin with the boot of its run.
    pub fn journal(
        &self,
    ) -> Result<impl Iterator<Item = Result<(Stamp, Input), ReadError>> + Send, ReadError> {
        let journal = self.container.topics().iter().find(|topic| topic.name == crate::topics::INPUT);
        let Some(topic) = journal else { return Err(ReadError::NotAJournal) };
        if !decode::is_known_journal(&topic.type_name) {
            return Err(ReadError::OtherJournalVersion { found: topic.type_name.clone() });
        }
        let segment = self.container.metadata(SEGMENT_KEY);
        if let Some(number) = segment.filter(|number| *number != "0") {
            return Err(ReadError::NotFromBoot { path: self.path.clone(), segment: number.to_owned() });
        }
        let roles: Vec<_> = self.topics().map(|(topic, _)| crate::journal_role(&topic.name)).collect();
        let wanted: Vec<bool> = roles.iter().map(Option::is_some).collect();
        let container = self.container.clone();
        let messages = self.container.messages(&wanted, MessageOrder::File);
        Ok(messages.filter_map(move |raw| {
            let decoded = raw.and_then(|raw| {
                let role = roles[raw.topic].unwrap_or(TopicRole::Journal);
                let input = decode::input(&raw, &container.topics()[raw.topic], role)?;
                Ok(input.map(|input| (raw.at, input)))
            });
            decoded.transpose()
        }))
    }

    /// Ground truth, if the recording has it: poses of the base in a fixed frame, which need not be the map frame.
    ///
    /// # Errors
    /// When the poses cannot be read.
    pub fn truth(&self) -> Result<Option<Vec<(Stamp, Pose)>>, ReadError> {
        let wanted = self.wanted(|role| role == TopicRole::Truth);
        if !wanted.contains(&true) {
            return Ok(None);
        }
        let mut poses = Vec::new();
        for raw in self.container.messages(&wanted, MessageOrder::LogTime) {
            let raw = raw?;
            poses.extend(decode::truth(&raw, &self.container.topics()[raw.topic])?);
        }
        Ok(Some(poses))
    }

    /// Topics with their roles.
    fn topics(&self) -> impl Iterator<Item = (&Topic, Option<TopicRole>)> {
        self.container.topics().iter().zip(self.roles.iter().copied())
    }

    fn wanted(&self, is_wanted: impl Fn(TopicRole) -> bool) -> Vec<bool> {
        self.roles.iter().map(|role| role.is_some_and(&is_wanted)).collect()
    }

    /// Assigns a topic to every role: the topic that the caller named, else the best candidate.
    fn assign(&mut self, selection: &TopicSelection) -> Result<(), OpenError> {
        let topics = self.container.topics().to_vec();
        for (topic, role) in topics.iter().zip(&mut self.roles) {
            *role = selection::guess_role(topic).filter(|_| topic.count > 0);
        }
        for (role, name) in selection.named() {
            let index = self.find_named(&topics, role, name)?;
            for (i, other) in self.roles.iter_mut().enumerate() {
                if *other == Some(role) && i != index {
                    *other = None;
                }
            }
            self.roles[index] = Some(role);
        }
        for role in
            [TopicRole::Lidar, TopicRole::Imu, TopicRole::Legs, TopicRole::External, TopicRole::Battery]
        {
            self.select_best_topic(&topics, role);
        }
        Ok(())
    }

    fn find_named(&self, topics: &[Topic], role: TopicRole, name: &str) -> Result<usize, OpenError> {
        let Some(index) = topics.iter().position(|topic| topic.name == name) else {
            let present: Vec<&str> = topics.iter().map(|topic| topic.name.as_str()).collect();
            return Err(OpenError::NoSuchTopic {
                path: self.path.clone(),
                topic: name.to_owned(),
                present: if present.is_empty() { "none".into() } else { texts::list_of(&present) },
            });
        };
        if !selection::can_serve(&topics[index], role) {
            return Err(OpenError::WrongTopicType {
                topic: name.to_owned(),
                type_name: topics[index].type_name.clone(),
                purpose: role.name().to_owned(),
            });
        }
        Ok(index)
    }

    /// Keeps the candidate for a role that has the most data, and adds a note if there are several.
    fn select_best_topic(&mut self, topics: &[Topic], role: TopicRole) {
        let candidates: Vec<usize> =
            (0..topics.len()).filter(|index| self.roles[*index] == Some(role)).collect();
        let layouts: Vec<Option<ScanLayout>> = candidates
            .iter()
            .map(|index| (role == TopicRole::Lidar).then(|| self.scan_layout(*index)).flatten())
            .collect();
        let weight = |nth: &usize| {
            let points = layouts[*nth].as_ref().map_or(1, |scan_layout| scan_layout.points as u64);
            topics[candidates[*nth]].count.saturating_mul(points)
        };
        // Of equal candidates the first is kept, because topics of a file have a fixed order.
        let best = (0..candidates.len()).rev().max_by_key(weight);
        let Some(best) = best else { return };
        self.first_scan = self.first_scan.take().or(layouts[best].clone());
        if candidates.len() > 1 {
            let others: Vec<&str> = candidates
                .iter()
                .filter(|index| **index != candidates[best])
                .map(|index| topics[*index].name.as_str())
                .collect();
            self.notes.push(texts::several_topics(
                candidates.len(),
                role.name(),
                &topics[candidates[best]].name,
                &texts::list_of(&others),
            ));
        }
        for index in candidates.iter().filter(|index| **index != candidates[best]) {
            self.roles[*index] = None;
        }
    }

    fn scan_layout(&self, topic: usize) -> Option<ScanLayout> {
        let raw = self.first_message(topic)?;
        if let Some(scan) = decode::range_image(&raw, &self.container.topics()[topic]).ok()? {
            return Some(ScanLayout {
                points: scan.xyz.len(),
                has_times: !scan.offset_ns.is_empty(),
                has_rings: !scan.ring.is_empty(),
                frame_id: crate::topics::LIDAR_FRAME.to_owned(),
            });
        }
        let cloud = decode::cloud(&raw, &self.container.topics()[topic]).ok()??;
        Some(ScanLayout {
            points: cloud.table.len(),
            has_times: cloud.table.has_times(),
            has_rings: cloud.table.has_rings(),
            frame_id: cloud.header.frame_id,
        })
    }

    fn first_message(&self, topic: usize) -> Option<RawMessage> {
        let wanted: Vec<bool> = (0..self.roles.len()).map(|index| index == topic).collect();
        self.container.messages(&wanted, MessageOrder::LogTime).find_map(Result::ok)
    }

    fn ros_encoding(&self, topic: usize) -> Option<formats::cdr::Encoding> {
        match self.container.topics()[topic].encoding {
            MessageEncoding::Ros(encoding) => Some(encoding),
            _ => None,
        }
    }

    fn topic_of(&self, role: TopicRole) -> Option<usize> {
        self.roles.iter().position(|other| *other == Some(role))
    }

    fn find_mounting(&self) -> Mounting {
        let imu = self.first_ros::<Imu>(TopicRole::Imu).map(|imu| imu.header.frame_id);
        let external =
            self.first_ros::<Odometry>(TopicRole::External).map(|odometry| odometry.child_frame_id);
        let names = frames::SensorFrames {
            lidar: self.first_scan.as_ref().map(|scan_layout| scan_layout.frame_id.clone()),
            imu,
            external,
        };
        let standing_height_m =
            self.container.metadata("standing_height_m").and_then(|text| text.parse().ok());
        Mounting { standing_height_m, ..frames::mounting(&self.static_transforms(), &names) }
    }

    fn first_ros<M: RosMessage>(&self, role: TopicRole) -> Option<M> {
        let topic = self.topic_of(role)?;
        M::from_bytes(self.ros_encoding(topic)?, self.first_message(topic)?.bytes()).ok()
    }

    fn static_transforms(&self) -> Vec<TransformStamped> {
        let wanted = self.wanted(|role| role == TopicRole::Tf);
        if !wanted.contains(&true) {
            return Vec::new();
        }
        let messages = self.container.messages(&wanted, MessageOrder::LogTime).filter_map(Result::ok);
        messages
            .filter_map(|raw| TfMessage::from_bytes(self.ros_encoding(raw.topic)?, raw.bytes()).ok())
            .flat_map(|message| message.transforms)
            .collect()
    }
}

/// Iterator over sensor messages. See [`Recording::inputs`].
pub struct Inputs {
    messages: containers::Messages,
    container: Arc<dyn Container>,
    roles: Vec<Option<TopicRole>>,
    /// Stamp of the last message of each topic.
    latest: Vec<Option<Stamp>>,
    dropped_points: u64,
}

impl Inputs {
    /// Points left out so far because they were not finite or had no return.
    pub fn dropped_points(&self) -> u64 {
        self.dropped_points
    }

    fn decode(&mut self, raw: &RawMessage) -> Result<Option<(Stamp, Sensor)>, ReadError> {
        let topic = &self.container.topics()[raw.topic];
        let Some(role) = self.roles[raw.topic] else { return Ok(None) };
        if role == TopicRole::Journal {
            return Ok(match decode::input(raw, topic, role)? {
                Some(Input::Sensor(sensor)) => Some((raw.at, sensor)),
                _ => None,
            });
        }
        let Some((sensor, report)) = decode::sensor(raw, topic, role)? else { return Ok(None) };
        self.dropped_points += report.dropped.total() as u64;
        let stamp = sensor.stamp();
        if let Some(last) = self.latest[raw.topic].filter(|last| stamp < *last) {
            let by = (last - stamp).secs_f64();
            return Err(ReadError::Backward { topic: topic.name.clone(), at: raw.at, by });
        }
        self.latest[raw.topic] = Some(stamp);
        if matches!(&sensor, Sensor::Scan(scan) if scan.xyz.is_empty()) {
            let points = report.dropped.total();
            return Err(ReadError::EmptyScan { topic: topic.name.clone(), at: raw.at, points });
        }
        Ok(Some((raw.at, sensor)))
    }
}

impl Iterator for Inputs {
    type Item = Result<(Stamp, Sensor), ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let decoded = match self.messages.next()? {
                Ok(raw) => self.decode(&raw),
                Err(error) => Err(error),
            };
            if let Some(item) = decoded.transpose() {
                return Some(item);
            }
        }
    }
}
