//! The bridge of text inputs: an `<input>` or `<textarea>` of the page lies over every text field that the panels request.
//!
//! On-screen keyboards, selection, copy and paste, autocorrection, password managers and screen readers work with elements of the page and
//! not with egui's controls. Each field has its own id, so there may be any number of them.

use crate::browser;
use egui::{Id, Rect};
use gloo_events::EventListener;
use panels::theme::Tokens;
use panels::{TextInputEvent, TextInputKind, TextInputRequest, TextInputs};
use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;
use wasm_bindgen::JsCast;
use web_sys::{HtmlElement, HtmlInputElement, HtmlTextAreaElement, KeyboardEvent, WheelEvent};

/// The text inputs of the page, by the id of their field.
pub(crate) struct TextInputElements {
    ctx: egui::Context,
    elements: HashMap<Id, TextInputElement>,
    wheel: WheelQueue,
}

/// Turns of the wheel over elements since the last frame, for the cards below them.
type WheelQueue = Rc<RefCell<Vec<egui::Event>>>;

/// Events of one element since the last frame, oldest first.
type EventQueue = Rc<RefCell<Vec<TextInputEvent>>>;

struct TextInputElement {
    field: Field,
    kind: TextInputKind,
    events: EventQueue,
    /// The element's present attributes; only those that differ from the request are set.
    shown: Option<ShownTextInput>,
    _listeners: Vec<EventListener>,
}

#[derive(PartialEq)]
struct ShownTextInput {
    request: TextInputRequest,
    style: String,
}

impl Drop for TextInputElement {
    fn drop(&mut self) {
        self.field.element().remove();
    }
}

/// The two elements that edit text.
#[derive(Clone)]
enum Field {
    Line(HtmlInputElement),
    Paragraph(HtmlTextAreaElement),
}

impl Field {
    fn create(kind: TextInputKind) -> Option<Self> {
        let input_type = match kind {
            TextInputKind::Paragraph => {
                return Some(Self::Paragraph(browser::create("textarea")?.dyn_into().ok()?));
            }
            TextInputKind::Line => "text",
            TextInputKind::Search => "search",
            TextInputKind::Password => "password",
            TextInputKind::Number => "text",
        };
        let input: HtmlInputElement = browser::create("input")?.dyn_into().ok()?;
        input.set_type(input_type);
        if kind == TextInputKind::Number {
            // A numeric keyboard, without the rules of `type=number`, which hides what it cannot parse.
            input.set_attribute("inputmode", "decimal").ok()?;
        }
        Some(Self::Line(input))
    }

    fn element(&self) -> &HtmlElement {
        match self {
            Self::Line(input) => input,
            Self::Paragraph(area) => area,
        }
    }

    fn value(&self) -> String {
        match self {
            Self::Line(input) => input.value(),
            Self::Paragraph(area) => area.value(),
        }
    }

    fn set_value(&self, value: &str) {
        match self {
            Self::Line(input) => input.set_value(value),
            Self::Paragraph(area) => area.set_value(value),
        }
    }

    /// Whether it has more text than it shows.
    fn scrolls(&self) -> bool {
        let element = self.element();
        element.scroll_height() > element.client_height()
    }

    fn set_disabled(&self, disabled: bool) {
        match self {
            Self::Line(input) => input.set_disabled(disabled),
            Self::Paragraph(area) => area.set_disabled(disabled),
        }
    }
}

impl TextInputElements {
    /// Every event of an element requests a frame of `ctx`.
    pub(crate) fn new(ctx: egui::Context) -> Self {
        Self { ctx, elements: HashMap::new(), wheel: WheelQueue::default() }
    }

    /// Passes the events since the last frame to the panels.
    pub(crate) fn take_events(&self, inputs: &mut TextInputs) {
        for (id, element) in &self.elements {
            for event in element.events.take() {
                inputs.push_event(*id, event);
            }
        }
    }

    /// Passes the turns of the wheel since the last frame to egui, which does not see them: elements take them, and the pointer over an element is not over the canvas.
    pub(crate) fn pass_wheel(&self, input: &mut egui::RawInput) {
        input.events.append(&mut self.wheel.borrow_mut());
    }

    /// Creates, places and removes elements as the panels request them.
    pub(crate) fn update(&mut self, inputs: &TextInputs, tokens: &Tokens) {
        let requests = inputs.requests();
        self.elements.retain(|id, element| {
            requests.iter().any(|request| request.id == *id && request.kind == element.kind)
        });
        for request in requests {
            if !self.elements.contains_key(&request.id)
                && let Some(element) = TextInputElement::create(&self.ctx, &self.wheel, request)
            {
                self.elements.insert(request.id, element);
            }
            if let Some(element) = self.elements.get_mut(&request.id) {
                element.update(request, tokens);
            }
        }
    }
}

