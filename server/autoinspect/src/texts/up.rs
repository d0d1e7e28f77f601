//! Texts of `autoinspect up` and its processes.

use std::fmt::Display;
use std::path::Path;
use std::time::Duration;

/// The given folder does not contain the browser client.
pub fn no_client_in(folder: &Path) -> String {
    format!("{} holds no index.html", folder.display())
}

/// The browser client was not found.
pub const NO_CLIENT: &str = "the browser client was not found; say where it is with --static FOLDER";

/// A process of the platform that the system could not start.
pub fn cannot_start(role: &str, error: &dyn Display) -> String {
    format!("the {role} could not be started: {error}")
}

/// A process of the platform that rejected its arguments.
pub fn cannot_run_as_asked(role: &str) -> String {
    format!("the {role} cannot run as asked")
}

/// The core was given a simulated robot by its site.
pub const SIMULATED_ROBOT_IS_A_PROCESS: &str = "the core reaches a simulated robot by its socket; give --robot socket:PATH of `autoinspect simulated-robot --socket PATH`";

/// The simulated robot was given another robot.
pub const ONLY_SITES_ARE_SIMULATED: &str = "only --robot sim:SITE can be simulated";

/// Another day at a site that is not simulated.
pub const ONLY_SITES_HAVE_DAYS: &str =
    "--day changes a simulated site; give it with --robot sim:SITE, or leave it out";

/// Changes of a site that is not simulated.
pub const ONLY_SITES_CHANGE: &str = "--changes, --random-changes and --truth-changes are for a simulated site; give them with --robot sim:SITE, or leave them out";

/// The simulation stopped without a request.
pub const SIMULATION_ENDED: &str = "the simulation ended unexpectedly";

/// Another robot answers at the robot's socket: its clock and its place may have changed. A clause after "the core".
pub const ROBOT_RESTARTED: &str = "began anew because the robot was started again";

/// No robot answers at its socket, for a reason that is a clause about the robot.
pub fn robot_not_connected(socket: &Path, reason: &dyn Display) -> String {
    format!("the robot at {} could not be connected: {reason}", socket.display())
}

/// It runs and can be opened at this address.
pub fn platform_running(address: &str) -> String {
    format!("AutoInspect is running: {address}")
}

/// How it is stopped.
pub fn platform_data(data: &Path) -> String {
    format!("data in {}; stop with Ctrl-C", data.display())
}

/// A process failed and is started again after this pause; `cause` is a clause.
pub fn process_restarts(role: &str, cause: &str, pause: Duration) -> String {
    let pause = match pause.is_zero() {
        true => String::new(),
        false => format!(" in {:.1} s", pause.as_secs_f64()),
    };
    format!("the {role} {cause} and is started again{pause}")
}

/// A process ends because one of its threads failed; `cause` is a clause.
pub fn process_failed(cause: &str) -> String {
    format!("this process {cause}")
}

/// Clauses after the name of a process: why it was started again.
pub const PANICKED: &str = "panicked";

pub fn did_not_answer(limit: Duration) -> String {
    format!("did not answer for {} s", limit.as_secs())
}

pub fn was_killed(signal: i32) -> String {
    format!("was killed (signal {signal})")
}

pub fn ended_with_code(code: i32) -> String {
    format!("ended (exit code {code})")
}

/// A process that does not end in time.
pub fn process_killed(role: &str) -> String {
    format!("the {role} does not stop and is killed")
}

/// A demonstration needs no sign-in, so it is not for a network.
pub fn demo_on_network(listen: &dyn Display) -> String {
    format!(
        "with --demo nobody signs in, so the server cannot listen on {listen}, which others can reach. Leave --demo out, or use --listen 127.0.0.1:8080"
    )
}

/// While there is no admin: how to make the first one.
pub fn make_first_admin(link: &str) -> String {
    format!("nobody can sign in yet. This address makes the first admin, once: {link}")
}

/// How people make their browsers trust the robot's own certificate authority.
pub fn trust_authority(address: &str, fingerprint: &str) -> String {
    format!(
        "browsers warn until they trust the robot's own certificate authority. {address}/trust.html explains how; its SHA-256 fingerprint is {fingerprint}"
    )
}
