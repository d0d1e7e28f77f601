//! Basic types of all parts: time, ids, plain vectors and poses, the head of cameras, why a goal failed, text from outside made legible, and fields of tables. They have no behaviour beyond arithmetic and sentences.
//!
//! Robot and browser both use this crate, so it depends on serde and a UUID type only. Mathematics beyond
//! component access lives in `autonomy/geometry`, which converts to and from these types.

mod camera_head;
mod content_hash;
mod csv;
mod goal_failure;
mod ids;
mod polygon;
mod pose;
mod role;
mod text;
mod time;

pub use camera_head::{CameraAim, CameraHead};
pub use content_hash::{BlobHash, BlobHashError};
pub use csv::csv_field;
pub use goal_failure::GoalFailure;
pub use ids::{
    ActionCallId, ClientId, CommandId, GoalId, KeyframeId, LegId, MAX_MAP_NAME_CHARS, MapId, SessionId,
    UploadId,
};
pub use polygon::is_in_polygon;
pub use pose::{Aabb, Covariance6, Pose, Quat, Twist, Vec3};
pub use role::{Role, RoleError};
pub use text::{MAX_SHOWN_NAME_CHARS, grouped, legible};
pub use time::{Span, Stamp};
