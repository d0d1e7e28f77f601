//! The browser's dialogue for files.

use crate::browser;
use gloo_events::EventListener;
use wasm_bindgen::JsCast;
use web_sys::{File, HtmlInputElement};

/// A dialogue, with the input of the page that opens it.
pub(crate) struct FileDialog {
    /// Id of the input.
    id: &'static str,
    /// File types that the dialogue offers first.
    file_types: &'static str,
    input: Option<HtmlInputElement>,
}

impl FileDialog {
    pub(crate) fn new(id: &'static str, file_types: &'static str) -> Self {
        Self { id, file_types, input: None }
    }

    /// Opens it. `on_file` of the first call gets each chosen file.
    pub(crate) fn open(&mut self, on_file: impl Fn(File) + 'static) {
        if self.input.is_none() {
            self.input = self.create_input(on_file);
        }
        match &self.input {
            Some(input) => {
                // Otherwise the browser reports no change when the same file is chosen again.
                input.set_value("");
                input.click();
            }
            None => browser::log_warning("the page has no input for files"),
        }
    }

    fn create_input(&self, on_file: impl Fn(File) + 'static) -> Option<HtmlInputElement> {
        let input: HtmlInputElement = browser::create("input")?.dyn_into().ok()?;
        input.set_type("file");
        input.set_id(self.id);
        input.set_accept(self.file_types);
        input.set_hidden(true);
        let source = input.clone();
        let on_change = move |_: &web_sys::Event| {
            if let Some(file) = source.files().and_then(|files| files.get(0)) {
                on_file(file);
            }
        };
        browser::document()?.body()?.append_child(&input).ok()?;
        // The input exists as long as the page.
        EventListener::new(&input, "change", on_change).forget();
        Some(input)
    }
}
