//! Text inputs on a page: any number of fields, each with its own text and events.

use crate::theme::Tokens;
use crate::{TextInput, TextInputEvent, TextInputKind, TextInputResponse, TextInputs};
use client_model::Theme;

/// Two fields and what they report.
#[derive(Default)]
struct Form {
    inputs: TextInputs,
    name: String,
    notes: String,
    responses: [TextInputResponse; 2],
}

impl Form {
    fn on_page() -> Self {
        Self { inputs: TextInputs::new(true), ..Self::default() }
    }

    fn run(&mut self, ctx: &egui::Context) {
        let tokens = Tokens::of(Theme::Dark);
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(800.0, 600.0))),
            ..egui::RawInput::default()
        };
        self.inputs.begin_frame();
        let mut output = ctx.run_ui(input, |ui| {
            let name = TextInput::new("name", "Mission name").hint("Night round");
            let notes = TextInput::new("notes", "Notes").paragraph(4).max_length(2000);
            self.responses = [
                name.show(ui, &tokens, &mut self.inputs, &mut self.name),
                notes.show(ui, &tokens, &mut self.inputs, &mut self.notes),
            ];
        });
        output.textures_delta.clear();
        self.inputs.end_frame();
    }
}

#[test]
fn every_field_requests_an_input_of_its_own() {
    let ctx = egui::Context::default();
    let mut form = Form::on_page();
    form.name = "Round".to_owned();
    form.run(&ctx);
    let [name, notes] = form.inputs.requests() else { panic!("{:?}", form.inputs.requests()) };
    assert_ne!(name.id, notes.id);
    assert_eq!(
        (name.name.as_str(), name.value.as_str(), name.kind),
        ("Mission name", "Round", TextInputKind::Line)
    );
    assert_eq!((notes.kind, notes.max_length), (TextInputKind::Paragraph, 2000));
    assert!(!name.rect.intersects(notes.rect) && notes.rect.height() > name.rect.height());
}

#[test]
fn events_reach_their_field_only_and_once() {
    let ctx = egui::Context::default();
    let mut form = Form::on_page();
    form.run(&ctx);
    let [name, notes] = [0, 1].map(|index: usize| form.inputs.requests()[index].id);
    form.inputs.push_event(notes, TextInputEvent::Changed("Mind the step".to_owned()));
    form.inputs.push_event(name, TextInputEvent::Submitted);
    form.run(&ctx);
    assert_eq!((form.name.as_str(), form.notes.as_str()), ("", "Mind the step"));
    assert!(form.responses[0].submitted && !form.responses[0].changed);
    assert!(form.responses[1].changed && !form.responses[1].submitted);
    form.run(&ctx);
    assert_eq!(form.responses, [TextInputResponse::default(); 2]);
    assert_eq!(form.inputs.requests()[1].value, "Mind the step");
}

#[test]
fn without_a_page_egui_draws_the_field() {
    let ctx = egui::Context::default();
    let mut form = Form::default();
    form.run(&ctx);
    assert!(form.inputs.requests().is_empty());
}
