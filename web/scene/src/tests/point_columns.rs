//! Floors and obstacles in columns of points.

use crate::point_columns::{ColumnsConfig, PointColumns};
use glam::{DVec2, DVec3};

/// A floor of 20 m by 20 m at a height, with a point each 5 cm.
fn floor(height: f64) -> Vec<DVec3> {
    let places = (0..400).flat_map(|x| (0..400).map(move |y| (x, y)));
    places.map(|(x, y)| DVec3::new(0.05 * f64::from(x), 0.05 * f64::from(y), height)).collect()
}

/// A box of points on its sides, 0.4 m square, from the floor to a height.
fn pillar(at: DVec2, height: f64) -> Vec<DVec3> {
    let sides = (0..40).flat_map(|side| (0..(height / 0.05) as i32).map(move |z| (side, z)));
    let place = |side: i32| {
        let along = 0.04 * f64::from(side % 10) - 0.2;
        [DVec2::new(along, 0.2), DVec2::new(along, -0.2), DVec2::new(0.2, along), DVec2::new(-0.2, along)]
            [side as usize / 10]
    };
    sides.map(|(side, z)| (at + place(side)).extend(0.05 * f64::from(z))).collect()
}

fn columns(points: &[DVec3]) -> PointColumns {
    let corners = [DVec2::ZERO, DVec2::splat(20.0)];
    PointColumns::new(ColumnsConfig::default(), corners, |visit| {
        points.iter().for_each(|point| visit(*point))
    })
}

#[test]
fn the_floor_nearest_to_a_height_is_found_and_no_table_or_other_storey() {
    let mut points = floor(0.02);
    points.extend(floor(3.0));
    points.extend(floor(0.75).into_iter().filter(|point| point.x > 10.0));
    let columns = columns(&points);
    let height = |x: f64, near: f64| columns.floor(DVec2::new(x, 5.0), near);
    assert!((height(5.0, 0.0).expect("a floor") - 0.02).abs() < 1e-3);
    assert!((height(5.0, 2.8).expect("the storey above") - 3.0).abs() < 1e-3);
    assert!((height(15.0, 0.1).expect("under the table") - 0.02).abs() < 1e-3);
    assert_eq!(height(5.0, 1.6), None);
    assert_eq!(columns.floor(DVec2::new(-5.0, 5.0), 0.0), None, "outside");
}

#[test]
fn what_stands_in_a_corridor_is_found_with_its_distance() {
    let mut points = floor(0.0);
    points.extend(pillar(DVec2::new(8.0, 10.0), 1.5));
    let columns = columns(&points);
    let along = |y: f64| {
        let ends = [DVec3::new(2.0, y, 0.0), DVec3::new(16.0, y, 0.0)];
        columns.obstruction(ends).map(|found| found.along_m)
    };
    let found = along(10.0).expect("through the pillar");
    assert!((found - 5.8).abs() < 0.15, "{found}");
    assert!(along(10.4).is_some(), "the body touches it");
    assert_eq!(along(10.7), None, "beside it");
    // Diagonally, backwards, and over a step that the robot climbs.
    let diagonal = [DVec3::new(13.0, 15.0, 0.0), DVec3::new(3.0, 5.0, 0.0)];
    let found = columns.obstruction(diagonal).expect("through the pillar").along_m;
    assert!((found - 6.8).abs() < 0.3, "{found}");
    let mut low = floor(0.0);
    low.extend(pillar(DVec2::new(8.0, 10.0), 0.2));
    let ends = [DVec3::new(2.0, 10.0, 0.0), DVec3::new(16.0, 10.0, 0.0)];
    assert_eq!(self::columns(&low).obstruction(ends), None);
}

#[test]
fn sloping_floors_and_single_points_are_no_obstacles() {
    let mut points: Vec<DVec3> = floor(0.0).into_iter().map(|point| point.with_z(0.2 * point.x)).collect();
    points.push(DVec3::new(8.0, 10.0, 2.1));
    let columns = columns(&points);
    let ends = [DVec3::new(2.0, 10.0, 0.4), DVec3::new(16.0, 10.0, 3.2)];
    assert_eq!(columns.obstruction(ends), None);
    assert_eq!(columns.obstruction([ends[0]; 2]), None, "a line without length");
}

#[test]
fn columns_without_area_or_with_too_much_hold_what_they_can() {
    for corners in [[DVec2::ZERO; 2], [DVec2::NAN; 2], [DVec2::ZERO, DVec2::splat(1e9)]] {
        let columns = PointColumns::new(ColumnsConfig::default(), corners, |visit| visit(DVec3::ONE));
        assert_eq!(columns.floor(DVec2::ONE, 1.0), None);
        assert_eq!(columns.obstruction([DVec3::ZERO, DVec3::X]), None);
        assert!(!columns.covers(DVec2::splat(-1.0), 0.5));
    }
}

/// The cost that the module states. The limit is ten times what a laptop takes without load, so that it holds while other tests run.
#[test]
fn a_long_line_over_a_dense_cloud_is_quick() {
    let points: Vec<DVec3> = (0..12).flat_map(|layer| floor(0.07 * f64::from(layer))).collect();
    let columns = columns(&points);
    let ends = [DVec3::new(2.0, 3.0, 0.7), DVec3::new(14.0, 3.3, 0.7)];
    let started = std::time::Instant::now();
    for _ in 0..100 {
        assert_eq!(columns.obstruction(ends).map(|found| found.along_m), None);
    }
    let each_ms = started.elapsed().as_secs_f64() * 10.0;
    println!("a line of 12 m over {} points: {each_ms:.3} ms", points.len());
    assert!(each_ms < 2.0, "{each_ms} ms");
}
