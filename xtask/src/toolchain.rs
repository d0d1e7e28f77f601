//! Chooses the compiler of the browser client.
//!
//! There are two: the active rustup toolchain, once it has the `wasm32-unknown-unknown` standard library, and Debian's Rust. The latter
//! has only the sources of that library and compiles it together with the client.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Result, bail};

use crate::{debian, shell};

pub(crate) const TARGET: &str = "wasm32-unknown-unknown";

/// Debian packages of the second toolchain.
const DEBIAN_PACKAGES: [&str; 4] = ["rustc-web", "cargo-web", "rust-web-src", "lld-19"];
const DEBIAN_LINKER: &str = "/usr/bin/wasm-ld-19";
const DEBIAN_CARGO: &str = "/usr/bin/cargo";
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";

/// Limit for rustup: it downloads 20 MB or hangs on a network that drops its packets.
const RUSTUP_LIMIT: Duration = Duration::from_secs(90);

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Toolchain {
    /// The toolchain that runs this program, with the target's standard library installed.
    Active,
    /// Debian's Rust, which builds the standard library from source.
    Debian,
}

impl Toolchain {
    /// The toolchain of that name, if it can be used without installing anything.
    pub(crate) fn named(name: &str) -> Result<Self> {
        let (toolchain, present) = match name {
            "rustup" => (Self::Active, active_is_ready()),
            "debian" => (Self::Debian, debian_is_ready()),
            _ => bail!("no toolchain {name}; there are rustup and debian"),
        };
        if !present {
            bail!(
                "the {name} toolchain cannot build for {TARGET} here; `cargo xtask setup` says what is missing"
            );
        }
        Ok(toolchain)
    }

    /// The first toolchain that can be used, after installing one if there is none.
    pub(crate) fn find_or_install() -> Result<Self> {
        if active_is_ready() {
            return Ok(Self::Active);
        }
        if debian_is_ready() {
            return Ok(Self::Debian);
        }
        Self::install()
    }

    /// Tries, in this order: the active toolchain, installing the target with rustup, Debian's packages.
    pub(crate) fn install() -> Result<Self> {
        if active_is_ready() {
            return Ok(Self::Active);
        }
        if shell::on_path("rustup") {
            eprintln!("adding the {TARGET} standard library with rustup");
            let mut add = shell::program("rustup");
            add.args(["target", "add", TARGET]);
            if shell::succeeds_within(&mut add, RUSTUP_LIMIT) && active_is_ready() {
                return Ok(Self::Active);
            }
        }
        if !debian_is_ready() {
            debian::apt_install(&DEBIAN_PACKAGES);
        }
        if debian_is_ready() {
            return Ok(Self::Debian);
        }
        bail!(
            "nothing here can compile for {TARGET}. Either run `rustup target add {TARGET}`, or, on Debian 12, as root: \
             apt-get update && apt-get install -y {}",
            DEBIAN_PACKAGES.join(" ")
        );
    }

    /// Cargo's `build` for the browser, with this toolchain.
    pub(crate) fn cargo_build(self) -> Command {
        match self {
            Self::Active => {
                let mut cargo = shell::cargo();
                cargo.args(["build", "--target", TARGET]);
                cargo
            }
            Self::Debian => {
                let mut cargo = shell::program(DEBIAN_CARGO);
                cargo.args(["build", "--target", TARGET, "-Zbuild-std=std,panic_abort"]);
                // Building the standard library is a nightly feature; the variable allows it on a stable compiler.
                cargo.env("RUSTC_BOOTSTRAP", "1").env("RUSTC", DEBIAN_RUSTC);
                cargo.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", DEBIAN_LINKER);
                cargo
            }
        }
    }

    /// The toolchain's own target folder, so that two compilers do not rebuild each other's outputs.
    pub(crate) fn target_folder(self) -> PathBuf {
        shell::root().join("target").join(match self {
            Self::Active => "web",
            Self::Debian => "web-debian",
        })
    }
}

fn active_is_ready() -> bool {
    has_library(shell::program("rustc"), &format!("lib/rustlib/{TARGET}/lib"))
}

fn debian_is_ready() -> bool {
    [DEBIAN_LINKER, DEBIAN_CARGO, DEBIAN_RUSTC].iter().all(|file| Path::new(file).exists())
        && has_library(shell::program(DEBIAN_RUSTC), "lib/rustlib/src/rust/library/Cargo.toml")
}

fn has_library(mut rustc: Command, below_sysroot: &str) -> bool {
    shell::output(rustc.args(["--print", "sysroot"]))
        .is_some_and(|sysroot| Path::new(&sysroot).join(below_sysroot).exists())
}
