//! After each run of a mission, its clouds are compared with those of an earlier run, or with the map. What has changed becomes objects of the site, for people to decide on.
//!
//! | file | what it does |
//! | --- | --- |
//! | `worker.rs` | the thread: one comparison at a time, in another process ([`ports::ChangeFinder`]) |
//! | `baseline.rs` | what a run is compared with |
//! | `physical_objects.rs` | of which thing each change is |
//! | `site_edit.rs` | the edit of the site; a change that is known is updated |

mod baseline;
mod physical_objects;
mod site_edit;
mod texts;
mod worker;

pub use baseline::{Baseline, BaselineConfig, find_baseline, note_comparison};
pub use worker::{SceneChangeQueue, SceneChangeWorker};
