//! `cargo xtask setup`: installs the requirements of building and testing, or names them.

use std::ffi::OsString;

use anyhow::{Result, bail};

use crate::debian::apt_install;
use crate::shell;
use crate::toolchain::Toolchain;

/// Names of the Chromium program on different systems.
const CHROMIUM_NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
/// The Debian package with Chromium.
const CHROMIUM_PACKAGE: &str = "chromium";

pub(crate) fn setup(arguments: Vec<OsString>) -> Result<()> {
    if let Some(argument) = arguments.first() {
        bail!("`cargo xtask setup` takes no arguments, got {}", argument.display());
    }
    let toolchain = Toolchain::install()?;
    println!(
        "browser client: {}",
        match toolchain {
            Toolchain::Active => "the active toolchain",
            Toolchain::Debian => "Debian's Rust, with the standard library from source",
        }
    );
    match find_or_install_chromium() {
        Some(name) => println!("browser tests:  {name}"),
        None => println!(
            "browser tests:  no Chromium found; they will be skipped. On Debian: apt-get install chromium"
        ),
    }
    for (tool, without_it) in [
        ("cargo-nextest", "tests run with `cargo test`"),
        ("cargo-deny", "licences are not checked"),
        ("npm", "the bundle is not shrunk with wasm-opt"),
    ] {
        match shell::on_path(tool) {
            true => println!("{:<15} found", format!("{tool}:")),
            false => println!("{:<15} absent; {without_it}", format!("{tool}:")),
        }
    }
    Ok(())
}

/// The name of the Chromium on this machine's PATH, after installing Debian's if there is none.
pub(crate) fn find_or_install_chromium() -> Option<&'static str> {
    let find = || CHROMIUM_NAMES.into_iter().find(|name| shell::on_path(name));
    find().or_else(|| {
        apt_install(&[CHROMIUM_PACKAGE]);
        find()
    })
}
