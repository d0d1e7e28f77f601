//! The interface between the frame and the panels of features: what a panel may show, and what it reads and writes meanwhile.

use crate::camera_preview::{CameraPreview, SightCheck};
use crate::layout::{Layout, Width};
use crate::next_run_texts::NextRunTexts;
use crate::page_clock::PageClock;
use crate::result_files::ResultFiles;
use crate::screens;
use crate::text_input::TextInputs;
use crate::theme::Tokens;
use client_model::{ClientCommand, Model, Screen};
use egui::{Context, Ui};

/// What a panel reads and writes in a frame.
pub(crate) struct PanelContext<'a> {
    /// State of the client. Read only.
    pub(crate) model: &'a Model,
    /// Colours of the theme.
    pub(crate) tokens: &'a Tokens,
    /// Positions of the cards.
    pub(crate) layout: &'a Layout,
    /// The client's offset from UTC, seconds.
    pub(crate) utc_offset_s: i64,
    /// The calendar clock and time zone of the operator's machine.
    pub(crate) clock: &'a PageClock,
    /// Whether the operator's system asks for reduced motion.
    pub(crate) is_motion_reduced: bool,
    /// The bridge to the text inputs of the page.
    pub(crate) text_inputs: &'a mut TextInputs,
    /// Pictures and other files of results.
    pub(crate) files: &'a mut ResultFiles,
    /// Which tab is open and what is unfolded.
    pub(crate) frame: &'a mut FrameState,
    /// Receives the commands of the operator.
    pub(crate) commands: &'a mut Vec<ClientCommand>,
}

impl PanelContext<'_> {
    /// The screen that is shown.
    pub(crate) fn screen(&self) -> Screen {
        self.model.view.screen().unwrap_or(screens::FIRST)
    }

    /// Whether a card of the screen lies over the scene, so that nothing of it can be seen or driven.
    pub(crate) fn is_scene_covered(&self) -> bool {
        screens::covers_scene(self.screen())
    }

    /// Whether the side card covers the cards at the left: on narrow windows it is a sheet over the whole width.
    pub(crate) fn is_covered_by_sheet(&self) -> bool {
        self.layout.width == Width::Narrow && self.frame.drawer_open
    }
}

/// A tab of the side card on one screen. A screen with one tab shows no choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tab {
    /// The screen that has the tab.
    pub(crate) screen: Screen,
    /// Text of the button that opens the tab. Unique on its screen.
    pub(crate) name: &'static str,
    /// Whether the frame scrolls the tab as a whole. Otherwise its section scrolls what it needs to.
    pub(crate) scrolls: bool,
    /// Vertical distance between rows, points.
    pub(crate) row_spacing: f32,
}

/// What is dragged in the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneDrag {
    /// Whether something is.
    pub is_active: bool,
    /// Something that stands in an edge of the node that is dragged.
    pub obstruction: Option<DragObstruction>,
}

/// Something that stands in an edge.
#[derive(Clone, Debug, PartialEq)]
pub struct DragObstruction {
    /// Name of the node from which it is measured.
    pub from: String,
    /// Name of the node at the other end.
    pub to: String,
    /// Distance from the first, m.
    pub along_m: f64,
    /// Number of further edges in which something stands.
    pub others: usize,
}

/// Which tabs are open and what is unfolded.
#[derive(Debug, Default)]
pub(crate) struct FrameState {
    /// What is dragged in the scene.
    pub(crate) scene_drag: SceneDrag,
    /// Room for the picture of the robot's camera in this frame.
    pub(crate) camera_preview: Option<CameraPreview>,
    /// What stands between that camera and its target.
    pub(crate) sight_check: Option<SightCheck>,
    /// Below 1100 px: whether the side card is shown.
    pub(crate) drawer_open: bool,
    /// Whether the list of keyboard shortcuts is shown.
    pub(crate) help_open: bool,
    /// Whether Escape belongs to something that was shown in the last frame, such as a field for a name, a drag or a question. It then ends that and does nothing
    /// else.
    pub(crate) is_escape_consumed: bool,
    /// Whether a picture is shown over all cards. Keys belong to it then.
    pub(crate) is_covered: bool,
    /// Whether a card covers the scene beside the tools. The drive card gives way to it.
    pub(crate) is_left_card_shown: bool,
    /// The next run that schedules begin.
    pub(crate) next_run: Option<NextRunTexts>,
    /// The tab that was opened last on each screen.
    open_tabs: Vec<Tab>,
}

impl FrameState {
    /// Opens a tab on its screen.
    pub(crate) fn open_tab(&mut self, tab: Tab) {
        self.open_tabs.retain(|open| open.screen != tab.screen);
        self.open_tabs.push(tab);
    }

    /// The tab that was opened last on a screen; `None` before one was.
    pub(crate) fn tab_of(&self, screen: Screen) -> Option<Tab> {
        self.open_tabs.iter().copied().find(|tab| tab.screen == screen)
    }
}

/// The panel of a feature, with what it keeps between frames. Every method has a default that shows nothing.
pub(crate) trait FeaturePanel {
    /// Reads keys and follows changes of the model. Called once per frame, before anything is shown.
    fn update(&mut self, _ctx: &Context, _cx: &mut PanelContext<'_>) {}

    /// Escape was pressed: cancels what is unfinished. Returns whether there was anything; only the first panel that has something
    /// cancels.
    fn cancel(&mut self, _cx: &mut PanelContext<'_>) -> bool {
        false
    }

    /// Shows a card of its own over the scene.
    fn show_card(&mut self, _ctx: &Context, _cx: &mut PanelContext<'_>) {}

    /// Shows messages at the top of the scene.
    fn show_messages(&mut self, _ui: &mut Ui, _cx: &mut PanelContext<'_>) {}

    /// The tabs in which the feature has a section.
    fn tabs(&self) -> &'static [Tab] {
        &[]
    }

    /// Shows the section of the feature in one of [`Self::tabs`].
    fn show_section(&mut self, _tab: Tab, _ui: &mut Ui, _cx: &mut PanelContext<'_>) {}
}
