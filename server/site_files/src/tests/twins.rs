//! The exported twin of a site agrees with the site.

use crate::{read_site, write_site};
use geometry::{Rng, RngTree, Vector3};
use sim::{SimulatedSite, SiteName, TessellationConfig};

/// Rounding of rays and of file coordinates to 32 bits, metres.
const ROUNDING_M: f64 = 0.0005;
/// Share of rays whose ranges agree within [`RANGE_TOLERANCE_M`]. The others graze a curved surface, or pass an edge.
const AGREEING_SHARE: f64 = 0.95;
/// A ray that meets a curved surface at 60 degrees ends 4 mm earlier or later.
const RANGE_TOLERANCE_M: f64 = 0.005;

fn twin(site: &SimulatedSite) -> SimulatedSite {
    let folder = tempfile::tempdir().unwrap();
    let file = write_site(folder.path(), site).unwrap();
    read_site(&file).unwrap()
}

fn random_direction(rng: &mut Rng) -> Vector3 {
    Vector3::new(rng.normal(), rng.normal(), 0.4 * rng.normal()).normalize()
}

/// Points of the site's routes, at the height of the LiDAR.
fn eyes(site: &SimulatedSite) -> Vec<Vector3> {
    let route = site.route("round").unwrap();
    let start = route.start.position;
    let over = |[x, y]: [f64; 2]| Vector3::new(x, y, start.z + 0.8);
    route.waypoints.iter().copied().map(over).collect()
}

#[test]
fn rays_end_on_the_surfaces_of_the_original() {
    let bound = TessellationConfig::default().max_deviation_m + ROUNDING_M;
    for name in [SiteName::B1, SiteName::Torus, SiteName::Plant, SiteName::Twins, SiteName::Generated(3)] {
        let site = SimulatedSite::new(name);
        let twin = twin(&site);
        let mut rng = RngTree::new(8).child("rays").rng();
        let (mut rays, mut agreeing) = (0, 0);
        for eye in eyes(&site) {
            for _ in 0..40 {
                let direction = random_direction(&mut rng);
                let [one, two] = [&site, &twin].map(|site| site.cast_ray(&eye, &direction, 80.0));
                rays += 1;
                agreeing += usize::from(match (&one, &two) {
                    (Some((a, _)), Some((b, _))) => (a - b).abs() < RANGE_TOLERANCE_M,
                    (None, None) => true,
                    _ => false,
                });
                for (hit, other) in [(&one, &twin), (&two, &site)] {
                    let Some((range, _)) = hit else { continue };
                    let end = eye + direction * *range;
                    let off = other.distance(&end, 0.5).map_or(f64::INFINITY, f64::abs);
                    assert!(off <= bound, "{name}: from {eye} along {direction}: {off} m from the surface");
                }
            }
        }
        let share = f64::from(agreeing as u32) / f64::from(rays);
        assert!(share >= AGREEING_SHARE, "{name}: {:.1} % of {rays} ranges agree", 100.0 * share);
    }
}

#[test]
fn docks_routes_paths_and_furniture_survive() {
    let site = SimulatedSite::new(SiteName::Generated(3));
    let twin = twin(&site);
    assert_eq!(twin.name(), "generated-3");
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart(twin.outline().as_flattened(), site.outline().as_flattened()) < 1e-9);
    assert_eq!(twin.docks().len(), site.docks().len());
    for (one, two) in twin.docks().iter().zip(site.docks()) {
        let [a, b] = [one, two].map(|dock| [dock.position.x, dock.position.y, dock.position.z, dock.yaw]);
        assert!(apart(&a, &b) < 1e-9);
    }
    for route in site.routes() {
        let again = twin.route(route.name).unwrap();
        assert_eq!(again.waypoints.len(), route.waypoints.len());
        assert!(apart(again.waypoints.as_flattened(), route.waypoints.as_flattened()) < 1e-9);
    }
    // The materials of the surfaces are the same.
    let mut rng = RngTree::new(9).child("rays").rng();
    let (mut same, mut all) = (0, 0);
    for eye in eyes(&site) {
        let direction = random_direction(&mut rng);
        let [one, two] = [&site, &twin].map(|site| site.cast_ray(&eye, &direction, 80.0));
        if let (Some((_, one)), Some((_, two))) = (one, two) {
            all += 1;
            same += usize::from(one.material == two.material);
        }
    }
    assert!(all > 20 && same * 20 >= all * 19, "{same} of {all} materials are the same");
    // What moves on another day moves in the twin too: the same random numbers fall on the same pieces.
    let [day, twin_day] = [&site, &twin].map(|site| site.on_another_day(5, 0.25));
    let mut rng = RngTree::new(10).child("rays").rng();
    let (mut agreeing, mut rays) = (0, 0);
    for eye in eyes(&site) {
        for _ in 0..20 {
            let direction = random_direction(&mut rng);
            let [one, two] = [&day, &twin_day].map(|site| site.cast_ray(&eye, &direction, 80.0));
            rays += 1;
            agreeing +=
                usize::from(matches!((one, two), (Some((a, _)), Some((b, _))) if (a - b).abs() < 0.01));
        }
    }
    assert!(agreeing * 20 >= rays * 19, "{agreeing} of {rays} rays agree on another day");
    let changed = day.solids().len() != site.solids().len();
    assert!(changed || day.solids() != site.solids(), "nothing moved");
}
