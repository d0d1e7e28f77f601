//! Index of scan contexts: which keyframes look like a query.

use crate::scan_context::{RING_KEY_LENGTH, ScanContext, ScanContextAlignment};
use std::ops::Range;
use std::sync::Arc;

/// Parameters of [`ScanContextIndex::search`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScanContextSearchConfig {
    /// Keyframes with the nearest ring keys whose images are compared, for each view of the query. Chosen: docs/maths/loops.md, section 2, has what is found with it. The
    /// time of a search is in proportion.
    pub shortlist: usize,
    /// Best correlations of the sector keys that are tried on the images. Chosen: docs/maths/loops.md, section 2, has what is found with it. Each is a comparison of
    /// images.
    pub sector_key_peaks: usize,
}

impl Default for ScanContextSearchConfig {
    fn default() -> Self {
        Self { shortlist: 12, sector_key_peaks: 3 }
    }
}

/// A keyframe that looks like the query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanContextMatch {
    /// Number of the keyframe, in the order of insertion.
    pub keyframe: usize,
    /// Index of the query's view that fitted best.
    pub view: usize,
    /// The alignment; its yaw turns the query as seen from the keyframe.
    pub alignment: ScanContextAlignment,
}

/// Scan contexts in the order of insertion. A search compares every ring key, 128 B each; docs/maths/loops.md has the time. A tree would
/// save little in 32 dimensions.
#[derive(Clone, Debug, Default)]
pub struct ScanContextIndex {
    config: ScanContextSearchConfig,
    ring_keys: Vec<[f32; RING_KEY_LENGTH]>,
    contexts: Vec<Arc<ScanContext>>,
}

impl ScanContextIndex {
    /// Adds a keyframe. Its number is the count before.
    pub fn push(&mut self, context: Arc<ScanContext>) {
        self.ring_keys.push(*context.ring_key());
        self.contexts.push(context);
    }

    /// Number of keyframes.
    pub fn len(&self) -> usize {
        self.ring_keys.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.ring_keys.is_empty()
    }

    /// The scan context of a keyframe.
    pub fn get(&self, keyframe: usize) -> Option<&Arc<ScanContext>> {
        self.contexts.get(keyframe)
    }

    /// Keyframes within `among` that look like the query, best first, each once. `views` are several scan contexts of one place.
    pub fn search(&self, views: &[Arc<ScanContext>], among: Range<usize>) -> Vec<ScanContextMatch> {
        let among = among.start.min(self.len())..among.end.min(self.len());
        let mut best: Vec<ScanContextMatch> = Vec::new();
        for (view, query) in views.iter().enumerate() {
            for keyframe in self.shortlist(query.ring_key(), among.clone()) {
                let alignment = self.contexts[keyframe].align(query, self.config.sector_key_peaks);
                match best.iter_mut().find(|held| held.keyframe == keyframe) {
                    Some(held) if held.alignment.distance <= alignment.distance => {}
                    Some(held) => *held = ScanContextMatch { keyframe, view, alignment },
                    None => best.push(ScanContextMatch { keyframe, view, alignment }),
                }
            }
        }
        best.sort_by(|a, b| {
            a.alignment.distance.total_cmp(&b.alignment.distance).then(a.keyframe.cmp(&b.keyframe))
        });
        best
    }

    /// Keyframes with the nearest ring keys, nearest first. Ties go to the older keyframe.
    fn shortlist(&self, key: &[f32; RING_KEY_LENGTH], among: Range<usize>) -> Vec<usize> {
        let mut nearest: Vec<(f32, usize)> = Vec::with_capacity(self.config.shortlist + 1);
        for keyframe in among {
            let distance = squared_distance(key, &self.ring_keys[keyframe]);
            let full = nearest.len() == self.config.shortlist;
            if full && nearest.last().is_some_and(|worst| distance >= worst.0) {
                continue;
            }
            let at = nearest.partition_point(|held| held.0 <= distance);
            nearest.insert(at, (distance, keyframe));
            nearest.truncate(self.config.shortlist);
        }
        nearest.into_iter().map(|(_, keyframe)| keyframe).collect()
    }
}

/// Sums in eight lanes, which the compiler turns into vector instructions.
#[inline]
fn squared_distance(a: &[f32; RING_KEY_LENGTH], b: &[f32; RING_KEY_LENGTH]) -> f32 {
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
    fn a_keyframe_is_found_among_hundreds_and_only_within_the_given_range() {
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
        assert_eq!(found[0].keyframe, 123);
        assert!(found[0].alignment.distance < 0.7 * found[1].alignment.distance, "{found:?}");
        assert!(places.search(&query, 0..100).iter().all(|r| r.keyframe < 100));
        assert!(places.search(&query, 300..900).is_empty() && places.search(&[], 0..300).is_empty());
    }
}
