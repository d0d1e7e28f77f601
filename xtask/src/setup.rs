//! `cargo xtask setup`: installs the requirements of building and testing, or names them.

use std::ffi::OsString;

use anyhow::{Result, bail};

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

/// Installs Debian packages if this user may. Otherwise it prints a message and returns; callers check the result themselves.
pub(crate) fn apt_install(packages: &[&str]) {
    if !shell::on_path("apt-get") {
        return;
    }
    let as_root = shell::output(shell::program("id").arg("-u")).is_some_and(|id| id == "0");
    let may_sudo = !as_root && shell::output(shell::program("sudo").args(["-n", "true"])).is_some();
    let prefix: &[&str] = match (as_root, may_sudo) {
        (true, _) => &["env"],
        (_, true) => &["sudo", "-n", "env"],
        _ => {
            eprintln!("not root and sudo asks for a password: not installing {}", packages.join(" "));
            return;
        }
    };
    let apt_get = |arguments: &[&str]| {
        let mut command = shell::program(prefix[0]);
        command.args(&prefix[1..]).args(["DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq"]).args(arguments);
        shell::run(&mut command)
    };
    eprintln!("installing {}", packages.join(" "));
    let installed = apt_get(&["update"])
        .and_then(|()| apt_get(&[&["install", "-y", "--no-install-recommends"], packages].concat()));
    if let Err(error) = installed {
        eprintln!("{error:#}");
    }
}
