//! Header, Imu, Odometry, TFMessage, BatteryState and PoseStamped, field by field as ROS defines them.

use super::RosMessage;
use crate::FormatError;
use crate::cdr::{CdrReader, Encoding, Writer};
use vocab::{Pose, Quat, Stamp, Twist, Vec3};

/// `std_msgs/Header`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Header {
    /// When the data was measured.
    pub stamp: Stamp,
    /// Frame the data is in.
    pub frame_id: String,
}

impl Header {
    /// Reads the header; ROS 1's sequence number is skipped.
    pub(super) fn read(reader: &mut CdrReader<'_>, encoding: Encoding) -> Result<Self, FormatError> {
        let seconds = match encoding {
            Encoding::Ros1 => {
                reader.u32()?;
                i64::from(reader.u32()?)
            }
            Encoding::Cdr => i64::from(reader.i32()?),
        };
        let stamp = Stamp::from_parts(seconds, reader.u32()?);
        Ok(Self { stamp, frame_id: reader.string()? })
    }

    /// Writes the header. Seconds that ROS cannot hold wrap; [`Header::can_hold`] checks for it.
    pub(super) fn write(stamp: Stamp, frame_id: &str, writer: &mut Writer<'_>) {
        let (seconds, nanos) = stamp.parts();
        if writer.encoding() == Encoding::Ros1 {
            writer.u32(0);
        }
        writer.u32(seconds as u32);
        writer.u32(nanos);
        writer.string(frame_id);
    }

    /// Whether ROS 2's 32-bit seconds can hold this instant (years 1970 to 2038).
    pub fn can_hold(stamp: Stamp) -> bool {
        (0..=i64::from(i32::MAX)).contains(&stamp.parts().0)
    }
}

fn read_vec3(reader: &mut CdrReader<'_>) -> Result<Vec3, FormatError> {
    Ok(Vec3::from(reader.f64_array::<3>()?))
}

fn read_quat(reader: &mut CdrReader<'_>) -> Result<Quat, FormatError> {
    let [x, y, z, w] = reader.f64_array::<4>()?;
    Ok(Quat { w, x, y, z })
}

fn read_pose(reader: &mut CdrReader<'_>) -> Result<Pose, FormatError> {
    Ok(Pose { position: read_vec3(reader)?, orientation: read_quat(reader)? })
}

fn write_quat(q: Quat, writer: &mut Writer<'_>) {
    writer.f64_array(&[q.x, q.y, q.z, q.w]);
}

fn write_pose(pose: &Pose, writer: &mut Writer<'_>) {
    writer.f64_array(&pose.position.to_array());
    write_quat(pose.orientation, writer);
}

/// `sensor_msgs/Imu`, without the covariances that nobody fills.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Imu {
    /// When, and in which frame.
    pub header: Header,
    /// Attitude as the device estimates it.
    pub orientation: Quat,
    /// Whether `orientation` means anything (ROS: first covariance element not -1).
    pub has_orientation: bool,
    /// rad/s.
    pub angular_velocity: Vec3,
    /// Specific force, m/s².
    pub linear_acceleration: Vec3,
}

impl RosMessage for Imu {
    const TYPE: &'static str = "sensor_msgs/Imu";

    fn read(reader: &mut CdrReader<'_>) -> Result<Self, FormatError> {
        let header = Header::read(reader, reader.encoding())?;
        let orientation = read_quat(reader)?;
        let has_orientation = reader.f64_array::<9>()?[0] != -1.0;
        let angular_velocity = read_vec3(reader)?;
        reader.f64_array::<9>()?;
        let linear_acceleration = read_vec3(reader)?;
        Ok(Self { header, orientation, has_orientation, angular_velocity, linear_acceleration })
    }

    fn write(&self, writer: &mut Writer<'_>) {
        let mut orientation_covariance = [0.0; 9];
        if !self.has_orientation {
            orientation_covariance[0] = -1.0;
        }
        Header::write(self.header.stamp, &self.header.frame_id, writer);
        write_quat(self.orientation, writer);
        writer.f64_array(&orientation_covariance);
        writer.f64_array(&self.angular_velocity.to_array());
        writer.f64_array(&[0.0; 9]);
        writer.f64_array(&self.linear_acceleration.to_array());
        writer.f64_array(&[0.0; 9]);
    }
}

/// `nav_msgs/Odometry`, without covariances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Odometry {
    /// When; `frame_id` is the odometry's origin.
    pub header: Header,
    /// Frame whose pose it is.
    pub child_frame_id: String,
    /// Child in the origin.
    pub pose: Pose,
    /// Velocity of the child in its own coordinates.
    pub twist: Twist,
}

