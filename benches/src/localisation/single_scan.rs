//! Global localisation of a standing robot from one scan, at random poses in the site.

use crate::arguments::Arguments;
use anyhow::Result;
use benches::mapped_site::MappedSite;
use benches::quantile;
use benches::random_places::{PlaceResult, PlacesPlan, localise_at_places};

/// Prints the names of the columns. *right* and *WRONG*: one hypothesis was accepted. *ambiguous* and *without*: several hypotheses fit, with and
/// without the right one. *nowhere*: no hypothesis fits well.
pub fn print_header() {
    println!(
        "{:<8}{:>8}{:>8}{:>8}{:>11}{:>9}{:>9}{:>11}{:>9}",
        "site", "places", "right", "WRONG", "ambiguous", "without", "nowhere", "median ms", "p99 ms"
    );
}

/// Localises at random poses.
pub fn run(mapped: &MappedSite, arguments: &Arguments) -> Result<()> {
    let plan = PlacesPlan {
        count: arguments.places,
        seed: arguments.seed,
        columns: arguments.columns,
        people: arguments.people,
    };
    let mut observer = |place: &PlaceResult<'_>| {
        if arguments.verbose {
            print_each(place);
        }
    };
    let counts = localise_at_places(mapped, &plan, &mut observer)?;
    println!(
        "{:<8}{:>8}{:>8}{:>8}{:>11}{:>9}{:>9}{:>11.1}{:>9.1}",
        mapped.site.name(),
        arguments.places,
        counts.right,
        counts.wrong,
        counts.ambiguous,
        counts.without,
        counts.nowhere,
        quantile(&counts.times_ms, 0.5),
        quantile(&counts.times_ms, 0.99)
    );
    Ok(())
}

/// Prints the place, the rank of the right hypothesis, the error of the best one in the frame of the base (metres), and the fits.
pub fn print_each(place: &PlaceResult<'_>) {
    let at = place.start.position;
    let position = format!("{:.1},{:.1},{:.1}", at.x, at.y, at.z);
    let right = place.right.map_or_else(|| "-".to_owned(), |index| index.to_string());
    let best = place.found.first();
    let off = best.map(|one| (place.map_from_base.inverse() * one.map_from_base).translation.vector);
    let off = off.map_or_else(|| "-".to_owned(), |off| format!("{:.3} {:.3} {:.3}", off.x, off.y, off.z));
    let fits = place.found.iter().take(4).map(|one| format!("{:.3}/{:.3}", one.fit, one.violation_share));
    let list: Vec<String> = fits.collect();
    println!("{:>4} {position:>16} {right:>3} {off:>21}  {}", place.number, list.join("  "));
}
