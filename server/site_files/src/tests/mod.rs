//! Sites that are written and read again, mistakes in files, and files of changes.

mod examples;
mod mistakes;
mod site_changes;
mod twins;
