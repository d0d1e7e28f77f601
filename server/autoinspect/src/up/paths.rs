//! Default locations of the data and the browser client.

use crate::failure::Failure;
use crate::texts;
use std::env;
use std::path::{Path, PathBuf};

/// The user's data directory (XDG Base Directory Specification), or a folder in the current directory if the user has none.
pub fn default_data_dir() -> PathBuf {
    let absolute = |name: &str| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    absolute("XDG_DATA_HOME")
        .or_else(|| absolute("HOME").map(|home| home.join(".local/share")))
        .map_or_else(|| PathBuf::from("autoinspect-data"), |data| data.join("autoinspect"))
}

/// The folder of the browser client: the given one, or else `static` beside the program, in one of the folders above it (the source tree of a
/// program that was just built), or in the current directory.
pub fn static_dir(given: Option<&Path>) -> Result<PathBuf, Failure> {
    let is_client = |path: &PathBuf| path.join("index.html").is_file();
    if let Some(given) = given {
        let given = given.to_owned();
        let missing = || Failure::usage(texts::no_client_in(&given));
        return given.canonicalize().ok().filter(is_client).ok_or_else(missing);
    }
    let program = env::current_exe().ok();
    let beside = program.iter().flat_map(|program| program.ancestors().skip(1).take(4));
    let installed =
        program.iter().filter_map(|program| Some(program.parent()?.parent()?.join("share/autoinspect")));
    let here = env::current_dir().ok();
    let candidates =
        installed.chain(beside.map(Path::to_owned)).chain(here).map(|folder| folder.join("static"));
    candidates.into_iter().find(is_client).ok_or_else(|| Failure::usage(texts::NO_CLIENT))
}
