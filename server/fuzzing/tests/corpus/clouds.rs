//! Seeds of point clouds, surveys, graphs and trajectories.

use ::e57::{E57Writer, Record, RecordDataType, RecordName, RecordValue};
use formats::e57::E57File;
use formats::g2o::{G2oEdge, G2oGraph, G2oVertex, Information, PlanarPose};
use formats::{g2o, las, pcd, ply, tum};
use std::fs::{self, OpenOptions};
use std::io::Cursor;
use vocab::{Pose, Quat, Stamp, Vec3};

/// Target, name and bytes.
pub type Seed = (&'static str, &'static str, Vec<u8>);

fn points(count: usize) -> (Vec<[f32; 3]>, Vec<f32>) {
    let xyz = (0..count).map(|i| [i as f32 * 0.25, -(i as f32) * 0.5, (i % 7) as f32]);
    (xyz.collect(), (0..count).map(|i| (i % 256) as f32).collect())
}

fn pose() -> Pose {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let orientation = Quat { w: half, x: 0.0, y: 0.0, z: half };
    Pose { position: Vec3::new(5.0, 6.0, 7.0), orientation }
}

pub fn seeds() -> Vec<Seed> {
    [pcd_seeds(), ply_seeds(), las_seeds(), e57_seeds(), text_seeds()].concat()
}

/// LZF of literal runs alone.
fn lzf(bytes: &[u8]) -> Vec<u8> {
    bytes.chunks(32).flat_map(|run| [&[run.len() as u8 - 1], run].concat()).collect()
}

fn pcd_seeds() -> Vec<Seed> {
    let (xyz, intensity) = points(3);
    let mut written = Vec::new();
    pcd::write(&mut written, [0.1, 0.2, 0.3], &xyz, &intensity).unwrap();
    let header = |data: &str| {
        format!(
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity t ring\nSIZE 4 4 8 2 4 2\nTYPE F F F U U U\nCOUNT 1 1 1 1 1 1\n\
             WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA {data}\n"
        )
    };
    let ascii = header("ascii") + "1 2 3 7 1000 0\n-1.5 nan 0.25 9 2000 31\n";
    let columns: Vec<u8> = (0..48).collect();
    let packed = lzf(&columns);
    let sizes = [packed.len() as u32, columns.len() as u32].map(u32::to_le_bytes).concat();
    let compressed = [header("binary_compressed").into_bytes(), sizes, packed].concat();
    let binary = [header("binary").into_bytes(), columns].concat();
    vec![
        ("pcd", "written", written),
        ("pcd", "ascii", ascii.into_bytes()),
        ("pcd", "binary", binary),
        ("pcd", "compressed", compressed),
    ]
}

