//! The records of the journal of a mapping session, as bytes.

use messages::{GraphDelta, LoopDecision, PoseGraph};
use serde::{Deserialize, Serialize};
use std::io::{self, Read};
use std::sync::Arc;
use vocab::{MapId, Pose, Stamp};

pub(crate) const MAGIC: [u8; 4] = *b"AISJ";
/// Version that this program writes.
pub(crate) const JOURNAL_FORMAT_VERSION: u32 = 1;
pub(crate) const HEADER_BYTES: u64 = 8;
const FRAME_BYTES: usize = 16;
const CHECKSUM_BYTES: usize = 8;

/// One change of a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum SessionRecord {
    /// State of the session; on every change of it.
    State {
        /// The saved map that it extends, if any.
        extends: Option<MapId>,
        /// Metres walked in it.
        distance_m: f64,
    },
    /// The whole pose graph.
    Graph(Arc<PoseGraph>),
    /// The pose graph changed.
    GraphDelta(Arc<GraphDelta>),
    /// A pair of keyframes was decided on.
    LoopDecided(LoopDecision),
    /// Pose of the base in the map after a scan.
    ScanPose {
        /// The instant of the pose.
        stamp: Stamp,
        /// Base in the map.
        map_from_base: Pose,
    },
}

pub(crate) fn encode(record: &SessionRecord) -> io::Result<Vec<u8>> {
    frame(&postcard::to_stdvec(record).map_err(io::Error::other)?)
}

pub(crate) fn frame(content: &[u8]) -> io::Result<Vec<u8>> {
    let length = u32::try_from(content.len()).map_err(io::Error::other)?;
    let mut bytes = Vec::with_capacity(content.len() + FRAME_BYTES);
    bytes.extend(length.to_le_bytes());
    bytes.extend((!length).to_le_bytes());
    bytes.extend(checksum(content));
    bytes.extend(content);
    Ok(bytes)
}

pub(crate) fn header() -> Vec<u8> {
    let mut header = MAGIC.to_vec();
    header.extend(JOURNAL_FORMAT_VERSION.to_le_bytes());
    header
}

fn checksum(content: &[u8]) -> [u8; CHECKSUM_BYTES] {
    let mut first = [0; CHECKSUM_BYTES];
    first.copy_from_slice(&blake3::hash(content).as_bytes()[..CHECKSUM_BYTES]);
    first
}

pub(crate) enum Frame {
    /// With the bytes that it takes.
    Record(SessionRecord, u64),
    /// The end of the file, or a record that was not written whole.
    End,
    Damaged,
}

/// The next record of a file that has this number of bytes left.
pub(crate) fn read_record(reader: &mut impl Read, left: u64) -> io::Result<Frame> {
    if left < FRAME_BYTES as u64 {
        return Ok(Frame::End);
    }
    let mut frame = [0; FRAME_BYTES];
    reader.read_exact(&mut frame)?;
    let number =
        |from: usize| u32::from_le_bytes([frame[from], frame[from + 1], frame[from + 2], frame[from + 3]]);
    let length = number(0);
    if number(4) != !length {
        return Ok(Frame::Damaged);
    }
    let bytes = FRAME_BYTES as u64 + u64::from(length);
    if left < bytes {
        return Ok(Frame::End);
    }
    let mut content = vec![0; length as usize];
    reader.read_exact(&mut content)?;
    if checksum(&content) != frame[FRAME_BYTES - CHECKSUM_BYTES..] {
        return Ok(Frame::Damaged);
    }
    Ok(match postcard::take_from_bytes(&content) {
        Ok((record, [])) => Frame::Record(record, bytes),
        _ => Frame::Damaged,
    })
}
