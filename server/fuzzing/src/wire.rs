//! Messages between core, gateway and clients.

use crate::assert_sentence;
use api::{ClientMessage, CoreMessage, DecodeError, GatewayMessage, ScanFrame, ServerMessage, StreamRequest};
use client_model::{ClientEvent, ClientTime, Ids, Model, Socket, ViewSettings};
use links::{RobotMessage, RobotRequest};
use serde::Serialize;
use serde::de::DeserializeOwned;
use uuid::Uuid;

/// Messages on the control socket, of both sides. The first byte chooses the side.
pub fn client_socket(bytes: &[u8]) {
    let Some((choice, message)) = bytes.split_first() else { return };
    match choice & 1 {
        0 => check::<ClientMessage>(message),
        _ => check::<ServerMessage>(message),
    }
}

/// Messages on the stream socket, of both sides. The first byte chooses the side.
pub fn scan_socket(bytes: &[u8]) {
    let Some((choice, message)) = bytes.split_first() else { return };
    match choice & 1 {
        0 => check::<StreamRequest>(message),
        _ => {
            check::<ScanFrame>(message);
            if let Ok(frame) = api::decode::<ScanFrame>(message) {
                point_chunk(&frame.points);
            }
        }
    }
}

/// Frames between core and gateway, of both sides. The first byte chooses the side.
pub fn core_link(bytes: &[u8]) {
    let Some((choice, frames)) = bytes.split_first() else { return };
    match choice & 1 {
        0 => read_frames::<GatewayMessage>(frames, api::MAX_MESSAGE_BYTES),
        _ => check::<CoreMessage>(frames),
    }
    check::<GatewayMessage>(frames);
}

/// Frames between robot and core, of both sides, and single messages. The first byte chooses.
pub fn robot_link(bytes: &[u8]) {
    let Some((choice, frames)) = bytes.split_first() else { return };
    match choice & 3 {
        0 => read_frames::<RobotRequest>(frames, links::MAX_REQUEST_BYTES),
        1 => read_frames::<RobotMessage>(frames, links::MAX_ROBOT_MESSAGE_BYTES),
        2 => check::<RobotRequest>(frames),
        _ => check::<RobotMessage>(frames),
    }
}

fn read_frames<M: DeserializeOwned>(mut frames: &[u8], max_bytes: usize) {
    loop {
        match ports::read_frame::<M>(&mut frames, max_bytes) {
            Ok(Some(_)) => {}
            Ok(None) => return,
            Err(error) => return assert_sentence(&error),
        }
    }
}

/// Time between two messages to the client, seconds.
const STEP_S: f64 = 0.3;

/// A sequence of a server's messages to a client's state, each after its length, two bytes.
pub fn client_model(bytes: &[u8]) {
    let mut effects = Vec::new();
    let mut now = ClientTime(0.0);
    let mut model = Model::new(api::LeaseToken(Uuid::nil()), Ids::new(1), ViewSettings::default(), now);
    model.connect(&mut effects);
    for socket in [Socket::Control, Socket::Stream] {
        model.handle_event(now, ClientEvent::SocketOpened(socket), &mut effects);
    }
    let mut rest = bytes;
    while let Some((length, after)) = rest.split_first_chunk::<2>() {
        let (message, after) = after.split_at(usize::from(u16::from_le_bytes(*length)).min(after.len()));
        rest = after;
        now = now.after(STEP_S);
        let event = match api::decode::<ServerMessage>(message) {
            Ok(decoded) => ClientEvent::Server { message: decoded, bytes: message.len() },
            Err(_) => ClientEvent::Tick,
        };
        model.handle_event(now, event, &mut effects);
        effects.clear();
    }
}

/// Points of scans and tiles: `map_codec`.
pub fn point_chunk(bytes: &[u8]) {
    match map_codec::decode(bytes) {
        Ok(chunk) => {
            assert!(chunk.points.len() * 7 <= bytes.len() * map_codec::MAX_EXPANSION);
            let bounds = chunk.bounds();
            assert!(chunk.points.is_empty() || bounds.min.iter().chain(&bounds.max).all(|c| c.is_finite()));
            let again =
                map_codec::decode(&map_codec::encode(&chunk)).expect("what was encoded can be decoded");
            assert_eq!(again.points.len(), chunk.points.len());
        }
        Err(error) => assert_sentence(&error),
    }
}

/// What is decoded and encoded again decodes as the same.
fn check<M: Serialize + DeserializeOwned>(bytes: &[u8]) {
    let decoded: Result<M, DecodeError> = api::decode(bytes);
    match decoded {
        Ok(message) => {
            let encoded = api::encode(&message);
            let again: M = api::decode(&encoded).expect("what was encoded can be decoded");
            assert_eq!(api::encode(&again), encoded);
        }
        Err(error) => assert_sentence(&error),
    }
}
