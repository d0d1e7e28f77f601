//! All missions together, against the bars.

use super::score::{MissionScore, PictureScore};
use crate::quantile;

/// Bars: position and heading at a task, by the truth.
const MAX_POSITION_M: f64 = 0.10;
const MAX_HEADING_RAD: f64 = 0.0524;
/// Bar: targets are this near to the picture's centre, as a share of the picture, ...
const MAX_OFF_CENTRE: f64 = 0.05;
/// ... in this share of the pictures.
const MIN_CENTRED_SHARE: f64 = 0.95;
/// Bars: shares of tasks that are done, and of missions that end in the dock.
const MIN_DONE_SHARE: f64 = 0.99;
const MIN_DOCKED_SHARE: f64 = 0.98;

/// Sums over missions.
#[derive(Clone, Debug, Default)]
pub struct MissionTotals {
    missions: usize,
    tasks: usize,
    done: usize,
    without_reason: usize,
    pictures: Vec<PictureScore>,
    solids_touched: usize,
    people_touched: usize,
    people_walked_into_it: usize,
    docked: usize,
}

impl MissionTotals {
    /// Of these missions.
    pub fn of<'a>(scores: impl IntoIterator<Item = &'a MissionScore>) -> Self {
        let mut totals = Self::default();
        for score in scores {
            totals.missions += 1;
            totals.tasks += score.tasks;
            totals.done += score.done;
            totals.without_reason += score.without_reason();
            totals.pictures.extend(&score.pictures);
            totals.solids_touched += score.solids_touched;
            totals.people_touched += score.people_touched;
            totals.people_walked_into_it += score.people_walked_into_it;
            totals.docked += usize::from(score.docked.is_some());
        }
        totals
    }

    /// The header of the table of [`Self::row`].
    pub const HEADER: &str = "| site | missions | tasks done | failed without a reason | position: mean, worst | heading: worst | targets within 5 % of the centre | off the centre: median, worst | contacts with solids, with people | people walked into it | in the dock |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |";

    /// A row of a table in Markdown.
    pub fn row(&self, name: &str) -> String {
        let positions_m = self.sorted(|picture| picture.position_m);
        let off_centre = self.sorted(PictureScore::off_centre_or_infinite);
        format!(
            "| {name} | {} | {} of {} ({:.1} %) | {} | {:.1}, {:.1} cm | {:.2}° | {:.1} % | {:.1}, {:.1} % | {}, {} | {} | {} of {} ({:.1} %) |",
            self.missions,
            self.done,
            self.tasks,
            100.0 * share(self.done, self.tasks),
            self.without_reason,
            100.0 * positions_m.iter().sum::<f64>() / positions_m.len().max(1) as f64,
            100.0 * quantile(&positions_m, 1.0),
            quantile(&self.sorted(|picture| picture.heading_rad), 1.0).to_degrees(),
            100.0 * self.centred_share(),
            100.0 * quantile(&off_centre, 0.5),
            100.0 * quantile(&off_centre, 1.0),
            self.solids_touched,
            self.people_touched,
            self.people_walked_into_it,
            self.docked,
            self.missions,
            100.0 * share(self.docked, self.missions),
        )
    }

    /// A sentence for each bar that is missed.
    pub fn missed(&self) -> Vec<String> {
        let worst = |value: fn(&PictureScore) -> f64| self.sorted(value).last().copied().unwrap_or(0.0);
        let bars = [
            (share(self.done, self.tasks) >= MIN_DONE_SHARE, "99 % of the tasks are done"),
            (self.without_reason == 0, "every other task fails with a reason"),
            (
                worst(|picture| picture.position_m) <= MAX_POSITION_M,
                "the robot is within 10 cm at every task",
            ),
            (worst(|picture| picture.heading_rad) <= MAX_HEADING_RAD, "and within 3 degrees"),
            (
                self.centred_share() >= MIN_CENTRED_SHARE,
                "95 % of the targets are within 5 % of the picture's centre",
            ),
            (self.solids_touched == 0, "the robot touches no solid"),
            (self.people_touched == 0, "the robot touches nobody"),
            (share(self.docked, self.missions) >= MIN_DOCKED_SHARE, "98 % of the missions end in the dock"),
        ];
        bars.into_iter().filter(|(is_met, _)| !is_met).map(|(_, bar)| bar.to_owned()).collect()
    }

    fn centred_share(&self) -> f64 {
        let centred =
            self.pictures.iter().filter(|picture| picture.off_centre_or_infinite() <= MAX_OFF_CENTRE).count();
        share(centred, self.pictures.len())
    }

    fn sorted(&self, value: fn(&PictureScore) -> f64) -> Vec<f64> {
        let mut values: Vec<f64> = self.pictures.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        values
    }
}

/// One of nothing is all of it.
fn share(count: usize, of: usize) -> f64 {
    if of == 0 { 1.0 } else { count as f64 / of as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use site_model::{ReachFailure, TaskFailure};

    fn good() -> MissionScore {
        let picture = PictureScore { position_m: 0.02, heading_rad: 0.01, off_centre: Some(0.01) };
        let pictures = vec![picture; 2];
        MissionScore { tasks: 2, done: 2, pictures, docked: Some((0.01, 0.0)), ..MissionScore::default() }
    }

    #[test]
    fn every_bar_can_be_missed() {
        assert_eq!(MissionTotals::of(&[good(), good()]).missed(), [""; 0]);
        let failed = TaskFailure::NotReached(ReachFailure::PathBlocked);
        let picture = good().pictures[0];
        let bad = [
            (MissionScore { done: 1, failures: vec![failed], ..good() }, 1),
            (MissionScore { done: 1, ..good() }, 2),
            (MissionScore { pictures: vec![PictureScore { position_m: 0.11, ..picture }], ..good() }, 1),
            (MissionScore { pictures: vec![PictureScore { heading_rad: 0.06, ..picture }], ..good() }, 1),
            (MissionScore { pictures: vec![PictureScore { off_centre: None, ..picture }], ..good() }, 1),
            (MissionScore { solids_touched: 1, ..good() }, 1),
            (MissionScore { people_touched: 1, ..good() }, 1),
            (MissionScore { people_walked_into_it: 1, ..good() }, 0),
            (MissionScore { docked: None, ..good() }, 1),
        ];
        for (score, missed) in bad {
            assert_eq!(MissionTotals::of([&score]).missed().len(), missed, "{score:?}");
        }
    }
}
