//! Definitions of the message types that the platform writes, in the `ros2msg` form that MCAP files carry.

const HEADER: &str = "builtin_interfaces/Time stamp\nstring frame_id\n";
const TIME: &str = "int32 sec\nuint32 nanosec\n";
const VECTOR3: &str = "float64 x\nfloat64 y\nfloat64 z\n";
const QUATERNION: &str = "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n";
const POSE: &str = "Point position\nQuaternion orientation\n";

const WITH_HEADER: [(&str, &str); 2] = [("std_msgs/Header", HEADER), ("builtin_interfaces/Time", TIME)];

/// The complete definition of a type (e.g. `sensor_msgs/Imu`): its own fields, then those of every type it uses,
/// or `None` for a type that the platform does not write.
pub fn definition(type_name: &str) -> Option<String> {
    let (own, used): (&str, &[(&str, &str)]) = match type_name {
        "sensor_msgs/PointCloud2" => (
            "std_msgs/Header header\nuint32 height\nuint32 width\nPointField[] fields\nbool is_bigendian\n\
             uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
            &[(
                "sensor_msgs/PointField",
                "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\n\
                 uint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n",
            )],
        ),
        "sensor_msgs/Imu" => (
            "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n\
             float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n\
             float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n\
             float64[9] linear_acceleration_covariance\n",
            &[("geometry_msgs/Quaternion", QUATERNION), ("geometry_msgs/Vector3", VECTOR3)],
        ),
        "nav_msgs/Odometry" => (
            "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
             geometry_msgs/TwistWithCovariance twist\n",
            &[
                ("geometry_msgs/PoseWithCovariance", "Pose pose\nfloat64[36] covariance\n"),
                ("geometry_msgs/TwistWithCovariance", "Twist twist\nfloat64[36] covariance\n"),
                ("geometry_msgs/Pose", POSE),
                ("geometry_msgs/Point", VECTOR3),
                ("geometry_msgs/Quaternion", QUATERNION),
                ("geometry_msgs/Twist", "Vector3 linear\nVector3 angular\n"),
                ("geometry_msgs/Vector3", VECTOR3),
            ],
        ),
        "geometry_msgs/PoseStamped" => (
            "std_msgs/Header header\nPose pose\n",
            &[
                ("geometry_msgs/Pose", POSE),
                ("geometry_msgs/Point", VECTOR3),
                ("geometry_msgs/Quaternion", QUATERNION),
            ],
        ),
        "tf2_msgs/TFMessage" => (
            "geometry_msgs/TransformStamped[] transforms\n",
            &[
                (
                    "geometry_msgs/TransformStamped",
                    "std_msgs/Header header\nstring child_frame_id\nTransform transform\n",
                ),
                ("geometry_msgs/Transform", "Vector3 translation\nQuaternion rotation\n"),
                ("geometry_msgs/Vector3", VECTOR3),
                ("geometry_msgs/Quaternion", QUATERNION),
            ],
        ),
        "sensor_msgs/BatteryState" => (
            "std_msgs/Header header\nfloat32 voltage\nfloat32 temperature\nfloat32 current\nfloat32 charge\n\
             float32 capacity\nfloat32 design_capacity\nfloat32 percentage\nuint8 power_supply_status\n\
             uint8 power_supply_health\nuint8 power_supply_technology\nbool present\n\
             float32[] cell_voltage\nfloat32[] cell_temperature\nstring location\nstring serial_number\n",
            &[],
        ),
        _ => return None,
    };
    let rule = "=".repeat(80);
    let sections =
        used.iter().chain(&WITH_HEADER).map(|(name, fields)| format!("{rule}\nMSG: {name}\n{fields}"));
    Some(own.to_owned() + &sections.collect::<String>())
}
