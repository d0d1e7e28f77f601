//! Plans drawn as text: `#` an obstacle as tall as the robot, `_` a step, `.` seen floor, ` ` unseen, `S` start, `G` goal.

use super::*;
use crate::{GroundZones, RobotShape, ZoneArea, ZoneRule};
use expect_test::{Expect, expect};
use geometry::Isometry;

const SIZE: f64 = 0.25;
/// A sensor far above the ground, from which every point is visible and no ray clears another cell.
const FROM_ABOVE: [f32; 3] = [0.0, 0.0, 500.0];

/// Inserts the points that a LiDAR would see in the drawing.
pub(crate) fn elevation_map(picture: &str) -> (ElevationMap, Vector3, Vector3) {
    let shape = RobotShape { radius_m: 0.2, standing_height_m: 0.5, clearance_m: 0.9, step_m: 0.22 };
    let mut elevation_map = ElevationMap::new(SIZE, shape);
    let (mut points, mut from, mut to) = (Vec::new(), Vector3::zeros(), Vector3::zeros());
    for (row, line) in picture.lines().enumerate() {
        for (column, letter) in line.chars().enumerate() {
            let (x, y) = ((column as f64 + 0.5) * SIZE, -(row as f64 + 0.5) * SIZE);
            let at = |z: f64| [x as f32, y as f32, z as f32];
            match letter {
                '#' => points.extend([at(-0.5), at(0.2)]),
                '_' => points.push(at(-0.1)),
                ' ' => {}
                _ => points.push(at(-0.5)),
            }
            if letter == 'S' {
                from = Vector3::new(x, y, 0.0);
            } else if letter == 'G' {
                to = Vector3::new(x, y, 0.0);
            }
        }
    }
    for _ in 0..2 {
        elevation_map.insert_scan(&Isometry::identity(), FROM_ABOVE, &points, 100.0);
    }
    (elevation_map, from, to)
}

fn check(picture: &str, expected: Expect) {
    let picture = picture.trim_matches('\n');
    let (elevation_map, from, to) = elevation_map(picture);
    let drawn = match plan(&PlannerConfig::default(), &elevation_map, &from, &to) {
        Err(error) => format!("{error:?}"),
        Ok(path) => {
            let mut rows: Vec<Vec<char>> = picture.lines().map(|line| line.chars().collect()).collect();
            for pair in path.windows(2) {
                for step in 0..=200 {
                    let at = pair[0].lerp(&pair[1], f64::from(step) / 200.0);
                    let (row, column) = ((-at.y / SIZE) as usize, (at.x / SIZE) as usize);
                    let letter = &mut rows[row][column];
                    if *letter == '.' || *letter == ' ' {
                        *letter = '*';
                    }
                }
            }
            rows.iter().map(|row| row.iter().collect::<String>()).collect::<Vec<_>>().join("\n")
        }
    };
    expected.assert_eq(&drawn);
}

#[test]
fn the_path_keeps_away_from_a_wall() {
    check(
        "
............
.....#......
.S...#...G..
.....#......
.....#......
............
............
",
        expect![[r#"
            ............
            .....#......
            .S...#...G..
            .**..#..**..
            ..**.#.**...
            ...**.**....
            ....***....."#]],
    );
}

#[test]
fn the_path_leads_through_a_door_that_is_just_wide_enough() {
    check(
        "
......#.....
......#.....
.S..........
......#...G.
......#.....
",
        expect![[r#"
            ......#.....
            ......#.....
            .S********..
            ......#..*G.
            ......#....."#]],
    );
}

#[test]
fn a_closed_room_is_refused() {
    check(
        "
.....#######
.S...#.....#
.....#...G.#
.....#.....#
.....#######
",
        expect!["TooFar"],
    );
}

#[test]
fn the_path_avoids_a_step_that_is_too_high() {
    check(
        "
............
.S..._____..
....._____..
.....___G_..
............
",
        expect![[r#"
            ............
            .S..._____..
            .**.._____..
            ..**.___G_..
            ...******..."#]],
    );
}

#[test]
fn a_person_who_leaves_is_cleared() {
    let mut elevation_map = ElevationMap::new(SIZE, RobotShape::default());
    let person = [[2.0, 0.0, -0.4], [2.0, 0.0, 0.6]];
    let floor = [[2.0, 0.0, -0.55]];
    let cell = elevation_map.index(2.0, 0.0);
    elevation_map.insert_scan(&Isometry::identity(), FROM_ABOVE, &person, 10.0);
    assert!(!elevation_map.is_free(cell));
    for _ in 0..20 {
        elevation_map.insert_scan(&Isometry::identity(), FROM_ABOVE, &floor, 10.0);
    }
    assert!(elevation_map.is_free(cell));
}

/// A hall with two paths from the left to the right.
const HALL: &str = "
....................
....................
S..................G
....................
....................
....................
....................
....................";

fn with_zone(rule: ZoneRule, corners_m: [[f64; 2]; 4]) -> Result<Vec<Vector3>, PlanError> {
    let (mut elevation_map, from, to) = elevation_map(HALL.trim_matches('\n'));
    elevation_map.set_zones(GroundZones::new(vec![ZoneArea { corners_m: corners_m.to_vec(), rule }]));
    plan(&PlannerConfig::default(), &elevation_map, &from, &to)
}

/// Lowest y of a path; the start and the goal are at -0.625 m.
fn lowest(path: &[Vector3]) -> f64 {
    path.iter().map(|point| point.y).fold(f64::INFINITY, f64::min)
}

#[test]
fn paths_lead_round_a_keep_out_zone_and_not_into_it() {
    let across = [[2.0, 0.5], [3.0, 0.5], [3.0, -1.2], [2.0, -1.2]];
    let path = with_zone(ZoneRule::KeepOut, across).expect("a path round");
    // Paths lead over cells of 0.25 m.
    let inside = |at: Vector3| (2.25..2.75).contains(&at.x) && at.y > -0.95;
    for pair in path.windows(2) {
        assert!((0..=100).all(|step| !inside(pair[0].lerp(&pair[1], f64::from(step) / 100.0))), "{path:?}");
    }
    let all_over = [[2.0, 500.0], [3.0, 500.0], [3.0, -500.0], [2.0, -500.0]];
    assert!(with_zone(ZoneRule::KeepOut, all_over).is_err());
    let at_goal = [[4.0, 5.0], [9.0, 5.0], [9.0, -9.0], [4.0, -9.0]];
    assert_eq!(with_zone(ZoneRule::KeepOut, at_goal), Err(PlanError::GoalKeptOut));
}

#[test]
fn a_penalty_is_avoided_where_the_way_round_is_cheaper_and_a_speed_limit_changes_no_path() {
    let across = [[1.0, 0.5], [4.0, 0.5], [4.0, -0.9], [1.0, -0.9]];
    assert!(lowest(&with_zone(ZoneRule::Penalty(5.0), across).expect("a path")) < -0.9);
    assert!(lowest(&with_zone(ZoneRule::Penalty(1.01), across).expect("a path")) > -0.9);
    assert!(lowest(&with_zone(ZoneRule::SpeedLimit(0.1), across).expect("a path")) > -0.7);
    let all_over = [[1.0, 9.0], [4.0, 9.0], [4.0, -9.0], [1.0, -9.0]];
    assert!(with_zone(ZoneRule::Penalty(5.0), all_over).is_ok(), "there is no other way");
}
