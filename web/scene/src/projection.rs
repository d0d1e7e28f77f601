//! Projection: from points of the map to pixels of a viewport and back.

use crate::camera_pose::CameraPose;
use glam::{DMat4, DVec2, DVec3, DVec4, Mat4};

/// A half line in the map frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Its start, m, map frame.
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
}

impl Ray {
    /// Its intersection with the horizontal plane at a height (m); none when it runs along the plane or away from it.
    pub fn at_height(&self, height: f64) -> Option<DVec3> {
        let along = (height - self.origin.z) / self.direction.z;
        (along.is_finite() && along > 0.0).then(|| self.origin + self.direction * along)
    }
}

/// The perspective projection of a camera pose into a viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraProjection {
    pose: CameraPose,
    camera_position: DVec3,
    viewport_px: DVec2,
    /// Tangent of half the vertical field of view.
    tan_half_fov: f64,
}

impl CameraProjection {
    /// Tangent of half the vertical field of view (50 degrees).
    pub const TAN_HALF_FOV: f64 = 0.466_307_658_154_998_6;
    /// Depth of the near plane, m: nearer points are not drawn. A tenth of the shortest camera distance. The depth buffer holds reversed
    /// floats, so a near plane this close costs no precision.
    pub const NEAR_M: f64 = 0.01;

    /// Projects into a viewport, which counts as one pixel at least along each side.
    pub fn new(pose: CameraPose, viewport_px: [u32; 2]) -> Self {
        let viewport_px = DVec2::new(f64::from(viewport_px[0].max(1)), f64::from(viewport_px[1].max(1)));
        Self { pose, camera_position: pose.position(), viewport_px, tan_half_fov: Self::TAN_HALF_FOV }
    }

    /// The same with a focal length that is this many times as long.
    pub(crate) fn magnified(self, magnification: f64) -> Self {
        let magnification = if magnification > 0.0 { magnification } else { 1.0 };
        Self { tan_half_fov: Self::TAN_HALF_FOV / magnification, ..self }
    }

    /// Position of the camera, m, map frame.
    pub fn camera_position(&self) -> DVec3 {
        self.camera_position
    }

    /// Focal length, px: a metre at a depth of 1 m spans this many pixels.
    pub fn focal_px(&self) -> f64 {
        0.5 * self.viewport_px.y / self.tan_half_fov
    }

    /// From metres relative to the camera, along the map's axes, to clip coordinates: depth 1 at the near plane, 0 at
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
        let scale = 1.0 / self.tan_half_fov;
        let projection = DMat4::from_cols(
            DVec4::new(scale * self.viewport_px.y / self.viewport_px.x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, scale, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 0.0, -1.0),
            DVec4::new(0.0, 0.0, Self::NEAR_M, 0.0),
        );
        (projection * view).as_mat4()
    }

    /// Distance along the line of sight, metres; negative behind the camera.
    pub fn depth(&self, point_in_map: DVec3) -> f64 {
        (point_in_map - self.camera_position).dot(self.pose.forward())
    }

    /// Pixel (from the top left corner, y down) and depth (metres) of a point; none behind the near plane. The
    /// pixel may be outside the image.
    pub fn project(&self, point_in_map: DVec3) -> Option<(DVec2, f64)> {
        let relative = point_in_map - self.camera_position;
        let (right, forward) = (self.pose.right(), self.pose.forward());
        let depth = relative.dot(forward);
        let across = DVec2::new(relative.dot(right), -relative.dot(right.cross(forward)));
        (depth >= Self::NEAR_M).then(|| (self.viewport_px * 0.5 + across * (self.focal_px() / depth), depth))
    }

    /// Pixels of the two ends of a line, cut off at the near plane; none when all of it is behind that. Both may be
    /// outside the image.
    pub fn project_line(&self, ends_in_map: [DVec3; 2]) -> Option<[DVec2; 2]> {
        let [a, b] = ends_in_map;
        let (depth_a, depth_b) = (self.depth(a), self.depth(b));
        // 0.1 % beyond the plane, so that rounding does not put the cut before it.
        let plane = Self::NEAR_M * 1.001;
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
        Ray { origin: self.camera_position, direction: direction / direction.length() }
    }

    /// Whether a sphere (centre in m, map frame, and radius) may be in the image.
    pub fn sees_sphere(&self, centre_in_map: DVec3, radius: f64) -> bool {
        let relative = centre_in_map - self.camera_position;
        let (right, forward) = (self.pose.right(), self.pose.forward());
        let up = right.cross(forward);
        let depth = relative.dot(forward);
        let tan = DVec2::new(self.tan_half_fov * self.viewport_px.x / self.viewport_px.y, self.tan_half_fov);
        // Signed distance beyond each pair of side planes, whose normals have this length before scaling.
        let beyond = |across: f64, tan: f64| (across.abs() - depth * tan) / (1.0 + tan * tan).sqrt();
        depth > Self::NEAR_M - radius
            && beyond(relative.dot(right), tan.x) <= radius
            && beyond(relative.dot(up), tan.y) <= radius
    }
}
