//! Mapping, localisation and fault recovery on sites that no value was tuned on: generated ones, and buildings from files.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod arguments;
mod row;

use anyhow::{Context, Error, Result, ensure};
use arguments::Arguments;
use benches::fault_recovery::{FaultPlan, FaultRecoveries, walk_with_faults};
use benches::mapped_site::MappedSite;
use benches::random_places::{PlaceCounts, PlacesPlan, localise_at_places};
use benches::stack_walk::{WalkExtent, WalkPlan};
use clap::Parser;
use row::{Row, Total};
use site_files::SiteSource;
use vocab::Span;

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let sources = sources(&arguments)?;
    row::print_header();
    let mut total = Total::default();
    for source in &sources {
        let row = measure(source, &arguments).with_context(|| format!("{source}"))?;
        row.print();
        total.add(&row);
    }
    total.print();
    let missed = total.missed_bars();
    for bar in &missed {
        println!("BAR MISSED: {bar}");
    }
    if missed.is_empty() {
        println!("all bars met");
    }
    ensure!(missed.is_empty() || !arguments.bar, "{} bars are missed", missed.len());
    Ok(())
}

/// The sites that were asked for.
fn sources(arguments: &Arguments) -> Result<Vec<SiteSource>> {
    let generated = arguments.first..arguments.first.saturating_add(arguments.generated);
    let generated = generated.map(|seed| format!("generated:{seed}"));
    let names = generated.chain(arguments.sites.iter().cloned());
    names.map(|name| name.parse().map_err(Error::msg)).collect()
}

/// Maps a site, then localises and recovers in the map.
fn measure(source: &SiteSource, arguments: &Arguments) -> Result<Row> {
    let (seed, columns) = (arguments.seed, arguments.columns);
    let plan = WalkPlan { seed, columns, people: arguments.people, keep_ground_truth: true };
    let mapped = MappedSite::new(
        source.load()?,
        &plan,
        WalkExtent::Time(Span::from_secs_f64(60.0 * arguments.minutes)),
    )?;
    if arguments.verbose {
        row::print_keyframes(&mapped.score);
    }
    let places = if arguments.places > 0 {
        let plan = PlacesPlan { count: arguments.places, seed, columns, people: arguments.people };
        localise_at_places(&mapped, &plan, &mut |place| {
            if arguments.verbose {
                row::print_place(place);
            }
        })?
    } else {
        PlaceCounts::default()
    };
    let recoveries = if arguments.faults > 0 {
        let plan = FaultPlan {
            faults: arguments.faults,
            seed: 100 * seed + 77,
            columns,
            people: arguments.day_people,
            changed_share: arguments.changed_share,
            carry_distance_min_m: arguments.carry_distance_min,
            verbose: arguments.verbose,
        };
        walk_with_faults(&mapped, &plan)?
    } else {
        FaultRecoveries::default()
    };
    Ok(Row { name: mapped.site.name().to_owned(), map: mapped.score, places, recoveries })
}
