//! Compares the fast ray caster with a slow and simple one.

use crate::{LANES, NO_HIT, RayPacket, SimulatedSite, SiteName, Solid};
use geometry::{Rng, RngTree, Vector3};

/// Range of the first surface along the ray, found in steps of the distance to the nearest solid (sphere tracing). It shares no code with the
/// ray caster.
fn march(solids: &[&Solid], origin: &Vector3, direction: &Vector3, reach: f64) -> Option<f64> {
    let mut range = 0.0;
    while range < reach {
        let point = origin + direction * range;
        let gap = solids.iter().map(|s| s.shape.clearance(&point).distance).fold(f64::INFINITY, f64::min);
        if gap < 1e-5 {
            return Some(range);
        }
        range += gap;
    }
    None
}

/// A point in free space over the site's ground plan.
fn free_point(site: &SimulatedSite, rng: &mut Rng) -> Vector3 {
    let range = |axis: usize| {
        let along = site.outline().iter().map(|corner| corner[axis]);
        (along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max))
    };
    let ((x0, x1), (y0, y1)) = (range(0), range(1));
    loop {
        let point = Vector3::new(rng.range(x0, x1), rng.range(y0, y1), rng.range(0.3, 4.0));
        if site.distance(&point, 0.1).is_none()
            && site.solids().iter().all(|s| s.shape.clearance(&point).distance > 0.0)
        {
            return point;
        }
    }
}

fn random_direction(rng: &mut Rng) -> Vector3 {
    Vector3::new(rng.normal(), rng.normal(), 0.4 * rng.normal()).normalize()
}

#[test]
fn the_tree_finds_the_same_ranges_as_sphere_tracing() {
    for name in SiteName::ALL {
        let (site, mut rng) = (SimulatedSite::new(name), RngTree::new(5).rng());
        let all: Vec<&Solid> = site.solids().iter().collect();
        let (mut rays, mut differ) = (0, Vec::new());
        for _ in 0..12 {
            let origin = free_point(&site, &mut rng);
            let middle = random_direction(&mut rng);
            // The eight rays differ as little as those of a packet, or widely.
            let spread = if rng.uniform() < 0.5 { 0.01 } else { 1.0 };
            let directions: [Vector3; LANES] =
                std::array::from_fn(|_| (middle + random_direction(&mut rng) * spread).normalize());
            let mut packet = RayPacket::new(
                [0, 1, 2].map(|axis| [origin[axis] as f32; LANES]),
                [0, 1, 2].map(|axis| directions.map(|d| d[axis] as f32)),
                60.0,
            );
            site.bvh().cast(&mut packet);
            for lane in 0..LANES {
                rays += 1;
                let fast = (packet.solid[lane] != NO_HIT).then(|| f64::from(packet.range[lane]));
                let slow = march(&all, &origin, &directions[lane], 60.0);
                let same = match (fast, slow) {
                    (Some(a), Some(b)) => (a - b).abs() < 2e-3,
                    (None, None) => true,
                    _ => false,
                };
                if !same {
                    differ.push((origin, directions[lane], fast, slow));
                }
            }
        }
        // A ray along an edge may hit or miss it, so 2 % may differ.
        assert!(differ.len() * 50 <= rays, "{name}: {} of {rays} differ: {:?}", differ.len(), &differ[..3]);
    }
}

/// A random packet from one free point.
fn random_packet(site: &SimulatedSite, rng: &mut Rng) -> RayPacket {
    let origin = free_point(site, rng);
    let directions: [Vector3; LANES] = std::array::from_fn(|_| random_direction(rng));
    RayPacket::new(
        [0, 1, 2].map(|axis| [origin[axis] as f32; LANES]),
        [0, 1, 2].map(|axis| directions.map(|d| d[axis] as f32)),
        60.0,
    )
}

#[test]
fn both_sets_of_instructions_find_the_same_bits() {
    if !crate::Bvh::has_wide_instructions() {
        println!("skipped: this processor has no AVX2");
        return;
    }
    for name in SiteName::ALL {
        let (site, mut rng) = (SimulatedSite::new(name), RngTree::new(9).rng());
        for _ in 0..500 {
            let mut fast = random_packet(&site, &mut rng);
            let mut portable = fast.clone();
            site.bvh().cast(&mut fast);
            site.bvh().cast_portable(&mut portable);
            let bits = |packet: &RayPacket| (packet.range.map(f32::to_bits), packet.solid);
            assert_eq!(bits(&fast), bits(&portable), "{name}");
        }
    }
}

#[test]
fn normals_point_away_from_surfaces_and_single_casts_agree_with_packets() {
    for name in SiteName::ALL {
        let (site, mut rng) = (SimulatedSite::new(name), RngTree::new(6).rng());
        let (mut hits, mut odd) = (0, 0);
        for _ in 0..400 {
            let (origin, direction) = (free_point(&site, &mut rng), random_direction(&mut rng));
            let Some((range, solid)) = site.cast_ray(&origin, &direction, 60.0) else { continue };
            hits += 1;
            let mut packet = RayPacket::single(&origin, &direction, 60.0);
            site.bvh().cast(&mut packet);
            let fast = site.bvh().normal(packet.solid[LANES - 1], packet.end(LANES - 1));
            // Just outside the surface the gradient of the distance is the normal, except at edges.
            let outside = solid.shape.clearance(&(origin + direction * (range - 2e-3))).outward;
            let agreement = (0..3).map(|i| f64::from(fast[i]) * outside[i]).sum::<f64>();
            odd += usize::from(agreement.abs() < 0.98);
        }
        assert!(hits > 200 && odd * 25 < hits, "{name}: {odd} wrong normals of {hits}");
    }
}

#[test]
fn rays_miss_an_empty_tree() {
    let tree = crate::Bvh::new(&[]);
    let mut packet = RayPacket::single(&Vector3::zeros(), &Vector3::x(), 10.0);
    tree.cast(&mut packet);
    tree.near(&Vector3::zeros(), 10.0, |_| unreachable!());
    assert_eq!((packet.solid[0], packet.range[0]), (NO_HIT, 10.0));
}
