//! What a run should name: what has changed at the places it passes since they were last passed.

use crate::comparison::Found;
use changes::{SensorView, UprightBox};
use geometry::Vector3;
use sim::{LooseObject, ObjectChange};
use std::fmt;

/// A run has passed a thing if it has at least this number of points of it, and the place of one that is gone if as many rays went through its middle.
const PASSED_RAYS: usize = 30;
/// What is named within this distance of a changed thing is that thing, metres.
const NEAR_M: f64 = 0.5;
/// Things with a side of at least this length are counted, metres; smaller ones may be named or not.
const LARGE_M: f64 = 0.3;

/// Which end of a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// Something stands where nothing stood.
    New,
    /// Nothing stands where something stood.
    Gone,
}

/// One end of a change that no run has passed yet.
struct Pending {
    end: End,
    place: UprightBox,
    /// Whether it has to be named: it is large, was moved from where it stood, and the background shows it.
    counts: bool,
    /// Whether a run has passed it and did not name it.
    is_late: bool,
}

/// Numbers of ends of changes.
#[derive(Clone, Copy, Debug, Default)]
pub struct NewsScore {
    /// Ends of large things that were passed for the first time, and those of them that were named then.
    pub passed: usize,
    pub named: usize,
    /// Named by a later run only.
    pub late: usize,
    /// Named though an earlier run has named it.
    pub repeated: usize,
    /// Named where nothing has changed.
    pub wrong: usize,
    /// All that were named.
    pub all_named: usize,
}

impl NewsScore {
    /// Adds another score.
    pub fn add(&mut self, other: &Self) {
        self.passed += other.passed;
        self.named += other.named;
        self.late += other.late;
        self.repeated += other.repeated;
        self.wrong += other.wrong;
        self.all_named += other.all_named;
    }

    /// Share of the ends that were named by the first run that passed them.
    pub fn named_share(&self) -> f64 {
        self.named as f64 / self.passed.max(1) as f64
    }

    /// Share of what was named that had changed and was not known.
    pub fn right_share(&self) -> f64 {
        1.0 - (self.repeated + self.wrong) as f64 / self.all_named.max(1) as f64
    }
}

impl fmt::Display for NewsScore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} of {} ends of changes of 0.3 m and more were named by the first run that passed them ({:.1} %), {} by a later one; of {} named ends {:.1} % are news, {} were known, {} are wrong",
            self.named,
            self.passed,
            100.0 * self.named_share(),
            self.late,
            self.all_named,
            100.0 * self.right_share(),
            self.repeated,
            self.wrong
        )
    }
}

/// What has changed and was not passed yet, and what was named.
#[derive(Default)]
pub struct News {
    pending: Vec<Pending>,
    named: Vec<(End, UprightBox)>,
    /// Places of things that a run has points of.
    seen: Vec<UprightBox>,
}

impl News {
    /// Notes what a run shows without a comparison: the first one.
    pub fn first_run(&mut self, things: &[LooseObject], views: &[SensorView]) {
        let places = things.iter().map(place);
        self.seen = places.filter(|place| points_of(place, views) >= PASSED_RAYS).collect();
    }

    /// Notes changes. What is gone before a run has passed it was never news.
    pub fn change(&mut self, changes: &[ObjectChange]) {
        for change in changes {
            match change {
                ObjectChange::Put(thing) => self.add(End::New, thing, true),
                ObjectChange::Taken(thing) => self.add(End::Gone, thing, true),
                ObjectChange::Moved { from, to } => {
                    self.add(End::Gone, from, true);
                    self.add(End::New, to, true);
                }
                ObjectChange::Turned { from, to } => {
                    self.add(End::Gone, from, false);
                    self.add(End::New, to, false);
                }
            }
        }
    }

    fn add(&mut self, end: End, thing: &LooseObject, counts: bool) {
        let place = place(thing);
        let is_same = |other: &UprightBox| (other.centre_m - place.centre_m).norm() < 1e-6;
        if end == End::Gone {
            let known = self.pending.len();
            self.pending.retain(|other| other.end != End::New || !is_same(&other.place));
            if self.pending.len() < known {
                return;
            }
        }
        let is_large = thing.size_m.into_iter().fold(0.0, f64::max) >= LARGE_M;
        let is_shown = end == End::New || self.seen.iter().any(is_same);
        self.pending.push(Pending { end, place, counts: counts && is_large && is_shown, is_late: false });
    }

