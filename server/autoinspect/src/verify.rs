//! `autoinspect verify`: whether the ledger of a data directory is whole, and its audit log unchanged.

use crate::failure::Failure;
use crate::output::{print_human, print_json};
use crate::{texts, up};
use clap::Args;
use ports::DataDir;
use serde_json::json;
use std::path::PathBuf;

/// Check the ledger: every row against its checksum, and the chain of the audit log.
#[derive(Args, Debug)]
#[command(after_help = "EXAMPLE:
  autoinspect verify /var/lib/autoinspect")]
pub struct VerifyArgs {
    /// Data directory [default: the user's data directory].
    data: Option<PathBuf>,
    /// Print one JSON object as the last line.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &VerifyArgs) -> Result<(), Failure> {
    let data = args.data.clone().unwrap_or_else(up::default_data_dir);
    let path = DataDir::new(&data).ledger();
    if !path.exists() {
        return Err(Failure::usage(texts::no_ledger(&path)));
    }
    let audit = store::verify_ledger(&path).map_err(Failure::failed)?;
    let checksum =
        audit.checksum.map(|hash| hash.iter().map(|byte| format!("{byte:02x}")).collect::<String>());
    let (first, last) = (audit.first, audit.last);
    print_human(args.json, &texts::ledger_is_whole(first, last, checksum.as_deref().unwrap_or("none")));
    let entries = if last == 0 { 0 } else { last + 1 - first };
    print_json(
        args.json,
        &json!({ "audit_entries": entries, "first_entry": first, "last_entry": last, "last_checksum": checksum }),
    )
}
