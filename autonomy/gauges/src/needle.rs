//! The needle in the evidence of one kind.

use crate::evidence::Evidence;
use crate::rays::Rays;
use crate::{Dial, EvidenceKind, GaugeConfig};
use std::f64::consts::TAU;

/// A needle that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Needle {
    pub(crate) kind: EvidenceKind,
    /// Its direction, radians, clockwise from up, 0 to below a turn.
    pub(crate) direction_rad: f64,
    /// Standard deviation of the direction, radians, without that of the dial.
    pub(crate) spread_rad: f64,
    /// Its length, pixels.
    pub(crate) length_px: f64,
    /// How clearly it is one needle, 0 to 1.
    pub(crate) quality: f64,
}

/// The needle of evidence: the longest run from the axis. None if no run begins there. Linear in the rays and their steps
/// (its quality: docs/maths/gauges.md, equation 4).
pub(crate) fn find(evidence: &Evidence, dial: &Dial, config: &GaugeConfig) -> Option<Needle> {
    let rays = Rays::new(evidence, dial, config);
    let runs: Vec<f64> = (0..rays.count()).map(|ray| rays.run_px(ray, dial.radius_px, config)).collect();
    let longest = (0..runs.len()).max_by(|a, b| runs[*a].total_cmp(&runs[*b]).then(b.cmp(a)))?;
    let length_px = runs[longest];
    if length_px <= 0.0 {
        return None;
    }
    let tip = middle_of_tip(&runs, longest, config);
    let middles = middles(&rays, tip, length_px, config);
    let middle = median(&middles)?;
    let off: Vec<f64> = middles.iter().map(|other| (other - middle).abs()).collect();
    let step_rad = TAU / runs.len() as f64;
    let spread = 1.48 * median(&off)?;
    let other_px = longest_elsewhere(&runs, tip, step_rad, config);
    let length_share = length_px / dial.radius_px;
    let distinctness = 1.0 - other_px / length_px;
    let contrast = evidence.signal / (evidence.signal + config.half_signal);
    let reach = if length_share > config.max_length_share { 0.5 } else { 1.0 };
    Some(Needle {
        kind: evidence.kind,
        direction_rad: (middle * step_rad).rem_euclid(TAU),
        spread_rad: spread.hypot(tip - middle) * step_rad / 2.0,
        length_px,
        quality: length_share.min(1.0) * distinctness * contrast * reach,
    })
}

/// Middle of the rays next to the longest whose runs are about as long, as a number of rays, which may be less than 0.
fn middle_of_tip(runs: &[f64], longest: usize, config: &GaugeConfig) -> f64 {
    let count = runs.len();
    let is_tip = |ray: usize| runs[ray % count] >= config.tip_share * runs[longest];
    let after = (1..count).take_while(|step| is_tip(longest + step)).count();
    let before = (1..count).take_while(|step| is_tip(longest + count - step)).count();
    longest as f64 + (after as f64 - before as f64) / 2.0
}

/// The middle between the edges of the needle at each step of its outer part, as a number of rays.
fn middles(rays: &Rays, tip: f64, length_px: f64, config: &GaugeConfig) -> Vec<f64> {
    let count = rays.count();
    let start = (tip.round() as isize).rem_euclid(count as isize) as usize;
    let (from, to) = (config.outer_from_share * length_px, config.outer_to_share * length_px);
    (from as usize..to as usize)
        .filter(|step| rays.is_needle(start, *step))
        .map(|step| {
            let max_width = count / 4;
            let after = (1..max_width).take_while(|ray| rays.is_needle(start + ray, step)).count();
            let before = (1..max_width).take_while(|ray| rays.is_needle(start + count - ray, step)).count();
            tip.round() + (after as f64 - before as f64) / 2.0
        })
        .collect()
}

/// The longest run in directions that are not the needle's, pixels.
fn longest_elsewhere(runs: &[f64], tip: f64, step_rad: f64, config: &GaugeConfig) -> f64 {
    let count = runs.len() as f64;
    let is_elsewhere = |ray: usize| {
        let apart = (ray as f64 - tip + count / 2.0).rem_euclid(count) - count / 2.0;
        apart.abs() * step_rad > config.other_direction_rad
    };
    (0..runs.len()).filter(|ray| is_elsewhere(*ray)).map(|ray| runs[ray]).fold(0.0, f64::max)
}

/// The middle one of values; none of none.
fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let low = *sorted.get(sorted.len().checked_sub(1)? / 2)?;
    let high = *sorted.get(sorted.len() / 2)?;
    Some((low + high) / 2.0)
}