impl RosMessage for Odometry {
    const TYPE: &'static str = "nav_msgs/Odometry";

    fn read(reader: &mut CdrReader<'_>) -> Result<Self, FormatError> {
        let header = Header::read(reader, reader.encoding())?;
        let child_frame_id = reader.string()?;
        let pose = read_pose(reader)?;
        reader.f64_array::<36>()?;
        let twist = Twist { linear: read_vec3(reader)?, angular: read_vec3(reader)? };
        Ok(Self { header, child_frame_id, pose, twist })
    }

    fn write(&self, writer: &mut Writer<'_>) {
        Header::write(self.header.stamp, &self.header.frame_id, writer);
        writer.string(&self.child_frame_id);
        write_pose(&self.pose, writer);
        writer.f64_array(&[0.0; 36]);
        writer.f64_array(&self.twist.linear.to_array());
        writer.f64_array(&self.twist.angular.to_array());
        writer.f64_array(&[0.0; 36]);
    }
}

/// `geometry_msgs/PoseStamped`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseStamped {
    /// When; `frame_id` is the parent.
    pub header: Header,
    /// Pose in the parent.
    pub pose: Pose,
}

impl RosMessage for PoseStamped {
    const TYPE: &'static str = "geometry_msgs/PoseStamped";

    fn read(reader: &mut CdrReader<'_>) -> Result<Self, FormatError> {
        Ok(Self { header: Header::read(reader, reader.encoding())?, pose: read_pose(reader)? })
    }

    fn write(&self, writer: &mut Writer<'_>) {
        Header::write(self.header.stamp, &self.header.frame_id, writer);
        write_pose(&self.pose, writer);
    }
}

/// `geometry_msgs/TransformStamped`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransformStamped {
    /// When; `frame_id` is the parent.
    pub header: Header,
    /// The child frame.
    pub child_frame_id: String,
    /// Child in the parent.
    pub parent_from_child: Pose,
}

/// `tf2_msgs/TFMessage`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TfMessage {
    /// All transforms in the message.
    pub transforms: Vec<TransformStamped>,
}

impl RosMessage for TfMessage {
    const TYPE: &'static str = "tf2_msgs/TFMessage";

    fn read(reader: &mut CdrReader<'_>) -> Result<Self, FormatError> {
        let transforms = reader.sequence(64, |reader| {
            let header = Header::read(reader, reader.encoding())?;
            let child_frame_id = reader.string()?;
            Ok(TransformStamped { header, child_frame_id, parent_from_child: read_pose(reader)? })
        })?;
        Ok(Self { transforms })
    }

    fn write(&self, writer: &mut Writer<'_>) {
        writer.u32(self.transforms.len() as u32);
        for transform in &self.transforms {
            Header::write(transform.header.stamp, &transform.header.frame_id, writer);
            writer.string(&transform.child_frame_id);
            write_pose(&transform.parent_from_child, writer);
        }
    }
}

/// `sensor_msgs/BatteryState`, the fields that the platform uses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BatteryState {
    /// When.
    pub header: Header,
    /// V.
    pub voltage: f32,
    /// A, negative while discharging.
    pub current: f32,
    /// Charge, 0 to 1.
    pub percentage: f32,
    /// 0 unknown, 1 charging, 2 discharging, 3 not charging, 4 full.
    pub power_supply_status: u8,
}

impl RosMessage for BatteryState {
    const TYPE: &'static str = "sensor_msgs/BatteryState";

    fn read(reader: &mut CdrReader<'_>) -> Result<Self, FormatError> {
        let header = Header::read(reader, reader.encoding())?;
        let [voltage, _temperature, current] = [reader.f32()?, reader.f32()?, reader.f32()?];
        let _charge_capacity_design_capacity = [reader.f32()?, reader.f32()?, reader.f32()?];
        let percentage = reader.f32()?;
        let power_supply_status = reader.u8()?;
        Ok(Self { header, voltage, current, percentage, power_supply_status })
    }

    fn write(&self, writer: &mut Writer<'_>) {
        const UNMEASURED: f32 = f32::NAN;
        Header::write(self.header.stamp, &self.header.frame_id, writer);
        for value in
            [self.voltage, UNMEASURED, self.current, UNMEASURED, UNMEASURED, UNMEASURED, self.percentage]
        {
            writer.f32(value);
        }
        // Status, health and technology (unknown), present.
        for value in [self.power_supply_status, 0, 0, 1] {
            writer.u8(value);
        }
        // Cell voltages and temperatures.
        writer.u32(0);
        writer.u32(0);
        writer.string("");
        writer.string("");
    }
}