fn ply_seeds() -> Vec<Seed> {
    let (xyz, intensity) = points(3);
    let mut written = Vec::new();
    ply::write(&mut written, &xyz, &intensity).unwrap();
    let header = "comment c\nelement other 1\nproperty uchar a\nelement vertex 2\nproperty double x\nproperty float y\n\
                  property float z\nproperty ushort ring\nproperty double timestamp\nelement face 0\n\
                  property list uchar int vertex_indices\nend_header\n";
    let ascii =
        format!("ply\nformat ascii 1.0\n{header}7\n1 2 3 4 1700000000.5\n-1.5 0.25 9 31 1700000000.6\n");
    let binary = [format!("ply\nformat binary_big_endian 1.0\n{header}").as_bytes(), &[1; 60]].concat();
    let kitti: Vec<u8> =
        [1.0f32, 2.0, 3.0, 0.5, 0.0, 0.0, 0.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    vec![
        ("ply", "written", written),
        ("ply", "ascii", ascii.into_bytes()),
        ("ply", "big_endian", binary),
        ("kitti", "two_points", kitti),
    ]
}

fn las_seeds() -> Vec<Seed> {
    let folder = tempfile::tempdir().unwrap();
    let write = |count, compressed| {
        let path = folder.path().join("points");
        let (xyz, intensity) = points(count);
        las::write(fs::File::create(&path).unwrap(), &xyz, &intensity, compressed).unwrap();
        fs::read(path).unwrap()
    };
    vec![
        ("las", "points", write(5, false)),
        ("las", "no_points", write(0, false)),
        ("laz", "points", write(40, true)),
        ("laz", "no_points", write(0, true)),
        ("laz", "layers", layered_laz()),
    ]
}

/// Points of format 7, which are compressed in layers.
fn layered_laz() -> Vec<u8> {
    let mut builder = ::las::Builder::from((1, 4));
    builder.point_format = ::las::point::Format::new(7).unwrap();
    builder.point_format.is_compressed = true;
    let header = builder.into_header().unwrap();
    let mut writer = ::las::Writer::new(Cursor::new(Vec::new()), header).unwrap();
    for number in 0..20_u16 {
        let x = f64::from(number);
        let color = Some(::las::Color::new(number, 0, 9));
        writer.write_point(::las::Point { x, gps_time: Some(x), color, ..::las::Point::default() }).unwrap();
    }
    writer.into_inner().unwrap().into_inner()
}

fn e57_seeds() -> Vec<Seed> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scans.e57");
    let file = || OpenOptions::new().read(true).write(true).create(true).truncate(true).open(&path).unwrap();
    let (xyz, intensity) = points(5);
    let mut scans = E57File::new(file(), 7).unwrap();
    scans.add("keyframe 0", &Pose::IDENTITY, &xyz, &intensity).unwrap();
    scans.add("keyframe 1", &pose(), &xyz[..2], &[]).unwrap();
    scans.finish().unwrap();
    let floats = fs::read(&path).unwrap();

    let scaled = RecordDataType::ScaledInteger { min: -1000, max: 1000, scale: 0.001, offset: 0.5 };
    let column = |name| Record { name, data_type: scaled.clone() };
    let invalid = RecordDataType::Integer { min: 0, max: 2 };
    let prototype = vec![
        column(RecordName::SphericalRange),
        column(RecordName::SphericalAzimuth),
        column(RecordName::SphericalElevation),
        Record { name: RecordName::SphericalInvalidState, data_type: invalid },
    ];
    let mut writer = E57Writer::new(file(), "{guid}").unwrap();
    let mut scan = writer.add_pointcloud("{scan}", prototype).unwrap();
    for value in [0, 1, 500] {
        let scaled = RecordValue::ScaledInteger(value);
        scan.add_point(vec![scaled.clone(), scaled.clone(), scaled, RecordValue::Integer(value.min(1))])
            .unwrap();
    }
    scan.finalize().unwrap();
    writer.finalize().unwrap();
    vec![("e57", "floats", floats), ("e57", "spherical_integers", fs::read(path).unwrap())]
}

fn text_seeds() -> Vec<Seed> {
    let ptx = "2\n1\n5 6 7\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n5 6 7 1\n1 2 3 0.5\n0 0 0 0.5 1 2 3\n";
    let mut information = [[0.0; 6]; 6];
    (0..6).for_each(|i| information[i][i] = 2.5);
    let planar = PlanarPose { x: 1.0, y: 2.0, yaw: 0.5 };
    let graph = G2oGraph {
        vertices: vec![G2oVertex { id: 0, pose: Pose::IDENTITY }, G2oVertex { id: 1, pose: pose() }],
        edges: vec![G2oEdge { from: 0, to: 1, from_from_to: pose(), information }],
        planar_vertices: vec![G2oVertex { id: 2, pose: planar }],
        planar_edges: vec![G2oEdge { from: 2, to: 2, from_from_to: planar, information: [[1.0; 3]; 3] }],
        fixed: vec![0],
    };
    let mut text = Vec::new();
    g2o::write_as(&mut text, &graph, Information::RotationVector).unwrap();
    let mut trajectory = b"# time x y z qx qy qz qw\n".to_vec();
    tum::write(&mut trajectory, &[(Stamp::from_nanos(1_700_000_000_123_456_789), pose())]).unwrap();
    vec![
        ("ptx", "one_scan", ptx.as_bytes().to_vec()),
        ("ptx", "two_scans", [ptx, "\n", ptx].concat().into_bytes()),
        ("g2o", "both_spaces", text),
        ("tum", "one_pose", trajectory),
    ]
}
