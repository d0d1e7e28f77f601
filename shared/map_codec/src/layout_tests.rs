//! The bytes of scans and tiles. If these tests fail, the layout has changed: raise `chunk::VERSION`, let the decoder read the old version too, because
//! saved maps hold it, and add a line with the new bytes. Lines of earlier versions stay.

use crate::chunk::{PACKING_STORED, PACKING_ZSTD, VERSION};
use crate::*;

/// Chunks as they were written, by version. They can be read for good.
const STORED: [(u8, &str); 1] = [(
    1,
    "414950430100020003000000150000000000803f000000c00000003f0ad7233c0000803f0000003f000202000000000004000000000000000000c801ff",
)];
/// The same with its payload as a zstd frame, and more points.
const PACKED: [(u8, &str); 1] = [(
    1,
    "4149504301010200c80000001b0000000000803f000000c00000003f0ad7233c0000803f0000003f28b52ffd6078048d0000280002000700031000430ac9576c48b501",
)];

fn bytes_of(hex: &str) -> Vec<u8> {
    let digit = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).unwrap_or_default();
    (0..hex.len()).step_by(2).map(digit).collect()
}

fn hex_of(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn chunk(points: Vec<GpuPoint>) -> PointChunk {
    PointChunk { origin: [1.0, -2.0, 0.5], step: 0.01, intensity_unit: 1.0, spacing: 0.5, level: 2, points }
}

/// Three points in Morton order.
fn few() -> PointChunk {
    let point = |x, y, intensity| GpuPoint { position: [x, y, 0], intensity, spare: 0 };
    chunk(vec![point(0, 0, 200), point(1, 0, 201), point(2, 2, 200)])
}

/// 200 points on a line, in Morton order.
fn many() -> PointChunk {
    chunk((0..200).map(|x| GpuPoint { position: [x, 0, 0], intensity: 7, spare: 0 }).collect())
}

#[test]
fn the_bytes_of_a_chunk_are_unchanged() {
    let (version, written) = STORED[STORED.len() - 1];
    assert_eq!((VERSION, hex_of(&encode(&few())).as_str()), (version, written));
}

#[test]
fn chunks_of_every_version_are_read() {
    for (sample, lines, packing) in [(few(), STORED, PACKING_STORED), (many(), PACKED, PACKING_ZSTD)] {
        for (version, line) in lines {
            let bytes = bytes_of(line);
            assert_eq!(
                bytes.get(4..6),
                Some([version, packing].as_slice()),
                "now {}",
                hex_of(&encode(&sample))
            );
            assert_eq!(decode(&bytes).ok(), Some(sample.clone()), "version {version}");
        }
    }
}
