//! Texts of the history of an inspection point, by key.

use super::gauge_draft::Missing;
use crate::features::runs::{date_and_time, reading_name};
use crate::format;
use client_model::{HistorySpan, PairAlignment, PointHistory, PointResult, ReadingSeries, ResultJudgement};
use missions::SiteZone;
use site_model::{
    DialDirection, GaugeDial, LocalDateTime, LocalisationQuality, PictureComparisonOutcome, ReportPlace,
    RunId,
};

pub(super) const TAB: &str = "Points";
pub(super) const HEAD: &str = "History of an inspection point";
pub(super) const LOADING: &str = "The site has not arrived yet.";
pub(super) const NO_POINTS: &str =
    "There are no inspection points yet. Make one on the Site screen, and put it into a mission.";
pub(super) const CHOOSE: &str = "Choose an inspection point";
pub(super) const POINT: &str = "Inspection point";
pub(super) const WITHOUT_ASSET: &str = "Without an asset";
pub(super) const DELETED_POINT: &str = "Deleted inspection point";
pub(super) const FETCHING: &str = "The results are fetched from the robot.";
pub(super) const EMPTY: &str =
    "There are no results of this point yet. They come when a mission with it has run.";
pub(super) const EMPTY_SPAN: &str = "There are no results in this part. Choose a longer one.";
pub(super) const RETRY: &str = "Fetch again";

/// The parts that can be chosen.
pub(super) const SPANS: [(&str, HistorySpan); 4] = [
    ("24 h", HistorySpan::Day),
    ("Week", HistorySpan::Week),
    ("Month", HistorySpan::Month),
    ("All", HistorySpan::All),
];

pub(super) const STRIP: &str = "Time line";
pub(super) const STRIP_REMARK: &str = "Drag over a part to see it larger. Press a mark to choose its result; arrow keys go on. A low mark is a usual result, a higher one an unusual one, and \
     a full one is outside the limits. A diamond above a mark: the photo differs from the one before.";
pub(super) const EARLIER_LETTER: &str = "A";
pub(super) const LATER_LETTER: &str = "B";
pub(super) const PREVIOUS: &str = "Previous result";
pub(super) const NEXT: &str = "Next result";
pub(super) const COMPARE: &str = "Compare large";
pub(super) const KEEP: &str = "Keep this one as A";
pub(super) const LET_GO: &str = "A is the one before";
pub(super) const NOTHING_BEFORE: &str = "There is no earlier result to compare with.";
pub(super) const NO_PICTURE: &str = "This result has no picture and no spectrum.";

pub(super) const READINGS_HEAD: &str = "Readings";
pub(super) const MEDIAN: &str = "Median";
pub(super) const TREND: &str = "Trend";
pub(super) const BY_HOUR: &str = "By the hour of the day";
pub(super) const UNUSUAL: &str = "Unusual";
pub(super) const OUTSIDE: &str = "Outside the limits";
pub(super) const LIMITS: &str = "Limits";
pub(super) const NO_CLEAR_TREND: &str = "none that is clear";
pub(super) const FEW_READINGS: &str = "A trend and unusual readings are found from 8 readings on.";
pub(super) const PLOT_REMARK: &str = "Line: trend. Dashed: limits. Triangle: unusual, more than 3.5 deviations from what the others let expect. Cross: outside the limits.";

pub(super) const EXPORT: &str = "Save all as a table (CSV)";
pub(super) const EXPORT_HINT: &str = "Every reading of this point with its time, pose and files.";
pub(super) const CANCEL_EXPORT: &str = "Do not save";

pub(super) const CARD: &str = "Comparison of two results";
pub(super) const CLOSE: &str = "Close the comparison";
pub(super) const DIVIDER: &str = "Divider";
pub(super) const STOP_BLINKING: &str = "Stop blinking";
pub(super) const BLINK_AGAIN: &str = "Go on blinking";
pub(super) const SWAP: &str = "Show the other one";
pub(super) const SHOWN: &str = "Shown";
pub(super) const WHOLE: &str = "Whole picture";

pub(super) const SIDE_BY_SIDE: &str = "Side by side";
pub(super) const WIPE: &str = "Wipe";
pub(super) const BLINK: &str = "Blink";

