//! Ticks on a recording's clock, like those of a robot.

use messages::{MAX_TICK_GAP, TICK_PERIOD};
use vocab::Stamp;

/// Generates the ticks between messages.
#[derive(Debug, Default)]
pub struct Ticks {
    next: Option<Stamp>,
}

impl Ticks {
    /// The next tick not later than a message; `None` once there are no more.
    pub fn before(&mut self, message: Stamp) -> Option<Stamp> {
        let next = self.next.filter(|next| message - *next <= MAX_TICK_GAP).unwrap_or(message);
        self.next = Some(next);
        if next > message {
            return None;
        }
        self.next = Some(next + TICK_PERIOD);
        Some(next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::Span;

    #[test]
    fn ticks_come_every_50_ms_and_gaps_have_none() {
        let at = |millis: i64| Stamp::from_parts(100, 0) + Span::from_millis(millis);
        let mut ticks = Ticks::default();
        let mut all = |message: i64| {
            std::iter::from_fn(|| ticks.before(at(message)))
                .map(|tick| (tick - at(0)).nanos() / 1_000_000)
                .collect::<Vec<_>>()
        };
        assert_eq!(all(0), [0]);
        assert_eq!(all(40), [0; 0]);
        assert_eq!(all(160), [50, 100, 150]);
        assert_eq!(all(10_000), [10_000]);
    }
}
