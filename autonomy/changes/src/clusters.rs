//! Groups of points that are near each other.

use crate::surfaces::squared_distance;
use points::hash::{CellKey, CellTable};

/// How many cells away, along each axis, a cell may have a point within the gap.
const REACH: i64 = 2;

/// Groups of these points in which each point has another within `gap_m`, metres: the places of the points, each group in ascending order, the groups by their first point.
/// Points of one cell are near each other anyway, because the diagonal of a cell is the gap; and two cells are asked for a pair of points only if they are not in one group yet. Linear in the points, and for cells
/// of which no points are near each other in the pairs of them.
pub(crate) fn clusters(points: &[[f32; 3]], gap_m: f32) -> Vec<Vec<usize>> {
    // A little less, so that rounding makes no diagonal longer.
    let cells_per_m = 1.001 * 3.0_f32.sqrt() / gap_m;
    let mut table = CellTable::default();
    let mut cells: Vec<(CellKey, Vec<usize>)> = Vec::new();
    let mut cell_of: Vec<usize> = Vec::with_capacity(points.len());
    for (place, point) in points.iter().enumerate() {
        let key = CellKey::of_point(point, cells_per_m);
        let (cell, is_new) = table.get_or_insert(key, cells.len() as u32);
        if is_new {
            cells.push((key, Vec::new()));
        }
        cells[cell as usize].1.push(place);
        cell_of.push(cell as usize);
    }
    let mut parents: Vec<usize> = (0..cells.len()).collect();
    let steps = -REACH..=REACH;
    let offsets: Vec<[i64; 3]> = steps
        .clone()
        .flat_map(|x| steps.clone().flat_map(move |y| (-REACH..=REACH).map(move |z| [x, y, z])))
        // The others are the same pairs of cells.
        .filter(|offset| *offset > [0; 3])
        .collect();
    for (cell, (key, of_cell)) in cells.iter().enumerate() {
        let at = key.cell();
        for offset in &offsets {
            let beside = CellKey::new(std::array::from_fn(|axis| at[axis] + offset[axis]));
            let Some(other) = table.get(beside).map(|other| other as usize) else { continue };
            let is_near = |a: &usize, b: &usize| squared_distance(&points[*a], &points[*b]) <= gap_m * gap_m;
            if root_of(&mut parents, cell) != root_of(&mut parents, other)
                && of_cell.iter().any(|a| cells[other].1.iter().any(|b| is_near(a, b)))
            {
                join(&mut parents, cell, other);
            }
        }
    }
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut group_of = vec![None; cells.len()];
    for (place, cell) in cell_of.into_iter().enumerate() {
        let root = root_of(&mut parents, cell);
        let group = *group_of[root].get_or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group].push(place);
    }
    groups
}

/// The group of a place: its root.
pub(crate) fn root_of(parents: &mut [usize], place: usize) -> usize {
    let mut root = place;
    while parents[root] != root {
        parents[root] = parents[parents[root]];
        root = parents[root];
    }
    root
}

/// Makes the groups of two places one.
pub(crate) fn join(parents: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root_of(parents, a), root_of(parents, b));
    // The earlier cell is the root, so that groups do not depend on the order of joining.
    parents[a.max(b)] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    #[test]
    fn points_are_grouped_by_chains_of_short_distances() {
        let points = [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.25, 0.0, 0.0], [5.2, 0.1, 0.0]];
        assert_eq!(clusters(&points, 0.3), [vec![0, 2, 3], vec![1, 4]]);
        assert_eq!(clusters(&[], 0.3), Vec::<Vec<usize>>::new());
    }

    #[test]
    fn groups_are_those_of_all_pairs() {
        let mut rng = RngTree::new(9).child("clusters").rng();
        let spots: Vec<[f64; 3]> = (0..40).map(|_| [0; 3].map(|_| rng.uniform() * 4.0)).collect();
        let mut near = |spot: &[f64; 3]| spot.map(|at| (at + 0.2 * rng.normal()) as f32);
        let points: Vec<[f32; 3]> = spots.iter().flat_map(|spot| [(); 12].map(|()| near(spot))).collect();
        let gap_m = 0.25;
        let mut expected: Vec<usize> = (0..points.len()).collect();
        for a in 0..points.len() {
            for b in 0..a {
                if squared_distance(&points[a], &points[b]) <= gap_m * gap_m {
                    join(&mut expected, a, b);
                }
            }
        }
        let groups = clusters(&points, gap_m);
        for group in &groups {
            assert!(group.iter().all(|place| root_of(&mut expected, *place) == group[0]));
        }
        let roots = (0..points.len()).filter(|place| root_of(&mut expected, *place) == *place).count();
        assert_eq!(groups.len(), roots);
        assert!(groups.len() > 10 && groups.iter().any(|group| group.len() > 12));
    }
}
