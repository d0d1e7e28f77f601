//! The ARIA mirror: every control that egui draws is mirrored as an ARIA element over the canvas, in `<div id="aria">`.
//!
//! egui describes each frame as an AccessKit tree, which a plugin takes from its output. The elements have the role, name, value, state and
//! position of the controls. They do not take pointer events, so the canvas gets them. A click by assistive technology (or `element.click()`) goes back
//! to egui as an AccessKit action. Text inputs are elements of the page themselves; see `text_inputs.rs`.

use crate::browser;
use egui::accesskit::{Action, ActionRequest, Node, NodeId, Role, Toggled, TreeId, TreeUpdate};
use gloo_events::{EventListener, EventListenerOptions};
use std::cell::RefCell;
use std::collections::BTreeMap;
use wasm_bindgen::JsCast;
use web_sys::HtmlElement;

thread_local! {
    /// The mirror is not a part of the plugin, because egui requires plugins to be `Send` and DOM elements are not.
    static MIRROR: RefCell<Mirror> = RefCell::default();
}

/// Turns accessibility on and mirrors every frame from now on.
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
    elements: BTreeMap<NodeId, MirroredElement>,
    order: Vec<NodeId>,
    requests: Vec<ActionRequest>,
}

/// An element and its attributes.
struct MirroredElement {
    element: HtmlElement,
    attributes: AriaAttributes,
}

/// Attributes of an element; only those that changed are set.
#[derive(Clone, Debug, Default, PartialEq)]
struct AriaAttributes {
    role: &'static str,
    name: String,
    text: String,
    style: String,
    pressed: Option<bool>,
    disabled: bool,
    range: Option<[String; 3]>,
}

impl Mirror {
    /// Turns clicks and keys on elements into actions.
    fn listen(&mut self, ctx: &egui::Context) {
        self.root = browser::element("aria");
        let Some(root) = &self.root else {
            browser::log_warning("the page has no element #aria: the client's controls are not accessible");
            return;
        };
        for event in ["click", "keydown"] {
            let ctx = ctx.clone();
            let options = EventListenerOptions::enable_prevent_default();
            let listener = EventListener::new_with_options(root, event, options, move |event| {
                if let Some(request) = request_of(event) {
                    event.prevent_default();
                    MIRROR.with_borrow_mut(|mirror| mirror.requests.push(request));
                    ctx.request_repaint();
                }
            });
            // The mirror lives as long as the page.
            listener.forget();
        }
    }

    /// Creates, changes and removes elements so that they equal the tree.
    fn update(&mut self, update: &TreeUpdate) {
        let Some(root) = self.root.clone() else { return };
        let nodes: BTreeMap<NodeId, &Node> = update.nodes.iter().map(|(id, node)| (*id, node)).collect();
        let mut order = Vec::with_capacity(nodes.len());
        if let Some(tree) = &update.tree {
            collect(tree.root, &nodes, &mut order);
        }
        let wanted: Vec<(NodeId, AriaAttributes)> =
            order.iter().filter_map(|id| Some((*id, attributes_of(nodes.get(id)?, &nodes)?))).collect();
        let ids: Vec<NodeId> = wanted.iter().map(|(id, _)| *id).collect();
        let present: std::collections::BTreeSet<NodeId> = ids.iter().copied().collect();
        self.elements.retain(|id, mirrored| {
            let stays = present.contains(id);
            if !stays {
                mirrored.element.remove();
            }
            stays
        });
        for (id, attributes) in wanted {
            match self.elements.get_mut(&id) {
                Some(mirrored) => mirrored.set(attributes),
                None => {
                    if let Some(element) = browser::create("div") {
                        let _ = element.set_attribute("data-node", &id.0.to_string());
                        let mut mirrored = MirroredElement { element, attributes: AriaAttributes::default() };
                        mirrored.set(attributes);
                        self.elements.insert(id, mirrored);
                    }
                }
            }
        }
        if ids != self.order {
            // Appending in order moves the elements that exist.
            for id in &ids {
                if let Some(mirrored) = self.elements.get(id) {
                    let _ = root.append_child(&mirrored.element);
                }
            }
            self.order = ids;
        }
    }
}

impl MirroredElement {
    fn set(&mut self, attributes: AriaAttributes) {
        if attributes == self.attributes {
            return;
        }
        let element = &self.element;
        let set = |name: &str, value: Option<&str>| {
            // The names are valid, so this cannot fail.
            let _ = match value {
                Some(value) => element.set_attribute(name, value),
                None => element.remove_attribute(name),
            };
        };
        let old = &self.attributes;
        if attributes.role != old.role {
            set("role", Some(attributes.role));
            let focusable = matches!(attributes.role, "button" | "slider" | "textbox" | "checkbox");
            set("tabindex", focusable.then_some("0"));
            // Values change at 10 Hz; a screen reader must not announce each of them.
            set("aria-live", (attributes.role == "status").then_some("off"));
        }
        if attributes.name != old.name {
            set("aria-label", (!attributes.name.is_empty()).then_some(&attributes.name));
        }
        if attributes.text != old.text {
            element.set_text_content(Some(&attributes.text));
        }
        if attributes.style != old.style {
            set("style", Some(&attributes.style));
        }
        if attributes.pressed != old.pressed {
            set("aria-pressed", attributes.pressed.map(|on| if on { "true" } else { "false" }));
        }
        if attributes.disabled != old.disabled {
            set("aria-disabled", attributes.disabled.then_some("true"));
        }
        if attributes.range != old.range {
            for (at, name) in ["aria-valuenow", "aria-valuemin", "aria-valuemax"].into_iter().enumerate() {
                set(name, attributes.range.as_ref().map(|range| range[at].as_str()));
            }
        }
        self.attributes = attributes;
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

/// Attributes of a node's element; `None` for nodes that only group others.
fn attributes_of(node: &Node, nodes: &BTreeMap<NodeId, &Node>) -> Option<AriaAttributes> {
    let role = aria_role(node.role())?;
    let labelled = || {
        let names: Vec<&str> = node.labelled_by().iter().filter_map(|id| nodes.get(id)?.value()).collect();
        (!names.is_empty()).then(|| names.join(" "))
    };
    let name = node.label().map(str::to_owned).or_else(labelled).unwrap_or_default();
    let text = if role == "button" { name.clone() } else { without_icons(node.value().unwrap_or_default()) };
    if name.is_empty() && text.is_empty() {
        return None;
    }
    let bounds = node.bounds().unwrap_or_default();
    let style = format!(
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
        style,
        pressed: node.toggled().map(|toggled| toggled == Toggled::True),
        disabled: node.is_disabled(),
        range: (role == "slider")
            .then(|| [node.numeric_value(), node.min_numeric_value(), node.max_numeric_value()].map(number)),
    })
}

/// Text without the characters of the icon font, which cannot be read aloud.
fn without_icons(text: &str) -> String {
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

/// The action that a click or key on an element requests of egui.
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
