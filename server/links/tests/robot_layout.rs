//! The bytes of all messages between robot and core. If this test fails, the layout has changed: raise `links::PROTOCOL_VERSION`, and write the new bytes
//! with `UPDATE_EXPECT=1`. They go to a file with the new version in its name; delete that of the old one. The greetings never change.

#![allow(clippy::unwrap_used, reason = "a test may panic at the first error")]

use expect_test::expect_file;
use links::{PROTOCOL_VERSION, RobotCapabilities, RobotIdentity, RobotMessage, RobotRequest};
use messages::{
    BatteryState, BootRecord, Drive, ExternalOdometry, ImuSample, LegOdometry, Mounting, RobotProfile, Scan,
    Sensor,
};
use ports::{ActionCall, ActionEnd, ActionEvent, ActionFile, ActionRegistration, SimulatedFault};
use serde::{Serialize, de::DeserializeOwned};
use std::fmt::{Debug, Write};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{ActionCallId, CommandId, Pose, Span, Stamp, Twist, Vec3};

const NOW: Stamp = Stamp::from_nanos(1_700_000_000_123_456_789);
const COMMAND: CommandId = CommandId(Uuid::from_u128(7));
const CALL: ActionCallId = ActionCallId(Uuid::from_u128(9));
const SECOND: Span = Span::from_millis(1_000);

/// At least one request of every kind.
fn requests() -> Vec<RobotRequest> {
    let velocity = Twist { linear: Vec3::new(0.5, 0.0, 0.0), angular: Vec3::new(0.0, 0.0, -0.25) };
    let faults = [
        SimulatedFault::CoverLidar(SECOND),
        SimulatedFault::SilenceLidar(SECOND),
        SimulatedFault::SilenceImu(SECOND),
        SimulatedFault::SlipFeet(SECOND),
        SimulatedFault::CarryAway,
        SimulatedFault::End,
    ];
    let fault = |fault| RobotRequest::InjectFault { id: COMMAND, fault };
    let call = ActionCall { id: CALL, action: "photo".to_owned(), parameters: "{}".to_owned() };
    let others = [
        RobotRequest::Hello { version: PROTOCOL_VERSION },
        RobotRequest::Drive(Drive { velocity }),
        RobotRequest::StartAction(call),
        RobotRequest::CancelAction(CALL),
    ];
    others.into_iter().chain(faults.map(fault)).collect()
}

/// At least one message of every kind, and every kind of measurement.
fn robot_messages() -> Vec<RobotMessage> {
    let scan = Scan {
        stamp: NOW,
        xyz: vec![[1.0, -2.0, 0.5], [0.25, 0.0, 3.0]],
        intensity: vec![7.0, 255.0],
        offset_ns: vec![0, -50_000],
        ring: vec![0, 31],
    };
    let imu = ImuSample {
        stamp: NOW,
        angular_velocity: Vec3::new(0.125, 0.0, 0.0),
        specific_force: Vec3::new(0.0, 0.0, 9.75),
    };
    let legs = LegOdometry { stamp: NOW, odom_from_base: Pose::IDENTITY, ..LegOdometry::default() };
    let external = ExternalOdometry { stamp: NOW, odom_from_external: Pose::IDENTITY };
    let battery = BatteryState { stamp: NOW, charge: 0.5, voltage_v: 51.5, current_a: -4.0, charging: true };
    let identity = RobotIdentity {
        run: 300,
        now: NOW,
        boot: BootRecord {
            profile: RobotProfile { name: "Rex".to_owned(), ..RobotProfile::default() },
            mounting: Mounting { base_from_lidar: Some(Pose::IDENTITY), ..Mounting::default() },
            ..BootRecord::default()
        },
        site: Some("b1".to_owned()),
        capabilities: RobotCapabilities { simulated_faults: true },
        actions: vec![ActionRegistration {
            name: "photo".to_owned(),
            title: "Photo".to_owned(),
            parameter_schema: "{}".to_owned(),
            expected: SECOND,
            expected_energy_j: 300,
            is_idempotent: true,
        }],
    };
    let sensors = [
        Sensor::Scan(Arc::new(scan)),
        Sensor::Imu(imu),
        Sensor::Legs(legs),
        Sensor::Odometry(external),
        Sensor::Battery(battery),
    ];
    let sensor = |sensor| RobotMessage::Sensor { at: NOW, sensor };
    let file = ActionFile {
        name: "a.jpg".to_owned(),
        media_type: "image/jpeg".to_owned(),
        bytes: vec![0, 255, 128],
    };
    let ended = |end| RobotMessage::Action(ActionEvent::Ended { call: CALL, end });
    let others = [
        RobotMessage::Action(ActionEvent::Feedback {
            call: CALL,
            progress: Some(0.5),
            text: "half".to_owned(),
        }),
        ended(ActionEnd::Succeeded { report: "{}".to_owned(), files: vec![file] }),
        ended(ActionEnd::Failed { reason: "no".to_owned() }),
        ended(ActionEnd::Cancelled),
        RobotMessage::Hello { version: PROTOCOL_VERSION },
        RobotMessage::Identity(Box::new(identity)),
        RobotMessage::Clock(NOW),
        RobotMessage::FaultAnswer { id: COMMAND, refused: None },
        RobotMessage::FaultAnswer { id: COMMAND, refused: Some("no".to_owned()) },
    ];
    others.into_iter().chain(sensors.map(sensor)).collect()
}

/// One line for each message: the type and its bytes. Fails if a variant of the type has no sample.
fn lines<T: Serialize + DeserializeOwned + PartialEq + Debug>(name: &str, samples: &[T], text: &mut String) {
    let mut variants = Vec::new();
    for sample in samples {
        let bytes = postcard::to_stdvec(sample).unwrap();
        assert_eq!(&postcard::from_bytes::<T>(&bytes).unwrap(), sample);
        variants.push(bytes[0]);
        let _ = write!(text, "{name} ");
        for byte in bytes {
            let _ = write!(text, "{byte:02x}");
        }
        text.push('\n');
    }
    let is_unknown =
        |variant: u8| matches!(postcard::from_bytes::<T>(&[variant]), Err(postcard::Error::SerdeDeCustom));
    let missing: Vec<u8> =
        (0..=u8::MAX).take_while(|v| !is_unknown(*v)).filter(|v| !variants.contains(v)).collect();
    assert!(missing.is_empty(), "no sample of {name} has the variants {missing:?}");
}

#[test]
fn the_bytes_of_messages_are_unchanged() {
    let mut text = String::new();
    lines("RobotRequest", &requests(), &mut text);
    lines("RobotMessage", &robot_messages(), &mut text);
    expect_file![format!("layouts/robot_v{PROTOCOL_VERSION}.txt")].assert_eq(&text);
}
