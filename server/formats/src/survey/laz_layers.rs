//! Checks the layers of compressed points of formats 6 to 10, because the decoder allocates by the lengths that the file states.
//!
//! A chunk of such points is its first point, the number of its points (u32), the length of each layer (u32), and the layers. Source: LASzip 3.4,
//! "lasreadpoint.cpp".

use crate::{FormatError, texts};
use laz::LazVlr;
use laz::laszip::LazItemType;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

/// What the file is, in errors.
pub(super) const WHAT: &str = "LAS or LAZ file";

/// Where chunks lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChunkRange {
    /// Offset of the first chunk.
    pub start: u64,
    /// Offset of the table of chunks, which follows them.
    pub table: u64,
    /// Number of chunks by the table.
    pub chunks: u64,
}

/// Number of layers of a chunk; zero if points are not compressed in layers.
fn layers(vlr: &LazVlr) -> u64 {
    let of_item = |kind: LazItemType| match kind {
        LazItemType::Point14 => 9,
        LazItemType::RGB14 | LazItemType::WavePacket14 => 1,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(bytes) => u64::from(bytes),
        _ => 0,
    };
    vlr.items().iter().map(|item| of_item(item.item_type())).sum()
}

/// Checks that the layers of each chunk end before the table, and that there are enough chunks for `points` points. `range` is none if the file has no
/// table of chunks.
///
/// # Errors
/// When they do not, or the file cannot be read.
pub(super) fn check(
    file: &mut File,
    vlr: &LazVlr,
    range: Option<ChunkRange>,
    points: u64,
) -> Result<(), FormatError> {
    let layers = layers(vlr);
    if layers == 0 || points == 0 {
        return Ok(());
    }
    let damaged = || FormatError::Malformed {
        what: WHAT,
        place: texts::COMPRESSED_POINTS.into(),
        problem: texts::COMPRESSED_DATA_DAMAGED.into(),
    };
    let ChunkRange { start, table, chunks } = range.ok_or_else(damaged)?;
    let mut head = vec![0; (vlr.items_size() + 4 + 4 * layers) as usize];
    let (mut at, mut found) = (start, 0);
    while at < table {
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(&mut head)?;
        let (lengths, _) = head[vlr.items_size() as usize + 4..].as_chunks::<4>();
        let bytes: u64 = lengths.iter().map(|length| u64::from(u32::from_le_bytes(*length))).sum();
        at += head.len() as u64 + bytes;
        found += 1;
    }
    let holds = |chunk_points: u32| points <= chunks.saturating_mul(u64::from(chunk_points));
    let is_enough = vlr.uses_variable_size_chunks() || holds(vlr.chunk_size());
    if at > table || found != chunks || !is_enough { Err(damaged()) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use crate::SurveyLimits;
    use crate::survey;
    use las::{Builder, Point, Writer, point::Format};
    use std::fs::{self, File};
    use std::path::Path;

    /// Where the first chunk begins: after the offset of the table of chunks.
    fn first_chunk(file: &[u8]) -> usize {
        u32::from_le_bytes([file[96], file[97], file[98], file[99]]) as usize + 8
    }

    /// A hundred points of format 6 in a file.
    fn points(path: &Path) -> Vec<u8> {
        let mut builder = Builder::from((1, 4));
        builder.point_format = Format::new(6).unwrap();
        builder.point_format.is_compressed = true;
        let file = File::create(path).unwrap();
        let mut writer = Writer::new(file, builder.into_header().unwrap()).unwrap();
        for number in 0..100 {
            let x = f64::from(number);
            writer.write_point(Point { x, gps_time: Some(x), ..Point::default() }).unwrap();
        }
        writer.close().unwrap();
        fs::read(path).unwrap()
    }

    #[test]
    fn the_number_of_chunks_is_checked_wherever_the_decoder_finds_the_table() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.laz");
        let whole = points(&path);
        let word = first_chunk(&whole) - 8;
        let read = || survey::read(&path, SurveyLimits { points: 1_000 }, &mut |_| {});
        // No offset of a table is possible before the points.
        for offset in [-1, -4_294_966_754, 0, word as i64] {
            let mut at_end = whole.clone();
            let table = at_end[word..][..8].to_vec();
            at_end[word..][..8].copy_from_slice(&offset.to_le_bytes());
            at_end.extend(&table);
            fs::write(&path, &at_end).unwrap();
            assert_eq!(read().unwrap().points(), 100, "{offset}");

            let mut many = at_end.clone();
            let place = many.len() as u64;
            many.extend([0, 0, 0, 0, 0xf5, 0x2d, 0x31, 0x2b]);
            many.extend(place.to_le_bytes());
            fs::write(&path, &many).unwrap();
            let problem = read().unwrap_err().to_string();
            assert!(problem.contains("724643317 chunks"), "{offset}: {problem}");
        }
    }

    #[test]
    fn a_layer_longer_than_the_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("layers.laz");
        let whole = points(&path);
        let read = || survey::read(&path, SurveyLimits { points: 1_000 }, &mut |_| {});
        assert_eq!(read().unwrap().points(), 100);
        let lengths = first_chunk(&whole) + 30 + 4;
        for layer in 0..9 {
            let mut damaged = whole.clone();
            damaged[lengths + 4 * layer..][..4].fill(0xff);
            fs::write(&path, damaged).unwrap();
            let problem = read().unwrap_err().to_string();
            assert!(problem.contains("compressed points"), "{problem}");
        }
    }
}
