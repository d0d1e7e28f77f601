//! The commands that work on files of other programs, within limits.

/// What runs within limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitedCommand {
    Import,
    Align,
    Changes,
    MakeNormal,
    Gauge,
    PictureChanges,
}

impl LimitedCommand {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Import => "import",
            Self::Align => "align",
            Self::Changes => "changes",
            Self::MakeNormal => "make-normal",
            Self::Gauge => "gauge",
            Self::PictureChanges => "picture-changes",
        }
    }
}

/// The limit at which a process has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    Memory,
    Time,
}