    /// Scores what a run has named. What was not named, was known or is wrong is said to `explain`.
    pub fn score(
        &mut self,
        found: &[Found],
        views: &[SensorView],
        mut explain: impl FnMut(String),
    ) -> NewsScore {
        let mut score = NewsScore::default();
        let of_found = |found: &Found| [(End::New, found.is), (End::Gone, found.was)];
        let ends: Vec<(End, UprightBox)> =
            found.iter().flat_map(of_found).filter_map(|(end, place)| Some((end, place?))).collect();
        let is_named = |pending: &Pending| {
            ends.iter().any(|(end, place)| *end == pending.end && is_near(place, &pending.place))
        };
        for (end, place) in &ends {
            score.all_named += 1;
            if self.pending.iter().any(|pending| is_near(place, &pending.place)) {
                continue;
            }
            let is_known = self.named.iter().any(|(_, known)| is_near(place, known));
            score.repeated += usize::from(is_known);
            score.wrong += usize::from(!is_known);
            explain(format!("{}: {}", if is_known { "known" } else { "wrong" }, described(*end, place)));
        }
        let mut pending = std::mem::take(&mut self.pending);
        pending.retain_mut(|pending| {
            let has_passed = match pending.end {
                End::New => points_of(&pending.place, views) >= PASSED_RAYS,
                End::Gone => rays_through(&pending.place, views) >= PASSED_RAYS,
            };
            let is_named = is_named(pending);
            if pending.counts && pending.is_late {
                score.late += usize::from(is_named);
            } else if pending.counts && (has_passed || is_named) {
                score.passed += 1;
                score.named += usize::from(is_named);
                if !is_named {
                    explain(format!("not named: {}", described(pending.end, &pending.place)));
                }
            }
            if pending.end == End::New && has_passed {
                self.seen.push(pending.place);
            }
            pending.is_late |= has_passed;
            // What does not count, and was passed, may still be named later.
            !is_named
        });
        self.pending = pending;
        self.named.extend(ends);
        score
    }
}

fn described(end: End, place: &UprightBox) -> String {
    let end = if end == End::New { "new" } else { "gone" };
    format!("{end} at {:.2?}, {:.2?}", place.centre_m.as_slice(), place.size_m)
}

fn place(thing: &LooseObject) -> UprightBox {
    UprightBox { centre_m: thing.middle(), size_m: thing.size_m, yaw_rad: thing.yaw_rad }
}

fn is_near(found: &UprightBox, truth: &UprightBox) -> bool {
    truth.holds(&found.centre_m, NEAR_M)
}

/// Points of a thing above its lower end.
fn points_of(place: &UprightBox, views: &[SensorView]) -> usize {
    let above = place.down_to(place.bottom_m() + 0.05);
    let points = views.iter().flat_map(|view| &view.points);
    points.filter(|point| above.holds(&Vector3::from(point.map(f64::from)), 0.02)).count()
}

/// Rays that went through the middle of a place: closer to it than half of its shortest side, and on behind it.
fn rays_through(place: &UprightBox, views: &[SensorView]) -> usize {
    let within_m = place.size_m.into_iter().fold(f64::INFINITY, f64::min) / 2.0;
    let behind_m = place.size_m.into_iter().fold(0.0, f64::max);
    let through = |view: &SensorView| {
        let offset = place.centre_m - view.sensor;
        let goes_through = |point: &&[f32; 3]| {
            let ray = Vector3::from(point.map(f64::from)) - view.sensor;
            let range_m = ray.norm();
            let at_m = ray.dot(&offset) / range_m;
            at_m > 0.0 && at_m + behind_m < range_m && (offset - ray * (at_m / range_m)).norm() < within_m
        };
        view.points.iter().filter(goes_through).count()
    };
    views.iter().map(through).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::Material;

    fn thing(x: f64) -> LooseObject {
        LooseObject {
            foot: Vector3::new(x, 0.0, 0.0),
            size_m: [0.5, 0.5, 0.5],
            yaw_rad: 0.0,
            material: Material::Wood,
        }
    }

    /// A view from 4 m before a place, of a wall behind it or of a thing there.
    fn view(x: f64, is_there: bool) -> Vec<SensorView> {
        let y = if is_there { -0.25 } else { 2.0 };
        let at = |index: i32| f64::from(index) * 0.02;
        let points =
            (-5..5).flat_map(|across| (8..18).map(move |up| [x + at(across), y, at(up)].map(|at| at as f32)));
        vec![SensorView { sensor: Vector3::new(x, -4.0, 0.3), points: points.collect() }]
    }

    #[test]
    fn each_end_is_news_once_and_only_for_a_run_that_passes_it() {
        let mut news = News::default();
        let found = |thing: &LooseObject, is_new: bool| {
            let place = place(thing);
            vec![Found { was: (!is_new).then_some(place), is: is_new.then_some(place) }]
        };
        let score = |news: &mut News, found: &[Found], views: &[SensorView]| {
            let score = news.score(found, views, |_| {});
            [score.passed, score.named, score.late, score.repeated, score.wrong]
        };
        news.first_run(&[thing(0.0)], &view(0.0, true));
        news.change(&[ObjectChange::Taken(thing(0.0)), ObjectChange::Put(thing(9.0))]);
        assert_eq!(score(&mut news, &[], &view(50.0, false)), [0; 5], "it was elsewhere");
        assert_eq!(score(&mut news, &found(&thing(0.0), false), &view(0.0, false)), [1, 1, 0, 0, 0]);
        assert_eq!(score(&mut news, &found(&thing(0.0), false), &view(0.0, false)), [0, 0, 0, 1, 0]);
        assert_eq!(score(&mut news, &[], &view(9.0, true)), [1, 0, 0, 0, 0], "not named");
        assert_eq!(score(&mut news, &found(&thing(9.0), true), &view(9.0, true)), [0, 0, 1, 0, 0]);
        assert_eq!(score(&mut news, &found(&thing(30.0), true), &view(30.0, true)), [0, 0, 0, 0, 1]);
        news.change(&[ObjectChange::Put(thing(15.0))]);
        news.change(&[ObjectChange::Taken(thing(15.0))]);
        assert_eq!(score(&mut news, &[], &view(15.0, false)), [0; 5], "nobody has seen it");
    }
}
