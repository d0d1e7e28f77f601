//! Sentences about pictures that are compared.

/// A photo differs from the one before.
pub fn changed(point: &str, places: usize) -> String {
    let places = if places == 1 { "1 place".to_owned() } else { format!("{places} places") };
    format!("{point}: the photo differs from the one before in {places}. Look at Points on Runs.")
}

/// Name of a point that was deleted.
pub const DELETED_POINT: &str = "An inspection point that was deleted";

/// What was compared could not be written.
pub fn not_kept(reason: &str) -> String {
    format!(
        "What a photo shows otherwise than the one before could not be stored: {reason}. That is tried again with the next result."
    )
}

/// The ledger could not be read.
pub fn not_read(reason: &str) -> String {
    format!("Photos could not be compared: {reason}. That is tried again with the next result.")
}
