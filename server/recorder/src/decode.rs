//! Decodes the bytes of a topic into the stack's messages.

use crate::containers::{MessageEncoding, RawMessage, Topic};
use crate::error::ReadError;
use crate::legacy::{
    BootRecordV10, INPUT_SCHEMA_V3, INPUT_SCHEMA_V4, INPUT_SCHEMA_V5, INPUT_SCHEMA_V6, INPUT_SCHEMA_V7,
    INPUT_SCHEMA_V8, INPUT_SCHEMA_V9, INPUT_SCHEMA_V10, INPUT_SCHEMA_V11, INPUT_SCHEMA_V12, INPUT_SCHEMA_V13,
    INPUT_SCHEMA_V14, InputV3, InputV4, InputV5, boot_record_v10,
};
use crate::legacy_site::take_site_entry_v13;
use crate::selection::TopicRole;
use crate::texts;
use crate::topics;
use formats::cdr::Encoding;
use formats::ros::{BatteryState, Header, Imu, Odometry, PointCloud2, PoseStamped, RosMessage};
use formats::{FormatError, ScanReport};
use messages::{Input, Scan, Sensor};
use serde::de::DeserializeOwned;
use std::sync::Arc;
use vocab::{Pose, Stamp};

/// The sensor message in `raw`, with the counts of points that were left out of a scan.
pub(crate) fn sensor(
    raw: &RawMessage,
    topic: &Topic,
    role: TopicRole,
) -> Result<Option<(Sensor, ScanReport)>, ReadError> {
    let failed = |source| message_error(raw, topic, source);
    if let Some(scan) = range_image(raw, topic)? {
        return Ok(Some((Sensor::Scan(Arc::new(scan)), ScanReport::default())));
    }
    if role == TopicRole::Lidar {
        let Some(cloud) = cloud(raw, topic)? else { return Ok(None) };
        let (scan, report) = cloud.table.to_scan(Some(cloud.header.stamp)).map_err(failed)?;
        return Ok(Some((Sensor::Scan(Arc::new(scan)), report)));
    }
    let MessageEncoding::Ros(encoding) = topic.encoding else { return Ok(None) };
    let plain = |sensor| Some((sensor, ScanReport::default()));
    let bytes = raw.bytes();
    Ok(match role {
        TopicRole::Imu => plain(Sensor::Imu((&Imu::from_bytes(encoding, bytes).map_err(failed)?).into())),
        TopicRole::Legs => {
            plain(Sensor::Legs((&Odometry::from_bytes(encoding, bytes).map_err(failed)?).into()))
        }
        TopicRole::External => {
            plain(Sensor::Odometry((&Odometry::from_bytes(encoding, bytes).map_err(failed)?).into()))
        }
        TopicRole::Battery => {
            plain(Sensor::Battery((&BatteryState::from_bytes(encoding, bytes).map_err(failed)?).into()))
        }
        TopicRole::Lidar | TopicRole::Tf | TopicRole::Truth | TopicRole::Journal => None,
    })
}

/// The sweep in `raw`, if it is a range image.
pub(crate) fn range_image(raw: &RawMessage, topic: &Topic) -> Result<Option<Scan>, ReadError> {
    if topic.encoding != MessageEncoding::RangeImage {
        return Ok(None);
    }
    let malformed = |error: scan_codec::RangeImageError| FormatError::Malformed {
        what: "range image",
        place: "its content".into(),
        problem: error.to_string(),
    };
    scan_codec::decode(raw.bytes()).map(Some).map_err(|error| message_error(raw, topic, malformed(error)))
}

/// The points in `raw`, with all fields of the file or message.
pub(crate) fn cloud<'a>(raw: &'a RawMessage, topic: &Topic) -> Result<Option<PointCloud2<'a>>, ReadError> {
    let failed = |source| message_error(raw, topic, source);
    Ok(match topic.encoding {
        MessageEncoding::Ros(encoding) => {
            Some(PointCloud2::from_bytes(encoding, raw.bytes()).map_err(failed)?)
        }
        MessageEncoding::ScanFile(format) => {
            let header = Header { stamp: raw.at, frame_id: String::new() };
            Some(PointCloud2 { header, table: format.read(raw.bytes()).map_err(failed)? })
        }
        _ => None,
    })
}

