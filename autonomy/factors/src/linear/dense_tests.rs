//! Compares the tiled elimination with the textbook's three nested loops.

use super::dense::{BadPivot, Front};
use geometry::RngTree;

/// Columns of a random positive definite matrix.
fn positive_definite(size: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = RngTree::new(seed).child("dense").rng();
    let root: Vec<Vec<f64>> = (0..size).map(|_| (0..size).map(|_| rng.normal()).collect()).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    (0..size)
        .map(|j| (0..size).map(|i| dot(&root[i], &root[j]) + if i == j { 1.0 } else { 0.0 }).collect())
        .collect()
}

fn textbook(columns: &mut [Vec<f64>], eliminate: usize) {
    let size = columns.len();
    for k in 0..eliminate {
        let root = columns[k][k].sqrt();
        for i in k..size {
            columns[k][i] /= root;
        }
        for j in k + 1..size {
            for i in j..size {
                let product = columns[k][i] * columns[k][j];
                columns[j][i] -= product;
            }
        }
    }
}

fn front(columns: &[Vec<f64>]) -> Front {
    let mut front = Front::default();
    front.reset(columns.len());
    for (j, column) in columns.iter().enumerate() {
        front.column_mut(j)[j..].copy_from_slice(&column[j..]);
    }
    front
}

#[test]
fn tiled_elimination_equals_three_nested_loops_at_every_size() {
    for size in [1, 2, 6, 7, 8, 9, 13, 19, 64, 65, 130, 200] {
        for eliminate in [1, 3, 6, 8, 12, 63, 64, 65, 72, 129, size] {
            if eliminate > size {
                continue;
            }
            let mut expected = positive_definite(size, (size * 1000 + eliminate) as u64);
            let mut front = front(&expected);
            textbook(&mut expected, eliminate);
            front.eliminate(eliminate).unwrap();
            for (j, column) in expected.iter().enumerate() {
                for (got, want) in front.column(j).iter().zip(&column[j..]) {
                    assert!((got - want).abs() < 1e-9 * (1.0 + want.abs()), "{size} {eliminate} column {j}");
                }
            }
        }
    }
}

#[test]
fn a_singular_or_nan_matrix_is_reported_with_its_column() {
    let mut columns = positive_definite(30, 3);
    // Column 20 becomes the sum of columns 3 and 7.
    for i in 0..30 {
        let sum = columns[3][i] + columns[7][i];
        columns[20][i] = sum;
    }
    for j in 0..30 {
        columns[j][20] = columns[20][j];
    }
    let corner = columns[20][3] + columns[20][7];
    columns[20][20] = corner;
    assert_eq!(front(&columns).eliminate(30), Err(BadPivot(20)));
    assert!(front(&columns).eliminate(20).is_ok());

    let mut columns = positive_definite(12, 4);
    columns[5][9] = f64::NAN;
    assert_eq!(front(&columns).eliminate(12), Err(BadPivot(9)));
    columns[2][2] = -1.0;
    assert_eq!(front(&columns).eliminate(12), Err(BadPivot(2)));
}
