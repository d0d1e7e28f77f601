//! What the operator changes of the site.

use site_model::{Object, ObjectId};

/// Objects that the operator changes together. It is one step of undo.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiteEdit {
    /// Objects as they are from now on, new or not.
    pub put: Vec<Object>,
    /// Objects that are removed, with all that cannot be without them.
    pub removed: Vec<ObjectId>,
}
