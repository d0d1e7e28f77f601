//! What a draft does with an object.

/// What becomes of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RowKind {
    Added,
    Changed,
    Removed,
}
