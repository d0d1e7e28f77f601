//! `cargo xtask web`: compiles the client for the browser and bundles it into `static/pkg`.

use std::ffi::OsString;
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result, bail};

use crate::lints::{self, Compiler};
use crate::toolchain::{TARGET, Toolchain};
use crate::{fingerprint, shell};

/// Largest size of a client that `wasm-opt` has shrunk, bytes after brotli, because it is loaded over slow radio links.
const MAX_BROTLI_BYTES: &str = "2200000";

/// The version of npm's `binaryen` whose `wasm-opt` shrinks release bundles.
const BINARYEN: &str = "binaryen@132";
const NPM_LIMIT: Duration = Duration::from_secs(120);

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flavour {
    /// Fast to build, larger to load.
    Dev,
    /// Small to load.
    Release,
}

/// What a release bundle above [`MAX_BROTLI_BYTES`] is. Other compilers make other sizes, and nobody's first start should fail for a kilobyte.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum SizeLimit {
    Enforced,
    Ignored,
}

impl Flavour {
    fn profile(self) -> &'static str {
        match self {
            Self::Dev => "web-dev",
            Self::Release => "web",
        }
    }
}

pub(crate) fn command(arguments: Vec<OsString>) -> Result<()> {
    use lexopt::prelude::*;

    let mut flavour = Flavour::Release;
    let mut toolchain = None;
    let mut parser = lexopt::Parser::from_args(arguments);
    while let Some(argument) = parser.next()? {
        match argument {
            Long("dev") => flavour = Flavour::Dev,
            Long("release") => flavour = Flavour::Release,
            Long("toolchain") => toolchain = Some(Toolchain::named(&parser.value()?.string()?)?),
            other => return Err(other.unexpected().into()),
        }
    }
    let toolchain = toolchain.map_or_else(Toolchain::find_or_install, Ok)?;
    build(flavour, toolchain, SizeLimit::Enforced, Compiler::Plain)
}

/// Compiles the client for development with lints.
///
/// # Errors
/// When it does not compile, and when there were warnings.
pub(crate) fn lint() -> Result<()> {
    lints::compile(|| compilation(Flavour::Dev, Toolchain::Active))
}

/// Builds the bundle unless the existing one was built from the same sources, in this flavour or a better one.
pub(crate) fn build_if_stale(least: Flavour, limit: SizeLimit, compiler: Compiler) -> Result<()> {
    let made_from = fs::read_to_string(stamp()).unwrap_or_default();
    let is_there = shell::root().join("static/pkg/manifest.json").exists();
    let fresh = |flavour| source_fingerprint(flavour).map(|fingerprint| made_from == fingerprint);
    if is_there && (fresh(Flavour::Release)? || least == Flavour::Dev && fresh(Flavour::Dev)?) {
        return Ok(());
    }
    build(least, Toolchain::find_or_install()?, limit, compiler)
}

/// The command that compiles the client.
fn compilation(flavour: Flavour, toolchain: Toolchain) -> Command {
    let mut cargo = toolchain.cargo_build();
    cargo.args(["-p", "app", "--lib", "--profile", flavour.profile()]);
    cargo.arg("--target-dir").arg(toolchain.target_folder());
    cargo
}

fn build(flavour: Flavour, toolchain: Toolchain, limit: SizeLimit, compiler: Compiler) -> Result<()> {
    let fingerprint = source_fingerprint(flavour)?;
    // Clippy is the active toolchain's.
    let compiler = if toolchain == Toolchain::Active { compiler } else { Compiler::Plain };
    shell::run(compiler.compiles(&mut compilation(flavour, toolchain)))?;
    let wasm = toolchain.target_folder().join(TARGET).join(flavour.profile()).join("app.wasm");
    if !wasm.exists() {
        bail!("compiling `app` left no {}; is it a cdylib?", wasm.display());
    }

    let mut bundler = bundler(compiler);
    bundler.arg(&wasm).arg(shell::root().join("static/pkg"));
    if flavour == Flavour::Release {
        bundler.arg("--smallest");
        match wasm_opt() {
            Some(path) => {
                bundler.arg("--wasm-opt").arg(path);
                if limit == SizeLimit::Enforced {
                    bundler.args(["--brotli-max", MAX_BROTLI_BYTES]);
                }
            }
            None => eprintln!(
                "npm or its package {BINARYEN} is not to be had: the bundle is not shrunk with wasm-opt, and its size is not checked"
            ),
        }
    }
    shell::run(&mut bundler)?;
    fs::write(stamp(), fingerprint).with_context(|| format!("could not write {}", stamp().display()))
}

/// The command that runs the bundler.
fn bundler(compiler: Compiler) -> Command {
    let built = shell::target().join("debug/bundler");
    match compiler {
        // The tests come first and have built it. Building its package alone selects other features, and a WASM parser would be compiled again.
        Compiler::Linting if built.exists() => shell::program(built),
        _ => {
            let mut run = shell::cargo();
            run.args(["run", "--quiet", "-p", "bundler", "--"]);
            run
        }
    }
}

/// File of the fingerprint of the bundle's sources. It is in the bundle's folder, so that both are deleted together.
fn stamp() -> PathBuf {
    shell::root().join("static/pkg/sources.stamp")
}

fn source_fingerprint(flavour: Flavour) -> Result<String> {
    let sources = ["Cargo.toml", "Cargo.lock", "shared", "web", "xtask/bundler"];
    fingerprint::of(&sources.map(|path| shell::root().join(path)), flavour.profile())
}

/// Path of a current `wasm-opt`, installed from npm into the target folder when it is not there yet.
fn wasm_opt() -> Option<PathBuf> {
    let folder = shell::root().join("target/binaryen");
    let script = folder.join("node_modules/binaryen/bin/wasm-opt");
    if !script.exists() && shell::on_path("npm") {
        fs::create_dir_all(&folder).ok()?;
        let mut npm = shell::program("npm");
        npm.args(["install", "--no-audit", "--no-fund", "--silent", "--prefix"]).arg(&folder).arg(BINARYEN);
        shell::succeeds_within(&mut npm, NPM_LIMIT);
    }
    script.exists().then_some(script)
}
