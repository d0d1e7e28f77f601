//! Errors of `autoinspect example`.

/// The folder of the example, in errors.
pub const EXAMPLE_FOLDER: &str = "the folder of the example";

/// The topological map of the example has no nodes.
pub const EXAMPLE_HAS_NO_NODES: &str = "the walk of the example made no nodes; give it more minutes";

/// No plate is seen from a node of the example.
pub const EXAMPLE_SEES_NOTHING: &str =
    "nothing to inspect is seen from the nodes of the example; give its walk more minutes";
