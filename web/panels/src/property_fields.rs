//! The fields for further properties of an object: a field for the value of each, and one for a new one.

use crate::TextInput;
use crate::feature_panel::PanelContext;
use crate::select::show_caption;
use crate::texts;
use egui::Ui;
use site_model::ObjectId;
use std::collections::BTreeMap;

/// Longest name with its value, characters. Chosen: a sentence.
const MAX_CHARS: u32 = 160;

/// What the fields keep between frames.
#[derive(Debug, Default)]
pub(crate) struct PropertyFields {
    /// The text that is typed: of this object, for this property; none: for a new one.
    typed: Option<(ObjectId, Option<String>, String)>,
}

impl PropertyFields {
    /// Shows the properties of an object. Returns other ones once a field with another text is left. A property whose value is emptied goes.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        object: ObjectId,
        properties: &BTreeMap<String, String>,
    ) -> Option<BTreeMap<String, String>> {
        let mut changed = None;
        for (name, value) in properties {
            if let Some(text) = self.show_field(ui, cx, object, Some(name), value) {
                let mut all = properties.clone();
                match text.trim() {
                    "" => all.remove(name),
                    text => all.insert(name.clone(), text.to_owned()),
                };
                changed = Some(all);
            }
        }
        if let Some((name, value)) = self.show_field(ui, cx, object, None, "").as_deref().and_then(parse) {
            let mut all = properties.clone();
            all.insert(name, value);
            changed = Some(all);
        }
        changed.filter(|changed| changed != properties)
    }

    /// One field. Returns its text once it is left with another one.
    fn show_field(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        object: ObjectId,
        property: Option<&String>,
        present: &str,
    ) -> Option<String> {
        let is_typed = |(of, name, _): &mut (ObjectId, Option<String>, String)| {
            *of == object && name.as_ref() == property
        };
        let mut text = self.typed.take_if(is_typed).map_or_else(|| present.to_owned(), |(.., text)| text);
        let caption = property.map_or(texts::NEW_PROPERTY, String::as_str);
        show_caption(ui, cx.tokens, caption);
        let hint = if property.is_some() { texts::PROPERTY_VALUE_HINT } else { texts::NEW_PROPERTY_HINT };
        let input = TextInput::new(("property", object, property), caption).hint(hint);
        let response = input.max_length(MAX_CHARS).show(ui, cx.tokens, cx.text_inputs, &mut text);
        if response.lost_focus || response.submitted {
            return Some(text).filter(|text| text != present);
        }
        if text != present {
            self.typed = Some((object, property.cloned(), text));
        }
        None
    }
}

/// Name and value of `name: value`; none without a name or a value.
fn parse(text: &str) -> Option<(String, String)> {
    let (name, value) = text.split_once(':')?;
    let (name, value) = (name.trim(), value.trim());
    (!name.is_empty() && !value.is_empty()).then(|| (name.to_owned(), value.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn a_new_property_has_a_name_and_a_value_with_a_colon_between_them() {
        let property = |name: &str, value: &str| Some((name.to_owned(), value.to_owned()));
        assert_eq!(parse(" owner : maintenance: north "), property("owner", "maintenance: north"));
        for text in ["", "owner", ":", "owner:", ": north"] {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
