//! The field for the name of an object of the site, with a button that gives it.

use crate::TextInput;
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::icon;
use egui::Ui;
use site_model::ObjectId;

/// Longest name of an object of the site, characters: what fits a row of a list on a desktop.
pub(crate) const MAX_NAME_CHARS: u32 = 80;

/// Longest paragraph about an object of the site, characters: a work order of half a page.
const MAX_PARAGRAPH_CHARS: u32 = 2_000;
/// Lines of a paragraph that are visible at once.
const PARAGRAPH_ROWS: u8 = 3;

/// What a field takes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A line, which is not empty.
    Name,
    /// A line, which may be emptied.
    Line,
    /// Several lines, which may be emptied.
    Paragraph,
}

/// What the field keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct NameField {
    typed: Option<Typed>,
}

/// The name that is typed.
#[derive(Debug)]
struct Typed {
    /// For which object.
    of: ObjectId,
    /// The object's name when it was typed.
    present: String,
    text: String,
}

/// Texts of a field.
pub(crate) struct NameFieldTexts {
    /// Name of the field.
    pub(crate) field: &'static str,
    /// Name of the button.
    pub(crate) rename: &'static str,
    /// Text of the button.
    pub(crate) rename_short: &'static str,
}

impl NameField {
    /// Shows the field of an object with its present name. Returns the new name once it is given.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        texts: &NameFieldTexts,
        id: ObjectId,
        present: &str,
    ) -> Option<String> {
        self.show_field(ui, cx, texts, (id, present), Kind::Name)
    }

    /// The same for a text that may be emptied.
    pub(crate) fn show_line(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        texts: &NameFieldTexts,
        id: ObjectId,
        present: &str,
    ) -> Option<String> {
        self.show_field(ui, cx, texts, (id, present), Kind::Line)
    }

    /// The same for a text of several lines, which may be emptied.
    pub(crate) fn show_paragraph(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        texts: &NameFieldTexts,
        id: ObjectId,
        present: &str,
    ) -> Option<String> {
        self.show_field(ui, cx, texts, (id, present), Kind::Paragraph)
    }

    fn show_field(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        texts: &NameFieldTexts,
        (id, present): (ObjectId, &str),
        kind: Kind,
    ) -> Option<String> {
        // A name that somebody else gives, or another button, is shown, unless another one is being typed.
        let is_stale =
            |typed: &Typed| typed.of != id || typed.present != present && typed.text == typed.present;
        if self.typed.as_ref().is_none_or(is_stale) {
            self.typed = Some(Typed { of: id, present: present.to_owned(), text: present.to_owned() });
        }
        let typed = &mut self.typed.as_mut()?.text;
        let field = TextInput::new((texts.field, id), texts.field);
        let field = match kind {
            Kind::Name | Kind::Line => field.max_length(MAX_NAME_CHARS),
            Kind::Paragraph => field.paragraph(PARAGRAPH_ROWS).max_length(MAX_PARAGRAPH_CHARS),
        };
        let mut is_given = field.show(ui, cx.tokens, cx.text_inputs, typed).submitted;
        let name = typed.trim().to_owned();
        let is_new = (kind != Kind::Name || !name.is_empty()) && name != present;
        if is_new {
            let button = Button::new(texts.rename).text(texts.rename_short).icon(icon::PENCIL_SIMPLE);
            is_given |= button.wide(ui).show(ui, cx.tokens).clicked();
        }
        (is_given && is_new).then(|| {
            self.typed = None;
            name
        })
    }
}
