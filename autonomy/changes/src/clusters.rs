//! Groups of points that are near each other.

use crate::surfaces::squared_distance;
use points::hash::{CellKey, CellTable};

/// Groups of these points in which each point has another within `gap_m`, metres: the places of the points, each group in ascending order, the groups by their first point.
/// Linear in the pairs of points in neighbouring cells, whose side is the gap.
pub(crate) fn clusters(points: &[[f32; 3]], gap_m: f32) -> Vec<Vec<usize>> {
    // Points of a cell, as a list that is linked through `next`.
    let mut heads = CellTable::with_capacity(points.len());
    let mut next = vec![None; points.len()];
    let mut first: Vec<usize> = Vec::new();
    let mut parents: Vec<usize> = (0..points.len()).collect();
    for (place, point) in points.iter().enumerate() {
        let cell = CellKey::of_point(point, 1.0 / gap_m);
        for offset in (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| [x, y, z]))) {
            let at = cell.cell();
            let around = CellKey::new(std::array::from_fn(|axis| at[axis] + offset[axis]));
            let mut other = heads.get(around).map(|head| first[head as usize]);
            while let Some(near) = other {
                if squared_distance(point, &points[near]) <= gap_m * gap_m {
                    join(&mut parents, place, near);
                }
                other = next[near];
            }
        }
        let (head, is_new) = heads.get_or_insert(cell, first.len() as u32);
        if is_new {
            first.push(place);
        } else {
            next[place] = Some(first[head as usize]);
            first[head as usize] = place;
        }
    }
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut group_of = vec![None; points.len()];
    for place in 0..points.len() {
        let root = root_of(&mut parents, place);
        let group = *group_of[root].get_or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group].push(place);
    }
    groups
}

fn root_of(parents: &mut [usize], place: usize) -> usize {
    let mut root = place;
    while parents[root] != root {
        parents[root] = parents[parents[root]];
        root = parents[root];
    }
    root
}

fn join(parents: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root_of(parents, a), root_of(parents, b));
    // The earlier point is the root, so that groups do not depend on the order of joining.
    parents[a.max(b)] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_grouped_by_chains_of_short_distances() {
        let points = [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.25, 0.0, 0.0], [5.2, 0.1, 0.0]];
        assert_eq!(clusters(&points, 0.3), [vec![0, 2, 3], vec![1, 4]]);
        assert_eq!(clusters(&[], 0.3), Vec::<Vec<usize>>::new());
    }
}
