//! Reads the needle of a dial from a picture.
//!
//! What does not change while a camera looks at a gauge is given once: a [`Dial`], with the centre, the ends of the scale and the range in the picture. [`read_gauge`] then
//! finds the needle in a [`Picture`]:
//!
//! 1. `evidence`: how much each pixel differs from the face of the dial, in colour, by being darker, or by being lighter. Nothing is assumed about the colour of the needle;
//! 2. `rays`: along rays from the axis, how far the needle goes without a gap. Digits and ticks are not connected with the axis;
//! 3. `needle`: the longest run is the needle, its direction the middle between its edges towards the tip;
//! 4. `read`: the evidence that shows one needle most clearly gives the value with its uncertainty; [`GaugeReading::Unsure`] says why there is none.
//!
//! A dial that the camera sees from the side is an ellipse: [`read_slanted_gauge`] takes four marks of its scale, and reads the picture as it would look from the front (`slanted`).
//!
//! Everything is a pure function: the same input gives the same bits. The method is in docs/maths/gauges.md.

mod config;
mod dial;
mod evidence;
mod needle;
mod picture;
mod rays;
mod read;
mod slanted;

pub use config::GaugeConfig;
pub use dial::{Dial, DialError};
pub use evidence::EvidenceKind;
pub use picture::{Picture, PictureError};
pub use read::{GaugeReading, UnsureReason, read_gauge};
pub use slanted::{DialMarks, read_slanted_gauge};
