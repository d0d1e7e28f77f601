//! How many samples a JPEG file has of each of its components, in the headers of its frames (ITU-T T.81, B.2.2).

/// Markers that begin a frame which the decoder reads: baseline, extended and progressive.
const FRAMES: std::ops::RangeInclusive<u8> = 0xc0..=0xc2;
/// Markers without a length: of a temporary use, of restarts, and of the begin and the end of the picture.
const WITHOUT_LENGTH: [std::ops::RangeInclusive<u8>; 2] = [0x01..=0x01, 0xd0..=0xd9];
/// Bytes of a frame's header before its components, after the length.
const BEFORE_COMPONENTS: usize = 6;

/// Whether no component of a frame has more samples than the first one, and each has a whole fraction of them along both sides. The first one is brightness, of which cameras have most. The decoder
/// panics at others. Linear in the bytes.
pub(super) fn is_common(bytes: &[u8]) -> bool {
    segments(bytes).filter(|(marker, _)| FRAMES.contains(marker)).all(|(_, header)| {
        let components = header.get(BEFORE_COMPONENTS..).unwrap_or_default().chunks_exact(3);
        let mut samples = components.map(|component| [component[1] >> 4, component[1] & 15]);
        let first = samples.next().unwrap_or([1; 2]);
        let divides = |[part, whole]: [u8; 2]| part > 0 && whole > 0 && whole % part == 0;
        samples.all(|samples| (0..2).all(|side| divides([samples[side], first[side]])))
    })
}

/// Each marker with the bytes of its segment after the length; those of a segment that is cut short are left out. Data between segments is skipped.
fn segments(bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut rest = bytes;
    std::iter::from_fn(move || {
        loop {
            let begin = rest.iter().position(|byte| *byte == 0xff)?;
            rest = &rest[begin + 1..];
            let marker = *rest.first()?;
            // A byte of data, or one of those that may come before a marker.
            if marker == 0 || marker == 0xff {
                continue;
            }
            rest = &rest[1..];
            if WITHOUT_LENGTH.iter().any(|markers| markers.contains(&marker)) {
                continue;
            }
            let length = usize::from(u16::from_be_bytes([*rest.first()?, *rest.get(1)?]));
            let segment = rest.get(2..length).unwrap_or_default();
            rest = rest.get(length.max(2)..).unwrap_or_default();
            return Some((marker, segment));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame's header with components of these samples, between a comment that looks like another one and data.
    fn file(frame: u8, samples: &[[u8; 2]]) -> Vec<u8> {
        let mut file = vec![0xff, 0xd8, 0xff, 0xfe, 0, 8, 0xff, 0xc0, 0, 20, 1, 0x14, 0xff, 0xff, frame];
        file.extend([0, 8 + 3 * samples.len() as u8, 8, 0, 16, 0, 16, samples.len() as u8]);
        file.extend((1..).zip(samples).flat_map(|(id, [across, down])| [id, across << 4 | down, 0]));
        file.extend([0xff, 0xda, 0, 2, 7, 0xff, 0, 0xc0, 0xff, 0xd0, 7, 0xff, 0xd9]);
        file
    }

    #[test]
    fn what_cameras_write_is_common_and_more_colour_than_brightness_is_not() {
        let common: [&[[u8; 2]]; 7] = [
            &[[1, 1]; 3],
            &[[2, 2], [1, 1], [1, 1]],
            &[[2, 1], [1, 1], [1, 1]],
            &[[4, 1], [1, 1], [1, 1]],
            &[[2, 2]; 3],
            &[[2, 2]],
            &[[2, 2], [1, 1], [1, 1], [2, 2]],
        ];
        let others: [&[[u8; 2]]; 4] = [
            &[[2, 2], [4, 1], [1, 1]],
            &[[1, 1], [1, 2], [1, 1]],
            &[[3, 1], [2, 1], [1, 1]],
            &[[2, 2], [0, 1], [1, 1]],
        ];
        for frame in [0xc0, 0xc1, 0xc2] {
            assert!(common.iter().all(|samples| is_common(&file(frame, samples))));
            assert!(others.iter().all(|samples| !is_common(&file(frame, samples))));
        }
        assert!(is_common(&[0xff, 0xd8, 0xff, 0xc0]), "cut short: the decoder says so");
    }
}
