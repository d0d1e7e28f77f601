//! The 3D scene of the operator's client: point clouds, robot, graph, trajectory, markers.
//!
//! It draws with wgpu on WebGPU and on WebGL2 (so no compute and no storage buffers) and knows neither the user
//! interface nor the server's API: callers hand in plain slices, poses and colours.
//!
//! How a frame is made:
//!
//! 1. [`Renderer::prepare`] picks tiles by how large their point spacing appears on the screen, coarse first, until
//!    the point budget is spent, and draws them as single pixels into colour and packed depth. The robot's model
//!    goes into the same pass.
//! 2. Two passes grow every point to the size of its spacing, nearest first, which closes surfaces without drawing
//!    more than one vertex a point.
//! 3. Eye-dome lighting shades the result by its depth; the background fades behind it.
//! 4. Grid, lines and markers go on top, faint where something is in front of them.
//! 5. [`Renderer::paint`] copies the picture into the caller's render pass.
//!
//! Steps 1 to 4 run only when something changed; see [`Renderer::needs_redraw`]. Positions are metres in the map
//! frame, z up. After a lost device, make a new [`Renderer`] and hand everything in again.

mod camera;
mod eye;
mod lines;
mod loops;
mod overlay;
mod pace;
mod pick;
mod pipelines;
mod ramp;
mod renderer;
mod robot;
mod select;
mod shaders;
mod targets;
mod tiles;
mod uniforms;
mod view;

#[cfg(test)]
mod tests;

pub use camera::{Camera, CameraPose, FLIGHT_SECONDS};
pub use eye::{Eye, Ray};
pub use loops::{LoopEdge, LoopState};
pub use overlay::{Marker, Node, Polyline, Shape};
pub use pace::Pace;
pub use pick::{Hit, PickOptions};
pub use ramp::Ramp;
pub use renderer::{Drawn, Renderer};
pub use robot::RobotState;
pub use tiles::{AnchorId, PointBlock, TileId, WHOLE_MAP};
pub use view::{Colour, ColourBy, Options, Palette, View};
