//! Point clouds and surveys.

use crate::assert_sentence;
use crate::scratch::with_file;
use formats::{FormatError, PointTable, SurveyLimits, survey};
use std::panic;
use std::sync::Once;
use vocab::Stamp;

/// `formats::pcd`.
pub fn pcd(bytes: &[u8]) {
    check_table(formats::pcd::read(bytes));
    let _ = formats::pcd::viewpoint(bytes);
    read_survey("scan.pcd", bytes);
}

/// `formats::ply`.
pub fn ply(bytes: &[u8]) {
    check_table(formats::ply::read(bytes));
    read_survey("scan.ply", bytes);
}

/// `formats::kitti`.
pub fn kitti(bytes: &[u8]) {
    check_table(formats::kitti::read(bytes));
}

/// LAS through `formats::survey`.
pub fn las(bytes: &[u8]) {
    read_survey("survey.las", bytes);
}

/// LAZ through `formats::survey`.
pub fn laz(bytes: &[u8]) {
    read_survey("survey.laz", bytes);
}

/// PTX through `formats::survey`.
pub fn ptx(bytes: &[u8]) {
    read_survey("survey.ptx", bytes);
}

/// E57 through `formats::survey`. Checksums of pages are corrected first: a fuzzer cannot guess them.
pub fn e57(bytes: &[u8]) {
    let mut bytes = bytes.to_vec();
    correct_page_checksums(&mut bytes);
    read_survey("survey.e57", &bytes);
}

fn check_table(table: Result<PointTable<'_>, FormatError>) {
    let table = match table {
        Ok(table) => table,
        Err(error) => return assert_sentence(&error),
    };
    let _ = (table.has_times(), table.has_rings());
    for stamp in [None, Some(Stamp::from_parts(1_700_000_000, 5))] {
        match table.to_scan(stamp) {
            Ok((scan, report)) => {
                let points = scan.xyz.len();
                assert_eq!(points + report.dropped.total(), table.len());
                let columns = [scan.intensity.len(), scan.offset_ns.len(), scan.ring.len()];
                assert!(columns.iter().all(|length| *length == points || *length == 0), "{columns:?}");
                assert!(scan.xyz.iter().flatten().all(|coordinate| coordinate.is_finite()));
            }
            Err(error) => assert_sentence(&error),
        }
    }
}

/// As an import has them, with fewer points, so that an input takes less time.
const LIMITS: SurveyLimits = SurveyLimits { points: 500_000 };

fn read_survey(name: &str, bytes: &[u8]) {
    keep_caught_panics_quiet();
    match with_file(name, bytes, |path| {
        survey::read(path, LIMITS, &mut |share| assert!((0.0..=1.0).contains(&share)))
    }) {
        Ok(survey) => {
            for station in &survey.stations {
                assert!(station.intensity.is_empty() || station.intensity.len() == station.xyz.len());
            }
        }
        Err(error) => assert_sentence(&error),
    }
}

/// `formats::survey` catches panics of the libraries that decode LAZ and E57. The fuzzer's hook would end the process at them, so another
/// hook takes its place. Panics that are not caught still end the process.
fn keep_caught_panics_quiet() {
    static ONCE: Once = Once::new();
    if cfg!(fuzzing) {
        ONCE.call_once(|| panic::set_hook(Box::new(|_| ())));
    }
}

/// Bytes of a page of E57 and of the checksum at its end.
const E57_PAGE_BYTES: usize = 1024;
const E57_CHECKSUM_BYTES: usize = 4;

fn correct_page_checksums(bytes: &mut Vec<u8>) {
    bytes.resize(bytes.len().next_multiple_of(E57_PAGE_BYTES), 0);
    for page in bytes.chunks_exact_mut(E57_PAGE_BYTES) {
        let (content, checksum) = page.split_at_mut(E57_PAGE_BYTES - E57_CHECKSUM_BYTES);
        checksum.copy_from_slice(&crc32c(content).to_be_bytes());
    }
}

/// CRC-32C (Castagnoli), bit by bit.
fn crc32c(bytes: &[u8]) -> u32 {
    const POLYNOMIAL_REFLECTED: u32 = 0x82f6_3b78;
    !bytes.iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
            (sum >> 1) ^ (POLYNOMIAL_REFLECTED & (sum & 1).wrapping_neg())
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_crc_32c() {
        assert_eq!(crc32c(b"123456789"), 0xe306_9283);
    }
}
