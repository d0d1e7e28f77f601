//! Client time, and how old values are.

/// Seconds since the page was opened, monotonic.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct ClientTime(pub f64);

impl ClientTime {
    /// Seconds from `earlier` to here; never negative.
    pub fn since(self, earlier: Self) -> f64 {
        (self.0 - earlier.0).max(0.0)
    }

    /// The instant `seconds` later.
    pub fn after(self, seconds: f64) -> Self {
        Self(self.0 + seconds)
    }
}

/// A value and when it arrived.
#[derive(Clone, Debug, PartialEq)]
pub struct Aged<T> {
    /// The value.
    pub value: T,
    /// When it arrived here.
    pub arrived: ClientTime,
}

impl<T> Aged<T> {
    /// Seconds since it arrived.
    pub fn age(&self, now: ClientTime) -> f64 {
        now.since(self.arrived)
    }
}
