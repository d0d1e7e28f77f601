//! What the operator sees and touches: egui views that read a [`client_model::Model`] and emit
//! [`client_model::ClientCommand`]s. They change nothing themselves but [`PanelState`]: which tab is open, and text that is not
//! submitted yet.
//!
//! `frame` draws the page and calls the panels of `features`, which says how to add one. `feature_panel` is the interface between the
//! two. `screens` says which screens there are, and how to add one.
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
//! | button (toggled) | `Live`, `Map`, `Site`, `Missions`, `Schedule`, `Runs`, `Settings` | rail |
//! | button (toggled) | `Add nodes`, `Connect nodes`, `Select several` | Site: what a click or drag in the scene does |
//! | button (toggled) | `All floors`, `Floor NUMBER` | Site, where there are several floors: the one that is shown |
//! | status | `Selected` | Site, while several nodes are selected |
//! | button | `Join them`, `Delete NUMBER nodes` | Site, while several nodes are selected |
//! | button (toggled) | `Routes may use their edges` | Site, while several nodes are selected |
//! | textbox | `x (m)`, `y (m)`, `Height (m)`, `Heading (°)`, `Floor`, each with the buttons `Less: NAME` and `More: NAME` | Site, while a node is selected |
//! | textbox | `Speed (m/s)`, `Room left (m)`, `Room right (m)`, with the same buttons | Site, while an edge is selected |
//! | button | `Traversal` | Site, while an edge is selected: unfolds a list |
//! | button (toggled) | `Forwards`, `Backwards`, `Any way` | Site, while an edge is selected |
//! | status | `Nodes`, `Edges`, `Not confirmed` | Site |
//! | button | `Make from the map`, then `Replace them`, `Keep them` if there are nodes | Site |
//! | status | `Making the topological map`, then `Result` with the button `Dismiss the result` | Site, after that |
//! | textbox | `Node name`, with the button `Rename node` | Site, while a node is selected |
//! | button (toggled) | `Waypoint`, `Inspection`, `Hold`, `Safe` | Site, while a node is selected: its kind |
//! | button | `Make it a dock`, `It is no dock`, `Delete node NAME` | Site, while a node is selected |
//! | textbox | `Tags` | Site, while a node is selected, and of an asset that is open |
//! | button (toggled) | `Near it`, `In an area too`, then the corners as of a zone | Site, while a node is selected |
//! | button | `Dock NAME` | Site, while nothing is selected: selects the node on it |
//! | textbox | `Dock name`, with the button `Rename dock` | Site, while a node of a dock is selected |
//! | button | `Approached from` | the same: unfolds a list |
//! | status | `Block of FROM → TO`, with the buttons `Show FROM → TO` and `Unblock FROM → TO now` | Site and Live, while an edge is blocked |
//! | button | `Hold GROUP`, `Release GROUP` | Site, while an edge of the group is selected; the second also in the list of held groups |
//! | button | `Edge FROM to TO` | Site, while a node is selected: selects the edge |
//! | button (toggled) | `Routes may use it`, `Both ways` | Site, while an edge is selected |
//! | button | `Split edge`, `Delete edge` | Site, while an edge is selected |
//! | button | the sentence itself | Site: a problem; selects its object |
//! | button | `MOMENT: add an action`, `MOMENT NUMBER: ACTION`, each with `Remove …` | Site, while an edge is selected; moments are `Before setting out`, `While walking`, `After arriving` |
//! | button | `Add a step`, `Step NUMBER` with `Remove Step NUMBER` | Site, while an edge is selected: what is tried if it cannot be walked |
//! | button (toggled) | `Topological map`, `Inspection points`, `Assets`, `Zones`, `Draft` | Site: parts of its card |
//! | button (toggled) | `Draw a zone` | Site, Zones: the next drag over the floor draws one |
//! | button (toggled) | `Zone NAME` | Site, Zones: selects it |
//! | textbox | `Zone name`, `At most (m/s)`, `Factor`, `From (m)`, `To (m)`, `From`, `Until` | Site, while a zone is selected |
//! | button (toggled) | `Keep out`, `Speed limit`, `Penalty`, `Action`; `All heights`, `From … to`, `Only floor NUMBER`; `Always`, `Every day` | Site, while a zone is selected |
//! | button | `Action on entering`, then the parameters of the action | Site, while a zone with an action is selected |
//! | button | `NUMBER corners`, then `Remove corner NUMBER`, `Add a corner`, and the textboxes `NUMBER: x (m)`, `NUMBER: y (m)` | Site, while a zone is selected |
//! | button | `Rename zone`, `Show the zone`, `Delete zone NAME` | Site, while a zone is selected |
//! | button | `Edit as draft`, then `Publish`, `Discard the draft` or `End the draft` | Site, Draft |
//! | status | `Changes` | Site, Draft |
//! | button | `KIND NAME: added`, `changed` or `removed` | Site, Draft: selects the object |
//! | button | `Keep mine: KIND NAME`, `Take theirs: KIND NAME` | Site, Draft: where somebody else has changed it too |
//! | button | `Show the draft` | Site, Missions, Schedule and Settings, while a draft is edited |
//! | button (toggled) | `Add inspection points` | Site: each click in the scene makes one |
//! | button (toggled) | `Inspection point NAME` | Site: selects it |
//! | status | `Stand-off`, `Target`, `Camera view` | Site, while an inspection point is selected |
//! | button | `Seen from`, `Action` | Site, while an inspection point is selected: each unfolds a list |
//! | button | `Asset`, `Reading` | Site, while an inspection point is selected: each unfolds a list |
//! | textbox | `At least (UNIT)`, `At most (UNIT)` | Site, while an inspection point with limits is selected |
//! | button | `New asset`, `Asset NAME`, then `Rename asset`, `Select inspection point NAME`, `Delete asset NAME` | Site, Assets |
//! | textbox | `Asset name`, `Find an asset` | Site, Assets |
//! | textbox | `Stand off (m)`, with the buttons `Less: Stand off (m)` and `More: Stand off (m)` | Site, while an inspection point is selected |
//! | button | `Turn the node to the target` | Site, while an inspection point is selected |
//! | textbox | `Inspection point name`, and the parameters of its action | Site, while an inspection point is selected |
//! | button | `Rename inspection point`, `Pick the target anew`, `Show the target`, `Delete inspection point NAME` | Site, while an inspection point is selected |
//! | button | `New mission`, `Mission NAME`, `Duplicate NAME`, `Delete NAME` | Missions: the list |
//! | button | `Delete NAME with its schedules`, `Keep the mission` | Missions: a deletion that takes schedules along |
//! | textbox | `Search missions`, `Mission name`, `Search places and actions` | Missions |
//! | button | `All missions`, `Undo edit`, `Redo edit`, `Run now`, `Queue` | Missions, while one is edited |
//! | status | `Expected time`, `Way`, `Problem of task NUMBER` | Missions, while one is edited |
//! | button | `Optimise: −TIME`, then `Use this order`, `Keep my order` | Missions: the shortest order |
//! | button | `Add inspection point NAME`, `Add node NAME`, `Add action NAME` | Missions: the palette. A press adds, a drag drops |
//! | button (toggled) | `Task NUMBER NAME` | Missions: selects and unfolds; a drag moves |
//! | button | `Move task NUMBER NAME` | Missions: Enter lets ↑ and ↓ move it, Enter drops it, Escape puts it back |
//! | button | `Place`, `Action`, `POLICY: Further tries`, `POLICY: Then` | Missions, a task: each unfolds a list |
//! | button | `Comes after`, `Comes before` | Missions, a task: each unfolds the other tasks |
//! | button | `Remove: ORDER` | Missions, a task, and below a circle of order constraints |
//! | status | `Problem of the order`, with the button `Put the list in this order` | Missions, while order constraints contradict each other or the list |
//! | button | `Move up`, `Move down`, `Duplicate task`, `Delete task` | Missions, tasks that are selected |
//! | button (toggled) | `As listed`, `Shortest`, `Keep the first`, `Keep the last`, `Nearest dock`, `Stay there`, `A node` | Missions |
//! | button (toggled) | `Week`, `Agenda` | Schedule: how occurrences are shown |
//! | button | `Earlier week`, `This week`, `Later week` | Schedule |
//! | button | `Undo`, `Redo` | Schedule |
//! | status | `Site time`, `Your time` | Schedule: the second where the time zones differ |
//! | button | `NAME, DAY TIME, STATE` | Schedule: an occurrence. A click selects it, a drag moves it; arrow keys move it too, Enter drops it, Escape cancels |
//! | button | `Schedule mission NAME` | Schedule: drag it into the week, or press it |
//! | button | `Open schedule NAME` | Schedule |
//! | group | `Which occurrences?` with `This one`, `This and following`, `All`, `Cancel` | Schedule: after a drag, or for a deletion |
//! | button | `All schedules`, `Pause schedule`, `Resume schedule`, `Skip next`, `Delete schedule` | Schedule: the one that is open |
//! | button | `Save to a file`, `Load from a file` | Schedule and Missions: missions and schedules together |
//! | button (toggled) | `Now`, `History`, `Points` | Runs: parts of its card |
//! | status | `Progress` | Runs, while a mission runs |
//! | button | `Pause`, `Resume`, `Skip task`, `Cancel run`, `Abort…` | Runs, while a mission runs; the last asks once more |
//! | button (toggled) | `TASK, STATE` | Runs: unfolds `Skip task TASK` or `Redo task TASK` |
//! | button | `Try again`, `Skip it`, `End at a dock`, `End here` | Runs, while a run asks what becomes of a task |
//! | button | `Show the run` | Live, while a mission runs |
//! | button | `Run MISSION` | Runs, while nothing runs |
//! | button | `Remove MISSION from the queue` | Runs |
//! | button (toggled) | `MISSION, OUTCOME, FACTS` | Runs: one that has ended, the last one also while nothing runs; opens its tasks, readings and files |
//! | textbox | `Site name` | Settings |
//! | button | `Mission`, `Outcome` | Runs, History: each unfolds a list and filters the runs |
//! | textbox | `From`, `To` | Runs, History: days between which runs were asked for |
//! | button | `Show all`, `Show older runs` | Runs, History |
//! | button | `MISSION, Skipped, FACTS`, `MISSION, Missed, FACTS` | Runs, History: a slot without a run; leads to the Schedule screen |
//! | button | `Download the run`, `Report`, `Download for Foxglove` | Runs, in a run that has ended: each fetches a file |
//! | button | `Report of the week` | Runs, History: fetches the report of the runs of the last seven days |
//! | button | `Show FILE of TASK` | Runs, in a run that has ended: a picture or a spectrum, large |
//! | button | `Open FILE of TASK` | Runs: the file in a tab of its own |
//! | group | `Pictures of the run` with the status `Picture` | Runs, after that; Escape closes it, arrow keys go on |
//! | button | `Previous picture`, `Next picture`, `Zoom in`, `Zoom out`, `Whole picture`, `Close the pictures` | in it |
//! | button (toggled) | `With the last one` | in it: side by side with the last picture of the same inspection point |
//! | status | `Spectrum` | in it: counts, live time, and what the pointer reads |
//! | button | `History of this point: TASK`, `History of this point` | Runs, below a result of an inspection point; Site, while one is selected |
//! | button | `Inspection point` | Runs, Points: unfolds the points below their assets |
//! | button (toggled) | `24 h`, `Week`, `Month`, `All` | Runs, Points: the part of the history that is shown |
//! | slider | `Time line` | Runs, Points: a drag zooms in, a press chooses, arrow keys go on |
//! | button | `Previous result`, `Next result`, `Picture A, TIME`, `Picture B, TIME`, `Compare large` | Runs, Points |
//! | button (toggled) | `Keep this one as A`, then `A is the one before` | Runs, Points |
//! | status | `READING, UNIT`, `Median`, `Trend`, `By the hour of the day`, `Limits`, `Unusual`, `Outside the limits` | Runs, Points: a plot and its facts |
//! | button | `Fetch again`, `Save all as a table (CSV)`, `Do not save` | Runs, Points |
//! | button (toggled) | `SEVERITY · PLACE · AGE` | Runs, Alerts: unfolds an alert |
//! | button | `Raise an alert`, `Raise an alert at POINT` | Runs, Alerts |
//! | button | `Acknowledge`, `Open again`, `I look after it`, `Close the alert`, `Keep the owner`, `Keep the work order`, `Keep the comment`, `Show the place`, `History of this point` | in an alert |
//! | textbox | `Owner`, `Work order`, `Comment`, `Closing remark` | in an alert |
//! | group | `Comparison of two results` | Runs, Points, after `Compare large`; Escape closes it |
//! | button | `Side by side`, `Wipe`, `Blink`, `Stop blinking`, `Go on blinking`, `Show the other one`, `Whole picture`, `Close the comparison` | in it |
//! | slider | `Divider` | in it, while wiping: a drag and arrow keys move it |
//! | status | `Shown` | in it, while blinking |
//! | button (toggled) | `General`, `Monitors` | Settings: parts of its card |
//! | button | `New monitor`, `Monitor NAME`, then `Signal`, `What happens`, `Which mission`, `Use the built-in values of NAME`, `Delete monitor NAME` | Settings, Monitors |
//! | button (toggled) | `It is watched`; `Below`, `Above`, `Silent`; `Goes on`, `Ends` | Settings, Monitors |
//! | textbox | `Monitor name`, `Below (%)`, `Until above (%)`, `For at least (s)` | Settings, Monitors |
//! | searchbox | `Find a time zone` | Settings |
//! | button (toggled) | `Time zone NAME` | Settings |
//! | button | `Open panel`, `Close panel` | top bar below 1100 px: the right card as a drawer; below 700 px the bar at the bottom opens it |
//! | button | `Explore the example`, `Map your own`, `Not now` | Live, while there is no map |
//! | status | `Example`, with the button `Cancel the example` | Live, while the example is made |
//! | button | `Start mapping` | Map, while not mapping |
//! | textbox | `Map name` | Map, while mapping |
//! | button | `Finish and save` | Map, while mapping: asks for nothing more when a name is given |
//! | button | `Discard` | Map, while mapping; then `Discard map` or `Keep mapping` |
//! | button (toggled) | `Session`, `Loops` | Map: parts of its card |
//! | status | `Accepted loops`, `Under test loops`, `Rejected loops` | Loops |
//! | button | `Add a loop`, then `Propose`, `Cancel adding` | Loops: two keyframes are chosen in between |
//! | button (toggled) | `From the graph`, `Same position` | Loops, once two keyframes are chosen |
//! | button | `Undo the decision` | Loops |
//! | button (toggled) | `Loop FROM → TO: VERDICT. REASON` | Loops: one for each row in sight |
//! | status | `Verdict`, `Overlap`, `Residual`, `Free-space violation`, `Runner-up`, `Correction`, `Found by` | a loop's evidence |
//! | button | `Accept loop`, `Reject loop`, `Show where it is`, `Close the loop's evidence` | a loop's evidence |
//! | button (toggled) | `As found`, `In the graph`, `Map only` | a loop's evidence |
//! | button | `View NAME` | Map: shows the saved map NAME |
//! | status | `Damaged map FOLDER` | Map: a saved map that cannot be read, with what to do |
//! | button | `Rename NAME`, `Delete NAME` | Map, below the saved map that is viewed |
//! | textbox | `New map name`, with the buttons `Save the name` and `Keep the name` | Map, while a saved map is renamed |
//! | button | `Undo`, `Dismiss the deletion` | after a map was deleted |
//! | button (toggled) | `Bin` | Map, while there are deleted maps |
//! | status | `Deleted map NAME`, with the buttons `Restore NAME` and `Delete NAME for good` | Map, in the bin |
//! | status | `Uploaded file NAME`, with the buttons `Try again with NAME` and `Delete file NAME` | Map: a file of which no map could be made |
//! | button | `Back to live` | while a saved map is viewed |
//! | button (toggled) | `Walk to a point` | drive card; then the next click on the floor says where |
//! | button | `Cancel walk` | drive card, while walking |
//! | group | `Joystick` | drive card |
//! | button | `Colour`, `Ceiling`, `Point size`, `Remembered views`, `Theme` | tools; each opens a menu |
//! | button (toggled) | `Pose graph`, `Follow robot` | tools |
//! | button | `Top view`, `Fit view`, `Keyboard shortcuts` | tools |
//! | button | `Dismiss` | on each notice |
//! | button | `Reconnect now` | while the link is lost |
//! | status | `Robot`, `Position`, `Battery`, `Link`, `Control`, `Next run` | top bar |
//! | status | `Mapping`, `Elapsed`, `Distance`, `Keyframes`, `Points in map` | Map, while mapping |
//! | status | `Motion`, `Speed`, sensors by their names | Live, and Map while mapping |
//! | status | `Position in the map`, `Accuracy`, `Walked` | Live |
//! | status | `Suggested walk NUMBER` | Map, while mapping: what the map lacks there |
//! | button | `Walk to position NUMBER` | Map, while mapping: walks to it |
//! | status | `Executive`, `Doing`, `To go`, `Waiting`, `Outcome` | Live, for the robot's goals |
//! | button | `Cancel goal`, `Dismiss the outcome` | Live, while there is a goal or an outcome |
//! | alert | the sentence itself | notices and findings |

