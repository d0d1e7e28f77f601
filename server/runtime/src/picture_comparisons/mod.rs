//! Each photo of an inspection point is compared with the one before it at that point, after its result was stored. What has changed is kept in the ledger beside the result, and told to
//! people. Clients may ask for other pairs.
//!
//! | file | what it does |
//! | --- | --- |
//! | `worker.rs` | the thread: one comparison at a time, in another process ([`ports::PictureComparer`]) |
//! | `photo.rs` | the photo of a result |

mod photo;
mod texts;
mod worker;

pub use worker::PictureWorker;
