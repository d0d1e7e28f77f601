//! The simulator as a whole: determinism, order of events, sites and their routes.

use super::{drive, ideal_blind, quiet, run};
use crate::{RouteFollower, SimConfig, SimEvent, SimulatedSite, Simulator, SiteName, UnknownSite};
use std::sync::Arc;
use vocab::{Span, Stamp};

fn events(seed: u64, chunk: Span) -> Vec<SimEvent> {
    let mut config = SimConfig { seed, people: 4, ..quiet(SiteName::Torus) };
    config.epoch = Stamp::from_parts(1_800_000_000, 5);
    let mut simulator = Simulator::new(config);
    let mut out = run(&mut simulator, drive(0.8, 0.1, 0.3), 20);
    let end = simulator.now() + Span::from_millis(1000);
    let mut until = simulator.now();
    while until < end {
        until = (until + chunk).min(end);
        simulator.advance(until, &mut out);
    }
    out
}

#[test]
fn the_same_seed_gives_the_same_bytes_for_every_step_length() {
    let once = events(3, Span::from_millis(1000));
    assert!(once.len() > 1500);
    assert!(once == events(3, Span::from_millis(1000)), "a second run differs");
    assert!(once == events(3, Span::from_millis(7)), "short steps differ");
    assert!(once != events(4, Span::from_millis(1000)), "another seed is the same");
}

#[test]
fn events_come_in_order_of_arrival_after_they_were_measured() {
    let events = events(1, Span::from_millis(35));
    assert!(events.is_sorted_by_key(|event| event.at));
    assert!(events.iter().all(|event| event.sensor.stamp() <= event.at));
}

/// Walks a route of a site to its end; returns the time it takes, seconds.
#[track_caller]
fn seconds_to_walk(name: SiteName, route: &str) -> f64 {
    let site = Arc::new(SimulatedSite::new(name));
    let route = site.route(route).cloned().unwrap();
    let mut config = ideal_blind(site);
    config.start = Some(route.start);
    let label = route.name;
    let mut simulator = Simulator::new(config);
    let mut walker = RouteFollower::new(route);
    while let Some(command) = walker.drive(&simulator.truth()) {
        run(&mut simulator, command, 1);
        let elapsed = simulator.elapsed().secs_f64();
        assert!(elapsed < 900.0, "{name} {label}: stuck at {:?}", walker.progress());
    }
    simulator.elapsed().secs_f64()
}

#[test]
fn every_short_route_can_be_walked_in_its_time() {
    for name in SiteName::ALL {
        let seconds = seconds_to_walk(name, "short");
        assert!((45.0..75.0).contains(&seconds), "{name}: {seconds} s");
    }
}

#[test]
fn every_round_can_be_walked_in_its_time() {
    for name in SiteName::ALL {
        let seconds = seconds_to_walk(name, "round");
        assert!((540.0..660.0).contains(&seconds), "{name}: {seconds} s");
    }
}

#[test]
fn sites_have_names_docks_outlines_and_pedestrian_paths() {
    for name in SiteName::ALL {
        assert_eq!(name.to_string().parse(), Ok(name));
        let site = SimulatedSite::new(name);
        assert!(!site.docks().is_empty() && site.outline().len() > 3 && site.pedestrian_paths().len() > 2);
        // The twins have few solids on purpose.
        let least = if name == SiteName::Twins { 400 } else { 1500 };
        assert!(site.solids().len() > least, "{name} has too few solids: {}", site.solids().len());
    }
    let unknown: Result<SiteName, UnknownSite> = "b2".parse();
    let text = unknown.unwrap_err().to_string();
    assert_eq!(text, "there is no site \"b2\"; the sites are b1, torus, plant, twins, and generated:SEED");
}

#[test]
fn changes_differ_by_seed_and_are_the_same_for_the_same_seed() {
    let usual = SimulatedSite::new(SiteName::B1);
    let [one, again, other] =
        [5, 5, 6].map(|seed| SimulatedSite::new(SiteName::B1).on_another_day(seed, 0.25));
    assert_eq!(one.solids(), again.solids());
    assert!(one.solids() != usual.solids() && one.solids() != other.solids());
    let kept = one.solids().iter().filter(|solid| usual.solids().contains(solid)).count();
    let share = kept as f64 / usual.solids().len() as f64;
    assert!((0.6..0.99).contains(&share), "{share} of all solids have not moved");
}
