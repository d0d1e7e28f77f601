//! Fingerprints of source files, to find out whether the bundle is up to date.
//!
//! Cargo checks this for its own outputs, but the bundle has further steps. A fingerprint of the content of every source file takes a few
//! milliseconds. Unlike file dates, it is right after a fresh clone and after a change of branch.

use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// A number that changes with the name or content of any file in `paths` (files, or folders with all below them), and
/// with `variant`.
pub(crate) fn of(paths: &[PathBuf], variant: &str) -> Result<String> {
    let mut hasher = DefaultHasher::new();
    hasher.write(variant.as_bytes());
    for path in paths {
        add(&mut hasher, path)?;
    }
    Ok(format!("{:016x}", hasher.finish()))
}

fn add(hasher: &mut DefaultHasher, path: &Path) -> Result<()> {
    hasher.write(path.as_os_str().as_encoded_bytes());
    if path.is_dir() {
        let entries = fs::read_dir(path).with_context(|| format!("could not list {}", path.display()))?;
        let mut children = entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
        children.sort();
        children.iter().try_for_each(|child| add(hasher, child))
    } else {
        let content = fs::read(path).with_context(|| format!("could not read {}", path.display()))?;
        hasher.write_usize(content.len());
        hasher.write(&content);
        Ok(())
    }
}
