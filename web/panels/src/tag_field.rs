//! The field for the tags of an object: words by which people find it, with commas between them.

use crate::TextInput;
use crate::feature_panel::PanelContext;
use crate::select::show_caption;
use crate::texts;
use client_model::tags_of;
use egui::Ui;
use site_model::ObjectId;
use std::collections::BTreeSet;

/// Longest text of all tags, characters. Chosen: a dozen words.
const MAX_CHARS: u32 = 160;

/// What the field keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct TagField {
    /// The text that is typed, of this object.
    typed: Option<(ObjectId, String)>,
}

impl TagField {
    /// Shows the tags of an object. Returns other ones once they are typed and the field is left.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        object: ObjectId,
        tags: &BTreeSet<String>,
    ) -> Option<BTreeSet<String>> {
        let present = tags.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        let of_object = self.typed.take().filter(|(of, _)| *of == object);
        let mut text = of_object.map_or_else(|| present.clone(), |(_, text)| text);
        show_caption(ui, cx.tokens, texts::TAGS);
        let input = TextInput::new(("tags", object), texts::TAGS).hint(texts::TAGS_HINT);
        let response = input.max_length(MAX_CHARS).show(ui, cx.tokens, cx.text_inputs, &mut text);
        if response.lost_focus || response.submitted {
            return Some(tags_of(&text)).filter(|given| given != tags);
        }
        self.typed = Some((object, text)).filter(|(_, text)| *text != present);
        None
    }
}
