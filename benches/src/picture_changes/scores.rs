//! What a site's visits came to, against the bars.

use benches::quantile;

/// Bar: the alignment is within this, pixels, ...
const MAX_RESIDUAL_PX: f64 = 1.5;
/// ... in this share of the pictures. Gauges are read this often within [`MAX_READING_SHARE`] too.
const MIN_SHARE: f64 = 0.95;
/// Bar: planted changes that are found.
const MIN_FLAGGED: f64 = 0.97;
/// Bar: pictures without a change in which one is reported.
const MAX_FALSE: f64 = 0.01;
/// Bar: error of a reading, as a share of the range.
const MAX_READING_SHARE: f64 = 0.015;

/// Counts and errors of visits.
#[derive(Clone, Debug, Default)]
pub struct Scores {
    /// Inspection points.
    pub points: usize,
    /// Pairs of pictures without a change.
    pub pairs: usize,
    /// Error of the mapping on the plate of the gauge for each pair that was aligned, pixels.
    pub plate_px: Vec<f64>,
    /// The same in the middle of the picture, whatever is there.
    pub middle_px: Vec<f64>,
    /// Pairs whose error on the plate is within the residual that the alignment states.
    pub within_stated: usize,
    /// Pairs with a reported change: on the plate of the gauge, and anywhere.
    pub false_on_plate: usize,
    pub false_anywhere: usize,
    /// Pairs with a planted change, and those of them where one is reported on the plate.
    pub planted: usize,
    pub flagged: usize,
    /// Readings of gauges: error as a share of the range; none where there is no value.
    pub readings: Vec<Option<f64>>,
    /// Gauges whose dial is smaller than what has to be read.
    pub too_small: usize,
    /// CPU times of an alignment and of a search for changes, milliseconds.
    pub align_ms: Vec<f64>,
    pub changes_ms: Vec<f64>,
}

impl Scores {
    /// The header of the table of [`Self::row`].
    pub const HEADER: &str = "| site | points | pairs, aligned | error on the plate: median, 95 %, worst, px | within 1.5 px | error within the stated residual | in the middle: median, 95 %, px | planted changes flagged | false alarms on the plate, anywhere | gauges read, within 1.5 %, too small | aligned, compared: median, ms |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |";

    /// Adds those of other visits.
    pub fn add(&mut self, other: &Self) {
        self.points += other.points;
        self.pairs += other.pairs;
        self.plate_px.extend(&other.plate_px);
        self.middle_px.extend(&other.middle_px);
        self.within_stated += other.within_stated;
        self.false_on_plate += other.false_on_plate;
        self.false_anywhere += other.false_anywhere;
        self.planted += other.planted;
        self.flagged += other.flagged;
        self.readings.extend(&other.readings);
        self.too_small += other.too_small;
        self.align_ms.extend(&other.align_ms);
        self.changes_ms.extend(&other.changes_ms);
    }

    /// A row of a table in Markdown.
    pub fn row(&self, name: &str) -> String {
        let at = |values: &[f64], share: f64| quantile(&sorted(values), share);
        format!(
            "| {name} | {} | {}, {} | {:.2}, {:.2}, {:.2} | {} | {} | {:.2}, {:.2} | {} | {}, {} | {}, {}, {} | {:.0}, {:.0} |",
            self.points,
            self.pairs,
            self.plate_px.len(),
            at(&self.plate_px, 0.5),
            at(&self.plate_px, 0.95),
            at(&self.plate_px, 1.0),
            percent(self.exact(), self.pairs),
            percent(self.within_stated, self.plate_px.len()),
            at(&self.middle_px, 0.5),
            at(&self.middle_px, 0.95),
            percent(self.flagged, self.planted),
            percent(self.false_on_plate, self.pairs),
            percent(self.false_anywhere, self.pairs),
            self.readings.iter().flatten().count(),
            percent(self.right_readings(), self.readings.len()),
            self.too_small,
            at(&self.align_ms, 0.5),
            at(&self.changes_ms, 0.5),
        )
    }

    /// A sentence for each bar that is missed.
    pub fn missed(&self) -> Vec<&'static str> {
        let bars = [
            (share(self.exact(), self.pairs) >= MIN_SHARE, "95 % of the pairs are aligned within 1.5 px"),
            (share(self.flagged, self.planted) >= MIN_FLAGGED, "97 % of the planted changes are flagged"),
            (
                1.0 - share(self.pairs - self.false_anywhere, self.pairs) <= MAX_FALSE,
                "at most 1 % of the pairs without a change have one reported",
            ),
            (
                share(self.right_readings(), self.readings.len()) >= MIN_SHARE,
                "95 % of the gauges are read within 1.5 % of their range",
            ),
        ];
        bars.into_iter().filter(|(is_met, _)| !is_met).map(|(_, bar)| bar).collect()
    }

    fn exact(&self) -> usize {
        self.plate_px.iter().filter(|error| **error <= MAX_RESIDUAL_PX).count()
    }

    fn right_readings(&self) -> usize {
        self.readings.iter().flatten().filter(|error| **error <= MAX_READING_SHARE).count()
    }
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values
}

/// NaN of nothing, so that a bar for which nothing was measured is missed.
fn share(count: usize, of: usize) -> f64 {
    count as f64 / of as f64
}

fn percent(count: usize, of: usize) -> String {
    if of == 0 { "none".to_owned() } else { format!("{count} of {of} ({:.1} %)", 100.0 * share(count, of)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bar_can_be_missed() {
        let good = Scores {
            pairs: 10,
            plate_px: vec![0.2; 10],
            planted: 10,
            flagged: 10,
            readings: vec![Some(0.01); 10],
            ..Scores::default()
        };
        assert_eq!(good.missed(), [""; 0]);
        let bad = [
            Scores { plate_px: vec![0.2; 9], ..good.clone() },
            Scores { flagged: 9, ..good.clone() },
            Scores { false_anywhere: 1, ..good.clone() },
            Scores { readings: vec![None; 10], ..good.clone() },
            Scores { readings: Vec::new(), ..good.clone() },
        ];
        for scores in bad {
            assert_eq!(scores.missed().len(), 1, "{scores:?}");
        }
    }
}