pub mod format;
pub mod icon;
pub mod theme;

mod button;
mod camera_preview;
mod corner_fields;
mod feature_panel;
mod features;
mod frame;
mod heading;
mod layout;
mod map_name;
mod message;
mod name_field;
mod next_run_texts;
mod number_field;
mod page_clock;
mod paint;
mod property_fields;
mod result_files;
mod screens;
mod select;
mod status_line;
mod tag_field;
mod text_input;
mod texts;
mod thermal;
mod widgets;

#[cfg(test)]
mod test_support;

pub use camera_preview::{CameraPreview, SightCheck};
pub use feature_panel::{DragObstruction, SceneDrag};
pub use features::scene_labels::{SceneLabel, graph_tool, show_labels};
pub(crate) use layout::{Layout, Width};
pub use page_clock::PageClock;
pub use result_files::{ResultFileContent, ResultFiles};
pub use text_input::{
    TextInput, TextInputEvent, TextInputKind, TextInputRequest, TextInputResponse, TextInputs,
};

use client_model::{ClientCommand, Model};
use feature_panel::{FrameState, PanelContext};
use features::FeaturePanels;
use theme::Tokens;

/// State of the panels between frames.
#[derive(Debug, Default)]
pub struct PanelState {
    /// The bridge to the page's text inputs.
    pub text_inputs: TextInputs,
    /// Pictures and other files of results.
    pub files: ResultFiles,
    /// The calendar clock and time zone of the operator's machine.
    pub clock: PageClock,
    /// Whether the operator's system asks for reduced motion: nothing moves or blinks by itself then.
    pub is_motion_reduced: bool,
    /// Which tabs are open and what is unfolded.
    frame: FrameState,
    /// What the panels of features keep.
    features: FeaturePanels,
}

