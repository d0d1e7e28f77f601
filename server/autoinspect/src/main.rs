//! The `autoinspect` program.
fn main() {}
