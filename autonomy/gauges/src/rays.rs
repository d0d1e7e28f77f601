//! The evidence along rays from the axis of a needle.

use crate::evidence::Evidence;
use crate::{Dial, GaugeConfig};
use std::f64::consts::TAU;

/// Whether the picture shows a needle, in steps of a pixel along rays in equal steps round the axis.
pub(crate) struct Rays {
    steps: usize,
    rays: usize,
    is_needle: Vec<bool>,
}

impl Rays {
    /// The rays of a dial. Linear in the pixels round it.
    pub(crate) fn new(evidence: &Evidence, dial: &Dial, config: &GaugeConfig) -> Self {
        let (rays, steps) = (config.rays.max(1), (dial.radius_px * config.reach_share).ceil() as usize);
        let mut is_needle = Vec::with_capacity(rays * steps);
        for ray in 0..rays {
            let (sine, cosine) = (ray as f64 / rays as f64 * TAU).sin_cos();
            is_needle.extend((0..steps).map(|step| {
                let range_px = step as f64 + 0.5;
                evidence.is_needle([dial.axis_px[0] + sine * range_px, dial.axis_px[1] - cosine * range_px])
            }));
        }
        Self { steps, rays, is_needle }
    }

    /// Number of rays.
    pub(crate) fn count(&self) -> usize {
        self.rays
    }

    /// Whether there is needle at a step of a ray, which counts round.
    pub(crate) fn is_needle(&self, ray: usize, step: usize) -> bool {
        step < self.steps && self.is_needle[(ray % self.rays) * self.steps + step]
    }

    /// Where the run of needle along a ray that begins near the axis ends, pixels; 0 without one.
    pub(crate) fn run_px(&self, ray: usize, radius_px: f64, config: &GaugeConfig) -> f64 {
        let start_max = (config.run_start_share * radius_px) as usize;
        let max_gap = ((config.gap_share * radius_px) as usize).max(1);
        let (mut end, mut gap) = (0, 0);
        for step in (config.run_from_share * radius_px) as usize..self.steps {
            if self.is_needle(ray, step) {
                (end, gap) = (step + 1, 0);
            } else if end > 0 {
                gap += 1;
                if gap > max_gap {
                    break;
                }
            } else if step >= start_max {
                break;
            }
        }
        end as f64
    }
}
