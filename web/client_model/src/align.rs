//! Points picked in two saved maps, so that one can be laid into the frame of the other.

use crate::{ClientEffect, Model};
use api::{Command, MAX_PAIRS};
use vocab::{MapId, UploadId, Vec3};

/// How far laying one map into the frame of another has come.
#[derive(Clone, Debug, PartialEq)]
pub struct Align {
    /// The map that is to be laid.
    pub map: MapId,
    /// The one whose frame it is to have; `None` until it is chosen.
    pub onto: Option<MapId>,
    /// The same points in both, that of `map` first, metres.
    pub pairs: Vec<[Vec3; 2]>,
    /// A point of `map` whose like in the other one comes next.
    pub first: Option<Vec3>,
    /// The work of laying it, while that is under way: what is picked stays until it is done, in case it fails.
    pub laying: Option<UploadId>,
}

impl Align {
    /// The map in which the next point is to be picked; `None` if that is none.
    pub fn picks_in(&self) -> Option<MapId> {
        let onto = self.onto.filter(|_| self.laying.is_none())?;
        if self.first.is_some() {
            Some(onto)
        } else {
            Some(self.map).filter(|_| self.pairs.len() < MAX_PAIRS)
        }
    }

    /// The points picked in one of the two maps, in their order.
    pub fn picked_in(&self, map: MapId) -> Vec<Vec3> {
        let side = usize::from(Some(map) == self.onto && map != self.map);
        let first = self.first.filter(|_| side == 0);
        self.pairs.iter().map(|pair| pair[side]).chain(first).collect()
    }

    /// How far the pairs stay apart when the map is laid by them as well as possible, root mean square, metres; `None` for fewer than two
    /// or for points above each other, which leave the heading open.
    ///
    /// The heading that minimises the sum of squares in the plane: `atan2(sum a x b, sum a . b)` of the offsets from the means.
    pub fn apart(&self) -> Option<f64> {
        let count = self.pairs.len() as f64;
        let mean = |side: usize| {
            let sum = self.pairs.iter().fold(Vec3::default(), |sum, pair| {
                Vec3::new(sum.x + pair[side].x, sum.y + pair[side].y, sum.z + pair[side].z)
            });
            Vec3::new(sum.x / count, sum.y / count, sum.z / count)
        };
        if self.pairs.len() < 2 {
            return None;
        }
        let means = [mean(0), mean(1)];
        let centred = self.pairs.iter().map(|pair| {
            [0, 1].map(|side| {
                let (at, mean) = (pair[side], means[side]);
                Vec3::new(at.x - mean.x, at.y - mean.y, at.z - mean.z)
            })
        });
        let centred: Vec<[Vec3; 2]> = centred.collect();
        let (cross, dot) = centred.iter().fold((0.0, 0.0), |(cross, dot), [a, b]| {
            (cross + a.x * b.y - a.y * b.x, dot + a.x * b.x + a.y * b.y)
        });
        let spread: f64 = centred.iter().map(|[a, _]| a.x * a.x + a.y * a.y).sum();
        let (sin, cos) = f64::atan2(cross, dot).sin_cos();
        let squares = centred.iter().map(|[a, b]| {
            let off = [cos * a.x - sin * a.y - b.x, sin * a.x + cos * a.y - b.y, a.z - b.z];
            off.iter().map(|c| c * c).sum::<f64>()
        });
        (spread > 1e-4).then(|| (squares.sum::<f64>() / count).sqrt())
    }
}

impl Model {
    /// Begins to lay a map, asks onto which, or goes on to picking.
    pub(crate) fn begin_align(&mut self, map: MapId, onto: Option<MapId>, effects: &mut Vec<ClientEffect>) {
        (self.walk_armed, self.place_armed) = (false, false);
        self.align = Some(Align {
            map,
            onto: onto.filter(|onto| *onto != map),
            pairs: Vec::new(),
            first: None,
            laying: None,
        });
        self.view_map(Some(map), effects);
    }

    /// Takes a point of the map on show, and shows the one in which the next is to be picked.
    pub(crate) fn pick_point(&mut self, at: Vec3, effects: &mut Vec<ClientEffect>) {
        let viewed = self.viewed_map();
        let Some(align) = self.align.as_mut().filter(|align| align.picks_in() == viewed) else { return };
        match align.first.take() {
            Some(first) => align.pairs.push([first, at]),
            None => align.first = Some(at),
        }
        self.show_pick(effects);
    }

    /// Takes the last point back; says whether there was one.
    pub(crate) fn take_point_back(&mut self, effects: &mut Vec<ClientEffect>) -> bool {
        let Some(align) = self.align.as_mut().filter(|align| align.laying.is_none()) else { return false };
        if align.first.take().is_none() {
            let Some([first, _]) = align.pairs.pop() else { return false };
            align.first = Some(first);
        }
        self.show_pick(effects);
        true
    }

    /// Lays the map by the pairs, or by what both look like where there are none.
    pub(crate) fn lay(&mut self, effects: &mut Vec<ClientEffect>) {
        let Some(Align { map, onto: Some(onto), pairs, laying: None, .. }) = self.align.clone() else {
            return;
        };
        let name = |id| {
            let known = self.maps.iter().flatten().find(|map| map.id == id);
            known.map_or_else(|| "Map".to_owned(), |map| map.name.clone())
        };
        let name = format!("{} on {}", name(map), name(onto));
        let upload = UploadId(self.ids.map().0);
        self.align.iter_mut().for_each(|align| align.laying = Some(upload));
        self.order(Command::AlignMap { upload, name, map, onto, pairs }, effects);
    }

    /// The work has ended: what was picked has served, or can be put right.
    pub(crate) fn laid(&mut self, work: UploadId, well: bool) {
        let Some(align) = self.align.as_mut().filter(|align| align.laying == Some(work)) else { return };
        align.laying = None;
        if well {
            self.align = None;
        }
    }

    fn show_pick(&mut self, effects: &mut Vec<ClientEffect>) {
        if let Some(map) = self.align.as_ref().and_then(Align::picks_in) {
            self.view_map(Some(map), effects);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use uuid::Uuid;

    fn align(pairs: Vec<[Vec3; 2]>) -> Align {
        let [map, onto] = [1, 2].map(|number| MapId(Uuid::from_u128(number)));
        Align { map, onto: Some(onto), pairs, first: None, laying: None }
    }

    #[test]
    fn how_far_pairs_stay_apart_is_what_no_heading_and_place_takes_away() {
        let (sin, cos) = 0.7_f64.sin_cos();
        let moved = |x: f64, y: f64, z: f64| {
            [Vec3::new(x, y, z), Vec3::new(cos * x - sin * y + 4.0, sin * x + cos * y - 9.0, z + 1.5)]
        };
        let mut exact = align(vec![moved(0.0, 0.0, 0.0), moved(5.0, 1.0, 0.4), moved(-2.0, 7.0, 2.0)]);
        assert!(exact.apart().is_some_and(|apart| apart < 1e-9));
        exact.pairs[1][1].z += 0.3;
        // Of the three heights' differences the mean goes: 0.3 * sqrt(2) / 3.
        assert!(exact.apart().is_some_and(|apart| (apart - 0.3 * 2_f64.sqrt() / 3.0).abs() < 1e-9));
        assert_eq!(align(vec![moved(1.0, 1.0, 0.0)]).apart(), None);
        assert_eq!(align(vec![moved(1.0, 1.0, 0.0), moved(1.0, 1.0, 3.0)]).apart(), None);
    }
}
