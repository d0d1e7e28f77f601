//! Both halves of a comparison at the same time.

use changes::Join;
use std::panic::resume_unwind;
use std::thread;

/// Does the second piece of work on a thread of its own.
pub struct OnTwoThreads;

impl Join for OnTwoThreads {
    fn join<A: Send, B: Send>(
        &self,
        first: impl FnOnce() -> A + Send,
        second: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        thread::scope(|scope| {
            let second = scope.spawn(second);
            (first(), second.join().unwrap_or_else(|panic| resume_unwind(panic)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use changes::{ChangesConfig, InTurn, SensorView, Visit, detect_changes_with, shipped_descriptor};

    /// A floor and a wall, seen from four places, with a box before the wall.
    fn visit(box_at_m: f32) -> Visit {
        let at = |index: i32| index as f32 * 0.05;
        let floor = (-60..60).flat_map(|x| (-60..60).map(move |y| [at(x), at(y), 0.0]));
        let wall = (-60..60).flat_map(|x| (0..40).map(move |z| [at(x), 3.0, at(z)]));
        let front = (0..10).flat_map(|x| (0..16).map(move |z| [box_at_m + at(x), 1.5, at(z)]));
        let is_seen = |point: &[f32; 3]| {
            let is_behind =
                (box_at_m..box_at_m + 0.5).contains(&point[0]) && point[1] > 1.5 && point[2] < 0.8;
            !is_behind
        };
        let points: Vec<[f32; 3]> = floor.chain(wall).filter(is_seen).chain(front).collect();
        let sensors = [-0.9, -0.3, 0.3, 0.9].map(|x| [x, -2.0, 0.6]);
        let view = |sensor: [f64; 3]| SensorView { sensor: sensor.into(), points: points.clone() };
        Visit { views: sensors.map(view).into() }
    }

    #[test]
    fn two_threads_find_the_same_bits_as_one() {
        let (before, after) = (visit(-1.2), visit(0.8));
        let (descriptor, config) = (shipped_descriptor(), ChangesConfig::default());
        let in_turn = detect_changes_with(&before, &after, &*descriptor, &InTurn, &config);
        assert!(!in_turn.objects.is_empty() && !in_turn.unchanged.is_empty());
        assert_eq!(detect_changes_with(&before, &after, &*descriptor, &OnTwoThreads, &config), in_turn);
    }
}
