//! One function for each parser of bytes from outside: files of other programs, messages of clients, and the program's own files, which a
//! failing disk may damage.
//!
//! The fuzzer in `fuzz/` calls them with inputs that it invents. `tests/corpus.rs` calls them with the kept inputs of `fuzz/corpus`, on
//! every run of the tests. A function panics if its parser breaks its contract: it panics itself, gives an error that is no sentence, or
//! gives data that contradicts itself.

mod clouds;
mod gauges;
mod graphs;
mod pictures;
mod recordings;
mod scratch;
mod sites;
mod stored;
mod wire;

pub use clouds::{e57, kitti, las, laz, pcd, ply, ptx};
pub use gauges::gauge;
pub use graphs::{g2o, tum};
pub use pictures::picture;
pub use recordings::{cdr, journal, range_image, recording, rosbag1, rosbag2};
pub use sites::{site, site_changes};
pub use stored::{STORED_FILES, places, session_journal, stored_files, viewpoints};
pub use wire::{client_model, client_socket, core_link, point_chunk, robot_link, scan_socket};

/// A parser under test.
#[derive(Clone, Copy, Debug)]
pub struct FuzzTarget {
    /// Name of its program in `fuzz/fuzz_targets` and of its folder in `fuzz/corpus`.
    pub name: &'static str,
    /// Parses some bytes.
    pub run: fn(&[u8]),
}

/// All targets.
pub const TARGETS: [FuzzTarget; 29] = [
    FuzzTarget { name: "cdr", run: cdr },
    FuzzTarget { name: "client_model", run: client_model },
    FuzzTarget { name: "client_socket", run: client_socket },
    FuzzTarget { name: "core_link", run: core_link },
    FuzzTarget { name: "e57", run: e57 },
    FuzzTarget { name: "g2o", run: g2o },
    FuzzTarget { name: "gauge", run: gauge },
    FuzzTarget { name: "journal", run: journal },
    FuzzTarget { name: "kitti", run: kitti },
    FuzzTarget { name: "las", run: las },
    FuzzTarget { name: "laz", run: laz },
    FuzzTarget { name: "pcd", run: pcd },
    FuzzTarget { name: "picture", run: picture },
    FuzzTarget { name: "places", run: places },
    FuzzTarget { name: "ply", run: ply },
    FuzzTarget { name: "point_chunk", run: point_chunk },
    FuzzTarget { name: "ptx", run: ptx },
    FuzzTarget { name: "range_image", run: range_image },
    FuzzTarget { name: "recording", run: recording },
    FuzzTarget { name: "robot_link", run: robot_link },
    FuzzTarget { name: "rosbag1", run: rosbag1 },
    FuzzTarget { name: "rosbag2", run: rosbag2 },
    FuzzTarget { name: "scan_socket", run: scan_socket },
    FuzzTarget { name: "session_journal", run: session_journal },
    FuzzTarget { name: "site", run: site },
    FuzzTarget { name: "site_changes", run: site_changes },
    FuzzTarget { name: "stored_files", run: stored_files },
    FuzzTarget { name: "tum", run: tum },
    FuzzTarget { name: "viewpoints", run: viewpoints },
];

/// Longest sentence that an error may have, bytes.
const MAX_SENTENCE_BYTES: usize = 1_000;

/// Checks that an error is a sentence for people: one line, not too long, without control characters of the input.
///
/// # Panics
/// When it is not.
fn assert_sentence(error: &dyn std::error::Error) {
    let sentence = ports::error_with_causes(error);
    assert!(!sentence.is_empty() && sentence.len() <= MAX_SENTENCE_BYTES, "{} bytes", sentence.len());
    assert!(!sentence.chars().any(char::is_control), "{sentence:?}");
}
