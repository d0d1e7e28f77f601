//! Sentences of links for people, by key. English.

/// A replay has no more messages.
pub(crate) const RECORDING_ENDED: &str =
    "The recording has been played to its end. The map so far can be saved.";
/// The queue of faults is full.
pub(crate) const TOO_MANY_FAULTS: &str = "Too much goes wrong at once. Try again in a moment.";
