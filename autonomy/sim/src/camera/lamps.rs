//! Where light comes from: lamps under the ceilings, and the sun where there is none.

use crate::ray_packet::{NO_HIT, RayPacket};
use crate::site::SimulatedSite;
use geometry::Vector3;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// Distance between lamps, metres: a small room has one.
const SPACING_M: f64 = 3.0;
/// Height of a lamp below its ceiling, metres.
const BELOW_CEILING_M: f64 = 0.15;
/// Least height of a ceiling above the floor, metres. Lower gaps are the insides of racks and ducts.
const MIN_CEILING_M: f64 = 2.2;
/// Greatest height of lamps above the floor, metres: those of a high hall hang from cables.
const MAX_LAMP_HEIGHT_M: f64 = 6.0;
/// Floors that are looked for under one point of the ground plan.
const MAX_FLOORS: usize = 6;
/// The sun is taken into account where more than this share of the places has no lamp. Walls and machines under a ceiling have none either.
const OPEN_SHARE: f64 = 0.2;
/// Half the edge of a lamp, metres: how soft shadows are. Each pixel has one ray to each lamp, so a larger lamp makes more grain.
pub(super) const LAMP_HALF_M: f32 = 0.05;
/// The sun of a scene of which nothing else is said: light relative to that of the lamps on the floor below, and the direction to it.
const DEFAULT_SUN: Sun = Sun { strength: 2.5, to_sun: [0.48, 0.36, 0.8] };
/// A lamp lights up what is nearer than this, metres; its light fades smoothly to nothing there. It bounds the number of lamps at a point.
const REACH_M: f32 = 9.0;
/// Edge of the cells in which lamps are looked up, metres.
const CELL_M: f32 = 3.0;
/// Positions that differ by less along each axis are of one lamp, metres.
const SAME_LAMP_M: f32 = 1e-3;
/// Greatest number of lamps of which shadows are cast at a point.
pub(super) const SHADOWED: usize = 3;

/// A lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lamp {
    /// Site frame, metres.
    pub(super) position: [f32; 3],
    /// Light at a distance of 1 m; the floor below a lamp has light 1.
    pub(super) intensity: f32,
}

/// The sun over a site.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sun {
    /// Light relative to that of the lamps on the floor below.
    pub(super) strength: f32,
    /// Direction to the sun, a unit vector.
    pub(super) to_sun: [f32; 3],
}

/// The lamps of a site.
#[derive(Clone, Debug, Default)]
pub(super) struct Lamps {
    /// The lamps within reach of each cell of the ground plan.
    cells: BTreeMap<[i32; 2], Vec<Lamp>>,
    /// The sun, if a part of the site has no ceiling, so that it shines on it.
    sun: Option<Sun>,
}

/// Light at a point, to be weighted by the normal there. It changes smoothly with the point.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalLight {
    /// The strongest lamps, the strongest first, with the share of their light of which a shadow is cast; `None` where there are fewer. The share is that
    /// above the light of the next weaker lamp, so nothing jumps where two lamps change their order.
    pub(super) strongest: [Option<(Lamp, f32)>; SHADOWED],
    /// Sum of all other light, as a vector towards it.
    pub(super) rest: [f32; 3],
}

impl Lamps {
    /// A lamp every 3 m under each ceiling.
    pub(super) fn of(site: &SimulatedSite) -> Self {
        let (mut lamps, mut places, mut open) = (Vec::new(), 0, 0);
        let Some((min, max)) = bounds(site) else {
            return Self { sun: Some(DEFAULT_SUN), ..Self::default() };
        };
        let steps = |axis: usize| {
            let count = ((max[axis] - min[axis]) / SPACING_M).floor().clamp(1.0, 400.0) as usize;
            let first = 0.5 * (min[axis] + max[axis] - SPACING_M * (count - 1) as f64);
            (0..count).map(move |step| first + SPACING_M * step as f64)
        };
        for x in steps(0) {
            for y in steps(1) {
                let found = lamps_over(site, x, y, max.z + 1.0);
                places += 1;
                open += usize::from(found.is_empty());
                lamps.extend(found);
            }
        }
        Self::new(&lamps, (open as f64 > OPEN_SHARE * f64::from(places)).then_some(DEFAULT_SUN))
    }

