//! Sweeps on the grid are restored bit for bit, and damaged bytes are errors.

use crate::*;
use messages::{ImuSample, LegOdometry, Scan, Sensor};
use proptest::prelude::*;
use std::sync::Arc;
use vocab::{Span, Stamp, Twist, Vec3};

/// A sweep of a hall by 32 channels, with noise and some points missing.
fn hall(columns: usize) -> Scan {
    let mut scan = Scan { stamp: Stamp::from_nanos(-5), ..Scan::default() };
    let mut noise = 0x2545_f491_4f6c_dd1d_u64;
    for (column, ring) in (0..columns).flat_map(|column| (0..32).map(move |ring| (column, ring))) {
        let azimuth = -(column as f32 / columns as f32 + ring as f32 * 1.5e-5) * std::f32::consts::TAU;
        let elevation = (15.0 - ring as f32).to_radians();
        let direction = [azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin()];
        let walls = [30.0, 20.0, if direction[2] < 0.0 { 0.6 } else { 7.4 }];
        let hit = direction.iter().zip(walls).map(|(d, w)| w / d.abs().max(1e-6)).fold(f32::MAX, f32::min);
        noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        if noise >> 55 == 0 {
            continue;
        }
        let range = hit + ((noise >> 40) as f32 / (1 << 24) as f32 - 0.5) * 0.035;
        scan.xyz.push(direction.map(|d| d * range));
        scan.intensity.push((40 + (noise >> 61)) as f32);
        scan.offset_ns.push(column as i32 * 50_000 + ring * 1_512);
        scan.ring.push(ring as u16);
    }
    scan
}

/// The columns of a sweep with floating-point numbers as their bits.
type Bits = (Stamp, Vec<[u32; 3]>, Vec<u32>, Vec<i32>, Vec<u16>);

fn bits(scan: &Scan) -> Bits {
    let xyz = scan.xyz.iter().map(|p| p.map(f32::to_bits)).collect();
    let intensity = scan.intensity.iter().map(|value| value.to_bits()).collect();
    (scan.stamp, xyz, intensity, scan.offset_ns.clone(), scan.ring.clone())
}

fn encoded(scan: &Scan) -> Vec<u8> {
    let mut bytes = Vec::new();
    assert!(encode(scan, &mut bytes), "a quantised sweep is on the grid");
    bytes
}

fn quantised(mut scan: Scan) -> Scan {
    quantise(&mut scan);
    scan
}

#[test]
fn a_sweep_takes_about_one_byte_a_point_and_no_point_moves_far() {
    let raw = hall(2000);
    let scan = quantised(raw.clone());
    for (moved, from) in scan.xyz.iter().zip(&raw.xyz) {
        let distance = (0..3).map(|axis| (moved[axis] - from[axis]).powi(2)).sum::<f32>().sqrt();
        let range = from.iter().map(|c| c * c).sum::<f32>().sqrt();
        assert!(distance <= 0.0021 + range * 1.3e-5, "{from:?} -> {moved:?}");
    }
    let bytes = encoded(&scan);
    assert!(bytes.len() < scan.xyz.len() * 12 / 10, "{} bytes of {} points", bytes.len(), scan.xyz.len());
    assert_eq!(bits(&decode(&bytes).expect("decodes")), bits(&scan));
    assert!(!encode(&raw, &mut Vec::new()), "a sweep that is not on the grid is refused");
}

#[test]
fn sweeps_without_channels_times_or_intensities_are_restored() {
    for without in 0..8 {
        let mut scan = hall(20);
        for (bit, column) in [1, 2, 4].into_iter().enumerate() {
            match (without & column != 0, bit) {
                (true, 0) => scan.ring.clear(),
                (true, 1) => scan.offset_ns.clear(),
                (true, 2) => scan.intensity.clear(),
                _ => {}
            }
        }
        let scan = quantised(scan);
        assert_eq!(bits(&decode(&encoded(&scan)).expect("decodes")), bits(&scan), "without {without}");
    }
}

