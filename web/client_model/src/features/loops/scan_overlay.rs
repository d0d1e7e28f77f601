//! The choice between the poses at which the scans of a loop are drawn.

/// At which poses the scans of a selected loop are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ScanOverlay {
    /// At the pose that the registration found.
    #[default]
    Registered,
    /// At their poses in the graph.
    Graph,
    /// Not at all: the map is drawn.
    Off,
}