    fn new(lamps: &[Lamp], sun: Option<Sun>) -> Self {
        let mut cells: BTreeMap<[i32; 2], Vec<Lamp>> = BTreeMap::new();
        let reach = (REACH_M / CELL_M).ceil() as i32;
        for lamp in lamps {
            let [x, y] = cell_of(lamp.position);
            for x in x - reach..=x + reach {
                for y in y - reach..=y + reach {
                    let nearest = [(x, 0), (y, 1)].map(|(cell, axis)| {
                        let low = cell as f32 * CELL_M;
                        lamp.position[axis].clamp(low, low + CELL_M) - lamp.position[axis]
                    });
                    if nearest[0].hypot(nearest[1]) < REACH_M {
                        cells.entry([x, y]).or_default().push(*lamp);
                    }
                }
            }
        }
        Self { cells, sun }
    }

    /// Where the lamps are, site frame, metres, in a fixed order.
    pub(super) fn positions(&self) -> Vec<[f32; 3]> {
        let mut positions: Vec<[f32; 3]> = self.cells.values().flatten().map(|lamp| lamp.position).collect();
        // A lamp is listed in each cell that it reaches.
        positions.sort_by(|a, b| {
            let differing = a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
            differing.unwrap_or(Ordering::Equal)
        });
        positions.dedup();
        positions
    }

    /// The lamps without one, site frame, metres.
    pub(super) fn without(mut self, position: [f32; 3]) -> Self {
        let is_other = |lamp: &Lamp| (0..3).any(|i| (lamp.position[i] - position[i]).abs() > SAME_LAMP_M);
        for lamps in self.cells.values_mut() {
            lamps.retain(is_other);
        }
        self
    }

    /// The sun, if a part of the site has no ceiling.
    pub(super) fn sun(&self) -> Option<Sun> {
        self.sun
    }

    /// Multiplies the light of each lamp by what `level` says of its place, and takes another sun if there is one.
    pub(super) fn relit(&self, level: impl Fn([f32; 3]) -> f32, sun: Sun) -> Self {
        let mut relit = self.clone();
        for lamp in relit.cells.values_mut().flatten() {
            lamp.intensity *= level(lamp.position);
        }
        relit.sun = relit.sun.map(|_| sun);
        relit
    }

    /// The light at a point, site frame, metres. Linear in the number of lamps within reach.
    pub(super) fn at(&self, point: [f32; 3]) -> LocalLight {
        let mut strongest: [Option<Lamp>; SHADOWED + 1] = [None; SHADOWED + 1];
        let mut strength = [0.0_f32; SHADOWED + 1];
        let mut rest = [0.0_f32; 3];
        let mut add = |lamp: &Lamp, strength: f32| {
            let offset = [0, 1, 2].map(|axis| lamp.position[axis] - point[axis]);
            let distance = offset.iter().map(|o| o * o).sum::<f32>().sqrt().max(1e-3);
            for axis in 0..3 {
                rest[axis] += strength * offset[axis] / distance;
            }
        };
        for lamp in self.cells.get(&cell_of(point)).into_iter().flatten() {
            let mut candidate = (*lamp, strength_at(lamp, point));
            for place in 0..=SHADOWED {
                if candidate.1 > strength[place] {
                    std::mem::swap(&mut candidate.1, &mut strength[place]);
                    if let Some(weaker) = strongest[place].replace(candidate.0) {
                        candidate.0 = weaker;
                    }
                }
            }
            add(&candidate.0, candidate.1);
        }
        let next = strength[SHADOWED];
        for lamp in strongest.iter().flatten() {
            add(lamp, next);
        }
        let shadowed = std::array::from_fn(|place| Some((strongest[place]?, 1.0 - next / strength[place])));
        LocalLight { strongest: shadowed, rest }
    }
}

/// The cell in which a point is.
fn cell_of(point: [f32; 3]) -> [i32; 2] {
    [0, 1].map(|axis| (point[axis] / CELL_M).floor() as i32)
}

/// Light of a lamp at a point, without the angle of the surface.
pub(super) fn strength_at(lamp: &Lamp, point: [f32; 3]) -> f32 {
    let squared: f32 = (0..3).map(|axis| (lamp.position[axis] - point[axis]).powi(2)).sum();
    let fade = (1.0 - squared / (REACH_M * REACH_M)).max(0.0);
    lamp.intensity / squared.max(0.01) * fade * fade
}

/// The box round the ground plan and the solids; `None` without a ground plan.
fn bounds(site: &SimulatedSite) -> Option<(Vector3, Vector3)> {
    let outline = site.outline();
    let edge = |axis: usize, pick: fn(f64, f64) -> f64| {
        outline.iter().map(|corner| corner[axis]).reduce(pick).unwrap_or_default()
    };
    let heights = site.solids().iter().map(|solid| solid.shape.bounds());
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (min, max)| {
        (low.min(min.z), high.max(max.z))
    });
    (!outline.is_empty() && low < high).then(|| {
        let min = Vector3::new(edge(0, f64::min), edge(1, f64::min), low);
        (min, Vector3::new(edge(0, f64::max), edge(1, f64::max), high))
    })
}

