//! Walks among solids and people in which nothing may be touched: round machines, onto stairs from beside them, and along the paths of people.

use crate::day::Day;
use messages::{GoalKind, GoalStatus};
use sim::{Contact, SiteName, Start};
use uuid::Uuid;
use vocab::{SessionId, Vec3};

/// Longest time for a walk to one place, robot time.
const WALK_LIMIT_S: u32 = 90;

/// Walks from the first place to all others while the robot maps the site; the heading at the beginning is that of the site. Returns the contacts that the robot has
/// caused.
fn walk_along(site: SiteName, people: u32, seed: u64, places: &[[f64; 2]]) -> Vec<Contact> {
    let [x, y] = places[0];
    let start = Start { position: Vec3::new(x, y, 0.0), yaw: 0.0 };
    let mut day = Day::on(site, people, start, seed, Some(SessionId(Uuid::from_u128(1))));
    day.run(2.0);
    for (number, [to_x, to_y]) in places.iter().enumerate().skip(1) {
        day.start_goal(GoalKind::WalkTo(Vec3::new(to_x - x, to_y - y, 0.0)));
        let mut seconds = 0;
        while day.outcomes.len() < number && seconds < WALK_LIMIT_S {
            day.run(1.0);
            seconds += 1;
        }
        assert!(
            matches!(day.outcomes.last(), Some(GoalStatus::Succeeded(_))) && day.outcomes.len() == number,
            "{site:?}, seed {seed}: not at {to_x}, {to_y}: {:?} {:?} {:?}",
            day.outcomes,
            day.motion,
            day.refusals
        );
    }
    let contacts = day.lockstep.simulator().take_contacts();
    contacts.into_iter().filter(|contact| contact.is_by_robot).collect()
}

/// Seeds and places are those with which robots that planned with a footprint of whole cells, and had no guard, touched something.
#[test]
fn a_robot_that_comes_from_beside_stairs_does_not_touch_their_handrails() {
    assert_eq!(walk_along(SiteName::Plant, 0, 5, &[[24.9, 18.2], [30.8, 18.9]]), []);
}

#[test]
fn stairs_are_walked_up_and_down_without_touching_their_handrails() {
    let up = [[25.2, 16.6], [30.8, 18.9], [30.8, 20.35], [25.2, 20.9]];
    let down = [[30.8, 20.35], [30.8, 18.9], [25.2, 16.6]];
    assert_eq!(walk_along(SiteName::Plant, 0, 1, &[&up[..], &down].concat()), []);
}

#[test]
fn a_robot_that_walks_round_machines_does_not_touch_them() {
    assert_eq!(walk_along(SiteName::Plant, 0, 3, &[[9.0, 18.6], [13.4, 15.8], [9.0, 18.6]]), []);
    let between_pumps = [[16.0, 2.2], [18.6, 4.6], [16.0, 7.4], [18.6, 10.4]];
    assert_eq!(walk_along(SiteName::Plant, 0, 6, &between_pumps), []);
}

#[test]
fn a_robot_on_the_path_of_a_person_touches_nobody() {
    let there_and_back = [[4.0, 21.2], [20.0, 21.2], [12.0, 20.2], [21.0, 20.2], [4.0, 21.2]];
    for seed in [1, 4] {
        assert_eq!(walk_along(SiteName::Plant, 1, seed, &there_and_back), [], "seed {seed}");
    }
}
