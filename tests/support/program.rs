//! The `autoinspect` program.

use std::path::PathBuf;

/// The program under test: `AUTOINSPECT_BIN`, else the newest of what cargo built beside this test.
pub fn autoinspect() -> PathBuf {
    if let Some(named) = std::env::var_os("AUTOINSPECT_BIN") {
        return named.into();
    }
    // This test is at target/PROFILE/deps/all-HASH.
    let test = std::env::current_exe().unwrap();
    let target = test.ancestors().nth(3).unwrap();
    let built = ["release", "debug"].map(|profile| target.join(profile).join("autoinspect"));
    built
        .into_iter()
        .filter_map(|path| Some((path.metadata().ok()?.modified().ok()?, path)))
        .max()
        .map(|(_, path)| path)
        .unwrap_or_else(|| {
            panic!("no autoinspect below {}; `cargo build -p autoinspect` first", target.display())
        })
}
