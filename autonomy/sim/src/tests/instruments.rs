//! Readings of the instruments on the sites.

use super::quiet;
use crate::{Simulator, SiteName, Start};
use geometry::{Vector3, vec_to_plain};

/// A robot that stands this far in front of the first source of b1.
fn at_source(away_m: f64) -> Simulator {
    let scene = Simulator::new(quiet(SiteName::B1)).camera_scene();
    let mut plain = Simulator::new(quiet(SiteName::B1));
    let source = plain.surroundings().gamma().sources()[0];
    let plate = scene
        .fixtures()
        .iter()
        .find(|fixture| (fixture.site_from_plate.translation.vector - source.position_m).norm() < 0.05)
        .expect("sources sit on plates");
    let outward = plate.site_from_plate.rotation * Vector3::z();
    let feet = source.position_m + outward * away_m;
    let position = vec_to_plain(&Vector3::new(feet.x, feet.y, feet.z - 1.0));
    let yaw = (-outward.y).atan2(-outward.x);
    Simulator::new(crate::SimConfig { start: Some(Start { position, yaw }), ..quiet(SiteName::B1) })
}

fn count(simulator: &mut Simulator, seconds: f64) -> Vec<u32> {
    let surroundings = simulator.surroundings();
    let mut counts = vec![0; surroundings.gamma().config().channels];
    simulator.instrument_snapshot().count_gamma(&surroundings, seconds, &mut counts);
    counts
}

#[test]
fn a_contaminated_machine_is_told_by_its_line_and_away_from_it_there_is_background_only() {
    let sum = |counts: &[u32]| counts.iter().map(|c| u64::from(*c)).sum::<u64>();
    let window = |counts: &[u32]| sum(&counts[610 / 3..710 / 3]);
    let beside = count(&mut at_source(1.6), 60.0);
    let mut dock = Simulator::new(quiet(SiteName::B1));
    let away = count(&mut dock, 60.0);
    assert!(window(&beside) > 10 * window(&away), "{} {}", window(&beside), window(&away));
    assert!((4_000..20_000).contains(&sum(&away)), "{} events of background", sum(&away));
    // The same simulation counts the same.
    assert_eq!(count(&mut Simulator::new(quiet(SiteName::B1)), 60.0), away);
    // And another time it counts something else.
    assert_ne!(count(&mut dock, 60.0), away);
}

#[test]
fn the_air_of_a_site_is_that_of_a_hall() {
    let mut simulator = Simulator::new(quiet(SiteName::B1));
    let surroundings = simulator.surroundings();
    let air = simulator.instrument_snapshot().air(&surroundings);
    assert!((17.0..26.0).contains(&air.celsius) && (30.0..60.0).contains(&air.humidity_percent), "{air:?}");
}
