//! Edits of the view: kept, merged, undone.

use crate::testing::*;
use crate::*;

#[test]
fn edits_of_the_view_are_kept_undone_and_merged_while_a_slider_is_dragged() {
    let mut client = TestClient::connected();
    client.now = client.now.after(10.0);
    for step in 0..10_u8 {
        client.now = client.now.after(0.05);
        let settings = ViewSettings { ceiling_m: f32::from(step), ..ViewSettings::default() };
        client.command(ClientCommand::EditView(settings));
    }
    assert!(
        matches!(client.take_effects().last(), Some(ClientEffect::SaveSettings(settings)) if settings.ceiling_m == 9.0)
    );
    client.command(ClientCommand::Undo);
    assert_eq!(client.model.view_settings(), &ViewSettings::default(), "one drag is one step");
    client.command(ClientCommand::Redo);
    assert_eq!(client.model.view_settings().ceiling_m, 9.0);
}
