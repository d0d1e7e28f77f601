//! What a supervised process tells its supervisor: a line on standard output each.

use std::fmt;
use std::net::SocketAddr;

/// One line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ChildReport {
    /// The process listens on this address.
    Address(SocketAddr),
    /// The process works. Twice a second.
    Alive,
    /// The process ends, because of this: a clause after its name.
    Failed(String),
}

const ALIVE: &str = "alive";
const FAILED: &str = "failed: ";

impl ChildReport {
    /// None for other lines.
    pub fn from_line(line: &str) -> Option<Self> {
        match line.strip_prefix(FAILED) {
            Some(cause) => Some(Self::Failed(cause.to_owned())),
            None if line == ALIVE => Some(Self::Alive),
            None => line.trim().parse().ok().map(Self::Address),
        }
    }
}

impl fmt::Display for ChildReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Address(address) => write!(f, "{address}"),
            Self::Alive => f.write_str(ALIVE),
            // The message of a panic may have several lines.
            Self::Failed(cause) => write!(f, "{FAILED}{}", cause.replace('\n', " ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_are_read_as_they_were_written() {
        let failed = ChildReport::Failed("panicked:\nat once".to_owned());
        let address = ChildReport::Address("127.0.0.1:80".parse().expect("an address"));
        for report in [address, ChildReport::Alive] {
            assert_eq!(ChildReport::from_line(&report.to_string()), Some(report));
        }
        let read = ChildReport::from_line(&failed.to_string());
        assert_eq!(read, Some(ChildReport::Failed("panicked: at once".to_owned())));
        assert_eq!(ChildReport::from_line("nonsense"), None);
    }
}