#[test]
fn an_empty_sweep_is_restored_and_columns_of_other_lengths_are_refused() {
    let empty = Scan { stamp: Stamp::from_nanos(7), ..Scan::default() };
    assert_eq!(decode(&encoded(&empty)).expect("decodes"), empty);
    let uneven = Scan { ring: vec![1], ..quantised(hall(3)) };
    assert!(!encode(&uneven, &mut Vec::new()));
    let at_the_origin = quantised(Scan { xyz: vec![[0.0; 3]], ..Scan::default() });
    assert_eq!(at_the_origin.xyz, [[0.0; 3]], "it has no direction and stays");
    assert!(!encode(&at_the_origin, &mut Vec::new()));
}

#[test]
fn every_cut_and_other_versions_are_errors() {
    let bytes = encoded(&quantised(hall(4)));
    for length in 0..bytes.len() {
        assert!(decode(&bytes[..length]).is_err(), "cut at {length}");
    }
    let mut later = bytes.clone();
    later[4] = 2;
    assert_eq!(decode(&later), Err(RangeImageError::Version(2)));
}

/// The bytes of one sweep. If this test fails, the format has changed: raise its version and keep reading this one.
#[test]
fn the_format_is_unchanged() {
    let scan = quantised(Scan {
        stamp: Stamp::from_nanos(1_700_000_000_000_000_001),
        xyz: vec![[1.0, 2.0, 0.5], [1.1, 2.0, 0.25], [-3.0, 2.0, 0.5], [-3.0, 1.9, 0.25]],
        intensity: vec![10.0, 11.0, 10.0, 255.0],
        offset_ns: vec![0, 1_512, 50_000, 51_512],
        ring: vec![0, 1, 0, 1],
    });
    let text: String = encoded(&scan).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(text, FORMAT_V1);
    let bytes: Vec<u8> = (0..FORMAT_V1.len())
        .step_by(2)
        .map(|at| u8::from_str_radix(&FORMAT_V1[at..at + 2], 16).expect("hexadecimal"))
        .collect();
    assert_eq!(bits(&decode(&bytes).expect("decodes")), bits(&scan));
}

const FORMAT_V1: &str = "414952490101030001002a36fe9c971704000000a00f0000010000000400000004000000000000000000000000000000040000000400000000ffff000500000005000000d115a18b060400000004000000ffffffff0a0000000a00000097dd078c21e1ad028b360400000004000000ffffffff0900000009000000f9c201d75fca47e0200100000001000000ff00000000000000000000000000000000030000000300000002ff270400000004000000fb06a303020000000200000016ff00000000000000000000000000000000020000000200000014000200000002000000e901";

#[test]
fn successive_thinned_sweeps_hold_all_columns() {
    let whole = hall(60);
    let mut points = Vec::new();
    for phase in 0..6 {
        let mut scan = whole.clone();
        thin(&mut scan, 6, phase);
        assert!((scan.xyz.len() * 6).abs_diff(whole.xyz.len()) < 200, "{}", scan.xyz.len());
        assert_eq!([scan.intensity.len(), scan.offset_ns.len(), scan.ring.len()], [scan.xyz.len(); 3]);
        points.extend(scan.offset_ns);
    }
    points.sort_unstable();
    let mut all = whole.offset_ns.clone();
    all.sort_unstable();
    assert_eq!(points, all);
}

/// A robot whose sensors speak every 10 ms.
struct Robot {
    preparation: ScanPreparation,
    now: Stamp,
    angular_velocity: f64,
    specific_force: f64,
    leg_speed: f64,
    has_imu: bool,
}

impl Robot {
    fn standing() -> Self {
        let (preparation, now) = (ScanPreparation::default(), Stamp::from_parts(100, 0));
        Self { preparation, now, angular_velocity: 0.01, specific_force: 9.8, leg_speed: 0.0, has_imu: true }
    }