impl TextInputElement {
    fn create(ctx: &egui::Context, wheel: &WheelQueue, request: &TextInputRequest) -> Option<Self> {
        let field = Field::create(request.kind)?;
        let events = EventQueue::default();
        let push = {
            let (events, ctx) = (Rc::clone(&events), ctx.clone());
            move |event: TextInputEvent| {
                events.borrow_mut().push(event);
                ctx.request_repaint();
            }
        };
        let on_input = {
            let (push, field) = (push.clone(), field.clone());
            move |_: &web_sys::Event| push(TextInputEvent::Changed(field.value()))
        };
        let multiline = request.kind == TextInputKind::Paragraph;
        let on_key = {
            let (push, field) = (push.clone(), field.clone());
            move |event: &web_sys::Event| {
                // Shortcuts of the client must not react to text.
                event.stop_propagation();
                let Some(key) = event.dyn_ref::<KeyboardEvent>() else { return };
                // Enter also confirms a word of an input method; it does not submit then.
                match key.key().as_str() {
                    "Enter" if !multiline && !key.is_composing() => push(TextInputEvent::Submitted),
                    // Fails only for an element that was removed.
                    "Escape" => drop(field.element().blur()),
                    _ => {}
                }
            }
        };
        let on_focus = {
            let push = push.clone();
            move |_: &web_sys::Event| push(TextInputEvent::FocusGained)
        };
        let on_blur = move |_: &web_sys::Event| push(TextInputEvent::FocusLost);
        let on_wheel = {
            let (wheel, ctx, field) = (Rc::clone(wheel), ctx.clone(), field.clone());
            move |event: &web_sys::Event| {
                // More text than the element shows is scrolled by the browser.
                if let Some(event) = event.dyn_ref::<WheelEvent>()
                    && !field.scrolls()
                {
                    wheel.borrow_mut().extend(wheel_events(event, &ctx));
                    ctx.request_repaint();
                }
            }
        };
        let element = field.element();
        browser::document()?.body()?.append_child(element).ok()?;
        let listeners = vec![
            EventListener::new(element, "input", on_input),
            EventListener::new(element, "keydown", on_key),
            EventListener::new(element, "focus", on_focus),
            EventListener::new(element, "blur", on_blur),
            EventListener::new(element, "wheel", on_wheel),
        ];
        Some(Self { field, kind: request.kind, events, shown: None, _listeners: listeners })
    }

    fn update(&mut self, request: &TextInputRequest, tokens: &Tokens) {
        // A change that is still on its way to the panels is newer than their value.
        if self.events.borrow().is_empty() && self.field.value() != request.value {
            self.field.set_value(&request.value);
        }
        let style = style(request, tokens);
        let shown = ShownTextInput { request: request.clone(), style };
        if self.shown.as_ref() == Some(&shown) {
            return;
        }
        let element = self.field.element();
        let max_length = request.max_length.to_string();
        let attributes = [
            ("aria-label", request.name.as_str()),
            ("name", request.name.as_str()),
            ("placeholder", request.hint.as_str()),
            ("autocomplete", request.autocomplete),
            ("maxlength", max_length.as_str()),
            ("style", shown.style.as_str()),
        ];
        for (name, value) in attributes {
            // The names are valid, so this cannot fail.
            let _ = element.set_attribute(name, value);
        }
        self.field.set_disabled(!request.enabled);
        if request.take_focus && self.shown.as_ref().is_none_or(|before| !before.request.take_focus) {
            // Fails only for an element that was removed.
            let _ = element.focus();
        }
        self.shown = Some(shown);
    }
}

/// A turn of the wheel as egui understands it, with the place of the pointer. A zoom of the page is none.
fn wheel_events(event: &WheelEvent, ctx: &egui::Context) -> Vec<egui::Event> {
    if event.ctrl_key() {
        return Vec::new();
    }
    let unit = match event.delta_mode() {
        WheelEvent::DOM_DELTA_LINE => egui::MouseWheelUnit::Line,
        WheelEvent::DOM_DELTA_PAGE => egui::MouseWheelUnit::Page,
        _ => egui::MouseWheelUnit::Point,
    };
    let place = egui::pos2(event.client_x() as f32, event.client_y() as f32) / ctx.zoom_factor();
    let turn = egui::Event::MouseWheel {
        unit,
        delta: -egui::vec2(event.delta_x() as f32, event.delta_y() as f32),
        modifiers: egui::Modifiers::default(),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Unknown,
    };
    vec![egui::Event::PointerMoved(place), turn]
}

fn style(request: &TextInputRequest, tokens: &Tokens) -> String {
    let css = |colour: egui::Color32| format!("rgb({} {} {})", colour.r(), colour.g(), colour.b());
    let rect = request.rect;
    let [top, right, bottom, left] = clipped_px(rect, request.clip_rect);
    // 16 px: with a smaller font, phones zoom into the page when the input gets the focus.
    format!(
        "position:fixed;left:{}px;top:{}px;width:{}px;height:{}px;box-sizing:border-box;margin:0;padding:{}px 12px;\
         font:400 16px Inter,system-ui,sans-serif;color:{};caret-color:{};background:transparent;resize:none;\
         border:{}px solid {};border-radius:8px;outline-color:{};clip-path:inset({top}px {right}px {bottom}px {left}px)",
        rect.left(),
        rect.top(),
        rect.width(),
        rect.height(),
        if request.kind == TextInputKind::Paragraph { 8 } else { 0 },
        css(tokens.text),
        css(tokens.accent),
        tokens.line_width,
        css(tokens.line),
        css(tokens.accent),
    )
}

/// Widths of the strips of `rect` outside `clip`: top, right, bottom, left. Negative where the clip leaves room, so that the focus outline
/// shows.
fn clipped_px(rect: Rect, clip: Rect) -> [f32; 4] {
    let outline_px = -4.0;
    [
        (clip.top() - rect.top()).max(outline_px),
        (rect.right() - clip.right()).max(outline_px),
        (rect.bottom() - clip.bottom()).max(outline_px),
        (clip.left() - rect.left()).max(outline_px),
    ]
}
