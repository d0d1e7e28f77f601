//! The 3D scene of the operator's client: point clouds, robot, graph, trajectory, markers.
//!
//! It draws with wgpu on WebGPU and on WebGL2, so it uses neither compute shaders nor storage buffers. It depends neither on the user
//! interface nor on the server's API: callers pass plain slices, poses and colours.
//!
//! A frame is drawn in these steps:
//!
//! 1. [`Renderer::prepare`] selects tiles by the spacing of their points on the screen (level of detail), coarse first, until the point
//!    budget is spent. It draws them as single pixels into colour and packed depth, and the robot's mesh with them.
//! 2. Two passes fill the gaps: they grow every point to the size of its spacing, nearest first. This closes surfaces with one vertex
//!    for each point.
//! 3. Eye-dome lighting shades the result by its depth, in front of the background's gradient.
//! 4. Grid, lines and markers are drawn on top, faintly where a surface hides them.
//! 5. [`Renderer::paint`] copies the image into the caller's render pass.
//!
//! Steps 1 to 4 run only when something changed; see [`Renderer::needs_redraw`]. Positions are in metres in the map frame, z up. After a
//! lost device, make a new [`Renderer`] and pass everything again.

mod camera;
mod camera_pose;
mod colour_map;
mod frame_pacing;
mod hatching;
mod level_of_detail;
mod overlay;
mod overlay_instances;
mod picking;
mod pipelines;
mod point_columns;
mod pose_graph;
mod projection;
mod render_targets;
mod renderer;
mod robot;
mod shaders;
mod tiles;
mod uniforms;
mod vertex_buffer;
mod view;

#[cfg(test)]
mod tests;

pub use camera::{Camera, FreeArea, SceneCameraConfig};
pub use camera_pose::CameraPose;
pub use colour_map::ColourMap;
pub use frame_pacing::{FramePacer, FramePacingConfig};
pub use hatching::hatching;
pub use overlay::{Marker, MarkerShape, Polyline};
pub use picking::{Hit, PickOptions};
pub use point_columns::{ColumnsConfig, Obstruction, PointColumns};
pub use pose_graph::{LoopEdge, LoopState, PoseNode};
pub use projection::{CameraProjection, Ray};
pub use renderer::{FrameStatistics, Renderer};
pub use robot::RobotState;
pub use tiles::{AnchorId, PointBlock, TileId, WHOLE_MAP};
pub use view::{Colour, ColourBy, Options, Palette, View};
