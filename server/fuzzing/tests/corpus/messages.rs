//! Seeds of messages between robot, core, gateway and clients: the bytes that `shared/api/tests` and `server/links/tests` keep.

use crate::clouds::Seed;
use std::fs;
use std::path::Path;

/// Bytes of a line of hexadecimal digits.
pub fn bytes_of_hex(digits: &str) -> Vec<u8> {
    (0..digits.len()).step_by(2).map(|at| u8::from_str_radix(&digits[at..at + 2], 16).unwrap()).collect()
}

/// The messages of a type in a file of layouts.
fn messages_of(layouts: &str, kind: &str) -> Vec<Vec<u8>> {
    let lines = layouts.lines().filter_map(|line| line.strip_prefix(kind)?.strip_prefix(' '));
    lines.map(bytes_of_hex).collect()
}

/// A message after its length.
fn framed(message: &Vec<u8>) -> Vec<u8> {
    [&(message.len() as u32).to_le_bytes(), message.as_slice()].concat()
}

/// Each message of robot and core, and all of a side as a stream.
fn robot_seeds() -> Vec<Seed> {
    let name = format!("../links/tests/layouts/robot_v{}.txt", links::PROTOCOL_VERSION);
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap();
    let mut seeds = Vec::new();
    for (stream, single, kind, side) in [(0, 2, "RobotRequest", "core"), (1, 3, "RobotMessage", "robot")] {
        let messages = messages_of(&text, kind);
        let frames: Vec<Vec<u8>> = messages.iter().map(framed).collect();
        seeds.push(("robot_link", &*format!("{side}-all").leak(), [vec![stream], frames.concat()].concat()));
        for (number, message) in messages.iter().enumerate() {
            let name = &*format!("{side}-{number:02}").leak();
            seeds.push(("robot_link", name, [&[single], message.as_slice()].concat()));
        }
    }
    seeds
}

pub fn seeds() -> Vec<Seed> {
    let name = format!("../../shared/api/tests/layouts/wire_v{}.txt", api::VERSION);
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap();
    let of = |kind: &str| messages_of(&text, kind);
    let mut seeds = robot_seeds();
    let mut add = |target, kind: &str, prefix: &[u8], messages: &[Vec<u8>]| {
        for (number, message) in messages.iter().enumerate() {
            let bytes = [prefix, message].concat();
            seeds.push((target, &*format!("{kind}-{number:02}").leak(), bytes));
        }
    };
    // A command of a client and an event of a server, each as the message that holds it: variant, id or number, content.
    let events: Vec<Vec<u8>> = of("Event").iter().map(|event| [&[2, 7], event.as_slice()].concat()).collect();
    let commands = |variant: u8, before: usize| -> Vec<Vec<u8>> {
        let ids = vec![16_u8; 1].into_iter().chain([7; 16]).collect::<Vec<u8>>().repeat(before);
        of("Command").iter().map(|command| [&[variant], ids.as_slice(), command].concat()).collect()
    };
    add("client_socket", "client", &[0], &of("ClientMessage"));
    add("client_socket", "command", &[0], &commands(1, 1));
    add("client_socket", "server", &[1], &of("ServerMessage"));
    add("client_socket", "event", &[1], &events);
    add("scan_socket", "client", &[0], &of("StreamRequest"));
    add("scan_socket", "server", &[1], &of("ScanFrame"));
    add("core_link", "core", &[1], &of("CoreMessage"));
    let frames: Vec<Vec<u8>> = of("GatewayMessage").iter().map(framed).collect();
    add("core_link", "gateway", &[0], &frames);
    add("core_link", "all", &[0], &[frames.concat()]);
    let commands: Vec<Vec<u8>> = commands(1, 2).iter().map(framed).collect();
    add("core_link", "command", &[0], &commands);
    let session = |events: &[Vec<u8>]| {
        let welcome = of("ServerMessage").swap_remove(0);
        let messages = std::iter::once(&welcome).chain(events);
        messages.flat_map(|m| [&(m.len() as u16).to_le_bytes(), m.as_slice()].concat()).collect::<Vec<u8>>()
    };
    let sessions: Vec<Vec<u8>> = events.chunks(6).map(session).collect();
    add("client_model", "session", &[], &sessions);
    let xyz: Vec<[f32; 3]> = (0..60_u8).map(|i| [f32::from(i), f32::from(i % 3), 0.5]).collect();
    let chunks =
        [map_codec::encode_scan(&xyz[..2], &[1.0, 2.0], 0.01), map_codec::encode_scan(&xyz, &[], 0.01)];
    add("point_chunk", "scan", &[], &chunks);
    seeds
}