impl PanelState {
    /// For a page that lays its own inputs over the text fields.
    pub fn for_page(clock: PageClock) -> Self {
        Self { clock, text_inputs: TextInputs::new(true), ..Self::default() }
    }

    /// What is dragged in the scene in this frame. Escape then belongs to it.
    pub fn set_scene_drag(&mut self, drag: SceneDrag) {
        self.frame.scene_drag = drag;
    }

    /// Where the picture of the robot's camera is shown in this frame, if anywhere.
    pub fn camera_preview(&self) -> Option<CameraPreview> {
        self.frame.camera_preview
    }

    /// What stands between the camera and its target.
    pub fn set_sight_check(&mut self, check: SightCheck) {
        self.frame.sight_check = Some(check);
    }

    /// The part of the scene in a window that no card covers: maps are fitted into it.
    pub fn free_area(&self, window: egui::Rect) -> egui::Rect {
        Layout::of(window).free_beside(self.frame.drawer_open, self.frame.is_left_card_shown)
    }
}

/// Whether drags in the scene move nodes of the topological map.
pub fn is_editing_graph(model: &Model) -> bool {
    model.view.screen() == Some(screens::SITE) && model.is_site_on_screen()
}

/// Whether the topological map takes the place of the pose graph in the scene: everywhere but on the screen on which maps are made. Keyframes would lie over its nodes.
pub fn is_graph_covered(model: &Model) -> bool {
    let has_nodes = model.site.site().is_some_and(|site| site.nodes().next().is_some());
    has_nodes && model.is_site_on_screen() && model.view.screen() != Some(screens::MAP)
}

