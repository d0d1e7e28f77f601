//! Buildings of other programs.

use crate::assert_sentence;

/// A GLB file with its sidecar. The input is the length of the sidecar, two bytes, the sidecar, and the GLB file.
pub fn site(bytes: &[u8]) {
    let Some((length, rest)) = bytes.split_first_chunk::<2>() else { return };
    let (sidecar, model) = rest.split_at(usize::from(u16::from_le_bytes(*length)).min(rest.len()));
    if let Err(error) = site_files::fuzzing::read_model(model, sidecar) {
        assert_sentence(&error);
    }
}
