//! Texts of `autoinspect verify`.

use std::path::Path;

/// A data directory without a ledger.
pub fn no_ledger(path: &Path) -> String {
    format!("there is no ledger at {}. Give the data directory of a platform that has run", path.display())
}

/// Every row of the ledger is whole, and its audit log has these entries.
pub fn ledger_is_whole(first: u64, last: u64, checksum: &str) -> String {
    format!(
        "the ledger is whole; its audit log has the entries {first} to {last}, the last with the checksum {checksum}"
    )
}
