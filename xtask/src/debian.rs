//! Installing packages of the system, where that is Debian or a relative.

use crate::shell;

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