pub(super) const ALIGN: &str = "Aligned";
pub(super) const ALIGN_HINT: &str = "Draws A as the camera of B sees it. Key L.";
pub(super) const SHOW_CHANGES: &str = "Mark changes";
pub(super) const CHANGES_HINT: &str = "Frames what has changed between both photos. Key C.";
pub(super) const ALIGNMENT: &str = "Alignment";
pub(super) const ALIGN_AGAIN: &str = "Ask again";
const ALIGNING: &str = "The robot aligns the photos.";

/// `Within 0.3 px, 2 changes`, or why there is no alignment. None for what is no two photos.
pub(super) fn alignment(alignment: PairAlignment<'_>) -> Option<String> {
    let sentence = match alignment {
        PairAlignment::NoPhotos => return None,
        PairAlignment::NotAsked | PairAlignment::Awaited => ALIGNING.to_owned(),
        PairAlignment::Failed(sentence) => sentence.to_owned(),
        PairAlignment::Known(PictureComparisonOutcome::NotAligned(sentence)) => sentence.clone(),
        PairAlignment::Known(PictureComparisonOutcome::Aligned(aligned)) => {
            let residual = format::decimal(aligned.residual_px, 1);
            format!("Aligned, within {residual} px · {}", changes(aligned.changes.len()))
        }
    };
    Some(sentence)
}

/// `nothing has changed`, `changed in 2 places`.
fn changes(count: usize) -> String {
    match count {
        0 => "nothing has changed".to_owned(),
        1 => "changed in 1 place".to_owned(),
        _ => format!("changed in {count} places"),
    }
}

/// `The photo has changed in 2 places since the one before.`, or why that is not known; none for a photo that was not compared.
pub(super) fn compared(result: &PointResult) -> Option<String> {
    Some(match &result.comparison.as_ref()?.outcome {
        PictureComparisonOutcome::NotAligned(sentence) => sentence.clone(),
        PictureComparisonOutcome::Aligned(aligned) if aligned.changes.is_empty() => {
            "Nothing in the photo has changed since the one before.".to_owned()
        }
        PictureComparisonOutcome::Aligned(aligned) => {
            format!("The photo has {} since the one before.", changes(aligned.changes.len()))
        }
    })
}

pub(super) fn judgement(judgement: ResultJudgement) -> &'static str {
    match judgement {
        ResultJudgement::NotJudged => "not judged",
        ResultJudgement::Usual => "usual",
        ResultJudgement::Unusual => "unusual",
        ResultJudgement::OutsideLimits => "outside the limits",
    }
}

/// `412 results, 2 unusual, 1 outside the limits. B: 24 Nov 2026, 11:00, usual.`
pub(super) fn strip_value(history: &PointHistory, zone: &SiteZone) -> String {
    let count = |wanted| history.judged().filter(|(_, judged)| *judged == wanted).count();
    let mut text = results(history.results().len());
    for wanted in [ResultJudgement::Unusual, ResultJudgement::OutsideLimits] {
        match count(wanted) {
            0 => {}
            found => text.push_str(&format!(", {found} {}", judgement(wanted))),
        }
    }
    match history.results().iter().filter(|result| result.changes() > 0).count() {
        0 => {}
        found => text.push_str(&format!(", {found} with a changed photo")),
    }
    if let Some(later) = history.later() {
        let at = date_and_time(zone.to_local(later.at));
        text.push_str(&format!(". {LATER_LETTER}: {at}, {}.", judgement(history.judgement(later.number))));
    }
    text
}

/// `1 result`, `5 000 results`.
pub(super) fn results(count: usize) -> String {
    if count == 1 { "1 result".to_owned() } else { format!("{} results", format::count(count as u64)) }
}

/// `1 reading`, `5 readings`.
pub(super) fn readings(count: usize) -> String {
    if count == 1 { "1 reading".to_owned() } else { format!("{} readings", format::count(count as u64)) }
}

/// `412 results so far`.
pub(super) fn fetched(count: usize) -> String {
    format!("Older results are fetched: {} so far.", results(count))
}

/// `All 412 results.`, or `The newest 200 results.`
pub(super) fn extent(count: usize, is_whole: bool) -> String {
    if is_whole { format!("{} in all.", results(count)) } else { format!("The newest {}.", results(count)) }
}

