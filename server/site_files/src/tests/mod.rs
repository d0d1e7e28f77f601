//! Sites that are written and read again, and mistakes in files.

mod examples;
mod mistakes;
mod twins;
