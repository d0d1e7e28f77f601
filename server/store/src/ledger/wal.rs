//! Damage to the write-ahead log that a killed program has left. SQLite ignores what follows a wrong bit in it without a word, so it is looked for before the ledger is opened.
//!
//! Format: <https://www.sqlite.org/fileformat2.html#the_write_ahead_log>. A log that was cut looks like that of a program that was killed earlier.

const HEADER_BYTES: usize = 32;
const FRAME_HEADER_BYTES: usize = 24;

/// Magic numbers of the header: checksums over little-endian words, and over big-endian ones.
const MAGIC: [u32; 2] = [0x377f_0682, 0x377f_0683];

/// Whether a log has frames that were written by the same program as the first, and do not match their checksum.
pub(super) fn is_damaged(wal: &[u8]) -> bool {
    let Some((header, mut frames)) = wal.split_at_checked(HEADER_BYTES) else { return false };
    let word = |bytes: &[u8], index: usize| {
        bytes
            .get(4 * index..4 * index + 4)
            .and_then(|word| word.try_into().ok())
            .map_or(0, u32::from_be_bytes)
    };
    let Some(order) = MAGIC.iter().position(|magic| word(header, 0) == *magic) else { return true };
    let order = if order == 0 { u32::from_le_bytes } else { u32::from_be_bytes };
    let mut sums = checksum((0, 0), &header[..24], order);
    if sums != (word(header, 6), word(header, 7)) {
        return true;
    }
    let page_bytes = word(header, 2) as usize;
    while let Some((frame, rest)) = frames.split_at_checked(FRAME_HEADER_BYTES + page_bytes) {
        let (about, page) = frame.split_at(FRAME_HEADER_BYTES);
        let is_of_this_log = (word(about, 2), word(about, 3)) == (word(header, 4), word(header, 5));
        sums = checksum(checksum(sums, &about[..8], order), page, order);
        // Frames with other salts are what the log held before it was begun anew. None of this log follows them.
        if !is_of_this_log || sums != (word(about, 4), word(about, 5)) {
            return is_of_this_log || has_later_frame(rest, header, page_bytes);
        }
        frames = rest;
    }
    false
}

/// Whether a frame of the log follows.
fn has_later_frame(frames: &[u8], header: &[u8], page_bytes: usize) -> bool {
    frames.chunks(FRAME_HEADER_BYTES + page_bytes).any(|frame| frame.get(8..16) == Some(&header[16..24]))
}

fn checksum((mut a, mut b): (u32, u32), bytes: &[u8], order: fn([u8; 4]) -> u32) -> (u32, u32) {
    for pair in bytes.chunks_exact(8) {
        let word = |at: usize| order([pair[at], pair[at + 1], pair[at + 2], pair[at + 3]]);
        a = a.wrapping_add(word(0)).wrapping_add(b);
        b = b.wrapping_add(word(4)).wrapping_add(a);
    }
    (a, b)
}
