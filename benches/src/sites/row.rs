//! The table: a row for each site, a row for all, and the bars.

use benches::fault_recovery::{FaultRecoveries, Recovery};
use benches::map_score::MapScore;
use benches::quantile;
use benches::random_places::{PlaceCounts, PlaceResult};

/// Greatest root mean square error of a map, metres.
const MAX_MAP_RMSE_M: f64 = 0.01;
/// Least share of the places that are right, or named among several.
const MIN_PLACES_SHARE: f64 = 0.95;
/// Limit of the duration of a recovery, seconds.
const MAX_RECOVERY_S: f64 = 20.0;
/// Least share of the recoveries within that limit.
const MIN_RECOVERIES_SHARE: f64 = 0.95;

/// The results of a site.
pub struct Row {
    pub name: String,
    pub map: MapScore,
    pub places: PlaceCounts,
    pub recoveries: FaultRecoveries,
}

/// Sums over sites.
#[derive(Default)]
pub struct Total {
    sites: usize,
    worst_map_m: f64,
    maps_over_limit: usize,
    wrong_loops: usize,
    places: PlaceCounts,
    recoveries: FaultRecoveries,
}

/// Prints the names of the columns.
pub fn print_header() {
    println!(
        "| site | path, m | keyframes | map, mm | loops, wrong | revisits, wrong | closed | places: right, among several, wrong, without, nowhere | covered: within 20 s, worst | carried: within 20 s, median, worst | scans with a claimed pose, wrong ones |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
}

impl Row {
    /// Prints the row.
    pub fn print(&self) {
        let (map, loops) = (&self.map, &self.map.loops);
        println!(
            "| {} | {:.0} | {} | {:.1} | {}, {} | {}, {} | {:.0} % | {} |",
            self.name,
            map.distance_m,
            loops.keyframes,
            1e3 * map.map_rmse_m,
            loops.accepted,
            loops.wrong,
            map.reanchorings,
            map.wrong_reanchorings,
            100.0 * loops.closed as f64 / loops.revisits.max(1) as f64,
            localisation(&self.places, &self.recoveries)
        );
    }
}

/// The cells of localisation and recovery.
fn localisation(places: &PlaceCounts, recoveries: &FaultRecoveries) -> String {
    let covered = ascending(&recoveries.covered);
    let carried = ascending(&recoveries.carried);
    format!(
        "{}, {}, {}, {}, {} | {} of {}, {} | {} of {}, {}, {} | {}, {}",
        places.right,
        places.ambiguous,
        places.wrong,
        places.without,
        places.nowhere,
        in_time(&covered),
        covered.len(),
        seconds(quantile(&covered, 1.0)),
        in_time(&carried),
        carried.len(),
        seconds(quantile(&carried, 0.5)),
        seconds(quantile(&carried, 1.0)),
        recoveries.claimed_scans,
        recoveries.wrong_scans
    )
}

fn ascending(recoveries: &[Recovery]) -> Vec<f64> {
    let mut durations: Vec<f64> = recoveries.iter().map(|recovery| recovery.duration_s).collect();
    durations.sort_by(f64::total_cmp);
    durations
}

fn in_time(durations: &[f64]) -> usize {
    durations.iter().filter(|duration| **duration <= MAX_RECOVERY_S).count()
}

fn seconds(duration: f64) -> String {
    match duration {
        d if d.is_nan() => "-".to_owned(),
        d if d.is_infinite() => "over 60 s".to_owned(),
        d => format!("{d:.1} s"),
    }
}

impl Total {
    /// Adds a site.
    pub fn add(&mut self, row: &Row) {
        self.sites += 1;
        self.worst_map_m = self.worst_map_m.max(row.map.map_rmse_m);
        // A map without an error is none either.
        self.maps_over_limit +=
            usize::from(row.map.map_rmse_m.is_nan() || row.map.map_rmse_m > MAX_MAP_RMSE_M);
        self.wrong_loops += row.map.loops.wrong + row.map.wrong_reanchorings;
        let (sum, places) = (&mut self.places, &row.places);
        sum.right += places.right;
        sum.ambiguous += places.ambiguous;
        sum.wrong += places.wrong;
        sum.without += places.without;
        sum.nowhere += places.nowhere;
        let (sum, recoveries) = (&mut self.recoveries, &row.recoveries);
        sum.covered.extend(&recoveries.covered);
        sum.carried.extend(&recoveries.carried);
        sum.claimed_scans += recoveries.claimed_scans;
        sum.wrong_scans += recoveries.wrong_scans;
    }

    /// Prints the row of all sites.
    pub fn print(&self) {
        println!(
            "| all {} | | | worst {:.1} | wrong {} | | | {} |",
            self.sites,
            1e3 * self.worst_map_m,
            self.wrong_loops,
            localisation(&self.places, &self.recoveries)
        );
    }

    /// A sentence for each bar that is missed.
    pub fn missed_bars(&self) -> Vec<String> {
        let places = &self.places;
        let named = places.right + places.ambiguous;
        let all = named + places.wrong + places.without + places.nowhere;
        let durations: Vec<f64> = [&self.recoveries.covered, &self.recoveries.carried]
            .into_iter()
            .flat_map(|recoveries| ascending(recoveries))
            .collect();
        let recovered = in_time(&durations);
        let mut missed = Vec::new();
        let mut check = |is_met: bool, sentence: String| missed.extend((!is_met).then_some(sentence));
        check(self.maps_over_limit == 0, format!("{} maps are over 10 mm RMSE", self.maps_over_limit));
        check(self.wrong_loops == 0, format!("{} loops or revisits are wrong", self.wrong_loops));
        check(places.wrong == 0, format!("{} places are wrong", places.wrong));
        let share = MIN_PLACES_SHARE * all as f64;
        check(named as f64 >= share, format!("{named} of {all} places are right or named among several"));
        let share = MIN_RECOVERIES_SHARE * durations.len() as f64;
        check(
            recovered as f64 >= share,
            format!("{recovered} of {} recoveries took at most 20 s", durations.len()),
        );
        missed
    }
}

/// Prints a place, the rank of the right hypothesis, and the fits of the best ones.
pub fn print_place(place: &PlaceResult<'_>) {
    let at = place.start.position;
    let right = place.right.map_or_else(|| "-".to_owned(), |rank| rank.to_string());
    let best = place.found.first();
    let off = best.map(|one| (place.map_from_base.inverse() * one.map_from_base).translation.vector.norm());
    let fits = place.found.iter().take(4).map(|one| format!("{:.3}/{:.3}", one.fit, one.violation_share));
    println!(
        "place {:>3} at {:.1},{:.1},{:.1}: right {right}, best off {:.2} m, fits {}",
        place.number,
        at.x,
        at.y,
        at.z,
        off.unwrap_or(f64::NAN),
        fits.collect::<Vec<_>>().join("  ")
    );
}

/// Prints the keyframes: their true positions, and the errors of the map there.
pub fn print_keyframes(score: &MapScore) {
    for (number, (place, off)) in score.keyframe_errors.iter().enumerate() {
        println!(
            "keyframe {number:>3} at {:.1},{:.1},{:.1}: off {:.1} {:.1} {:.1} mm",
            place.x,
            place.y,
            place.z,
            1e3 * off.x,
            1e3 * off.y,
            1e3 * off.z
        );
    }
}
