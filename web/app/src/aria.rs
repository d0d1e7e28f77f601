//! The mirror: every control that egui draws, as an ARIA element laid over the canvas in `<div id="aria">`.
//!
//! egui describes each frame as an AccessKit tree; a plugin hands it over as it leaves. The elements have the role,
//! name, value, state and place of what is drawn; the pointer goes through them to the canvas. A click from assistive
//! technology (or `element.click()`) goes back to egui as an AccessKit action.

use crate::browser;
use egui::accesskit::{Action, ActionRequest, Node, NodeId, Role, Toggled, TreeId, TreeUpdate};
use std::cell::RefCell;
use std::collections::BTreeMap;
use wasm_bindgen::JsCast;
use wasm_bindgen::prelude::Closure;
use web_sys::HtmlElement;

thread_local! {
    /// DOM elements cannot be part of the plugin, which egui wants to be able to send between threads.
    static MIRROR: RefCell<Mirror> = RefCell::default();
}

/// Turns accessibility on and mirrors it from now on.
pub(crate) fn install(ctx: &egui::Context) {
    ctx.enable_accesskit();
    ctx.add_plugin(AriaPlugin);
    MIRROR.with_borrow_mut(|mirror| mirror.listen(ctx));
}

struct AriaPlugin;

impl egui::Plugin for AriaPlugin {
    fn debug_name(&self) -> &'static str {
        "ARIA mirror"
    }

    fn input_hook(&mut self, _ctx: &egui::Context, input: &mut egui::RawInput) {
        let requests = MIRROR.with_borrow_mut(|mirror| std::mem::take(&mut mirror.requests));
        input.events.extend(requests.into_iter().map(egui::Event::AccessKitActionRequest));
    }

    fn output_hook(&mut self, _ctx: &egui::Context, output: &mut egui::FullOutput) {
        if let Some(update) = output.platform_output.accesskit_update.take() {
            MIRROR.with_borrow_mut(|mirror| mirror.update(&update));
        }
    }
}

#[derive(Default)]
struct Mirror {
    root: Option<HtmlElement>,
    shown: BTreeMap<NodeId, Shown>,
    order: Vec<NodeId>,
    requests: Vec<ActionRequest>,
}

/// An element and what it says.
struct Shown {
    element: HtmlElement,
    said: AriaAttributes,
}

/// Everything an element says; set again only when it differs.
#[derive(Clone, Debug, Default, PartialEq)]
struct AriaAttributes {
    role: &'static str,
    name: String,
    text: String,
    place: String,
    pressed: Option<bool>,
    disabled: bool,
    range: Option<[String; 3]>,
}

impl Mirror {
    /// Clicks and keys on elements become actions.
    fn listen(&mut self, ctx: &egui::Context) {
        self.root = browser::element("aria");
        let Some(root) = &self.root else {
            browser::log_warning("the page has no element #aria: the client's controls are not accessible");
            return;
        };
        for event in ["click", "keydown"] {
            let ctx = ctx.clone();
            let listener = Closure::<dyn FnMut(web_sys::Event)>::new(move |event: web_sys::Event| {
                if let Some(request) = request_of(&event) {
                    event.prevent_default();
                    MIRROR.with_borrow_mut(|mirror| mirror.requests.push(request));
                    ctx.request_repaint();
                }
            });
            // Lives as long as the page: there is one mirror and it is never taken down.
            if root.add_event_listener_with_callback(event, listener.as_ref().unchecked_ref()).is_ok() {
                listener.forget();
            }
        }
    }

    /// Makes the elements say what the tree says.
    fn update(&mut self, update: &TreeUpdate) {
        let Some(root) = self.root.clone() else { return };
        let nodes: BTreeMap<NodeId, &Node> = update.nodes.iter().map(|(id, node)| (*id, node)).collect();
        let mut order = Vec::with_capacity(nodes.len());
        if let Some(tree) = &update.tree {
            collect(tree.root, &nodes, &mut order);
        }
        let wanted: Vec<(NodeId, AriaAttributes)> =
            order.iter().filter_map(|id| Some((*id, said(nodes.get(id)?, &nodes)?))).collect();
        let ids: Vec<NodeId> = wanted.iter().map(|(id, _)| *id).collect();
        let known: std::collections::BTreeSet<NodeId> = ids.iter().copied().collect();
        self.shown.retain(|id, shown| {
            let stays = known.contains(id);
            if !stays {
                shown.element.remove();
            }
            stays
        });
        for (id, said) in wanted {
            match self.shown.get_mut(&id) {
                Some(shown) => shown.say(said),
                None => {
                    if let Some(element) = browser::create("div") {
                        let _ = element.set_attribute("data-node", &id.0.to_string());
                        let mut shown = Shown { element, said: AriaAttributes::default() };
                        shown.say(said);
                        self.shown.insert(id, shown);
                    }
                }
            }
        }
        if ids != self.order {
            // Appending in order moves what is there already.
            for id in &ids {
                if let Some(shown) = self.shown.get(id) {
                    let _ = root.append_child(&shown.element);
                }
            }
            self.order = ids;
        }
    }
}