/// `11:00`.
pub(super) fn clock_label(at: LocalDateTime) -> String {
    format!("{:02}:{:02}", at.time.hour, at.time.minute)
}

/// `24 Nov`; the first of January has its year.
pub(super) fn day_label(at: LocalDateTime) -> String {
    let whole = date_and_time(at);
    let words: Vec<&str> = whole.split([' ', ',']).collect();
    let is_new_year = (at.date.month, at.date.day) == (1, 1);
    words[..if is_new_year { 3 } else { 2 }].join(" ")
}

/// Above a picture: `B · 24 Nov 2026, 11:00 · 3 days old`.
pub(super) fn caption(letter: &str, at: LocalDateTime, age_s: f64) -> String {
    format!("{letter} · {} · {}", date_and_time(at), format::age(age_s.max(0.0)))
}

/// `Round A · pose known, ±1.4 cm`.
pub(super) fn facts(run: &str, place: Option<&ReportPlace>) -> String {
    let pose = place.map_or("pose not recorded".to_owned(), |place| {
        let rows = place.covariance.0;
        let sigma_m = (rows[3][3] + rows[4][4]).max(0.0).sqrt();
        format!("{}, ±{}", quality(place.quality), format::accuracy(sigma_m))
    });
    format!("{run} · {pose}")
}

fn quality(quality: LocalisationQuality) -> &'static str {
    match quality {
        LocalisationQuality::NoSavedMap => "no saved map",
        LocalisationQuality::Lost => "pose not known",
        LocalisationQuality::Good => "pose known",
        LocalisationQuality::Degraded => "pose unsure",
    }
}

/// Name of a run that is not listed: `Run 4a1f20c3`.
pub(super) fn run(run: RunId) -> String {
    let id = run.to_string();
    format!("Run {}", id.get(..8).unwrap_or(&id))
}

/// `Round A, 24 Nov 2026, 11:00`.
pub(super) fn run_of(mission: &str, began: Option<LocalDateTime>) -> String {
    began.map_or_else(|| mission.to_owned(), |began| format!("{mission}, {}", date_and_time(began)))
}

/// `A: Round A, 24 Nov 2026, 11:00 · pose known, ±1.4 cm`.
pub(super) fn facts_of_side(letter: &str, facts: &str) -> String {
    format!("{letter}: {facts}")
}

/// `A, 23 Nov 2026, 11:00`: name of a small picture.
pub(super) fn small_picture(letter: &str, at: LocalDateTime) -> String {
    format!("Picture {letter}, {}", date_and_time(at))
}

/// `Temperature, °C`.
pub(super) fn series(series: &ReadingSeries) -> String {
    format!("{}, {}", reading_name(&series.name), series.unit)
}

/// Digits after the point that tell readings apart whose deviation is this one.
pub(super) fn decimals(deviation: f64) -> usize {
    if deviation > 0.0 && deviation.is_finite() {
        (1.0 - deviation.log10().floor()).clamp(0.0, 6.0) as usize
    } else {
        2
    }
}

/// `20.2 °C, half of them within ±0.1`.
pub(super) fn median(median: f64, mad: f64, unit: &str, decimals: usize) -> String {
    format!("{} {unit}, half within ±{}", format::decimal(median, decimals), format::decimal(mad, decimals))
}

/// `+0.12 °C a week`.
pub(super) fn trend(per_s: f64, unit: &str, decimals: usize) -> String {
    const WEEK_S: f64 = 604_800.0;
    let change = format::decimal(per_s * WEEK_S, decimals + 1);
    let sign = if change.starts_with('-') { "" } else { "+" };
    format!("{sign}{change} {unit} a week")
}

/// `-0.3 to +0.9 °C`.
pub(super) fn by_hour([least, greatest]: [f64; 2], unit: &str, decimals: usize) -> String {
    let signed = |value: f64| {
        let text = format::decimal(value, decimals);
        if text.starts_with('-') { text } else { format!("+{text}") }
    };
    format!("{} to {} {unit}", signed(least), signed(greatest))
}

/// `at least 4.0, at most 6.0 bar`.
pub(super) fn limits(min: Option<f64>, max: Option<f64>, unit: &str) -> String {
    let min = min.map(|min| format!("at least {}", format::decimal(min, 2)));
    let max = max.map(|max| format!("at most {}", format::decimal(max, 2)));
    let both: Vec<String> = min.into_iter().chain(max).collect();
    format!("{} {unit}", both.join(", "))
}

