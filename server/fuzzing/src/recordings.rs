//! Recordings: their containers, and the messages in them.

use crate::assert_sentence;
use crate::scratch::with_file;
use formats::cdr::Encoding;
use formats::ros::{BatteryState, Imu, Odometry, PointCloud2, PoseStamped, RosMessage, TfMessage};
use formats::{FormatError, rosbag1, rosbag2};
use recorder::{Recording, TopicSelection};
use std::io::Cursor;
use std::path::Path;
use vocab::Stamp;

/// An MCAP file through `recorder::Recording`: its description, its sensors, its journal and its ground truth.
pub fn recording(bytes: &[u8]) {
    with_file("recording.mcap", bytes, read_recording);
}

/// A ROS 1 bag: its index, its chunks, and its sensors through `recorder::Recording`.
pub fn rosbag1(bytes: &[u8]) {
    let mut file = Cursor::new(bytes);
    match rosbag1::read_index(&mut file) {
        Ok(index) => {
            for chunk in &index.chunks {
                match rosbag1::read_chunk(&mut file, chunk.position) {
                    Ok(chunk) => chunk.messages.iter().for_each(|message| {
                        let _ = &chunk.bytes[message.range.clone()];
                    }),
                    Err(error) => assert_sentence(&error),
                }
            }
        }
        Err(error) => assert_sentence(&error),
    }
    with_file("recording.bag", bytes, read_recording);
}

/// The database of a ROS 2 bag, and as text the list of its files.
pub fn rosbag2(bytes: &[u8]) {
    let _ = rosbag2::read_metadata(&String::from_utf8_lossy(bytes));
    with_file("recording.db3", bytes, |path| {
        if let Err(error) = read_database(path) {
            assert_sentence(&error);
        }
        read_recording(path);
    });
}

fn read_database(path: &Path) -> Result<(), FormatError> {
    let database = rosbag2::Database::open(path)?;
    let topics: Vec<i64> = database.topics()?.iter().map(|topic| topic.id).collect();
    database.span()?;
    database.messages_after(&topics, (Stamp::from_nanos(i64::MIN), i64::MIN))?;
    Ok(())
}

fn read_recording(path: &Path) {
    let recording = match Recording::open(path, &TopicSelection::default()) {
        Ok(recording) => recording,
        Err(error) => return assert_sentence(&error),
    };
    let _ = recording.info().to_string();
    if let Err(error) = recording.require_scans() {
        assert_sentence(&error);
    }
    for error in recording.inputs().filter_map(Result::err) {
        assert_sentence(&error);
    }
    match recording.journal() {
        Ok(journal) => journal.filter_map(Result::err).for_each(|error| assert_sentence(&error)),
        Err(error) => assert_sentence(&error),
    }
    if let Err(error) = recording.truth() {
        assert_sentence(&error);
    }
}

/// ROS messages. The first byte chooses type and encoding.
pub fn cdr(bytes: &[u8]) {
    let Some((choice, message)) = bytes.split_first() else { return };
    let encoding = if choice & 0x80 == 0 { Encoding::Cdr } else { Encoding::Ros1 };
    let failed = match choice & 0x7f {
        0 => read_message::<Imu>(encoding, message),
        1 => read_message::<Odometry>(encoding, message),
        2 => read_message::<TfMessage>(encoding, message),
        3 => read_message::<BatteryState>(encoding, message),
        4 => read_message::<PoseStamped>(encoding, message),
        _ => PointCloud2::from_bytes(encoding, message).and_then(|cloud| {
            let _ = (cloud.table.has_times(), cloud.table.has_rings());
            cloud.table.to_scan(Some(cloud.header.stamp)).map(drop)
        }),
    };
    if let Err(error) = failed {
        assert_sentence(&error);
    }
}

fn read_message<M: RosMessage>(encoding: Encoding, bytes: &[u8]) -> Result<(), FormatError> {
    let message = M::from_bytes(encoding, bytes)?;
    let mut written = Vec::new();
    message.to_bytes(encoding, &mut written);
    M::from_bytes(encoding, &written).map(drop)
}

/// Entries of the journal, of every version that can be read. The first byte chooses the version.
pub fn journal(bytes: &[u8]) {
    let Some((choice, entry)) = bytes.split_first() else { return };
    let schemas = recorder::journal_schemas();
    let schema = schemas[usize::from(*choice) % schemas.len()];
    if let Some(Err(error)) = recorder::decode_journal_entry(schema, entry) {
        assert_sentence(&error);
    }
}

/// Scans as range images: `scan_codec`. What is decoded is encoded and decoded again.
///
/// # Panics
/// When a column has another length than the points.
pub fn range_image(bytes: &[u8]) {
    match scan_codec::decode(bytes) {
        Ok(scan) => {
            let columns = [scan.intensity.len(), scan.offset_ns.len(), scan.ring.len()];
            assert!(columns.iter().all(|length| *length == scan.xyz.len() || *length == 0), "{columns:?}");
            let mut again = Vec::new();
            if scan_codec::encode(&scan, &mut again) {
                let decoded = scan_codec::decode(&again).map(|scan| scan.xyz.len());
                assert_eq!(decoded.ok(), Some(scan.xyz.len()));
            }
        }
        Err(error) => assert_sentence(&error),
    }
}
