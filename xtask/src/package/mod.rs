//! `cargo xtask package`: a Debian package with a sandboxed service, and the files of a container image.
//!
//! What is in the package stands in `xtask/package`: the unit of the service, its settings, its user and the package's scripts. `dpkg-deb` of Debian builds it.

mod check;

use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::lints::Compiler;
use crate::shell;
use crate::web::{self, Flavour, SizeLimit};

/// Version of the workspace.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Files of the package: where they come from, where they go, and their mode.
const FILES: [(&str, &str, u32); 8] = [
    ("xtask/package/autoinspect.service", "usr/lib/systemd/system/autoinspect.service", 0o644),
    ("xtask/package/autoinspect.sysusers", "usr/lib/sysusers.d/autoinspect.conf", 0o644),
    ("xtask/package/autoinspect.default", "etc/default/autoinspect", 0o644),
    ("xtask/package/copyright", "usr/share/doc/autoinspect/copyright", 0o644),
    ("README.md", "usr/share/doc/autoinspect/README.md", 0o644),
    ("docs/guide/security.md", "usr/share/doc/autoinspect/security.md", 0o644),
    ("LICENSE-MIT", "usr/share/doc/autoinspect/LICENSE-MIT", 0o644),
    ("LICENSE-APACHE", "usr/share/doc/autoinspect/LICENSE-APACHE", 0o644),
];

/// Scripts that the package manager runs.
const SCRIPTS: [&str; 3] = ["postinst", "prerm", "postrm"];

pub(crate) fn command(arguments: Vec<OsString>) -> Result<()> {
    use lexopt::prelude::*;

    let mut is_check = false;
    let mut parser = lexopt::Parser::from_args(arguments);
    while let Some(argument) = parser.next()? {
        match argument {
            Long("check") => is_check = true,
            other => return Err(other.unexpected().into()),
        }
    }
    for program in ["dpkg-deb", "dpkg"] {
        if !shell::on_path(program) {
            bail!(
                "a Debian package is built with `{program}`, which is not here; install the package `dpkg`"
            );
        }
    }
    web::build_if_stale(Flavour::Release, SizeLimit::Enforced, Compiler::Plain)?;
    shell::run(shell::cargo().args(["build", "--release", "-p", "autoinspect"]))?;

    let folder = folder();
    fs::create_dir_all(&folder).with_context(|| format!("could not create {}", folder.display()))?;
    let package = build(VERSION)?;
    // The container file and what it copies.
    fs::copy(&package, folder.join("autoinspect.deb")).context("could not copy the package")?;
    println!("{}", package.display());
    if is_check { check::all(&package) } else { Ok(()) }
}

/// Where packages are built.
fn folder() -> PathBuf {
    shell::target().join("package")
}

/// Builds the package of this version, and returns its path.
fn build(version: &str) -> Result<PathBuf> {
    let architecture = shell::output(shell::program("dpkg").arg("--print-architecture"))
        .context("dpkg does not tell the architecture of this computer")?;
    let name = format!("autoinspect_{version}_{architecture}");
    let tree = folder().join(&name);
    if tree.exists() {
        fs::remove_dir_all(&tree).with_context(|| format!("could not empty {}", tree.display()))?;
    }
    for (from, to, mode) in FILES {
        install(&shell::root().join(from), &tree.join(to), mode)?;
    }
    install(&shell::target().join("release/autoinspect"), &tree.join("usr/bin/autoinspect"), 0o755)?;
    shell::run(shell::program("strip").arg("--strip-unneeded").arg(tree.join("usr/bin/autoinspect")))?;
    install_folder(&shell::root().join("static"), &tree.join("usr/share/autoinspect/static"))?;
    // Enabled by the package's scripts; a link in the package would enable it for those who masked it.
    let control = tree.join("DEBIAN");
    for script in SCRIPTS {
        install(&shell::root().join("xtask/package").join(script), &control.join(script), 0o755)?;
    }
    write(&control.join("conffiles"), "/etc/default/autoinspect\n")?;
    write(&control.join("control"), &control_file(version, &architecture, kib_below(&tree)?)?)?;

    let package = folder().join(format!("{name}.deb"));
    let mut dpkg_deb = shell::program("dpkg-deb");
    shell::run(dpkg_deb.args(["--root-owner-group", "--build", "-Zxz"]).arg(&tree).arg(&package))?;
    Ok(package)
}

/// The package's description, with the C library of this computer as the least that it needs.
fn control_file(version: &str, architecture: &str, installed_kib: u64) -> Result<String> {
    let libc = shell::output(shell::program("getconf").arg("GNU_LIBC_VERSION"))
        .and_then(|text| text.rsplit(' ').next().map(str::to_owned))
        .context("`getconf GNU_LIBC_VERSION` does not tell the version of the C library")?;
    let template = fs::read_to_string(shell::root().join("xtask/package/control"))
        .context("could not read xtask/package/control")?;
    Ok(template
        .replace("{version}", version)
        .replace("{architecture}", architecture)
        .replace("{installed_kib}", &installed_kib.to_string())
        .replace("{libc}", &libc))
}

fn install(from: &Path, to: &Path, mode: u32) -> Result<()> {
    let parent = to.parent().unwrap_or(to);
    fs::create_dir_all(parent).with_context(|| format!("could not create {}", parent.display()))?;
    fs::copy(from, to).with_context(|| format!("could not copy {} to {}", from.display(), to.display()))?;
    fs::set_permissions(to, fs::Permissions::from_mode(mode))
        .with_context(|| format!("could not set the mode of {}", to.display()))
}

/// Copies a folder of plain files.
fn install_folder(from: &Path, to: &Path) -> Result<()> {
    let entries = fs::read_dir(from).with_context(|| format!("could not list {}", from.display()))?;
    for entry in entries {
        let entry = entry.with_context(|| format!("could not list {}", from.display()))?;
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        let kind = entry.file_type().with_context(|| format!("could not look at {}", path.display()))?;
        if kind.is_dir() {
            install_folder(&path, &target)?;
        } else if kind.is_symlink() {
            let aim = fs::read_link(&path).with_context(|| format!("could not read {}", path.display()))?;
            symlink(aim, &target).with_context(|| format!("could not make {}", target.display()))?;
        } else {
            install(&path, &target, 0o644)?;
        }
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<()> {
    fs::write(path, text).with_context(|| format!("could not write {}", path.display()))
}

/// Size of all files below a folder, KiB.
fn kib_below(folder: &Path) -> Result<u64> {
    let mut kib = 0;
    for entry in fs::read_dir(folder).with_context(|| format!("could not list {}", folder.display()))? {
        let entry = entry?;
        let data = entry.metadata()?;
        kib += if data.is_dir() { kib_below(&entry.path())? } else { data.len().div_ceil(1024) };
    }
    Ok(kib)
}
