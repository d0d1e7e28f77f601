//! The budget is kept, coarse tiles come first, and nothing out of sight is drawn.

use crate::select::{Candidate, choose};
use crate::{CameraPose, Eye, TileId, WHOLE_MAP};
use glam::DVec3;

fn eye() -> Eye {
    let camera = CameraPose { target: DVec3::ZERO, yaw: 0.0, pitch: 0.0, distance: 10.0 };
    Eye::new(camera, [800, 800])
}

fn candidate(tile: u64, x: f64, spacing: f32) -> Candidate {
    let centre = DVec3::new(x, 0.0, 0.0);
    Candidate { tile: TileId(tile), anchor: WHOLE_MAP, centre, radius: 2.0, spacing, points: 100 }
}

fn names(chosen: &[crate::select::Chosen]) -> Vec<u64> {
    chosen.iter().map(|c| c.tile.0).collect()
}

#[test]
fn coarse_and_near_tiles_come_first_until_the_budget_is_spent() {
    let tiles =
        [candidate(1, 0.0, 0.1), candidate(2, 0.0, 0.4), candidate(3, 40.0, 0.4), candidate(4, 40.0, 0.1)];
    assert_eq!(names(&choose(&tiles, &eye(), 1000)), [2, 1, 3, 4]);
    assert_eq!(names(&choose(&tiles, &eye(), 250)), [2, 1]);
    assert!(choose(&tiles, &eye(), 99).is_empty());
}

#[test]
fn tiles_out_of_sight_or_finer_than_a_pixel_are_left_out() {
    let behind = candidate(1, -20.0, 0.4);
    let too_fine = candidate(2, 300.0, 0.05);
    let fine_but_near = candidate(3, 0.0, 0.05);
    let aside = Candidate { centre: DVec3::new(0.0, 50.0, 0.0), ..candidate(4, 0.0, 0.4) };
    assert_eq!(names(&choose(&[behind, too_fine, fine_but_near, aside], &eye(), 1000)), [3]);
}

#[test]
fn coarse_points_shrink_where_finer_ones_are_drawn_too() {
    let tiles = [candidate(1, 0.0, 0.4), candidate(2, 1.0, 0.1), candidate(3, 30.0, 0.4)];
    let spacing = |budget| {
        let mut chosen = choose(&tiles, &eye(), budget);
        chosen.sort_by_key(|c| c.tile);
        chosen.iter().map(|c| c.spacing).collect::<Vec<_>>()
    };
    assert_eq!(spacing(1000), [0.1, 0.1, 0.4]);
    assert_eq!(spacing(100), [0.4]);
}
