//! The `autoinspect` program.

use std::path::PathBuf;

/// The program under test: `AUTOINSPECT_BIN`, else for a benchmark the program in its folder, and for a test the newest build in its target folder.
pub fn autoinspect() -> PathBuf {
    if let Some(named) = std::env::var_os("AUTOINSPECT_BIN") {
        return named.into();
    }
    // A benchmark is at target/PROFILE/NAME, and uses the program in the same folder.
    let here = std::env::current_exe().unwrap();
    let beside = here.with_file_name("autoinspect");
    if beside.exists() {
        return beside;
    }
    // A test is at target/PROFILE/deps/all-HASH.
    let target = here.ancestors().find(|folder| folder.join("CACHEDIR.TAG").exists()).unwrap();
    ["release", "debug"]
        .map(|profile| target.join(profile).join("autoinspect"))
        .into_iter()
        .filter_map(|path| Some((path.metadata().ok()?.modified().ok()?, path)))
        .max()
        .map(|(_, path)| path)
        .unwrap_or_else(|| {
            panic!("no autoinspect below {}; `cargo build -p autoinspect` first", target.display())
        })
}
