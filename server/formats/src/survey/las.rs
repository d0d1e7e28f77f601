//! LAS 1.0 to 1.4 and LAZ: points only. Coordinate systems and extra bytes are skipped, so that damage in them does no harm.
//!
//! Source: ASPRS, "LAS Specification 1.4 - R15", 2019; LASzip's record in the variable length records, by the `laz` crate.

use super::coordinate_offset::CoordinateOffset;
use super::laz_layers::{self, ChunkRange, WHAT};
use super::point_collector::PointCollector;
use super::station::{Station, Survey};
use crate::{FormatError, SurveyLimits, texts};
use laz::{DecompressionSelection, LasZipDecompressor, LazVlr};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes of the header in versions 1.0 to 1.2 (public header block); later versions append to it.
const HEADER_LEN: usize = 227;
/// Bytes of the header in version 1.4 (public header block), which counts points in 64 bits.
const HEADER_LEN_1_4: usize = 375;
/// Bytes of the header of a variable length record, in all versions.
const RECORD_HEADER_LEN: u64 = 54;
/// Bytes of points decoded at a time; at least one point.
const BATCH_BYTES: usize = 1 << 20;
/// Bytes of the shortest point: point data record format 0.
const MIN_POINT_BYTES: usize = 20;

/// The fields of the header that describe the points.
struct Header {
    size: u64,
    points_at: u64,
    records: u32,
    compressed: bool,
    point_size: usize,
    count: u64,
    scale: [f64; 3],
    offset: [f64; 3],
}

/// Reads all points.
///
/// # Errors
/// When the header contradicts itself or the file, or compressed points are damaged.
pub(super) fn read(
    path: &Path,
    limits: SurveyLimits,
    progress: &mut dyn FnMut(f64),
) -> Result<Survey, FormatError> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    let mut start = Vec::new();
    (&mut file).take(HEADER_LEN_1_4 as u64).read_to_end(&mut start)?;
    let header = Header::read(&start, length)?;
    let mut coordinate_offset = CoordinateOffset::default();
    let mut collector = PointCollector::new(&mut coordinate_offset, limits, 0);
    if header.compressed {
        let vlr = laszip_record(&mut file, &header)?;
        let chunks = check_chunks(&mut file, &header, length)?;
        laz_layers::check(&mut file, &vlr, chunks, header.count)?;
        file.seek(SeekFrom::Start(header.points_at))?;
        // Nothing else is used. And the library follows changes of the sequence of GPS times, of which a damaged file can have any number, by recursion.
        let selection = DecompressionSelection::base().decompress_z().decompress_intensity();
        let points = LasZipDecompressor::selective(BufReader::new(file), vlr, selection);
        let mut points = points.map_err(compressed)?;
        header.each(&mut collector, progress, |bytes| {
            points.decompress_many(bytes).map_err(|error| FormatError::Malformed {
                what: WHAT,
                place: texts::COMPRESSED_POINTS.into(),
                problem: texts::library_error(error),
            })
        })?;
    } else {
        collector.reserve(header.count);
        file.seek(SeekFrom::Start(header.points_at))?;
        let mut points = BufReader::with_capacity(1 << 20, file);
        header.each(&mut collector, progress, |bytes| Ok(points.read_exact(bytes)?))?;
    }
    let (xyz, intensity, unusable) = collector.finish();
    let station = Station { name: None, survey_from_station: None, xyz, intensity };
    Ok(Survey { offset: coordinate_offset.offset(), stations: vec![station], unusable })
}

impl Header {
    /// Reads the header of a file of `length` bytes.
    fn read(bytes: &[u8], length: u64) -> Result<Self, FormatError> {
        if bytes.len() < HEADER_LEN {
            let missing = (HEADER_LEN - bytes.len()) as u64;
            return Err(FormatError::Truncated { what: WHAT, at: bytes.len() as u64, missing });
        }
        let u16_at = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let u32_at = |at: usize| u32::from(u16_at(at)) | u32::from(u16_at(at + 2)) << 16;
        let u64_at = |at: usize| u64::from(u32_at(at)) | u64::from(u32_at(at + 4)) << 32;
        let three = |at: usize| std::array::from_fn(|axis| f64::from_bits(u64_at(at + 8 * axis)));
        let wide =
            bytes[25] >= 4 && usize::from(u16_at(94)) >= HEADER_LEN_1_4 && bytes.len() >= HEADER_LEN_1_4;
        let (legacy, wide_count) = (u64::from(u32_at(107)), if wide { u64_at(247) } else { 0 });
        let header = Self {
            size: u64::from(u16_at(94)),
            points_at: u64::from(u32_at(96)),
            records: u32_at(100),
            // LASzip marks compressed points in the format's highest bits.
            compressed: bytes[104] & 0xc0 != 0,
            point_size: usize::from(u16_at(105)),
            count: if wide_count > 0 { wide_count } else { legacy },
            scale: three(131),
            offset: three(155),
        };
        header.check(length)?;
        Ok(header)
    }

