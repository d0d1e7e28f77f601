//! Aligning one saved map to another: points are picked in both, then a third map is made in the frame of the second.

use super::Feature;
use crate::features::selection::PointerMode;
use crate::shared::{Context, SliceChange};
use crate::{ClientCommand, texts};
use api::{Import, MAX_PAIRS};
use vocab::{MapId, UploadId, Vec3};

/// Parameters of the alignment by pairs of points.
struct PairAlignmentConfig {
    /// Sum of squared horizontal distances from the centroid below which the points leave the heading open, square metres. 1 cm squared: two clicks on the same point.
    min_spread_m2: f64,
}

const CONFIG: PairAlignmentConfig = PairAlignmentConfig { min_spread_m2: 1e-4 };

/// The alignment of one map to another that is being prepared.
#[derive(Clone, Debug, PartialEq)]
pub struct AlignmentDraft {
    /// The map that is moved.
    pub map: MapId,
    /// The map whose frame the result has; `None` until it is chosen.
    pub reference: Option<MapId>,
    /// Corresponding points, that of `map` first, each in the frame of its map, metres.
    pub pairs: Vec<[Vec3; 2]>,
    /// A point of `map` whose corresponding point comes next.
    pub unpaired: Option<Vec3>,
    /// The job that makes the aligned map, while it runs. The points stay until it succeeds.
    pub job: Option<UploadId>,
}

impl AlignmentDraft {
    /// The map in which the next point is to be picked; `None` if no point is.
    pub fn next_map(&self) -> Option<MapId> {
        let reference = self.reference.filter(|_| self.job.is_none())?;
        if self.unpaired.is_some() {
            Some(reference)
        } else {
            Some(self.map).filter(|_| self.pairs.len() < MAX_PAIRS)
        }
    }

    /// The points picked in one of the two maps, in the order of their pairs.
    pub fn points_in(&self, map: MapId) -> Vec<Vec3> {
        let side = usize::from(Some(map) == self.reference && map != self.map);
        let unpaired = self.unpaired.filter(|_| side == 0);
        self.pairs.iter().map(|pair| pair[side]).chain(unpaired).collect()
    }

    /// Root mean square distance of corresponding points after the best alignment (heading and translation), metres. `None` for fewer than
    /// two pairs, or for points above each other, which leave the heading open.
    ///
    /// The heading that minimises the sum of squares in the plane is `atan2(sum a x b, sum a . b)` of the offsets from the centroids.
    pub fn rms_residual_m(&self) -> Option<f64> {
        let count = self.pairs.len() as f64;
        if self.pairs.len() < 2 {
            return None;
        }
        let centroid = |side: usize| {
            let sum = self.pairs.iter().fold(Vec3::default(), |sum, pair| {
                Vec3::new(sum.x + pair[side].x, sum.y + pair[side].y, sum.z + pair[side].z)
            });
            Vec3::new(sum.x / count, sum.y / count, sum.z / count)
        };
        let centroids = [centroid(0), centroid(1)];
        let centred = self.pairs.iter().map(|pair| {
            [0, 1].map(|side| {
                let (point, centroid) = (pair[side], centroids[side]);
                Vec3::new(point.x - centroid.x, point.y - centroid.y, point.z - centroid.z)
            })
        });
        let centred: Vec<[Vec3; 2]> = centred.collect();
        let (cross, dot) = centred.iter().fold((0.0, 0.0), |(cross, dot), [a, b]| {
            (cross + a.x * b.y - a.y * b.x, dot + a.x * b.x + a.y * b.y)
        });
        let spread_m2: f64 = centred.iter().map(|[a, _]| a.x * a.x + a.y * a.y).sum();
        let (sin, cos) = f64::atan2(cross, dot).sin_cos();
        let squares = centred.iter().map(|[a, b]| {
            let residual = [cos * a.x - sin * a.y - b.x, sin * a.x + cos * a.y - b.y, a.z - b.z];
            residual.iter().map(|c| c * c).sum::<f64>()
        });
        (spread_m2 > CONFIG.min_spread_m2).then(|| (squares.sum::<f64>() / count).sqrt())
    }

    /// Takes a point of the map that is viewed. Returns whether it was expected there.
    fn add_point(&mut self, viewed: Option<MapId>, point: Vec3) -> bool {
        if self.next_map() != viewed || viewed.is_none() {
            return false;
        }
        match self.unpaired.take() {
            Some(first) => self.pairs.push([first, point]),
            None => self.unpaired = Some(point),
        }
        true
    }

