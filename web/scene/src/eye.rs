//! The mathematics of one picture: what a camera pose and a viewport make of points and pixels.

use crate::camera::CameraPose;
use glam::{DMat4, DVec2, DVec3, DVec4, Mat4};

/// A half line in the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts, metres, map frame.
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
}

impl Ray {
    /// Where it meets the horizontal plane at a height (metres); none when it runs along or away from it.
    pub fn at_height(&self, height: f64) -> Option<DVec3> {
        let along = (height - self.origin.z) / self.direction.z;
        (along.is_finite() && along > 0.0).then(|| self.origin + self.direction * along)
    }
}

/// A camera pose with a viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    pose: CameraPose,
    position: DVec3,
    viewport_px: DVec2,
}

impl Eye {
    /// Tangent of half the vertical field of view (50 degrees).
    pub const TAN_HALF_FOV: f64 = 0.466_307_658_154_998_6;
    /// What is nearer than this is not drawn, metres.
    pub const NEAR: f64 = 0.05;

    /// A picture of at least one pixel.
    pub fn new(pose: CameraPose, viewport_px: [u32; 2]) -> Self {
        let viewport_px = DVec2::new(f64::from(viewport_px[0].max(1)), f64::from(viewport_px[1].max(1)));
        Self { pose, position: pose.eye_position(), viewport_px }
    }

    /// Where the eye is, metres, map frame.
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// Pixels that one metre spans at a distance of one metre.
    pub fn focal_px(&self) -> f64 {
        0.5 * self.viewport_px.y / Self::TAN_HALF_FOV
    }

    /// From metres relative to the eye, along the map's axes, to clip coordinates: depth 1 at the near plane, 0 at
    /// infinity, w the distance along the line of sight.
    pub fn clip_from_relative(&self) -> Mat4 {
        let (right, forward) = (self.pose.right(), self.pose.forward());
        let up = right.cross(forward);
        let view = DMat4::from_cols(
            DVec4::new(right.x, up.x, -forward.x, 0.0),
            DVec4::new(right.y, up.y, -forward.y, 0.0),
            DVec4::new(right.z, up.z, -forward.z, 0.0),
            DVec4::W,
        );
        let scale = 1.0 / Self::TAN_HALF_FOV;
        let projection = DMat4::from_cols(
            DVec4::new(scale * self.viewport_px.y / self.viewport_px.x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, scale, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 0.0, -1.0),
            DVec4::new(0.0, 0.0, Self::NEAR, 0.0),
        );
        (projection * view).as_mat4()
    }

    /// Distance along the line of sight, metres; negative behind the eye.
    pub fn depth(&self, point_in_map: DVec3) -> f64 {
        (point_in_map - self.position).dot(self.pose.forward())
    }

    /// Pixel (from the top left corner, y down) and depth (metres) of a point; none behind the near plane. The
    /// pixel may be outside the picture.
    pub fn project(&self, point_in_map: DVec3) -> Option<(DVec2, f64)> {
        let relative = point_in_map - self.position;
        let (right, forward) = (self.pose.right(), self.pose.forward());
        let depth = relative.dot(forward);
        let across = DVec2::new(relative.dot(right), -relative.dot(right.cross(forward)));
        (depth >= Self::NEAR).then(|| (self.viewport_px * 0.5 + across * (self.focal_px() / depth), depth))
    }

    /// Pixels of the two ends of a line, cut off at the near plane; none when all of it is behind that. Both may be
    /// outside the picture.
    pub fn project_line(&self, ends_in_map: [DVec3; 2]) -> Option<[DVec2; 2]> {
        let [a, b] = ends_in_map;
        let (depth_a, depth_b) = (self.depth(a), self.depth(b));
        // A little beyond the plane, so that rounding does not put the cut before it.
        let plane = Self::NEAR * 1.001;
        let cut = |from: DVec3, to: DVec3, near: f64, far: f64| {
            if near >= plane { from } else { from.lerp(to, (plane - near) / (far - near)) }
        };
        if depth_a.max(depth_b) < plane {
            return None;
        }
        let (first, second) = (cut(a, b, depth_a, depth_b), cut(b, a, depth_b, depth_a));
        Some([self.project(first)?.0, self.project(second)?.0])
    }

    /// The ray through a pixel.
    pub fn ray(&self, pixel: DVec2) -> Ray {
        let (right, forward) = (self.pose.right(), self.pose.forward());
        let across = (pixel - self.viewport_px * 0.5) / self.focal_px();
        let direction = forward + right * across.x - right.cross(forward) * across.y;
        Ray { origin: self.position, direction: direction / direction.length() }
    }

    /// Whether a ball (centre in metres, map frame, and radius) may be in the picture.
    pub fn sees_ball(&self, centre_in_map: DVec3, radius: f64) -> bool {
        let relative = centre_in_map - self.position;
        let (right, forward) = (self.pose.right(), self.pose.forward());
        let up = right.cross(forward);
        let depth = relative.dot(forward);
        let tan =
            DVec2::new(Self::TAN_HALF_FOV * self.viewport_px.x / self.viewport_px.y, Self::TAN_HALF_FOV);
        // Signed distance beyond each pair of side planes, whose normals have this length before scaling.
        let beyond = |across: f64, tan: f64| (across.abs() - depth * tan) / (1.0 + tan * tan).sqrt();
        depth > Self::NEAR - radius
            && beyond(relative.dot(right), tan.x) <= radius
            && beyond(relative.dot(up), tan.y) <= radius
    }
}