    fn check(&self, length: u64) -> Result<(), FormatError> {
        let problem = |at: u64, problem: String| Err(FormatError::at_byte(WHAT, at, problem));
        if self.size < HEADER_LEN as u64 || self.points_at < self.size {
            return problem(96, texts::points_begin_in_header(self.points_at));
        }
        let room = self.points_at - self.size;
        if u64::from(self.records) * RECORD_HEADER_LEN > room {
            return problem(100, texts::records_too_many(self.records, room));
        }
        if self.point_size < MIN_POINT_BYTES {
            return problem(105, texts::point_too_small(self.point_size));
        }
        if !self.scale.iter().chain(&self.offset).all(|value| value.is_finite()) || self.scale.contains(&0.0)
        {
            return problem(131, texts::SCALE_NOT_FINITE.into());
        }
        let needed = if self.compressed { self.count.min(1) } else { self.count }
            .saturating_mul(self.point_size as u64)
            .saturating_add(self.points_at);
        if !self.compressed && needed > length || self.points_at > length {
            let missing = needed.saturating_sub(length).max(1);
            return Err(FormatError::Truncated { what: WHAT, at: length, missing });
        }
        Ok(())
    }

    /// Reads all points, one batch at a time.
    fn each(
        &self,
        collector: &mut PointCollector<'_>,
        progress: &mut dyn FnMut(f64),
        mut next: impl FnMut(&mut [u8]) -> Result<(), FormatError>,
    ) -> Result<(), FormatError> {
        let most = (BATCH_BYTES / self.point_size)
            .clamp(1, usize::try_from(self.count).unwrap_or(usize::MAX).max(1));
        let mut buffer = vec![0; most * self.point_size];
        let mut done = 0;
        while done < self.count {
            let batch = (self.count - done).min(most as u64);
            let bytes = &mut buffer[..batch as usize * self.point_size];
            next(bytes)?;
            for point in bytes.chunks_exact(self.point_size) {
                let whole =
                    |at: usize| i32::from_le_bytes([point[at], point[at + 1], point[at + 2], point[at + 3]]);
                let place = std::array::from_fn(|axis| {
                    f64::from(whole(4 * axis)) * self.scale[axis] + self.offset[axis]
                });
                collector.add(place, f32::from(u16::from_le_bytes([point[12], point[13]])))?;
            }
            done += batch;
            progress(done as f64 / self.count as f64);
        }
        Ok(())
    }
}

/// The record that says how points were compressed.
fn laszip_record(file: &mut File, header: &Header) -> Result<LazVlr, FormatError> {
    let mut at = header.size;
    for _ in 0..header.records {
        let mut record = [0; RECORD_HEADER_LEN as usize];
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(&mut record)?;
        let length = u16::from_le_bytes([record[20], record[21]]);
        let number = u16::from_le_bytes([record[18], record[19]]);
        if record[2..18].starts_with(LazVlr::USER_ID.as_bytes()) && number == LazVlr::RECORD_ID {
            let mut bytes = vec![0; usize::from(length)];
            file.read_exact(&mut bytes)?;
            let vlr = LazVlr::from_buffer(&bytes).map_err(compressed)?;
            if vlr.items().is_empty() || vlr.items_size() != header.point_size as u64 {
                let problem = texts::laszip_record_differs(header.point_size);
                return Err(FormatError::at_byte(WHAT, at, problem));
            }
            return Ok(vlr);
        }
        at += RECORD_HEADER_LEN + u64::from(length);
    }
    Err(FormatError::at_byte(WHAT, header.size, texts::NO_LASZIP_RECORD))
}

/// Checks the number of chunks, because the decoder allocates by it. None if the file has no table of chunks.
fn check_chunks(file: &mut File, header: &Header, length: u64) -> Result<Option<ChunkRange>, FormatError> {
    let mut word = [0; 8];
    file.seek(SeekFrom::Start(header.points_at))?;
    file.read_exact(&mut word)?;
    let table =
        |word: [u8; 8]| u64::try_from(i64::from_le_bytes(word)).ok().filter(|at| *at > header.points_at);
    // A writer that could not go back states the offset at the end. The decoder looks there whenever the first one is impossible, so this has to do the same.
    if table(word).is_none() {
        file.seek(SeekFrom::End(-8))?;
        file.read_exact(&mut word)?;
    }
    // Files of the oldest kind have no table; points begin where its offset would be.
    let Some(table) = table(word) else { return Ok(None) };
    if table > length.saturating_sub(8) {
        return Ok(None);
    }
    file.seek(SeekFrom::Start(table))?;
    file.read_exact(&mut word)?;
    let chunks = u64::from(u32::from_le_bytes([word[4], word[5], word[6], word[7]]));
    if chunks > header.count.max(1).min(length) {
        let problem = texts::chunks_impossible(chunks, header.count);
        return Err(FormatError::at_byte(WHAT, table + 4, problem));
    }
    Ok(Some(ChunkRange { start: header.points_at + word.len() as u64, table, chunks }))
}

fn compressed(error: laz::LasZipError) -> FormatError {
    match error {
        laz::LasZipError::IoError(error) => FormatError::Io(error),
        other => {
            FormatError::Unsupported { what: texts::unknown_laz(other), remedy: texts::SAVE_AS_OTHER_LAS }
        }
    }
}