    /// Takes back the last point. Returns whether there was one.
    fn remove_point(&mut self) -> bool {
        if self.job.is_some() {
            return false;
        }
        if self.unpaired.take().is_none() {
            let Some([first, _]) = self.pairs.pop() else { return false };
            self.unpaired = Some(first);
        }
        true
    }
}

/// The alignment that the operator prepares, if any.
#[derive(Clone, Debug, Default)]
pub struct AlignmentFeature {
    current: Option<AlignmentDraft>,
}

impl AlignmentFeature {
    pub(crate) fn current(&self) -> Option<&AlignmentDraft> {
        self.current.as_ref()
    }

    /// Begins an alignment, or chooses its reference.
    fn begin(&mut self, map: MapId, reference: Option<MapId>, cx: &mut Context<'_>) {
        cx.shared.selected.enter(PointerMode::Select);
        self.current = Some(AlignmentDraft {
            map,
            reference: reference.filter(|reference| *reference != map),
            pairs: Vec::new(),
            unpaired: None,
            job: None,
        });
        cx.view_map(Some(map));
    }

    /// Views the map in which the next point is to be picked.
    fn view_next(&self, cx: &mut Context<'_>) {
        if let Some(map) = self.current.as_ref().and_then(AlignmentDraft::next_map) {
            cx.view_map(Some(map));
        }
    }

    fn remove_point(&mut self, cx: &mut Context<'_>) -> bool {
        let removed = self.current.as_mut().is_some_and(AlignmentDraft::remove_point);
        if removed {
            self.view_next(cx);
        }
        removed
    }

    /// Starts the job: by the pairs, or by the appearance of both maps if there are none.
    fn start(&mut self, cx: &mut Context<'_>) {
        let Some(alignment) = &mut self.current else { return };
        let (map, None, Some(onto)) = (alignment.map, alignment.job, alignment.reference) else { return };
        let name = |id| cx.shared.maps.get(id).map_or(texts::UNNAMED_MAP, |map| map.name.as_str());
        let name = texts::aligned_map_name(name(map), name(onto));
        let upload = UploadId(cx.shared.ids.map().0);
        alignment.job = Some(upload);
        let pairs = alignment.pairs.clone();
        cx.send(api::Command::AlignMap { upload, name, map, onto, pairs });
    }

    /// The job ended. After a failure the points stay, to be corrected.
    fn on_job_ended(&mut self, job: UploadId, succeeded: bool) {
        let Some(alignment) = self.current.as_mut().filter(|it| it.job == Some(job)) else { return };
        alignment.job = None;
        if succeeded {
            self.current = None;
        }
    }
}

impl Feature for AlignmentFeature {
    fn on_event(&mut self, event: &api::Event, _cx: &mut Context<'_>) {
        match event {
            api::Event::Import(Import::Done { upload, .. }) => self.on_job_ended(*upload, true),
            api::Event::Import(Import::Failed { upload, .. }) => self.on_job_ended(*upload, false),
            _ => {}
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::AlignMap { map, reference } => self.begin(*map, *reference, cx),
            ClientCommand::AddAlignmentPoint(point) => {
                let viewed = cx.shared.map_views.viewed();
                if self.current.as_mut().is_some_and(|it| it.add_point(viewed, *point)) {
                    self.view_next(cx);
                }
            }
            ClientCommand::RemoveAlignmentPoint => {
                self.remove_point(cx);
            }
            ClientCommand::StartAlignment => self.start(cx),
            ClientCommand::CancelAlignment => self.current = None,
            _ => {}
        }
    }

    fn on_change(&mut self, change: &SliceChange, _cx: &mut Context<'_>) {
        match change {
            // Whoever views a third map does not want to align these two any more.
            SliceChange::MapViewed { map, .. } => {
                self.current.take_if(|it| *map != Some(it.map) && (map.is_none() || *map != it.reference));
            }
            SliceChange::CommandAnswered {
                command: Some(api::Command::AlignMap { upload, .. }),
                accepted: false,
                ..
            } => self.on_job_ended(*upload, false),
            _ => {}
        }
    }

    fn undo_unfinished(&mut self, cx: &mut Context<'_>) -> bool {
        self.remove_point(cx)
    }
}

#[cfg(test)]
mod tests;
