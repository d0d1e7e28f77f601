//! How leaks look: puddles on the floor in visible light, and warmer or colder spots in pictures of temperatures.

use super::surfaces::Finish;
use crate::site::{Leak, Liquid};

/// A puddle lies on surfaces at most this far above or below its middle, metres: a floor is not quite level.
const LEVEL_M: f32 = 0.02;
/// Least upward part of the normal of a surface on which a puddle lies.
const MIN_UPWARD: f32 = 0.9;
/// Width of the edge over which a puddle becomes floor, metres.
const EDGE_M: f32 = 0.02;
/// The outline of a puddle: mean of its radius, and how far two waves round it go to either side, as shares of the radius. Together at most 1.
const OUTLINE: [f32; 3] = [0.86, 0.09, 0.05];

/// How a liquid on a floor looks.
struct LiquidLook {
    /// Red, green and blue light that the floor reflects below it, as shares of what it reflects when it is dry.
    reflected_share: [f32; 3],
    /// Its gloss, as of [`Finish::gloss`].
    gloss: f32,
}

/// Chosen: a wet floor is darker, and a little bluer.
const WATER: LiquidLook = LiquidLook { reflected_share: [0.38, 0.4, 0.43], gloss: 0.7 };
/// Chosen: nearly black, and a little brown.
const OIL: LiquidLook = LiquidLook { reflected_share: [0.12, 0.1, 0.07], gloss: 0.8 };

/// The share of a leak's effect at a point of a surface, both in the site frame, metres: 1 at its middle, 0 outside.
fn share(leak: &Leak, point: [f32; 3], normal: [f32; 3]) -> f32 {
    let radius = leak.radius_m as f32;
    let offset = [0, 1, 2].map(|axis| point[axis] - leak.place.to_array()[axis] as f32);
    let away = offset.iter().map(|c| c * c).sum::<f32>().sqrt();
    if away >= radius {
        return 0.0;
    }
    if leak.liquid.is_none() {
        return (1.0 - (away / radius).powi(2)).powi(2);
    }
    if offset[2].abs() > LEVEL_M || normal[2] < MIN_UPWARD {
        return 0.0;
    }
    let angle = offset[1].atan2(offset[0]);
    // Another outline at each place.
    let phase = (leak.place.x + leak.place.y) as f32;
    let [mean, coarse, fine] = OUTLINE;
    let outline =
        radius * (mean + coarse * (3.0 * angle + phase).sin() + fine * (5.0 * angle - 2.0 * phase).sin());
    let inside = ((outline - away) / EDGE_M.min(0.3 * radius)).clamp(0.0, 1.0);
    inside * inside * (3.0 - 2.0 * inside)
}

/// A surface with what has leaked onto it.
pub(super) fn wetted(leaks: &[Leak], dry: Finish, point: [f32; 3], normal: [f32; 3]) -> Finish {
    leaks.iter().fold(dry, |under, leak| {
        let LiquidLook { reflected_share, gloss } = match leak.liquid {
            None => return under,
            Some(Liquid::Water) => WATER,
            Some(Liquid::Oil) => OIL,
        };
        let share = share(leak, point, normal);
        let albedo = [0, 1, 2].map(|i| under.albedo[i] * (1.0 - share * (1.0 - reflected_share[i])));
        Finish { albedo, gloss: under.gloss + share * (gloss - under.gloss) }
    })
}

/// By how much leaks make a point of a surface warmer, kelvin.
pub(super) fn warmth_k(leaks: &[Leak], point: [f32; 3], normal: [f32; 3]) -> f32 {
    leaks.iter().map(|leak| leak.warmer_k as f32 * share(leak, point, normal)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::Vec3;

    #[test]
    fn a_puddle_stays_on_its_floor_and_within_its_radius() {
        let puddle = Leak {
            place: Vec3::new(3.0, -2.0, 4.0),
            radius_m: 0.5,
            liquid: Some(Liquid::Water),
            warmer_k: 8.0,
        };
        let up = [0.0, 0.0, 1.0];
        let dry = Finish { albedo: [0.4; 3], gloss: 0.1 };
        assert!((warmth_k(&[puddle], [3.0, -2.0, 4.0], up) - 8.0).abs() < 1e-6);
        assert!(wetted(&[puddle], dry, [3.0, -2.0, 4.0], up).albedo[0] < 0.2);
        for (point, normal) in [
            ([3.51, -2.0, 4.0], up),
            ([3.0, -2.0, 4.1], up),
            ([3.0, -2.0, 0.0], up),
            ([3.0, -2.0, 4.0], [1.0, 0.0, 0.0]),
        ] {
            assert_eq!(wetted(&[puddle], dry, point, normal), dry, "{point:?}");
            assert!(warmth_k(&[puddle], point, normal).abs() < 1e-9, "{point:?}");
        }
        // Without a liquid it is on any surface, and is not seen.
        let steam = Leak { liquid: None, ..puddle };
        assert_eq!(wetted(&[steam], dry, [3.0, -2.0, 4.0], up), dry);
        assert!((warmth_k(&[steam], [3.0, -2.0, 4.0], [1.0, 0.0, 0.0]) - 8.0).abs() < 1e-6);
        assert!(warmth_k(&[steam], [3.0, -2.0, 4.49], [1.0, 0.0, 0.0]) < 0.1);
    }
}
