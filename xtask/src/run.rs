//! `cargo xtask run`: from sources to a simulated robot on a web page.

use std::ffi::OsString;
use std::path::PathBuf;

use anyhow::Result;

use crate::lints::Compiler;
use crate::shell;
use crate::web::{self, Flavour, SizeLimit};

struct Options {
    site: String,
    port: u16,
    data: PathBuf,
    speed: Option<String>,
    flavour: Flavour,
}

pub(crate) fn command(arguments: Vec<OsString>) -> Result<()> {
    let options = options(arguments)?;
    web::build_if_stale(options.flavour, SizeLimit::Ignored, Compiler::Plain)?;
    shell::run(shell::cargo().args(["build", "--quiet", "--release", "-p", "autoinspect"]))?;

    let address = format!("127.0.0.1:{}", options.port);
    eprintln!("AutoInspect with a simulated robot at {}: http://{address}", options.site);
    let mut server = shell::program(shell::target().join("release/autoinspect"));
    server.args([
        "up",
        "--demo",
        "--robot",
        &format!("sim:{}", options.site),
        "--listen",
        &address,
        "--data",
    ]);
    server.arg(&options.data);
    if let Some(speed) = &options.speed {
        server.args(["--speed", speed]);
    }
    shell::run(&mut server)
}

/// The name of a site. The file of a building is relative to the current directory of the command.
fn site(name: &str) -> Result<String> {
    if !name.ends_with(".glb") {
        return Ok(name.to_owned());
    }
    Ok(std::env::current_dir()?.join(name).display().to_string())
}

fn options(arguments: Vec<OsString>) -> Result<Options> {
    use lexopt::prelude::*;

    let mut options = Options {
        site: "b1".to_owned(),
        port: 8080,
        data: shell::root().join("target/data"),
        speed: None,
        flavour: Flavour::Release,
    };
    let mut parser = lexopt::Parser::from_args(arguments);
    while let Some(argument) = parser.next()? {
        match argument {
            Long("site") => options.site = site(&parser.value()?.string()?)?,
            Long("port") => options.port = parser.value()?.parse()?,
            // Relative to the current directory of the command.
            Long("data") => options.data = std::env::current_dir()?.join(parser.value()?),
            Long("speed") => options.speed = Some(parser.value()?.string()?),
            Long("dev") => options.flavour = Flavour::Dev,
            other => return Err(other.unexpected().into()),
        }
    }
    Ok(options)
}
