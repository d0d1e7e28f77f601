//! A headless Chromium with an empty profile, ended when dropped.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use tempfile::TempDir;

use super::devtools::DevTools;
use super::page::Page;
use super::wait_for;

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
const START_LIMIT: Duration = Duration::from_secs(60);

/// Names the number of drawn pixels for each of the page, 1 by default. In software, fewer are drawn sooner, and the page looks the same to all but its pictures: it has the
/// same size and the same layout.
const SCALE: &str = "AUTOINSPECT_BROWSER_SCALE";

/// Host name of the server in the browser, like that of a machine on the local network.
pub const LAN_HOST: &str = "robot.test";

pub struct Chromium {
    process: Child,
    profile: TempDir,
}

impl Chromium {
    /// Starts the first Chromium on the PATH; `None`, with a printed note, if there is none.
    pub fn start() -> Option<Self> {
        let Some(name) = NAMES.into_iter().find(|name| on_path(name)) else {
            println!("skipped: no Chromium on this machine (`cargo xtask setup` says how to get one)");
            return None;
        };
        let profile = tempfile::tempdir().unwrap();
        // In software a browser takes all processors it gets. That of an operator is on another machine and takes nothing from the robot.
        let process = Command::new("nice")
            .args(["-n", "10", name])
            .args(["--headless=new", "--no-sandbox", "--no-first-run", "--remote-debugging-port=0"])
            .args([
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-sync",
                "--disable-quic",
            ])
            // WebGL 2 in software, because test machines have no graphics card.
            .args(["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
            .arg(format!("--force-device-scale-factor={}", pixel_scale()))
            .arg(format!("--host-resolver-rules=MAP {LAN_HOST} 127.0.0.1"))
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        Some(Self { process, profile })
    }

    /// Opens an empty page of `width` by `height` CSS pixels.
    pub fn open(&self, width: u32, height: u32) -> Page {
        self.open_with(width, height, |_| json!({ "url": "about:blank" }))
    }

    /// As [`Self::open`], with cookies and storage of its own, as on another computer.
    pub fn open_apart(&self, width: u32, height: u32) -> Page {
        self.open_with(width, height, |devtools| {
            let context = devtools.call(None, "Target.createBrowserContext", json!({}));
            // In a window of its own, because only the page in front of a window draws frames.
            json!({ "url": "about:blank", "browserContextId": context["browserContextId"], "newWindow": true })
        })
    }

    /// `target`: what is asked of the browser for the new page.
    fn open_with(&self, width: u32, height: u32, target: impl FnOnce(&mut DevTools) -> Value) -> Page {
        let (port, path) = wait_for("Chromium to start", START_LIMIT, || self.address());
        let mut devtools = DevTools::connect(port, &path);
        let target = target(&mut devtools);
        let target = devtools.call(None, "Target.createTarget", target);
        let attached = devtools.call(
            None,
            "Target.attachToTarget",
            json!({ "targetId": target["targetId"], "flatten": true }),
        );
        Page::new(devtools, attached["sessionId"].as_str().unwrap().to_owned(), width, height)
    }

    /// Port and path of its debugging socket, once it has written them to a file.
    fn address(&self) -> Option<(u16, String)> {
        let text = fs::read_to_string(self.profile.path().join("DevToolsActivePort")).ok()?;
        let (port, path) = text.split_once('\n')?;
        Some((port.parse().ok()?, path.trim().to_owned()))
    }
}

impl Drop for Chromium {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Drawn pixels for each of the page, along both sides.
pub fn pixel_scale() -> f64 {
    let Ok(text) = std::env::var(SCALE) else { return 1.0 };
    let scale = text.parse().ok().filter(|scale| (0.25..=2.0).contains(scale));
    scale.unwrap_or_else(|| panic!("{SCALE} is {text:?}, and has to be a number from 0.25 to 2"))
}

fn on_path(name: &str) -> bool {
    std::env::var_os("PATH")
        .is_some_and(|path| std::env::split_paths(&path).any(|folder| folder.join(name).is_file()))
}
