//! One page in a browser, operated like by a person or a screen reader: by role and name, pointer and keyboard.

use std::path::Path;
use std::time::Duration;

use base64::Engine;
use serde_json::{Value, json};

use super::devtools::DevTools;
use super::picture::Picture;
use super::wait_for;

/// Longest wait for a control, which allows for software rendering on a busy machine.
const CONTROL_LIMIT: Duration = Duration::from_secs(60);

pub struct Page {
    devtools: DevTools,
    session: String,
    errors: Vec<String>,
    /// Width and height of the window, CSS pixels.
    size: [u32; 2],
}

/// Evaluates to true once two more frames have been drawn.
pub const NEXT_PICTURES: &str =
    "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))";

/// A control that moves less than this while the pointer comes stands still, CSS pixels. Chosen: far less than the smallest button.
const STILL_PX: f64 = 2.0;

/// A key in the form of the protocol.
#[derive(Clone, Copy)]
pub struct KeyPress {
    code: &'static str,
    key: &'static str,
    number: u8,
}

impl KeyPress {
    pub const W: Self = Self { code: "KeyW", key: "w", number: b'W' };
    pub const ESCAPE: Self = Self { code: "Escape", key: "Escape", number: 27 };
    pub const ENTER: Self = Self { code: "Enter", key: "Enter", number: 13 };
    pub const TAB: Self = Self { code: "Tab", key: "Tab", number: 9 };
    pub const Q: Self = Self { code: "KeyQ", key: "q", number: b'Q' };
}

impl KeyPress {
    /// `text`: the character that the key types, or nothing.
    fn event(self, kind: &str, text: &str) -> Value {
        json!({ "type": kind, "code": self.code, "key": self.key, "windowsVirtualKeyCode": self.number, "text": text })
    }
}

/// An element of the page with a role and a name.
#[derive(Debug, Clone)]
pub struct PageControl {
    /// The browser's number of the element.
    node: i64,
    pub disabled: bool,
}

/// A point on the page, CSS pixels from the top left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct At {
    pub x: f64,
    pub y: f64,
}

impl Page {
    pub(super) fn new(devtools: DevTools, session: String, width: u32, height: u32) -> Self {
        let mut page = Self { devtools, session, errors: Vec::new(), size: [width, height] };
        for domain in ["Page", "Runtime", "Log", "DOM", "Accessibility", "Network"] {
            page.call(&format!("{domain}.enable"), json!({}));
        }
        page.resize(width, height);
        page
    }

    /// Sets the inner size of the window to `width` by `height` CSS pixels.
    pub fn resize(&mut self, width: u32, height: u32) {
        self.size = [width, height];
        self.call(
            "Emulation.setDeviceMetricsOverride",
            // 0: that of the browser.
            json!({ "width": width, "height": height, "deviceScaleFactor": 0, "mobile": false }),
        );
    }

    /// Width and height of the window, CSS pixels.
    pub fn size(&self) -> [f64; 2] {
        self.size.map(f64::from)
    }

    /// Puts the calendar clock of the pages that are loaded from now on ahead by this time, seconds.
    pub fn set_clock_offset(&mut self, offset_s: i64) {
        let source = format!("{{ const now = Date.now; Date.now = () => now() + {offset_s}000; }}");
        self.call("Page.addScriptToEvaluateOnNewDocument", json!({ "source": source }));
    }

    /// Lets the page take fingers.
    pub fn allow_touch(&mut self) {
        self.call("Emulation.setTouchEmulationEnabled", json!({ "enabled": true, "maxTouchPoints": 5 }));
    }

    /// Puts the page before the others of its browser, which draws no frames of a page that another one hides.
    pub fn bring_to_front(&mut self) {
        self.call("Page.bringToFront", json!({}));
    }

    /// Waits until the next frame.
    #[track_caller]
    pub fn wait_for_frame(&mut self) {
        self.evaluate("new Promise(done => requestAnimationFrame(() => done(true)))");
    }

    /// Waits until two more frames have been drawn.
    #[track_caller]
    pub fn wait_for_pictures(&mut self) {
        assert_eq!(self.evaluate(NEXT_PICTURES), true);
    }