/// The stack's input in `raw`.
pub(crate) fn input(raw: &RawMessage, topic: &Topic, role: TopicRole) -> Result<Option<Input>, ReadError> {
    if role != TopicRole::Journal {
        return Ok(sensor(raw, topic, role)?.map(|(sensor, _)| Input::Sensor(sensor)));
    }
    match decode_journal_entry(&topic.type_name, raw.bytes()) {
        Some(decoded) => decoded.map(Some).map_err(|source| message_error(raw, topic, source)),
        None => Err(ReadError::OtherJournalVersion { found: topic.type_name.clone() }),
    }
}

/// Decodes an entry of the journal that a schema describes; `None` if this program does not know the schema.
pub fn decode_journal_entry(schema: &str, bytes: &[u8]) -> Option<Result<Input, FormatError>> {
    let decoded = match schema {
        topics::INPUT_SCHEMA | INPUT_SCHEMA_V14 => whole(bytes),
        INPUT_SCHEMA_V13 | INPUT_SCHEMA_V12 | INPUT_SCHEMA_V11 => match take_site_entry_v13(bytes) {
            Some(Ok((entry, []))) => Ok(entry.into()),
            Some(Ok(_)) => Err(texts::BYTES_LEFT_OVER.to_owned()),
            Some(Err(error)) => Err(error.to_string()),
            None => whole(bytes),
        },
        // Version 7 differs from version 6 by the range images beside it. The later ones have further entries.
        INPUT_SCHEMA_V10 | INPUT_SCHEMA_V9 | INPUT_SCHEMA_V8 | INPUT_SCHEMA_V7 | INPUT_SCHEMA_V6 => {
            match boot_record_v10(bytes) {
                Some(record) => {
                    whole::<BootRecordV10>(record).map(|record| Input::Boot(Box::new(record.into())))
                }
                None => whole(bytes),
            }
        }
        INPUT_SCHEMA_V5 => whole::<InputV5>(bytes).map(Input::from),
        INPUT_SCHEMA_V4 => whole::<InputV4>(bytes).map(Input::from),
        INPUT_SCHEMA_V3 => whole::<InputV3>(bytes).map(Input::from),
        _ => return None,
    };
    Some(decoded.map_err(|problem| journal_error(&problem)))
}

/// Names of the schemas of journals that can be read, newest first.
pub fn journal_schemas() -> [&'static str; 13] {
    [
        topics::INPUT_SCHEMA,
        INPUT_SCHEMA_V14,
        INPUT_SCHEMA_V13,
        INPUT_SCHEMA_V12,
        INPUT_SCHEMA_V11,
        INPUT_SCHEMA_V10,
        INPUT_SCHEMA_V9,
        INPUT_SCHEMA_V8,
        INPUT_SCHEMA_V7,
        INPUT_SCHEMA_V6,
        INPUT_SCHEMA_V5,
        INPUT_SCHEMA_V4,
        INPUT_SCHEMA_V3,
    ]
}

/// Whether journals of this schema can be read.
pub(crate) fn is_known_journal(schema: &str) -> bool {
    journal_schemas().contains(&schema)
}

/// Decodes a value that must use all bytes.
fn whole<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    match postcard::take_from_bytes(bytes) {
        Ok((value, [])) => Ok(value),
        Ok(_) => Err(texts::BYTES_LEFT_OVER.to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

/// A ground-truth pose with its stamp.
pub(crate) fn truth(raw: &RawMessage, topic: &Topic) -> Result<Option<(Stamp, Pose)>, ReadError> {
    let failed = |source| message_error(raw, topic, source);
    let MessageEncoding::Ros(encoding) = topic.encoding else { return Ok(None) };
    stamped_pose(&topic.type_name, encoding, raw.bytes()).map(Some).map_err(failed)
}

fn stamped_pose(type_name: &str, encoding: Encoding, bytes: &[u8]) -> Result<(Stamp, Pose), FormatError> {
    if type_name == Odometry::TYPE {
        let odometry = Odometry::from_bytes(encoding, bytes)?;
        return Ok((odometry.header.stamp, odometry.pose));
    }
    let pose = PoseStamped::from_bytes(encoding, bytes)?;
    Ok((pose.header.stamp, pose.pose))
}

fn journal_error(problem: &str) -> FormatError {
    FormatError::Malformed { what: "journal entry", place: "its content".into(), problem: problem.into() }
}

fn message_error(raw: &RawMessage, topic: &Topic, source: FormatError) -> ReadError {
    match &raw.file {
        Some(path) => ReadError::Format { path: path.clone(), source },
        None => ReadError::Message { topic: topic.name.clone(), at: raw.at, source },
    }
}
