//! Whose objects are shown.

/// Whose objects are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ShownChanges {
    /// Those of the earlier visit: what is gone now.
    Before,
    /// Those of the later visit: what is new.
    After,
    /// All.
    #[default]
    Both,
    /// Those of the earlier visit left of a line across the picture, those of the later one right of it. The share of the width that is left of it, 0 to 1.
    Wipe(f32),
}

impl ShownChanges {
    /// Whether those of the earlier and of the later visit are shown.
    pub fn visits(self) -> [bool; 2] {
        [self != Self::After, self != Self::Before]
    }

    /// Where the line of a wipe is.
    pub fn wipe(self) -> Option<f32> {
        match self {
            Self::Wipe(share) => Some(share),
            Self::Before | Self::After | Self::Both => None,
        }
    }
}