    /// Points of the sweep after some time.
    fn points_after(&mut self, millis: i64) -> usize {
        for _ in 0..millis / 10 {
            self.now += Span::from_millis(10);
            let imu = ImuSample {
                stamp: self.now,
                angular_velocity: Vec3::new(self.angular_velocity, 0.0, 0.0),
                specific_force: Vec3::new(0.0, 0.0, self.specific_force),
            };
            let base_velocity = Twist { linear: Vec3::new(self.leg_speed, 0.0, 0.0), ..Twist::default() };
            let legs = LegOdometry { stamp: self.now, base_velocity, ..LegOdometry::default() };
            if self.has_imu {
                self.preparation.prepare(self.now, Sensor::Imu(imu));
            }
            self.preparation.prepare(self.now, Sensor::Legs(legs));
        }
        match self.preparation.prepare(self.now, Sensor::Scan(Arc::new(hall(1000)))) {
            Sensor::Scan(scan) => scan.xyz.len(),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_robot_that_stands_is_thinned_and_one_that_may_move_is_not() {
    const FULL: std::ops::RangeInclusive<usize> = 31_000..=32_000;
    let limit = PreparationConfig::default().max_standing_points;
    let mut robot = Robot::standing();
    assert!(FULL.contains(&robot.points_after(1_000)), "it has not stood for long");
    assert!((limit / 2..=limit).contains(&robot.points_after(2_000)));

    type Push = (&'static str, fn(&mut Robot));
    let pushes: [Push; 4] = [
        ("turned", |robot| robot.angular_velocity = 0.1),
        ("lifted", |robot| robot.specific_force = 11.0),
        ("walking", |robot| robot.leg_speed = 0.1),
        ("without IMU", |robot| robot.has_imu = false),
    ];
    for (what, push) in pushes {
        let mut robot = Robot::standing();
        assert!(robot.points_after(3_000) <= limit);
        push(&mut robot);
        assert!(FULL.contains(&robot.points_after(300)), "{what}");
        robot = Robot { preparation: robot.preparation, now: robot.now, ..Robot::standing() };
        assert!(FULL.contains(&robot.points_after(1_000)), "{what}, and not for long");
        assert!(robot.points_after(4_000) <= limit, "{what}, and at rest again");
    }
}

#[test]
fn a_thinned_sweep_is_not_thinned_again() {
    let mut robot = Robot::standing();
    robot.points_after(3_000);
    let mut scan = hall(1000);
    thin(&mut scan, 4, 1);
    let points = scan.xyz.len();
    match robot.preparation.prepare(robot.now, Sensor::Scan(Arc::new(scan))) {
        Sensor::Scan(scan) => assert_eq!(scan.xyz.len(), points),
        other => panic!("{other:?}"),
    }
}

fn any_column<T: std::fmt::Debug + Clone>(
    value: impl Strategy<Value = T> + Clone,
    length: usize,
) -> impl Strategy<Value = Vec<T>> {
    prop_oneof![4 => Just(length), 1 => Just(0)]
        .prop_flat_map(move |size| prop::collection::vec(value.clone(), size))
}

fn any_scan() -> impl Strategy<Value = Scan> {
    let coordinate = prop_oneof![20 => -200f32..200f32, 1 => Just(0.0), 1 => -0.01f32..0.01];
    let xyz = [coordinate.clone(), coordinate.clone(), coordinate];
    let intensity = prop_oneof![8 => (0u16..=65_535).prop_map(f32::from), 1 => any::<f32>()];
    prop::collection::vec(xyz, 0..60).prop_flat_map(move |xyz| {
        let length = xyz.len();
        let columns = (
            any::<i64>(),
            any_column(intensity.clone(), length),
            any_column(any::<i32>(), length),
            any_column(0u16..200, length),
        );
        columns.prop_map(move |(stamp, intensity, offset_ns, ring)| Scan {
            stamp: Stamp::from_nanos(stamp),
            xyz: xyz.clone(),
            intensity,
            offset_ns,
            ring,
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_encoded_is_restored_bit_for_bit(scan in any_scan()) {
        let once = quantised(scan);
        prop_assert_eq!(bits(&quantised(once.clone())), bits(&once));
        let mut bytes = Vec::new();
        if encode(&once, &mut bytes) {
            prop_assert_eq!(bits(&decode(&bytes).expect("decodes")), bits(&once));
        } else {
            prop_assert!(bytes.is_empty());
            // Only points that have no direction, or hardly one, are refused.
            prop_assert!(once.xyz.iter().any(|p| p[0].hypot(p[1]) < 0.01));
        }
    }

    #[test]
    fn damaged_bytes_do_not_panic(at in 0usize..600, to in any::<u8>()) {
        let mut bytes = encoded(&quantised(hall(6)));
        let at = at % bytes.len();
        bytes[at] = to;
        let _ = decode(&bytes);
    }
}
