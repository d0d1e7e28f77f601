//! Names of topics, frames and schemas in recordings of the platform.

/// LiDAR sweeps, `sensor_msgs/PointCloud2`.
pub const LIDAR: &str = "/lidar/points";
/// LiDAR sweeps as range images, see [`scan_codec`]: those that the stack saw on the grid of the sensor, in a tenth of the space.
pub const RANGE_IMAGE: &str = "/lidar/range_image";
/// Name of the schema of [`RANGE_IMAGE`].
pub const RANGE_IMAGE_SCHEMA: &str = "autoinspect.RangeImage.v1";
/// Message and schema encoding of [`RANGE_IMAGE`].
pub const RANGE_IMAGE_ENCODING: &str = "autoinspect.range_image";
/// Inertial samples, `sensor_msgs/Imu`.
pub const IMU: &str = "/imu/data";
/// Leg odometry, `nav_msgs/Odometry`, velocity in the base frame.
pub const LEGS: &str = "/legs/odometry";
/// Another odometry, `nav_msgs/Odometry`.
pub const EXTERNAL: &str = "/external/odometry";
/// Battery, `sensor_msgs/BatteryState`.
pub const BATTERY: &str = "/battery";
/// Mounting of the sensors, `tf2_msgs/TFMessage`.
pub const TF_STATIC: &str = "/tf_static";
/// Ground truth (simulation only), `geometry_msgs/PoseStamped`.
pub const TRUTH: &str = "/truth";
/// The estimated pose, `geometry_msgs/PoseStamped`.
pub const POSE: &str = "/autoinspect/pose";
/// All other inputs of the stack: `messages::Input` in postcard's encoding.
pub const INPUT: &str = "/autoinspect/input";
/// Name of the schema of [`INPUT`]. Its version rises with every change of `messages::Input`; older versions are read too.
pub const INPUT_SCHEMA: &str = "autoinspect.Input.v15";
/// Message and schema encoding of [`INPUT`].
pub const INPUT_ENCODING: &str = "postcard";

/// Frame of the robot's body.
pub const BASE_FRAME: &str = "base_link";
/// Frame of the LiDAR.
pub const LIDAR_FRAME: &str = "lidar";
/// Frame of the IMU.
pub const IMU_FRAME: &str = "imu";
/// Frame whose pose the other odometry reports.
pub const EXTERNAL_FRAME: &str = "external";
