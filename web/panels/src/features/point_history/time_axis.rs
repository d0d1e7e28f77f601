//! The axis of time: from instants to places on the screen and back, and where its labels stand.

use egui::Rect;
use missions::{SiteZone, local_of, minute_number};
use site_model::Utc;

/// Distances of labels that are tried, minutes: hours, days, weeks, about months, quarters and years.
const STEPS_MIN: [i64; 12] = [
    60,
    3 * 60,
    6 * 60,
    12 * 60,
    DAY_MIN,
    2 * DAY_MIN,
    7 * DAY_MIN,
    14 * DAY_MIN,
    30 * DAY_MIN,
    91 * DAY_MIN,
    182 * DAY_MIN,
    365 * DAY_MIN,
];
/// Minutes of a day.
pub(super) const DAY_MIN: i64 = 24 * 60;
/// Least distance of labels, points.
const LABEL_DISTANCE: f32 = 64.0;

/// A stretch of time over the width of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TimeAxis {
    pub(super) from: Utc,
    pub(super) to: Utc,
    pub(super) left: f32,
    pub(super) width: f32,
}

impl TimeAxis {
    /// Of a stretch whose end is later than its beginning.
    pub(super) fn new([from, to]: [Utc; 2], place: Rect) -> Self {
        Self { from, to, left: place.left(), width: place.width().max(1.0) }
    }

    /// Where an instant is.
    pub(super) fn x(&self, at: Utc) -> f32 {
        let share = (at.0 - self.from.0) as f64 / self.length_ns();
        self.left + (share * f64::from(self.width)) as f32
    }

    /// The instant at a place, within the axis.
    pub(super) fn at(&self, x: f32) -> Utc {
        let share = f64::from((x - self.left) / self.width).clamp(0.0, 1.0);
        Utc(self.from.0 + (share * self.length_ns()) as i64)
    }

    /// The column of a pixel, a point wide, in which an instant is; none outside the axis.
    pub(super) fn column(&self, at: Utc) -> Option<usize> {
        let is_inside = (self.from..=self.to).contains(&at);
        is_inside.then(|| ((self.x(at) - self.left) as usize).min(self.columns() - 1))
    }

    /// Number of columns.
    pub(super) fn columns(&self) -> usize {
        (self.width as usize).max(1)
    }

    /// The middle of a column.
    pub(super) fn column_x(&self, column: usize) -> f32 {
        self.left + column as f32 + 0.5
    }

    /// Instants with a label, and the distance between them, minutes: whole hours or midnights by the clock of the site.
    pub(super) fn labels(&self, zone: &SiteZone) -> (Vec<Utc>, i64) {
        let most = f64::from((self.width / LABEL_DISTANCE).max(1.0));
        let length_min = self.length_ns() / 60e9;
        let step = STEPS_MIN.into_iter().find(|step| length_min / *step as f64 <= most);
        let step = step.unwrap_or_else(|| (length_min / most) as i64 + 1);
        let [first, last] = [self.from, self.to].map(|at| minute_number(zone.to_local(at)));
        let numbers = first.div_euclid(step) + 1..=last.div_euclid(step);
        let instants = numbers.filter_map(|number| Some(zone.to_utc(local_of(number * step))?.0));
        (instants.filter(|at| (self.from..=self.to).contains(at)).collect(), step)
    }

    fn length_ns(&self) -> f64 {
        (self.to.0 - self.from.0).max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{pos2, vec2};

    const HOUR_NS: i64 = 3_600_000_000_000;
    /// 2026-03-28T00:00 UTC; clocks in Rome go forward in the night after it.
    const BEGIN: Utc = Utc(1_774_656_000_000_000_000);

    fn axis(hours: i64) -> TimeAxis {
        let place = Rect::from_min_size(pos2(10.0, 0.0), vec2(320.0, 40.0));
        TimeAxis::new([BEGIN, Utc(BEGIN.0 + hours * HOUR_NS)], place)
    }

    #[test]
    fn places_and_instants_belong_together() {
        let axis = axis(320);
        let at = Utc(BEGIN.0 + 100 * HOUR_NS);
        assert!((axis.x(at) - 110.0).abs() < 1e-3);
        assert_eq!(axis.at(axis.x(at)).0 / HOUR_NS, at.0 / HOUR_NS);
        assert_eq!((axis.column(at), axis.columns()), (Some(100), 320));
        assert_eq!(axis.column(Utc(BEGIN.0 - 1)), None);
        assert_eq!((axis.column(axis.to), axis.at(5_000.0)), (Some(319), axis.to));
    }

    #[test]
    fn labels_stand_at_midnights_of_the_site_also_after_a_change_of_its_clocks() {
        let rome = SiteZone::new("Europe/Rome").unwrap();
        let (labels, step_min) = axis(96).labels(&rome);
        assert_eq!(step_min, DAY_MIN);
        let midnights: Vec<_> = labels.iter().map(|at| rome.to_local(*at).time).collect();
        assert_eq!(labels.len(), 4);
        assert!(midnights.iter().all(|time| (time.hour, time.minute) == (0, 0)), "{midnights:?}");
        let (labels, step_min) = axis(24).labels(&rome);
        assert_eq!((labels.len(), step_min), (4, 6 * 60));
        let (labels, _) = axis(24 * 365 * 40).labels(&rome);
        assert!((1..=5).contains(&labels.len()), "{}", labels.len());
    }
}