impl Shown {
    fn say(&mut self, said: AriaAttributes) {
        if said == self.said {
            return;
        }
        let element = &self.element;
        let set = |name: &str, value: Option<&str>| {
            // Names are constants of ours, so setting cannot fail.
            let _ = match value {
                Some(value) => element.set_attribute(name, value),
                None => element.remove_attribute(name),
            };
        };
        let old = &self.said;
        if said.role != old.role {
            set("role", Some(said.role));
            let focusable = matches!(said.role, "button" | "slider" | "textbox" | "checkbox");
            set("tabindex", focusable.then_some("0"));
            // Values change ten times a second; nobody wants to hear each of them.
            set("aria-live", (said.role == "status").then_some("off"));
        }
        if said.name != old.name {
            set("aria-label", (!said.name.is_empty()).then_some(&said.name));
        }
        if said.text != old.text {
            element.set_text_content(Some(&said.text));
        }
        if said.place != old.place {
            set("style", Some(&said.place));
        }
        if said.pressed != old.pressed {
            set("aria-pressed", said.pressed.map(|on| if on { "true" } else { "false" }));
        }
        if said.disabled != old.disabled {
            set("aria-disabled", said.disabled.then_some("true"));
        }
        if said.range != old.range {
            for (at, name) in ["aria-valuenow", "aria-valuemin", "aria-valuemax"].into_iter().enumerate() {
                set(name, said.range.as_ref().map(|range| range[at].as_str()));
            }
        }
        self.said = said;
    }
}

/// Ids in reading order, parents first.
fn collect(id: NodeId, nodes: &BTreeMap<NodeId, &Node>, order: &mut Vec<NodeId>) {
    if let Some(node) = nodes.get(&id) {
        order.push(id);
        for child in node.children() {
            collect(*child, nodes, order);
        }
    }
}

/// What the element of a node says; `None` for nodes that are only there to hold others.
fn said(node: &Node, nodes: &BTreeMap<NodeId, &Node>) -> Option<AriaAttributes> {
    let role = aria_role(node.role())?;
    let labelled = || {
        let names: Vec<&str> = node.labelled_by().iter().filter_map(|id| nodes.get(id)?.value()).collect();
        (!names.is_empty()).then(|| names.join(" "))
    };
    let name = node.label().map(str::to_owned).or_else(labelled).unwrap_or_default();
    let text = if role == "button" { name.clone() } else { plain(node.value().unwrap_or_default()) };
    if name.is_empty() && text.is_empty() {
        return None;
    }
    let bounds = node.bounds().unwrap_or_default();
    let place = format!(
        "position:absolute;left:{:.0}px;top:{:.0}px;width:{:.0}px;height:{:.0}px;overflow:hidden;opacity:0;pointer-events:none",
        bounds.x0,
        bounds.y0,
        bounds.width(),
        bounds.height(),
    );
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value}"));
    Some(AriaAttributes {
        role,
        name,
        text,
        place,
        pressed: node.toggled().map(|toggled| toggled == Toggled::True),
        disabled: node.is_disabled(),
        range: (role == "slider")
            .then(|| [node.numeric_value(), node.min_numeric_value(), node.max_numeric_value()].map(number)),
    })
}

/// Text without the signs of the icon font, which mean nothing when read aloud.
fn plain(text: &str) -> String {
    text.chars().filter(|c| !('\u{e000}'..='\u{f8ff}').contains(c)).collect::<String>().trim().to_owned()
}

fn aria_role(role: Role) -> Option<&'static str> {
    Some(match role {
        Role::Button => "button",
        Role::CheckBox => "checkbox",
        Role::Slider => "slider",
        Role::TextInput => "textbox",
        Role::Label => "text",
        Role::Heading => "heading",
        Role::Status => "status",
        Role::Alert => "alert",
        Role::Group => "group",
        Role::Canvas => "img",
        Role::ProgressIndicator => "progressbar",
        _ => return None,
    })
}

/// What a click or key on an element asks of egui.
fn request_of(event: &web_sys::Event) -> Option<ActionRequest> {
    let element: HtmlElement = event.target()?.dyn_into().ok()?;
    let id = element.get_attribute("data-node")?.parse().ok()?;
    let action = match event.dyn_ref::<web_sys::KeyboardEvent>() {
        None => Action::Click,
        Some(key) => match key.key().as_str() {
            "Enter" | " " => Action::Click,
            "ArrowRight" | "ArrowUp" => Action::Increment,
            "ArrowLeft" | "ArrowDown" => Action::Decrement,
            _ => return None,
        },
    };
    Some(ActionRequest { action, target_tree: TreeId::ROOT, target_node: NodeId(id), data: None })
}
