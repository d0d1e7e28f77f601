//! One type for each kind of id, so that a map's id cannot be passed for a keyframe's.

use serde::{Deserialize, Serialize};

/// Declares a type of ids that are UUIDs. The crate that uses it needs `serde` and `uuid`.
#[macro_export]
macro_rules! uuid_id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(
            Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize,
        )]
        pub struct $name(pub uuid::Uuid);

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.0.fmt(f)
            }
        }

        impl std::str::FromStr for $name {
            type Err = uuid::Error;
            fn from_str(text: &str) -> Result<Self, Self::Err> {
                text.parse().map(Self)
            }
        }
    };
}

/// Longest name of a map, characters; longer names are cut. Chosen: lists show fewer.
pub const MAX_MAP_NAME_CHARS: usize = 120;

uuid_id! {
    /// A saved map version. Immutable once written.
    MapId
}
uuid_id! {
    /// One mapping session, from start to save or discard.
    SessionId
}
uuid_id! {
    /// One browser tab or program connected to the gateway.
    ClientId
}
uuid_id! {
    /// A file on its way to the server, named by the client that sends it.
    UploadId
}
uuid_id! {
    /// A command, named by the client, so that a command sent twice is executed once.
    CommandId
}
uuid_id! {
    /// A goal of the robot, named by the requesting client, so that a request sent twice starts it once.
    GoalId
}
uuid_id! {
    /// A part of the route to a goal on the topological map, which the robot walks in one go; or a turn of its body for an action.
    LegId
}
uuid_id! {
    /// One call of an action, named by the stack.
    ActionCallId
}

/// A keyframe of one map or mapping session, numbered from zero in the order of creation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct KeyframeId(pub u32);
