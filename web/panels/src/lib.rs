//! What the operator sees and touches: egui views that read a [`client_model::Model`] and emit
//! [`client_model::ClientCommand`]s. The only thing that they change themselves is [`PanelState`]: what is unfolded, and text that is
//! not submitted yet.
//!
//! # Names of the controls
//!
//! Every control is in the accessible tree under the name it shows, and stays there under that name; browser tests and
//! people with screen readers find it by role and name:
//!
//! | role | name | where |
//! |---|---|---|
//! | button | `Stop motion` | top bar, always |
//! | button | `Allow motion` | top bar, while motion is stopped |
//! | button | `Take control`, `Release control` | top bar |
//! | button (toggled) | `Live`, `Map` | rail |
//! | button | `Open panel`, `Close panel` | top bar below 1100 px: the right card as a drawer; below 700 px the bar at the bottom opens it |
//! | button | `Start mapping` | Map, while not mapping |
//! | textbox | `Map name` | Map, while mapping |
//! | button | `Finish and save` | Map, while mapping: asks for nothing more when a name is given |
//! | button | `Discard` | Map, while mapping; then `Discard map` or `Keep mapping` |
//! | button (toggled) | `Session`, `Loops` | Map: parts of its card |
//! | status | `Accepted loops`, `Under test loops`, `Rejected loops` | Loops |
//! | button | `Add a loop`, then `Propose`, `Cancel adding` | Loops: two keyframes are chosen in between |
//! | button (toggled) | `From the graph`, `Same place` | Loops, once two keyframes are chosen |
//! | button | `Undo the decision` | Loops |
//! | button (toggled) | `Loop FROM → TO: VERDICT. REASON` | Loops: one for each row in sight |
//! | status | `Verdict`, `Overlap`, `Surfaces apart`, `Seen through`, `Best rival`, `Moved from the guess`, `Found by` | a loop's evidence |
//! | button | `Accept loop`, `Reject loop`, `Show where it is`, `Close the loop's evidence` | a loop's evidence |
//! | button (toggled) | `As found`, `In the graph`, `Map only` | a loop's evidence |
//! | button | `View NAME` | Map: looks at the saved map NAME |
//! | button | `Back to live` | while looking at a saved map |
//! | button (toggled) | `Walk to a point` | drive card; then the next click on the floor says where |
//! | button | `Cancel walk` | drive card, while walking |
//! | group | `Drive stick` | drive card |
//! | button | `Colour`, `Ceiling`, `Point size`, `Remembered views`, `Theme` | tools; each opens a menu |
//! | button (toggled) | `Pose graph`, `Follow robot` | tools |
//! | button | `Top view`, `Fit view`, `Keyboard shortcuts` | tools |
//! | button | `Dismiss` | on each notice |
//! | button | `Reconnect now` | while the link is lost |
//! | status | `Robot`, `Position`, `Battery`, `Link`, `Control` | top bar |
//! | status | `Mapping`, `Elapsed`, `Distance`, `Keyframes`, `Points in map` | Map, while mapping |
//! | status | `Motion`, `Speed`, sensors by their names | Live, and Map while mapping |
//! | status | `Executive`, `Doing`, `To go`, `Waiting`, `Outcome` | Live, for the robot's goals |
//! | button | `Cancel goal`, `Dismiss the outcome` | Live, while there is a goal or an outcome |
//! | alert | the sentence itself | notices and findings |

pub mod icon;
pub mod theme;
pub mod words;

mod banner;
mod button;
mod drive;
mod features;
mod help;
mod layout;
mod live;
mod map_card;
mod rail;
mod sensors;
mod simulated_faults;
mod state;
mod text_input;
mod top_bar;
mod widgets;

#[cfg(test)]
mod test_support;
#[cfg(test)]
mod tests;

pub use features::scene_labels::{SceneLabel, show_labels};
pub use layout::{Layout, Width};
pub use state::PanelState;
pub use text_input::{
    TextInput, TextInputEvent, TextInputKind, TextInputRequest, TextInputResponse, TextInputs,
};

use client_model::{ClientCommand, Model, Screen};
use features::view_settings;
use theme::Tokens;

/// Draws everything that floats over the scene. `out` receives what the person asks for.
pub fn show(ctx: &egui::Context, model: &Model, state: &mut PanelState, out: &mut Vec<ClientCommand>) {
    let tokens = Tokens::of(model.view_settings().theme);
    let layout = Layout::of(ctx.content_rect());
    state.text_inputs.begin_frame();
    drive::shortcuts(ctx, model, out);
    map_card::follow_selection(model, state, out);

    top_bar::show(ctx, model, &tokens, &layout, state, out);
    rail::show(ctx, model, &tokens, &layout, state, out);
    view_settings::show(ctx, model, &tokens, &layout, state, out);
    drive::show(ctx, model, &tokens, &layout, state, out);
    drive::steer(ctx, model, state, out);
    if layout.width == Width::Wide || state.drawer_open {
        right_card(ctx, model, &tokens, &layout, state, out);
    }
    banner::show(ctx, model, &tokens, &layout, state.drawer_open, out);
    help::show(ctx, &tokens, state);
    state.text_inputs.end_frame();
}

/// What the screen is about.
fn right_card(
    ctx: &egui::Context,
    model: &Model,
    tokens: &Tokens,
    layout: &Layout,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    let name = match model.view.screen() {
        Screen::Live => "Robot panel",
        Screen::Map => "Map panel",
    };
    layout::card(ctx, tokens, name, layout.card, |ui| match model.view.screen() {
        Screen::Live => live::show(ui, model, tokens, state, out),
        Screen::Map => map_card::show(ui, model, tokens, state, out),
    });
}
