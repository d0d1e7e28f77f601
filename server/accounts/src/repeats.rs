//! Counts what recurs, so that a flood of refusals makes few entries of the audit log.
//!
//! The first of a kind is due at once. Further ones are counted, and are due as one after [`RepeatConfig::period`]. Kinds are few: beyond [`RepeatConfig::max_kinds`] a new
//! one is not taken, and whoever counts says so in other words.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Parameters of [`Repeats`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RepeatConfig {
    /// Time for which what recurs is counted before it is due again. Given by the user of [`Repeats`].
    pub period: Duration,
    /// Kinds that are told apart at a time. Given by the user of [`Repeats`].
    pub max_kinds: usize,
}

/// What has recurred.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Repeated<K, V> {
    /// Its kind.
    pub kind: K,
    /// What was noted with the last of it.
    pub last: V,
    /// How often it was noted since it was due last.
    pub count: u32,
}

#[derive(Debug)]
struct Noted<V> {
    last: V,
    count: u32,
    taken: Option<Instant>,
}

/// Counts what recurs.
#[derive(Debug)]
pub struct Repeats<K, V> {
    config: RepeatConfig,
    noted: BTreeMap<K, Noted<V>>,
}

impl<K: Ord + Clone, V: Clone> Repeats<K, V> {
    /// With these parameters.
    pub fn new(config: RepeatConfig) -> Self {
        Self { config, noted: BTreeMap::new() }
    }

    /// Something has happened `count` times. Returns whether there was room for its kind.
    pub fn note(&mut self, kind: K, last: V, count: u32) -> bool {
        let has_room = self.noted.len() < self.config.max_kinds || self.noted.contains_key(&kind);
        if has_room {
            self.note_always(kind, last, count);
        }
        has_room
    }

    /// The same for a kind that always has room, of which there are few.
    pub fn note_always(&mut self, kind: K, last: V, count: u32) {
        let noted =
            self.noted.entry(kind).or_insert_with(|| Noted { last: last.clone(), count: 0, taken: None });
        noted.last = last;
        noted.count = noted.count.saturating_add(count);
    }

    /// Takes what is due, `most` at most, and forgets what has not recurred for a period.
    pub fn take_due(&mut self, now: Instant, most: usize) -> Vec<Repeated<K, V>> {
        let period = self.config.period;
        let is_old = |taken: Instant| now.saturating_duration_since(taken) >= period;
        self.noted.retain(|_, noted| noted.count > 0 || !noted.taken.is_some_and(is_old));
        let due =
            self.noted.iter_mut().filter(|(_, noted)| noted.count > 0 && noted.taken.is_none_or(is_old));
        due.take(most)
            .map(|(kind, noted)| {
                noted.taken = Some(now);
                let count = std::mem::take(&mut noted.count);
                Repeated { kind: kind.clone(), last: noted.last.clone(), count }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIG: RepeatConfig = RepeatConfig { period: Duration::from_secs(600), max_kinds: 2 };

    fn due(repeats: &mut Repeats<&'static str, ()>, now: Instant) -> Vec<(&'static str, u32)> {
        repeats.take_due(now, 10).into_iter().map(|due| (due.kind, due.count)).collect()
    }

    #[test]
    fn the_first_is_due_at_once_and_the_rest_as_one() {
        let (mut repeats, start) = (Repeats::new(CONFIG), Instant::now());
        assert!(repeats.note("a", (), 1));
        assert_eq!(due(&mut repeats, start), [("a", 1)]);
        (0..1_000).for_each(|_| assert!(repeats.note("a", (), 1)));
        assert_eq!(due(&mut repeats, start + CONFIG.period / 2), []);
        assert_eq!(due(&mut repeats, start + CONFIG.period), [("a", 1_000)]);
        assert_eq!(due(&mut repeats, start + CONFIG.period * 2), []);
        assert!(repeats.noted.is_empty(), "what has ended is forgotten");
    }

    #[test]
    fn kinds_are_few_but_for_one_that_always_has_room() {
        let mut repeats = Repeats::new(CONFIG);
        assert!(repeats.note("a", (), 1) && repeats.note("b", (), 1) && !repeats.note("c", (), 1));
        repeats.note_always("others", (), 1);
        assert_eq!(due(&mut repeats, Instant::now()), [("a", 1), ("b", 1), ("others", 1)]);
    }
}