    /// Starts loading `url`.
    pub fn go(&mut self, url: &str) {
        let answer = self.call("Page.navigate", json!({ "url": url }));
        assert!(answer["errorText"].is_null(), "{url}: {}", answer["errorText"]);
    }

    /// Reloads the page. Waits until the old one is gone, because it would take the next click.
    #[track_caller]
    pub fn reload(&mut self) {
        self.evaluate("window.isOld = true");
        self.call("Page.reload", json!({}));
        wait_for("the page anew", CONTROL_LIMIT, || {
            // Between two documents the evaluation fails.
            let asked = json!({ "expression": "window.isOld !== true", "returnByValue": true });
            let answer = self.try_call("Runtime.evaluate", asked).ok()?;
            (answer["result"]["value"] == true).then_some(())
        });
    }

    /// The value of a JavaScript expression, which may be a promise.
    #[track_caller]
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let mut answer = self.call(
            "Runtime.evaluate",
            json!({ "expression": expression, "returnByValue": true, "awaitPromise": true }),
        );
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {}", answer["exceptionDetails"]);
        answer["result"]["value"].take()
    }

    /// The marks of the page in the browser's timeline: names and seconds since the navigation.
    pub fn marks(&mut self) -> Vec<(String, f64)> {
        let noted =
            self.evaluate("performance.getEntriesByType('mark').map(m => [m.name, m.startTime * 1e-3])");
        serde_json::from_value(noted).unwrap_or_default()
    }

    /// Waits for the control with this role and exact name.
    #[track_caller]
    pub fn control(&mut self, role: &str, name: &str) -> PageControl {
        wait_for(&format!("{role} “{name}”"), CONTROL_LIMIT, || self.find(role, name))
    }

    /// The control with this role and exact name, if it exists now.
    pub fn find(&mut self, role: &str, name: &str) -> Option<PageControl> {
        self.all(role).into_iter().find_map(|(found, control)| (found == name).then_some(control))
    }

    /// All controls with this role and their names, in document order.
    pub fn all(&mut self, role: &str) -> Vec<(String, PageControl)> {
        // Between two documents the page has no controls.
        let Ok(document) = self.try_call("DOM.getDocument", json!({ "depth": 0 })) else { return Vec::new() };
        let root = document["root"]["nodeId"].clone();
        let Ok(mut answer) =
            self.try_call("Accessibility.queryAXTree", json!({ "nodeId": root, "role": role }))
        else {
            return Vec::new();
        };
        let Value::Array(nodes) = answer["nodes"].take() else { return Vec::new() };
        nodes
            .into_iter()
            .filter(|node| node["ignored"] != true)
            .filter_map(|node| {
                let name = node["name"]["value"].as_str().unwrap_or_default().to_owned();
                let properties = node["properties"].as_array();
                let disabled = properties.is_some_and(|properties| {
                    properties
                        .iter()
                        .any(|property| property["name"] == "disabled" && property["value"]["value"] == true)
                });
                Some((name, PageControl { node: node["backendDOMNodeId"].as_i64()?, disabled }))
            })
            .collect()
    }

    /// The present text of the status with this name; `None` if there is no such status.
    pub fn status(&mut self, name: &str) -> Option<String> {
        let control = self.find("status", name)?;
        self.text(&control)
    }

    /// The text content of a control.
    pub fn text(&mut self, control: &PageControl) -> Option<String> {
        let object = self.try_call("DOM.resolveNode", json!({ "backendNodeId": control.node })).ok()?;
        let answer = self
            .try_call(
                "Runtime.callFunctionOn",
                json!({
                    "objectId": object["object"]["objectId"],
                    "functionDeclaration": "function() { return this.textContent }",
                    "returnByValue": true,
                }),
            )
            .ok()?;
        answer["result"]["value"].as_str().map(str::to_owned)
    }

    /// The centre of a control, if it is still on the page.
    pub fn middle(&mut self, control: &PageControl) -> Option<At> {
        let [min, max] = self.corners(control)?;
        Some(At { x: 0.5 * (min.x + max.x), y: 0.5 * (min.y + max.y) })
    }

    /// The upper left and the lower right corner of a control, if it is still on the page.
    pub fn corners(&mut self, control: &PageControl) -> Option<[At; 2]> {
        let answer = self.try_call("DOM.getBoxModel", json!({ "backendNodeId": control.node })).ok()?;
        let corners: Vec<f64> =
            answer["model"]["border"].as_array()?.iter().filter_map(Value::as_f64).collect();
        // Clockwise from the upper left one.
        (corners.len() == 8)
            .then(|| [At { x: corners[0], y: corners[1] }, At { x: corners[4], y: corners[5] }])
    }

    /// Waits until the control with this role and name is enabled and is where it was before the pointer came, as a person would, and clicks it.
    #[track_caller]
    pub fn click(&mut self, role: &str, name: &str) {
        let at = wait_for(
            &format!("an enabled {role} “{name}” that stays in its place"),
            CONTROL_LIMIT,
            || {
                let at = self.middle_if_enabled(role, name)?;
                self.pointer("mouseMoved", at);
                let now = self.middle_if_enabled(role, name)?;
                ((now.x - at.x).hypot(now.y - at.y) < STILL_PX).then_some(now)
            },
        );
        self.press(at);
        self.release(at);
    }

    fn middle_if_enabled(&mut self, role: &str, name: &str) -> Option<At> {
        let control = self.find(role, name).filter(|control| !control.disabled)?;
        self.middle(&control)
    }

    pub fn press(&mut self, at: At) {
        self.pointer("mousePressed", at);
    }

    pub fn move_to(&mut self, at: At) {
        self.pointer("mouseMoved", at);
    }

    pub fn release(&mut self, at: At) {
        self.pointer("mouseReleased", at);
    }

    /// Turns the wheel over a place. Positive is towards the user, CSS pixels.
    pub fn wheel(&mut self, at: At, delta_y: f64) {
        self.call(
            "Input.dispatchMouseEvent",
            json!({ "type": "mouseWheel", "x": at.x, "y": at.y, "deltaX": 0.0, "deltaY": delta_y }),
        );
    }

    /// Clicks three times, which selects the text of a field.
    pub fn triple_click(&mut self, at: At) {
        for count in 1..=3 {
            self.count_pointer("mousePressed", at, count);
            self.count_pointer("mouseReleased", at, count);
        }
    }

    fn pointer(&mut self, kind: &str, at: At) {
        self.count_pointer(kind, at, 1);
    }

    /// `count`: the number of this click in a series of clicks.
    fn count_pointer(&mut self, kind: &str, at: At, count: u32) {
        let button = if kind == "mouseMoved" { "none" } else { "left" };
        let buttons = i32::from(kind != "mouseReleased");
        self.call(
            "Input.dispatchMouseEvent",
            json!({ "type": kind, "x": at.x, "y": at.y, "button": button, "buttons": buttons, "clickCount": count }),
        );
    }

    /// Waits as [`Self::click`] does, and taps the control with a finger.
    #[track_caller]
    pub fn tap(&mut self, role: &str, name: &str) {
        let what = format!("an enabled {role} “{name}” that stays in its place");
        let at = wait_for(&what, CONTROL_LIMIT, || {
            let at = self.middle_if_enabled(role, name)?;
            self.wait_for_frame();
            let now = self.middle_if_enabled(role, name)?;
            ((now.x - at.x).hypot(now.y - at.y) < STILL_PX).then_some(now)
        });
        self.touch("touchStart", Some(at));
        self.touch("touchEnd", None);
    }

    /// A finger: `touchStart`, `touchMove` or, without a place, `touchEnd`.
    pub fn touch(&mut self, kind: &str, at: Option<At>) {
        let points: Vec<Value> = at.iter().map(|at| json!({ "x": at.x, "y": at.y })).collect();
        self.call("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }));
    }

    pub fn key_down(&mut self, key: KeyPress) {
        self.key("rawKeyDown", key);
    }

    pub fn key_up(&mut self, key: KeyPress) {
        self.key("keyUp", key);
    }

    /// Presses and releases a key as in a form, where Enter is a character too.
    pub fn key_in_form(&mut self, key: KeyPress) {
        self.call("Input.dispatchKeyEvent", key.event("keyDown", if key.number == 13 { "\r" } else { "" }));
        self.key_up(key);
    }

    fn key(&mut self, kind: &str, key: KeyPress) {
        self.call("Input.dispatchKeyEvent", key.event(kind, ""));
    }

    /// Types `text` into the element with the focus.
    pub fn type_text(&mut self, text: &str) {
        self.call("Input.insertText", json!({ "text": text }));
    }

    /// Clicks the button with this name, which opens the browser's dialogue for files, and chooses one in it.
    #[track_caller]
    pub fn choose_file(&mut self, button: &str, file: &Path) {
        self.call("Page.setInterceptFileChooserDialog", json!({ "enabled": true }));
        self.click("button", button);
        let input = wait_for("an input for files", CONTROL_LIMIT, || {
            let document = self.call("DOM.getDocument", json!({}));
            let root = document["root"]["nodeId"].as_i64()?;
            let query = json!({ "nodeId": root, "selector": "input[type=file]" });
            self.call("DOM.querySelector", query)["nodeId"].as_i64().filter(|node| *node > 0)
        });
        self.call("DOM.setFileInputFiles", json!({ "files": [file], "nodeId": input }));
    }

    /// A picture for the guide: WebP, which is a fifth of the size of PNG where points are drawn.
    pub fn guide_picture(&mut self) -> Vec<u8> {
        let answer = self.call("Page.captureScreenshot", json!({ "format": "webp", "quality": 72 }));
        base64::engine::general_purpose::STANDARD.decode(answer["data"].as_str().unwrap()).unwrap()
    }

    pub fn screenshot(&mut self) -> Picture {
        let answer = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        Picture::from_base64(answer["data"].as_str().unwrap(), self.size[0]).unwrap()
    }

    /// Errors that the page has reported so far: uncaught exceptions, failed loads, `console.error`.
    pub fn errors(&mut self) -> Vec<String> {
        // Any call also receives the events that the browser has sent meanwhile.
        self.call("Runtime.evaluate", json!({ "expression": "0" }));
        for event in self.devtools.take_events() {
            let error = match event.method.as_str() {
                "Runtime.exceptionThrown" => Some(&event.params["exceptionDetails"]),
                "Runtime.consoleAPICalled" if event.params["type"] == "error" => Some(&event.params["args"]),
                "Log.entryAdded" if event.params["entry"]["level"] == "error" => Some(&event.params["entry"]),
                _ => None,
            };
            self.errors.extend(error.map(Value::to_string));
        }
        self.errors.clone()
    }

    #[track_caller]
    fn call(&mut self, method: &str, params: Value) -> Value {
        self.devtools.call(Some(&self.session), method, params)
    }

    fn try_call(&mut self, method: &str, params: Value) -> Result<Value, String> {
        self.devtools.try_call(Some(&self.session), method, params)
    }
}

impl Drop for Page {
    /// After a failed test, saves a screenshot and prints the controls.
    fn drop(&mut self) {
        if !std::thread::panicking() {
            return;
        }
        let test =
            std::thread::current().name().unwrap_or("test").rsplit("::").next().unwrap_or("test").to_owned();
        // A page that another one hides draws nothing, and would give no picture for ever.
        drop(self.try_call("Page.bringToFront", json!({})));
        match self.try_call("Page.captureScreenshot", json!({ "format": "png" })) {
            Ok(answer) => {
                match Picture::from_base64(answer["data"].as_str().unwrap_or_default(), self.size[0]) {
                    Some(picture) => {
                        println!("the page as it was: {}", picture.save(&format!("failed-{test}")).display())
                    }
                    None => println!("the page gave no picture"),
                }
            }
            Err(error) => println!("the page gave no picture: {error}"),
        }
        for role in ["button", "status", "alert"] {
            for (name, control) in self.all(role) {
                let text = self.text(&control).unwrap_or_default();
                println!("  {role} “{name}”{} {text}", if control.disabled { " (disabled)" } else { "" });
            }
        }
    }
}