/// The lamps above one point of the ground plan, one for each floor with a ceiling.
fn lamps_over(site: &SimulatedSite, x: f64, y: f64, top: f64) -> Vec<Lamp> {
    let mut lamps = Vec::new();
    let mut from = Vector3::new(x, y, top);
    let mut ceiling: Option<f64> = None;
    for _ in 0..MAX_FLOORS {
        let Some((down, _)) = site.cast_ray(&from, &-Vector3::z(), 200.0) else { break };
        let floor = from.z - down;
        if let Some(ceiling) = ceiling
            && ceiling - floor >= MIN_CEILING_M
        {
            let height = (ceiling - floor - BELOW_CEILING_M).min(MAX_LAMP_HEIGHT_M);
            let position = Vector3::new(x, y, floor + height);
            // A duct may be where the lamp would be.
            if site.distance(&position, 0.1).is_none_or(|distance| distance > 0.0) {
                let position = [x as f32, y as f32, position.z as f32];
                lamps.push(Lamp { position, intensity: (height * height) as f32 });
            }
        }
        // The underside of what the ray has met: a ray up from below it, or the next floor if nothing is met.
        let Some(underside) = underside(site, x, y, floor) else { break };
        ceiling = Some(underside);
        from.z = underside - 1e-3;
    }
    lamps
}

/// Height at which the solid whose upper side is at `upper` ends below; `None` if it cannot be seen from below.
fn underside(site: &SimulatedSite, x: f64, y: f64, upper: f64) -> Option<f64> {
    const THICKNESSES_M: [f64; 6] = [0.05, 0.15, 0.3, 0.5, 0.8, 1.2];
    THICKNESSES_M.into_iter().find_map(|thickness| {
        let below = upper - thickness;
        let mut packet = RayPacket::single(&Vector3::new(x, y, below), &Vector3::z(), thickness as f32);
        site.bvh().cast(&mut packet);
        (packet.solid[0] != NO_HIT).then(|| below + f64::from(packet.range[0]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::SiteName;

    #[test]
    fn every_floor_under_a_ceiling_has_lamps_and_none_is_inside_a_solid() {
        for name in [SiteName::B1, SiteName::Plant, SiteName::Generated(3)] {
            let site = SimulatedSite::new(name);
            let lamps = Lamps::of(&site);
            let listed: Vec<Lamp> = lamps.cells.values().flatten().copied().collect();
            assert!(listed.len() > 200, "{name}: {}", listed.len());
            for lamp in &listed {
                let [x, y, z] = lamp.position.map(f64::from);
                let distance = site.distance(&Vector3::new(x, y, z), 1.0);
                assert!(distance.is_none_or(|distance| distance > -0.05), "{name}: {lamp:?} {distance:?}");
            }
        }
    }

    #[test]
    fn light_does_not_jump_where_lamps_change_their_order_and_every_lamp_counts_once() {
        let lamp = |x: f32| Lamp { position: [x, 0.0, 2.0], intensity: 4.0 };
        let lamps = Lamps::new(&[5.0, 1.0, 0.0, 9.0, 3.0, -4.0].map(lamp), None);
        // Without shadows, as the sum of the parts.
        let total = |x: f32| {
            let point = [x, 0.0, 0.0];
            let light = lamps.at(point);
            let shadowed = light.strongest.iter().flatten().map(|(lamp, share)| {
                let offset = lamp.position[0] - x;
                share * strength_at(lamp, point) * 2.0 / (offset * offset + 4.0).sqrt()
            });
            (shadowed.sum::<f32>(), light.rest[2])
        };
        let expected = |x: f32| {
            let each = |at: f32| strength_at(&lamp(at), [x, 0.0, 0.0]) * 2.0 / (at - x).hypot(2.0);
            [5.0, 1.0, 0.0, 9.0, 3.0, -4.0].map(each).iter().sum::<f32>()
        };
        let mut before: Option<(f32, f32)> = None;
        for step in 0..2000 {
            let x = -5.0 + 0.008 * step as f32;
            let (shadowed, rest) = total(x);
            assert!((shadowed + rest - expected(x)).abs() < 1e-4, "{x}");
            if let Some(before) = before {
                assert!((shadowed - before.0).abs() < 0.02 && (rest - before.1).abs() < 0.02, "{x}");
            }
            before = Some((shadowed, rest));
        }
    }
}