/// `20.4 °C on 24 Nov 2026, 11:00`.
pub(super) fn value_at(value: f64, unit: &str, decimals: usize, at: LocalDateTime) -> String {
    format!("{} {unit} on {}", format::decimal(value, decimals), date_and_time(at))
}

/// In the accessible tree: what a plot shows.
pub(super) fn plot_value(series: &ReadingSeries, decimals: usize) -> String {
    let newest = series.values.last().map_or(f64::NAN, |value| value.value);
    let [unusual, outside] = series.remarkable();
    let count = series.values.len();
    format!(
        "{count} readings, newest {} {}, {unusual} unusual, {outside} outside the limits",
        format::decimal(newest, decimals),
        series.unit
    )
}

/// `40 %`: where the divider is.
pub(super) fn divider(share: f32) -> String {
    format::percent(share)
}

pub(super) const GAUGE_HEAD: &str = "Gauge";
pub(super) const DESCRIBE_GAUGE: &str = "Describe the gauge";
pub(super) const CHANGE_GAUGE: &str = "Change the gauge";
pub(super) const NO_GAUGE: &str =
    "If this photo shows a gauge, describe it once: the robot then reads its needle in every later photo.";
pub(super) const GAUGE_CARD: &str = "Description of a gauge";
pub(super) const GAUGE_PHOTO: &str = "Photo of the gauge";
pub(super) const CLOSE_GAUGE: &str = "Close the gauge";
pub(super) const MARK_AGAIN: &str = "Mark again";
pub(super) const SHORT_MARKS: [&str; 4] = ["centre", "lower end", "middle", "upper end"];
pub(super) const DIRECTIONS: [(&str, DialDirection); 2] =
    [("Clockwise", DialDirection::Clockwise), ("Counterclockwise", DialDirection::Counterclockwise)];
pub(super) const TURNS: [(&str, bool); 2] = [("Two ends", false), ("Full turn", true)];
pub(super) const VALUES: [&str; 2] = ["At lower end", "At upper end"];
pub(super) const UNIT: &str = "Unit";
pub(super) const CHOOSE_UNIT: &str = "Choose a unit";
pub(super) const UNITS: [&str; 18] = [
    "bar", "mbar", "kPa", "MPa", "psi", "°C", "°F", "%", "mm", "m", "l/min", "m³/h", "m³", "1/min", "V", "A",
    "kW", "kg",
];
pub(super) const SAVE_GAUGE: &str = "Save the gauge";
pub(super) const REMOVE_GAUGE: &str = "Remove the description";
pub(super) const GAUGE_REMARK: &str = "The gauge is read in photos that are taken from now on. Photos are aligned with this one first, so the robot may stand a little elsewhere. Limits are set on the Site screen.";

/// What to press next on the photo.
pub(super) fn mark_hint(next: Option<usize>) -> &'static str {
    match next {
        Some(0) => "Press the centre of the scale, where the needle turns. The wheel or two fingers magnify.",
        Some(1) => "Press the tick at the lower end of the scale.",
        Some(2) => "Press the tick in the middle of the scale, at the value half way between its ends.",
        Some(_) => "Press the tick at the upper end of the scale.",
        None => "Drag a mark to correct it, or move it with the arrow keys.",
    }
}

/// `0 to 6 bar`.
pub(super) fn gauge(dial: &GaugeDial) -> String {
    let [low, high] = dial.range;
    format!("The needle is read in every photo, from {low} to {high} {}.", dial.unit)
}

pub(super) fn gauge_of(point: &str) -> String {
    format!("Gauge of {point}")
}

pub(super) fn pixels([x, y]: [f64; 2]) -> String {
    format!("{x:.0}, {y:.0} px")
}

/// What is missing before a gauge can be saved.
pub(super) fn missing(missing: &Missing) -> String {
    match missing {
        Missing::Marks => "The marks are missing: press them on the photo.".to_owned(),
        Missing::Values => "The values at the ends of the scale are missing.".to_owned(),
        Missing::Of(error) => format!("A gauge needs {error}."),
    }
}
