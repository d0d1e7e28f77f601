use super::*;
use std::io::Cursor;

/// A bag as a recorder writes it, in memory.
struct Maker {
    bytes: Vec<u8>,
}

fn record(fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let mut header = Vec::new();
    for (name, value) in fields {
        header.extend((name.len() as u32 + 1 + value.len() as u32).to_le_bytes());
        header.extend(name.as_bytes());
        header.push(b'=');
        header.extend(*value);
    }
    let mut out = (header.len() as u32).to_le_bytes().to_vec();
    out.extend(header);
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(data);
    out
}

fn connection_record() -> Vec<u8> {
    let fields = record(&[("type", b"sensor_msgs/Imu"), ("topic", b"/imu")], &[]);
    let inner = &fields[4..fields.len() - 4];
    record(&[("op", &[op::CONNECTION]), ("conn", &0u32.to_le_bytes()), ("topic", b"/imu")], inner)
}

fn time(seconds: u32) -> [u8; 8] {
    u64::from(seconds).to_le_bytes()
}

fn message_record(seconds: u32) -> Vec<u8> {
    let fields: [(&str, &[u8]); 3] =
        [("op", &[op::MESSAGE]), ("conn", &0u32.to_le_bytes()), ("time", &time(seconds))];
    record(&fields, &seconds.to_le_bytes())
}

impl Maker {
    /// Two chunks of two messages, then the index.
    fn bag(compression: &str) -> Vec<u8> {
        let mut maker = Self { bytes: MAGIC.to_vec() };
        let header_length = maker.header(0).len();
        maker.bytes.resize(MAGIC.len() + header_length, 0);
        let mut infos = Vec::new();
        for chunk in 0..2u32 {
            let position = maker.bytes.len() as u64;
            let mut content = connection_record();
            content.extend(message_record(10 * chunk + 1));
            content.extend(message_record(10 * chunk + 2));
            let packed = pack(&content, compression);
            let size = (content.len() as u32).to_le_bytes();
            let fields: [(&str, &[u8]); 3] =
                [("op", &[op::CHUNK]), ("compression", compression.as_bytes()), ("size", &size)];
            maker.bytes.extend(record(&fields, &packed));
            infos.extend(record(
                &[
                    ("op", &[op::CHUNK_INFO]),
                    ("chunk_pos", &position.to_le_bytes()),
                    ("start_time", &time(10 * chunk + 1)),
                    ("end_time", &time(10 * chunk + 2)),
                ],
                &[0, 0, 0, 0, 2, 0, 0, 0],
            ));
        }
        let index = maker.bytes.len() as u64;
        let header = maker.header(index);
        maker.bytes[MAGIC.len()..MAGIC.len() + header_length].copy_from_slice(&header);
        maker.bytes.extend(connection_record());
        maker.bytes.extend(infos);
        maker.bytes
    }

    fn header(&self, index: u64) -> Vec<u8> {
        let (connections, chunks) = (1u32.to_le_bytes(), 2u32.to_le_bytes());
        let fields: [(&str, &[u8]); 4] = [
            ("op", &[3]),
            ("index_pos", &index.to_le_bytes()),
            ("conn_count", &connections),
            ("chunk_count", &chunks),
        ];
        record(&fields, b"    ")
    }
}

fn pack(content: &[u8], compression: &str) -> Vec<u8> {
    use std::io::Write;
    match compression {
        "bz2" => {
            let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
            encoder.write_all(content).unwrap();
            encoder.finish().unwrap()
        }
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            encoder.write_all(content).unwrap();
            encoder.finish().unwrap()
        }
        _ => content.to_vec(),
    }
}

/// Seconds of all messages, read through the index.
fn read_all(bytes: &[u8]) -> Result<(Vec<i64>, BagIndex), FormatError> {
    let mut file = Cursor::new(bytes);
    let index = read_index(&mut file)?;
    let mut seconds = Vec::new();
    for chunk in &index.chunks {
        if let Ok(unpacked) = read_chunk(&mut file, chunk.position) {
            for message in unpacked.messages {
                assert_eq!(unpacked.bytes[message.range].len(), 4);
                seconds.push(message.at.parts().0);
            }
        }
    }
    Ok((seconds, index))
}

#[test]
fn every_compression_is_read() {
    for compression in ["none", "bz2", "lz4"] {
        let (seconds, index) = read_all(&Maker::bag(compression)).unwrap();
        assert_eq!(seconds, [1, 2, 11, 12], "{compression}");
        assert_eq!(index.connections[&0].topic, "/imu");
        assert_eq!(index.connections[&0].type_name, "sensor_msgs/Imu");
        assert!(index.warnings.is_empty());
    }
}

#[test]
fn a_truncated_bag_gives_its_whole_messages_and_a_warning() {
    for compression in ["none", "bz2", "lz4"] {
        let bytes = Maker::bag(compression);
        let mut best = 0;
        for cut in 0..bytes.len() {
            match read_all(&bytes[..cut]) {
                Ok((seconds, index)) => {
                    assert!(!index.warnings.is_empty(), "{compression} cut at {cut}");
                    assert!(seconds.len() >= best, "{compression} cut at {cut}: more bytes, fewer messages");
                    best = seconds.len();
                    assert_eq!(seconds, [1, 2, 11, 12][..best]);
                }
                Err(_) => assert!(cut < MAGIC.len(), "{compression} cut at {cut}"),
            }
        }
        assert_eq!(best, 4, "only the index was cut");
    }
}

#[test]
fn absurd_lengths_are_refused_without_allocating() {
    let bytes = Maker::bag("none");
    for at in MAGIC.len()..bytes.len() - 4 {
        let mut broken = bytes.clone();
        broken[at..at + 4].fill(0xff);
        let _ = read_all(&broken);
    }
    assert!(read_all(b"").is_err());
    let old = read_all(b"#ROSBAG V1.2\n").unwrap_err().to_string();
    assert!(old.contains("rosbag fix"), "{old}");
}
