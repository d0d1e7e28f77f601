//! All places seen so far, to be asked which of them looks like this one.

use crate::scan_context::{Alignment, KEY, ScanContext};
use std::ops::Range;
use std::sync::Arc;

/// Places whose pictures are compared for each way of looking, nearest ring keys first.
const SHORTLIST: usize = 12;

/// A place that looks alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanContextMatch {
    /// Number of the place, in the order of insertion.
    pub place: usize,
    /// Which of the query's descriptors fitted best.
    pub view: usize,
    /// How they fit; its yaw turns the query as seen from the place.
    pub alignment: Alignment,
}

/// Descriptors in the order of insertion. A search looks at every ring key: 128 B each, so 1 ms for some 100,000
/// places; a tree would save little in 32 dimensions.
#[derive(Clone, Debug, Default)]
pub struct ScanContextIndex {
    keys: Vec<[f32; KEY]>,
    descriptors: Vec<Arc<ScanContext>>,
}

impl ScanContextIndex {
    /// Adds a place; its number is the count before.
    pub fn push(&mut self, descriptor: Arc<ScanContext>) {
        self.keys.push(*descriptor.ring_key());
        self.descriptors.push(descriptor);
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// The descriptor of a place.
    pub fn descriptor(&self, place: usize) -> Option<&Arc<ScanContext>> {
        self.descriptors.get(place)
    }

    /// Places within `among` that look like the query (the same place seen in several ways), best first, each once.
    pub fn search(&self, views: &[Arc<ScanContext>], among: Range<usize>) -> Vec<ScanContextMatch> {
        let among = among.start.min(self.len())..among.end.min(self.len());
        let mut best: Vec<ScanContextMatch> = Vec::new();
        for (view, query) in views.iter().enumerate() {
            for place in self.shortlist(query.ring_key(), among.clone()) {
                let alignment = self.descriptors[place].align(query);
                match best.iter_mut().find(|held| held.place == place) {
                    Some(held) if held.alignment.distance <= alignment.distance => {}
                    Some(held) => *held = ScanContextMatch { place, view, alignment },
                    None => best.push(ScanContextMatch { place, view, alignment }),
                }
            }
        }
        best.sort_by(|a, b| {
            a.alignment.distance.total_cmp(&b.alignment.distance).then(a.place.cmp(&b.place))
        });
        best
    }

    /// The nearest ring keys, nearest first; ties go to the older place.
    fn shortlist(&self, key: &[f32; KEY], among: Range<usize>) -> Vec<usize> {
        let mut nearest: Vec<(f32, usize)> = Vec::with_capacity(SHORTLIST + 1);
        for place in among {
            let distance = squared_distance(key, &self.keys[place]);
            let full = nearest.len() == SHORTLIST;
            if full && nearest.last().is_some_and(|worst| distance >= worst.0) {
                continue;
            }
            let at = nearest.partition_point(|held| held.0 <= distance);
            nearest.insert(at, (distance, place));
            nearest.truncate(SHORTLIST);
        }
        nearest.into_iter().map(|(_, place)| place).collect()
    }
}

/// In eight sums side by side, which the compiler turns into vector instructions.
#[inline]
fn squared_distance(a: &[f32; KEY], b: &[f32; KEY]) -> f32 {
    let mut sums = [0.0_f32; 8];
    for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
        for lane in 0..8 {
            let difference = a[lane] - b[lane];
            sums[lane] += difference * difference;
        }
    }
    sums.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{RngTree, Rotation};

    fn place(seed: u64) -> Vec<[f32; 3]> {
        let mut rng = RngTree::new(seed).child("place").rng();
        let mut points = Vec::new();
        for _ in 0..15 {
            let (x, y, high) = (rng.range(-12.0, 12.0), rng.range(-12.0, 12.0), rng.range(0.2, 2.5));
            for _ in 0..60 {
                points.push([x + rng.uniform(), y + rng.uniform(), rng.range(-0.5, high)].map(|c| c as f32));
            }
        }
        points
    }

    #[test]
    fn a_place_is_found_among_hundreds_and_only_where_it_may_be() {
        let level = Rotation::identity();
        let mut places = ScanContextIndex::default();
        for seed in 0..300 {
            places.push(Arc::new(ScanContext::new(&place(seed), &level, [0.0; 2])));
        }
        // Seen again with a different heading and every third point missing.
        let turn = geometry::so3::exp(&(geometry::Vector3::z() * 1.3));
        let again: Vec<[f32; 3]> =
            place(123).into_iter().enumerate().filter(|(i, _)| i % 3 != 0).map(|(_, p)| p).collect();
        let query = [Arc::new(ScanContext::new(&again, &turn, [0.0; 2]))];
        let found = places.search(&query, 0..300);
        assert_eq!(found[0].place, 123);
        assert!(found[0].alignment.distance < 0.7 * found[1].alignment.distance, "{found:?}");
        assert!(places.search(&query, 0..100).iter().all(|r| r.place < 100));
        assert!(places.search(&query, 300..900).is_empty() && places.search(&[], 0..300).is_empty());
    }
}
