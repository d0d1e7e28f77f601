//! Fixed walks through a site.

use vocab::Vec3;

/// Initial position and heading of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Position on or somewhat above the ground, site frame, metres.
    pub position: Vec3,
    /// Heading, counter-clockwise from the site's x axis, radians.
    pub yaw: f64,
}

/// A walk through a site.
#[derive(Clone, Debug, PartialEq)]
pub struct SiteRoute {
    /// Name: "round" or "short".
    pub name: &'static str,
    /// Where the walk begins.
    pub start: Start,
    /// Corners of the walk, site frame x and y, metres. Heights follow from the ground.
    pub waypoints: Vec<[f64; 2]>,
    /// Speed on straight stretches, m/s.
    pub speed: f64,
}
