//! Correspondence by K-means, as the reference does it.

use crate::Descriptor;

/// Rounds at most; the clusters of a comparison settle in a few.
const MAX_ROUNDS: usize = 100;

/// Pairs of objects of two lists whose descriptors come into one cluster, each object once, the nearest first. There are as many clusters as objects in the longer list, because each of its
/// objects is a thing of its own. The first centres are descriptors that are farthest from each other, so nothing is random. Source: LiSTA (Rowell and others, 2024) clusters
/// the descriptors of objects of all visits by K-means (Lloyd, *Least squares quantization in PCM*, 1982). Descriptors of several names give no pairs.
pub fn pairs_by_clusters(first: &[Descriptor], second: &[Descriptor]) -> Vec<[usize; 2]> {
    let all: Vec<&Descriptor> = first.iter().chain(second).collect();
    if first.is_empty() || second.is_empty() || all.iter().any(|one| all[0].distance(one).is_none()) {
        return Vec::new();
    }
    let points: Vec<Vec<f64>> =
        all.iter().map(|one| one.values.iter().map(|value| f64::from(*value) / 127.0).collect()).collect();
    let cluster = clusters(&points, first.len().max(second.len()));
    let mut candidates = Vec::new();
    for a in 0..first.len() {
        for b in 0..second.len() {
            if cluster[a] == cluster[first.len() + b] {
                candidates.push((squared(&points[a], &points[first.len() + b]), [a, b]));
            }
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    for (_, [a, b]) in candidates {
        if pairs.iter().all(|pair| pair[0] != a && pair[1] != b) {
            pairs.push([a, b]);
        }
    }
    pairs.sort_unstable();
    pairs
}

/// The cluster of each point.
fn clusters(points: &[Vec<f64>], count: usize) -> Vec<usize> {
    let mut centres: Vec<Vec<f64>> = vec![points[0].clone()];
    while centres.len() < count {
        let distance = |point: &Vec<f64>| {
            centres.iter().map(|centre| squared(point, centre)).fold(f64::INFINITY, f64::min)
        };
        let distances: Vec<f64> = points.iter().map(distance).collect();
        let farthest = (0..points.len())
            .fold(0, |best, place| if distances[place] > distances[best] { place } else { best });
        centres.push(points[farthest].clone());
    }
    let mut of_point = vec![usize::MAX; points.len()];
    for _ in 0..MAX_ROUNDS {
        let nearest = |point: &Vec<f64>| {
            let distances: Vec<f64> = centres.iter().map(|centre| squared(point, centre)).collect();
            (0..centres.len())
                .fold(0, |best, place| if distances[place] < distances[best] { place } else { best })
        };
        let next: Vec<usize> = points.iter().map(nearest).collect();
        if next == of_point {
            break;
        }
        of_point = next;
        for (number, centre) in centres.iter_mut().enumerate() {
            let members: Vec<&Vec<f64>> = points
                .iter()
                .zip(&of_point)
                .filter(|(_, of)| **of == number)
                .map(|(point, _)| point)
                .collect();
            if !members.is_empty() {
                for (axis, at) in centre.iter_mut().enumerate() {
                    *at = members.iter().map(|member| member[axis]).sum::<f64>() / members.len() as f64;
                }
            }
        }
    }
    of_point
}

fn squared(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: [i8; 2]) -> Descriptor {
        Descriptor { name: "test".to_owned(), values: values.to_vec() }
    }

    #[test]
    fn objects_of_one_cluster_are_pairs() {
        let first = [of([0, 0]), of([100, 0]), of([0, 100])];
        let second = [of([2, 98]), of([97, 3])];
        assert_eq!(pairs_by_clusters(&first, &second), [[1, 1], [2, 0]]);
        assert_eq!(pairs_by_clusters(&first, &[]), [[0; 2]; 0]);
        let other = Descriptor { name: "other".to_owned(), values: vec![0, 0] };
        assert_eq!(pairs_by_clusters(&first, &[other]), [[0; 2]; 0], "not comparable");
    }
}
