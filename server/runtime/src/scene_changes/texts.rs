//! Sentences about changes between visits.

use std::fmt::Display;

/// Objects that were found for the first time, and known ones that were found again.
pub fn changes_found(new: usize, known: usize, is_against_map: bool) -> String {
    let with = earlier_visit(is_against_map);
    let things = |count: usize| if count == 1 { "1 thing".to_owned() } else { format!("{count} things") };
    match (new, known) {
        (new, 0) => format!("Compared with {with}, {} changed. Look at Changes on Runs.", things(new)),
        (0, known) => format!("Compared with {with}, nothing new changed; {} known before.", things(known)),
        (new, known) => {
            format!(
                "Compared with {with}, {} changed, and {known} known before. Look at Changes on Runs.",
                things(new)
            )
        }
    }
}

/// No object was found.
pub fn nothing_changed(is_against_map: bool) -> String {
    format!("Compared with {}, nothing has changed.", earlier_visit(is_against_map))
}

fn earlier_visit(is_against_map: bool) -> &'static str {
    if is_against_map { "the map" } else { "earlier runs" }
}

/// More objects than are kept.
pub fn too_many_changes(found: usize, kept: usize) -> String {
    format!(
        "The comparison of the run found {found} changes, of which the {kept} largest are kept. Check whether the robot was localised well on the run."
    )
}

/// No comparison was made, for `reason`, a sentence.
pub fn not_compared(reason: &dyn Display) -> String {
    format!("The run was not compared with earlier ones. {reason}")
}

/// The files of a comparison were not kept, for `reason`, a clause.
pub fn clouds_not_kept(reason: &dyn Display) -> String {
    format!("The clouds of the changes were not kept: {reason}.")
}

/// The site did not take the changes, for `reason`, a clause or a sentence.
pub fn site_refused(reason: &str) -> String {
    format!("The site does not take the changes: {}.", reason.trim_end_matches('.'))
}

/// The comparison is made after the next start.
pub const CORE_ENDS: &str = "The platform was ending.";
