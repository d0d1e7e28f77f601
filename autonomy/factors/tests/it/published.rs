//! Every method reaches the published optima of published graphs.

use crate::support::{Published, load, load_with};
use factors::Residual;
use factors::{BatchConfig, ChordalConfig, Method, chordal, optimise};

/// Name and chi-squared at the optimum, with the residual that is the logarithm of the whole motion.
const OPTIMA: [(&str, f64); 7] = [
    ("tinyGrid3D", 18.627819),
    ("smallGrid3D", 1035.8507),
    ("sphere2500", 1351.4019),
    ("parking-garage", 1.2683848),
    ("intel", 45.004233),
    ("CSAIL", 40.550883),
    ("kitti_05", 157.10385),
];

fn start(published: &Published) -> factors::Values {
    if published.has_start {
        published.values.clone()
    } else {
        chordal(&published.graph, &published.values, &ChordalConfig::default()).unwrap()
    }
}

#[test]
fn every_published_graph_reaches_its_optimum_by_every_method() {
    for (name, optimum) in OPTIMA {
        let Some(published) = load_with(&format!("pose-graphs/{name}.g2o"), Residual::Logarithm) else {
            return;
        };
        for method in [Method::GaussNewton, Method::LevenbergMarquardt, Method::Dogleg] {
            let config = BatchConfig { method, ..BatchConfig::default() };
            let solution = optimise(&published.graph, &start(&published), &config).unwrap();
            let chi2 = published.graph.chi_squared(&solution.values).unwrap();
            println!("{name} {method:?} {chi2} in {} iterations", solution.iterations);
            assert!((chi2 / optimum - 1.0).abs() < 1e-3, "{name} {method:?}: {chi2} instead of {optimum}");
            assert!(solution.converged, "{name} {method:?}");
        }
    }
}

#[test]
fn the_chordal_start_is_close_to_the_optimum() {
    for (name, chordal_chi2, optimum) in [
        ("sphere2500", 1679.35, 1351.4019),
        ("parking-garage", 1.41538, 1.2683848),
        ("intel", 47.7368, 45.004233),
    ] {
        let Some(published) = load_with(&format!("pose-graphs/{name}.g2o"), Residual::Logarithm) else {
            return;
        };
        let values = chordal(&published.graph, &published.values, &ChordalConfig::default()).unwrap();
        let chi2 = published.graph.chi_squared(&values).unwrap();
        println!("{name}: {chi2} at the chordal start, {chordal_chi2} published");
        let config = BatchConfig { method: Method::GaussNewton, ..BatchConfig::default() };
        let solution = optimise(&published.graph, &values, &config).unwrap();
        assert!((solution.cost / optimum - 1.0).abs() < 1e-3, "{name}: {}", solution.cost);
        assert!(chi2 < 3.0 * chordal_chi2, "{name}: {chi2}");
    }
}

#[test]
fn the_same_graph_gives_the_same_bits() {
    let Some(published) = load("pose-graphs/intel.g2o") else { return };
    let run = || optimise(&published.graph, &published.values, &BatchConfig::default()).unwrap();
    let (first, second) = (run(), run());
    assert_eq!(first.cost.to_bits(), second.cost.to_bits());
    assert_eq!(first.values, second.values);
}
