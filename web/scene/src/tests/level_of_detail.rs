//! Tests: the point budget is kept, coarse tiles come first, and tiles outside the image are not drawn.

use crate::level_of_detail::{LevelOfDetailConfig, SelectedTile, TileCandidate, select_tiles};
use crate::{CameraPose, CameraProjection, TileId, WHOLE_MAP};
use glam::DVec3;

fn projection() -> CameraProjection {
    let camera = CameraPose { target: DVec3::ZERO, yaw: 0.0, pitch: 0.0, distance: 10.0 };
    CameraProjection::new(camera, [800, 800])
}

fn candidate(tile: u64, x: f64, spacing: f32) -> TileCandidate {
    let centre = DVec3::new(x, 0.0, 0.0);
    TileCandidate { tile: TileId(tile), anchor: WHOLE_MAP, centre, radius: 2.0, spacing, points: 100 }
}

fn tile_ids(selected: &[SelectedTile]) -> Vec<u64> {
    selected.iter().map(|c| c.tile.0).collect()
}

#[test]
fn coarse_and_near_tiles_come_first_until_the_budget_is_spent() {
    let tiles =
        [candidate(1, 0.0, 0.1), candidate(2, 0.0, 0.4), candidate(3, 40.0, 0.4), candidate(4, 40.0, 0.1)];
    assert_eq!(
        tile_ids(&select_tiles(&LevelOfDetailConfig::default(), &tiles, &projection(), 1000)),
        [2, 1, 3, 4]
    );
    assert_eq!(tile_ids(&select_tiles(&LevelOfDetailConfig::default(), &tiles, &projection(), 250)), [2, 1]);
    assert!(select_tiles(&LevelOfDetailConfig::default(), &tiles, &projection(), 99).is_empty());
}

#[test]
fn tiles_outside_the_image_or_finer_than_a_pixel_are_not_drawn() {
    let behind = candidate(1, -20.0, 0.4);
    let too_fine = candidate(2, 300.0, 0.05);
    let fine_but_near = candidate(3, 0.0, 0.05);
    let beside = TileCandidate { centre: DVec3::new(0.0, 50.0, 0.0), ..candidate(4, 0.0, 0.4) };
    assert_eq!(
        tile_ids(&select_tiles(
            &LevelOfDetailConfig::default(),
            &[behind, too_fine, fine_but_near, beside],
            &projection(),
            1000
        )),
        [3]
    );
}

#[test]
fn coarse_points_shrink_where_finer_ones_are_drawn_too() {
    let tiles = [candidate(1, 0.0, 0.4), candidate(2, 1.0, 0.1), candidate(3, 30.0, 0.4)];
    let spacing = |budget| {
        let mut selected = select_tiles(&LevelOfDetailConfig::default(), &tiles, &projection(), budget);
        selected.sort_by_key(|c| c.tile);
        selected.iter().map(|c| c.spacing).collect::<Vec<_>>()
    };
    assert_eq!(spacing(1000), [0.1, 0.1, 0.4]);
    assert_eq!(spacing(100), [0.4]);
}
