//! Measures components separately: place recognition by appearance, removal of people, and the time of each.

use crate::recorded_walk::RecordedKeyframe;
use geometry::{Isometry, Vector3};
use mapping::dynamic_points::DynamicPointsConfig;
use mapping::scan_context::{ScanContext, level_from_base};
use mapping::scan_context_index::ScanContextIndex;
use mapping::submap::KeyframeCloud;
use mapping::{LoopFinder, PoseGraph};
use points::Downsampler;
use sim::SimulatedSite;
use std::sync::Arc;
use std::time::Instant;
use vocab::KeyframeId;

/// A recognised place is right within this horizontal distance, metres.
const MAX_DISTANCE_M: f64 = 3.0;
/// A recognised place is right within this vertical distance, metres: the same floor.
const MAX_HEIGHT_M: f64 = 1.0;
/// Number of places in the large index whose search is timed.
const LARGE_INDEX: usize = 100_000;
/// A point farther than this from all surfaces of the site is on a person, metres. The range noise is smaller.
const MIN_PERSON_DISTANCE_M: f64 = 0.12;

/// The figures of one walk.
#[derive(Debug, Default)]
pub struct ComponentFigures {
    /// Number of revisits that were searched for.
    pub searched: usize,
    /// Number of those whose first result is right.
    pub first_right: usize,
    /// Number of those with a right result among the first five.
    pub five_right: usize,
    /// Number of points on people.
    pub people: usize,
    /// Number of those that were removed.
    pub people_dropped: usize,
    /// Number of points on the site.
    pub site: usize,
    /// Number of those that were removed.
    pub site_dropped: usize,
    /// Mean times, milliseconds: cloud and range image, descriptor, search in this walk, search in [`LARGE_INDEX`], removal of people.
    pub cloud_ms: f64,
    pub descriptor_ms: f64,
    pub search_ms: f64,
    pub search_many_ms: f64,
    pub people_ms: f64,
}

/// Measures place recognition at every keyframe of `revisits`, and removal of people at every eighth keyframe.
pub fn measure(
    site: &SimulatedSite,
    recorded: &[RecordedKeyframe],
    revisits: &[usize],
    (finder, graph): (&LoopFinder, &PoseGraph),
) -> ComponentFigures {
    let mut figures = ComponentFigures::default();
    figures.measure_recognition(recorded, revisits);
    figures.measure_people(site, recorded, (finder, graph));
    figures
}

impl ComponentFigures {
    fn measure_recognition(&mut self, recorded: &[RecordedKeyframe], revisits: &[usize]) {
        let (mut places, mut downsampler) = (ScanContextIndex::default(), Downsampler::default());
        for keyframe in recorded {
            let level = level_from_base(&keyframe.odom_from_base.rotation);
            let began = Instant::now();
            std::hint::black_box(KeyframeCloud::new(&keyframe.cloud, [0.0; 3], &mut downsampler));
            self.cloud_ms += milliseconds(began) / recorded.len() as f64;
            let began = Instant::now();
            let descriptor = ScanContext::new(&keyframe.cloud, &level, [0.0; 2]);
            self.descriptor_ms += milliseconds(began) / recorded.len() as f64;
            places.push(Arc::new(descriptor));
        }
        for &newer in revisits {
            let keyframe = &recorded[newer];
            let level = level_from_base(&keyframe.odom_from_base.rotation);
            let view = |aside| Arc::new(ScanContext::new(&keyframe.cloud, &level, [0.0, aside]));
            let views = [0.0, 1.5, -1.5].map(view);
            let began = Instant::now();
            let found = places.search(&views, 0..newer.saturating_sub(15));
            self.search_ms += milliseconds(began) / revisits.len() as f64;
            let right = |place: usize| near(&recorded[place].site_from_base, &keyframe.site_from_base);
            self.searched += 1;
            self.first_right += usize::from(found.first().is_some_and(|first| right(first.keyframe)));
            self.five_right += usize::from(found.iter().take(5).any(|one| right(one.keyframe)));
        }
        self.search_many(&places, recorded);
    }

    fn search_many(&mut self, places: &ScanContextIndex, recorded: &[RecordedKeyframe]) {
        let (Some(last), Some(keyframe)) = (places.len().checked_sub(1), recorded.last()) else { return };
        let mut many = ScanContextIndex::default();
        for place in 0..LARGE_INDEX {
            if let Some(descriptor) = places.get(place % last.max(1)) {
                many.push(descriptor.clone());
            }
        }
        let level = level_from_base(&keyframe.odom_from_base.rotation);
        let view = [Arc::new(ScanContext::new(&keyframe.cloud, &level, [0.0; 2]))];
        let began = Instant::now();
        for _ in 0..10 {
            std::hint::black_box(many.search(&view, 0..LARGE_INDEX));
        }
        self.search_many_ms = milliseconds(began) / 10.0;
    }

    fn measure_people(
        &mut self,
        site: &SimulatedSite,
        recorded: &[RecordedKeyframe],
        (finder, graph): (&LoopFinder, &PoseGraph),
    ) {
        let mut clouds = 0;
        for (index, keyframe) in recorded.iter().enumerate().step_by(8) {
            let began = Instant::now();
            let dropped = finder.dynamic_points(graph, KeyframeId(index as u32), &keyframe.cloud);
            self.people_ms += milliseconds(began);
            clouds += 1;
            let mut is_dropped = vec![false; keyframe.cloud.len()];
            dropped.iter().for_each(|&point| is_dropped[point as usize] = true);
            for (point, dropped) in keyframe.cloud.iter().zip(is_dropped) {
                let place = keyframe.site_from_base * nalgebra::Point3::from(point.map(f64::from));
                let built = site.distance(&place.coords, MIN_PERSON_DISTANCE_M).is_some();
                let (count, gone) = if built {
                    (&mut self.site, &mut self.site_dropped)
                } else {
                    (&mut self.people, &mut self.people_dropped)
                };
                *count += 1;
                *gone += usize::from(dropped);
            }
        }
        self.people_ms /= f64::from(clouds.max(1));
    }

    /// Prints one line.
    pub fn print(&self, case: &str) {
        let percent = |part: usize, whole: usize| 100.0 * part as f64 / whole.max(1) as f64;
        println!(
            "{case:<12} appearance: right place first {:.1} %, among five {:.1} % of {}; people dropped {:.1} % of {}, site {:.3} % of {}",
            percent(self.first_right, self.searched),
            percent(self.five_right, self.searched),
            self.searched,
            percent(self.people_dropped, self.people),
            self.people,
            percent(self.site_dropped, self.site),
            self.site,
        );
        println!(
            "{case:<12} ms: cloud {:.2}, descriptor {:.2}, search of three views {:.2} (one view in {LARGE_INDEX}: {:.2}), people with {} voters {:.2}",
            self.cloud_ms,
            self.descriptor_ms,
            self.search_ms,
            self.search_many_ms,
            DynamicPointsConfig::default().max_voters,
            self.people_ms,
        );
    }
}

fn near(a: &Isometry, b: &Isometry) -> bool {
    let offset: Vector3 = a.translation.vector - b.translation.vector;
    offset.xy().norm() < MAX_DISTANCE_M && offset.z.abs() < MAX_HEIGHT_M
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
