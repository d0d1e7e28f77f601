//! The distances over the floor of a survey, compared with a search by hand.

use super::*;
use crate::TopomapConfig;
use crate::floor::FloorBuilder;
use crate::tests::ROBOT;
use geometry::Isometry;
use std::collections::BinaryHeap;
use vocab::Stamp;

/// A level floor of 6 by 5 m with a box on it.
fn floor() -> Floor {
    let mut points = Vec::new();
    for x in 0..120_u16 {
        for y in 0..100_u16 {
            let [x, y] = [x, y].map(|step| 0.05 * f32::from(step) + 0.02);
            let is_box = (2.5..3.5).contains(&x) && (1.5..3.0).contains(&y);
            points.push([x, y, if is_box { 0.8 } else { 0.0 }]);
        }
    }
    let mut builder = FloorBuilder::new(ROBOT, TopomapConfig::default());
    builder.insert(Stamp::EPOCH, &Isometry::identity(), &points);
    builder.build(&[])
}

/// Dijkstra's search with a queue of its own, which settles ties by the numbers of cell and parent.
fn add_by_hand(reach: &mut Reach, walkable: &Walkable, floor: &Floor, cell: u32, number: u32) {
    let mut queue = BinaryHeap::from([Reverse((0_u32, cell, NONE))]);
    while let Some(Reverse((distance, cell, parent))) = queue.pop() {
        let index = cell as usize;
        if distance >= reach.distance[index] {
            continue;
        }
        (reach.distance[index], reach.parent[index], reach.place[index]) = (distance, parent, number);
        for next in walkable.next_to(cell) {
            let reached = distance.saturating_add(walkable.cost(floor, cell, next));
            if reached < reach.distance[next as usize] {
                queue.push(Reverse((reached, next, cell)));
            }
        }
    }
}

#[test]
fn distances_paths_and_regions_are_those_of_a_search_by_hand() {
    let floor = floor();
    let walkable = Walkable::new(&floor);
    let cells = walkable.cells.len() as u32;
    assert!(cells > 500, "{cells} cells");
    let (mut reach, mut by_hand) = (Reach::new(walkable.cells.len()), Reach::new(walkable.cells.len()));
    for (number, cell) in (0..).zip([0, cells - 1, cells / 2, cells / 3, cells / 5]) {
        reach.add(&walkable, &floor, cell, number);
        add_by_hand(&mut by_hand, &walkable, &floor, cell, number);
        assert_eq!(reach.distance, by_hand.distance, "after place {number}");
        assert_eq!(reach.parent, by_hand.parent, "after place {number}");
        assert_eq!(reach.place, by_hand.place, "after place {number}");
    }
}
