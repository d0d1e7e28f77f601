//! The bytes of all messages between core, gateway and clients. If this test fails, the layout has changed: raise `api::VERSION`, and write the new
//! bytes with `UPDATE_EXPECT=1`. They go to a file with the new version in its name; delete that of the old one.

#![allow(clippy::unwrap_used, reason = "a test may panic at the first error")]

mod samples;

use api::{
    ClientMessage, Command, CoreMessage, DecodeError, Event, GatewayMessage, ScanFrame, ServerMessage,
};
use api::{StreamRequest, decode, encode};
use expect_test::expect_file;
use serde::{Serialize, de::DeserializeOwned};
use std::fmt::{Debug, Write};

/// One line for each message: the type and its bytes. Fails if a variant of the type has no sample.
fn lines<T: Serialize + DeserializeOwned + PartialEq + Debug>(name: &str, samples: &[T], text: &mut String) {
    let mut variants = Vec::new();
    for sample in samples {
        let bytes = encode(sample);
        assert_eq!(decode::<T>(&bytes).as_ref(), Ok(sample));
        variants.push(bytes[0]);
        let _ = write!(text, "{name} ");
        for byte in bytes {
            let _ = write!(text, "{byte:02x}");
        }
        text.push('\n');
    }
    let is_unknown = |variant: u8| {
        matches!(decode::<T>(&[variant]), Err(DecodeError::Malformed(postcard::Error::SerdeDeCustom)))
    };
    let missing: Vec<u8> =
        (0..=u8::MAX).take_while(|v| !is_unknown(*v)).filter(|v| !variants.contains(v)).collect();
    assert!(missing.is_empty(), "no sample of {name} has the variants {missing:?}; add them to `samples`");
}

#[test]
fn the_bytes_of_messages_are_unchanged() {
    let mut text = String::new();
    lines::<Command>("Command", &samples::commands(), &mut text);
    lines::<Event>("Event", &samples::events(), &mut text);
    lines::<ClientMessage>("ClientMessage", &samples::client_messages(), &mut text);
    lines::<ServerMessage>("ServerMessage", &samples::server_messages(), &mut text);
    lines::<StreamRequest>("StreamRequest", &samples::stream_requests(), &mut text);
    lines::<CoreMessage>("CoreMessage", &samples::core_messages(), &mut text);
    lines::<GatewayMessage>("GatewayMessage", &samples::gateway_messages(), &mut text);
    // A structure: its first byte is no variant.
    text.push_str("ScanFrame ");
    for byte in encode(&samples::scan_frame()) {
        let _ = write!(text, "{byte:02x}");
    }
    assert_eq!(decode::<ScanFrame>(&encode(&samples::scan_frame())), Ok(samples::scan_frame()));
    text.push('\n');
    expect_file![format!("layouts/wire_v{}.txt", api::VERSION)].assert_eq(&text);
}
