//! Real inputs of the page over the holes that the panels leave: touch keyboards, autocorrection and screen readers
//! know them better than anything drawn.

use crate::browser;
use panels::theme::Tokens;
use panels::{PanelState, TextField};
use std::cell::Cell;
use std::rc::Rc;
use wasm_bindgen::JsCast;
use wasm_bindgen::prelude::Closure;
use web_sys::{HtmlElement, HtmlInputElement};

/// The inputs of the page. At most one is shown: the map's name.
pub(crate) struct Inputs {
    ctx: egui::Context,
    shown: Option<Shown>,
}

struct Shown {
    field: TextField,
    input: HtmlInputElement,
    changed: Rc<Cell<bool>>,
    style: String,
    _listener: Closure<dyn FnMut()>,
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.input.remove();
    }
}

impl Inputs {
    pub(crate) fn new(ctx: egui::Context) -> Self {
        Self { ctx, shown: None }
    }

    /// Takes what was typed since the last frame.
    pub(crate) fn read(&self, panels: &mut PanelState) {
        if let Some(shown) = &self.shown
            && shown.changed.take()
        {
            panels.map_name = shown.input.value();
        }
    }

    /// Puts the inputs where the panels want them, and takes away those they no longer want.
    pub(crate) fn lay(&mut self, panels: &PanelState, tokens: &Tokens) {
        let Some(field) = panels.text_fields.first() else {
            self.shown = None;
            return;
        };
        if self.shown.as_ref().is_none_or(|shown| shown.field.name != field.name) {
            self.shown = Shown::create(&self.ctx, field);
        }
        if let Some(shown) = &mut self.shown {
            shown.place(field, tokens);
            if shown.input.value() != panels.map_name && !shown.changed.get() {
                shown.input.set_value(&panels.map_name);
            }
        }
    }
}

impl Shown {
    fn create(ctx: &egui::Context, field: &TextField) -> Option<Self> {
        let input: HtmlInputElement = browser::create("input")?.dyn_into().ok()?;
        input.set_type("text");
        for (name, value) in [("aria-label", field.name), ("autocomplete", "off"), ("maxlength", "80")] {
            input.set_attribute(name, value).ok()?;
        }
        let changed = Rc::new(Cell::new(false));
        let listener = {
            let (changed, ctx) = (Rc::clone(&changed), ctx.clone());
            Closure::<dyn FnMut()>::new(move || {
                changed.set(true);
                ctx.request_repaint();
            })
        };
        input.add_event_listener_with_callback("input", listener.as_ref().unchecked_ref()).ok()?;
        browser::document()?.body()?.append_child(&input).ok()?;
        Some(Self { field: field.clone(), input, changed, style: String::new(), _listener: listener })
    }

    fn place(&mut self, field: &TextField, tokens: &Tokens) {
        if self.field.hint != field.hint || self.input.placeholder().is_empty() {
            self.input.set_placeholder(&field.hint);
        }
        self.field = field.clone();
        let css = |colour: egui::Color32| format!("rgb({} {} {})", colour.r(), colour.g(), colour.b());
        let rect = field.rect;
        // 16 px: below that, phones zoom into the page when the input gets the focus.
        let style = format!(
            "position:fixed;left:{}px;top:{}px;width:{}px;height:{}px;box-sizing:border-box;margin:0;padding:0 12px;\
             font:400 16px Inter,system-ui,sans-serif;color:{};caret-color:{};background:transparent;\
             border:{}px solid {};border-radius:8px;outline-color:{}",
            rect.left(),
            rect.top(),
            rect.width(),
            rect.height(),
            css(tokens.text),
            css(tokens.accent),
            tokens.line_width,
            css(tokens.line),
            css(tokens.accent),
        );
        if style != self.style {
            let element: &HtmlElement = &self.input;
            element.style().set_css_text(&style);
            self.style = style;
        }
    }
}
