//! Pose graphs and trajectories, which are text.

use crate::assert_sentence;
use formats::g2o::{self, Information};

/// `formats::g2o`. What is read and written again reads as the same.
///
/// # Panics
/// When it does not.
pub fn g2o(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Err(error) = g2o::read_as(&text, Information::HalfAngle) {
        assert_sentence(&error);
    }
    match g2o::read(&text) {
        Ok(graph) => {
            let mut written = Vec::new();
            g2o::write_as(&mut written, &graph, Information::RotationVector)
                .expect("a vector takes all bytes");
            let again = g2o::read(&String::from_utf8_lossy(&written)).expect("what was written can be read");
            // As text, because not-a-number differs from itself.
            assert_eq!(format!("{graph:?}"), format!("{again:?}"));
        }
        Err(error) => assert_sentence(&error),
    }
}

/// `formats::tum`.
pub fn tum(bytes: &[u8]) {
    match formats::tum::read(&String::from_utf8_lossy(bytes)) {
        Ok(poses) => {
            let mut written = Vec::new();
            formats::tum::write(&mut written, &poses).expect("a vector takes all bytes");
            let again = formats::tum::read(&String::from_utf8_lossy(&written));
            assert_eq!(again.map(|poses| poses.len()).ok(), Some(poses.len()));
        }
        Err(error) => assert_sentence(&error),
    }
}
