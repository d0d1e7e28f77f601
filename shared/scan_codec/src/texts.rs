//! Clauses for people, by key: why bytes are not a range image. English.

pub(crate) const TOO_SHORT: &str = "it is too short";
pub(crate) const OTHER_BEGINNING: &str = "it does not begin as one";
pub(crate) const UNKNOWN_INTENSITIES: &str = "its intensities are of an unknown kind";
pub(crate) const TOO_MANY_POINTS: &str = "it has too many points";
pub(crate) const CHANNEL_OUT_OF_RANGE: &str = "a channel is out of range";
pub(crate) const TIME_OUT_OF_RANGE: &str = "a time is out of range";
pub(crate) const AZIMUTH_OUT_OF_RANGE: &str = "an azimuth is out of range";
pub(crate) const ELEVATION_OUT_OF_RANGE: &str = "an elevation is out of range";
pub(crate) const RANGE_OUT_OF_RANGE: &str = "a range is out of range";
pub(crate) const INTENSITY_OUT_OF_RANGE: &str = "an intensity is out of range";
pub(crate) const OTHER_INTENSITIES_LENGTH: &str = "a stream of intensities has another length";
pub(crate) const NUMBERS_END_EARLY: &str = "a stream of numbers ends early";
pub(crate) const NUMBER_TOO_LARGE: &str = "a number is too large";
pub(crate) const ENDS_WITHIN_STREAM: &str = "it ends within a stream";
pub(crate) const STREAM_TOO_LONG: &str = "a stream is longer than its points allow";
pub(crate) const STREAM_NOT_UNPACKED: &str = "a stream does not unpack";
