//! Sites that are written and read again, and mistakes in files.

mod mistakes;
mod twins;