/// Whether the boxes of what has changed between visits are shown: on the screen of runs.
pub fn shows_changes(model: &Model) -> bool {
    model.view.screen() == Some(screens::RUNS)
}

/// The mission that is edited and the site that it is of, while its way is drawn: on its screen, and in the map of the site.
pub fn shown_mission(model: &Model) -> Option<(&site_model::Site, &client_model::MissionPlan)> {
    let is_shown = model.view.screen() == Some(screens::MISSIONS) && model.is_site_on_screen();
    Some((model.site.site()?, model.missions.plan().filter(|_| is_shown)?))
}

/// Shows everything that floats over the scene. `commands` receives the commands of the operator.
pub fn show(ctx: &egui::Context, model: &Model, state: &mut PanelState, commands: &mut Vec<ClientCommand>) {
    state.text_inputs.begin_frame();
    state.files.begin_frame();
    state.frame.camera_preview = None;
    let mut cx = PanelContext {
        model,
        tokens: &Tokens::of(model.view_settings().theme),
        layout: &Layout::of(ctx.content_rect()),
        utc_offset_s: state.clock.utc_offset_s,
        clock: &state.clock,
        is_motion_reduced: state.is_motion_reduced,
        text_inputs: &mut state.text_inputs,
        files: &mut state.files,
        frame: &mut state.frame,
        commands,
    };
    frame::show(ctx, &mut state.features, &mut cx);
    state.text_inputs.end_frame();
}
