//! A practised person at a page: operates it like [`Page`], and counts what that costs by the keystroke-level model. Waits for the robot's legs and for the platform
//! are measured apart.

use super::effort::{Effort, KeystrokeTimes};
use super::page::{At, KeyPress, Page};
use super::wait_for;
use std::time::{Duration, Instant};

/// Longest wait for a control.
const CONTROL_LIMIT: Duration = Duration::from_secs(60);
/// Points of a drag between its ends: a person's pointer passes over what lies between.
const DRAG_STEPS: u32 = 4;
/// What one turn of the wheel scrolls, CSS pixels.
const SCROLL_PX: f64 = 240.0;
/// Heights of the bar at the top, of what stands above a list in a card, and of the rest below a card, CSS pixels.
const TOP_BAR_PX: f64 = 64.0;
const LIST_TOP_PX: f64 = 215.0;
const LIST_BOTTOM_PX: f64 = 40.0;
/// Widths of the rail and of the card at the right with their margins, CSS pixels.
const RAIL_PX: f64 = 80.0;
const CARD_PX: f64 = 370.0;

/// What a wait is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaitsFor {
    /// The robot walks or acts.
    Robot,
    /// The platform computes, stores or draws.
    Platform,
}

/// A named part of the work.
#[derive(Debug)]
struct Step {
    name: String,
    effort: Effort,
    robot: Duration,
    platform: Duration,
}

/// Where the right hand is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hand {
    Pointer,
    Keyboard,
}

/// A person at a page.
pub struct Operator {
    pub page: Page,
    hand: Hand,
    steps: Vec<Step>,
}

impl Operator {
    pub fn at(page: Page) -> Self {
        Self { page, hand: Hand::Pointer, steps: Vec::new() }
    }

    /// A new part of the work begins.
    pub fn begin(&mut self, name: &str) {
        println!("{name}");
        let step = Step {
            name: name.to_owned(),
            effort: Effort::default(),
            robot: Duration::ZERO,
            platform: Duration::ZERO,
        };
        self.steps.push(step);
    }

    fn step(&mut self) -> &mut Step {
        if self.steps.is_empty() {
            self.begin("before the first step");
        }
        self.steps.last_mut().unwrap()
    }

    fn spend(&mut self, effort: Effort) {
        self.step().effort += effort;
    }

    fn move_hand_to(&mut self, hand: Hand) {
        if self.hand != hand {
            self.hand = hand;
            self.spend(Effort { homings: 1, ..Effort::default() });
        }
    }

    /// Clicks a control, after scrolling to it if it is out of sight.
    #[track_caller]
    pub fn click(&mut self, role: &str, name: &str) {
        let at = self.reveal(role, name);
        self.click_at(at);
    }

    /// Clicks a place.
    pub fn click_at(&mut self, at: At) {
        self.move_hand_to(Hand::Pointer);
        self.spend(Effort { thoughts: 1, points: 1, buttons: 2, clicks: 1, ..Effort::default() });
        self.page.move_to(at);
        self.page.press(at);
        self.page.release(at);
    }

    /// Drags something from one place to another, and lets go after `before_release`.
    pub fn drag(&mut self, from: At, to: At, before_release: impl FnOnce(&mut Page)) {
        self.move_hand_to(Hand::Pointer);
        self.spend(Effort { thoughts: 1, points: 2, buttons: 2, drags: 1, ..Effort::default() });
        self.page.move_to(from);
        self.page.press(from);
        for step in 1..=DRAG_STEPS {
            let share = f64::from(step) / f64::from(DRAG_STEPS);
            self.page
                .move_to(At { x: from.x + share * (to.x - from.x), y: from.y + share * (to.y - from.y) });
            self.page.wait_for_pictures();
        }
        before_release(&mut self.page);
        self.page.release(to);
    }

    /// Drags with a finger.
    pub fn drag_by_finger(&mut self, from: At, to: At, before_release: impl FnOnce(&mut Page)) {
        self.spend(Effort { thoughts: 1, points: 2, buttons: 2, drags: 1, ..Effort::default() });
        self.page.touch("touchStart", Some(from));
        for step in 1..=DRAG_STEPS {
            let share = f64::from(step) / f64::from(DRAG_STEPS);
            let at = At { x: from.x + share * (to.x - from.x), y: from.y + share * (to.y - from.y) };
            self.page.touch("touchMove", Some(at));
            self.page.wait_for_pictures();
        }
        before_release(&mut self.page);
        self.page.touch("touchEnd", None);
    }

    /// Taps a control with a finger.
    #[track_caller]
    pub fn tap(&mut self, role: &str, name: &str) {
        let at = self.reveal(role, name);
        self.spend(Effort { thoughts: 1, points: 1, buttons: 2, clicks: 1, ..Effort::default() });
        // Without a wait, because a finger that stays for 0.8 s is no tap, and a frame may take that long here.
        self.page.touch("touchStart", Some(at));
        self.page.touch("touchEnd", None);
    }

    /// Replaces the text of a field, and confirms it with Enter.
    #[track_caller]
    pub fn write(&mut self, field: &str, text: &str) {
        let at = self.reveal("textbox", field);
        self.move_hand_to(Hand::Pointer);
        // Three clicks select what is there.
        self.spend(Effort { thoughts: 1, points: 1, buttons: 6, clicks: 3, ..Effort::default() });
        self.page.move_to(at);
        self.page.triple_click(at);
        self.move_hand_to(Hand::Keyboard);
        let keys = text.chars().count() as u32 + 1;
        self.spend(Effort { keys, ..Effort::default() });
        self.page.type_text(text);
        self.press_uncounted(KeyPress::ENTER);
    }

    /// Presses a key.
    pub fn press(&mut self, key: KeyPress) {
        self.move_hand_to(Hand::Keyboard);
        self.spend(Effort { thoughts: 1, keys: 1, ..Effort::default() });
        self.press_uncounted(key);
    }

    fn press_uncounted(&mut self, key: KeyPress) {
        self.page.key_down(key);
        self.page.key_up(key);
    }

    /// Holds a key until the robot has done something.
    #[track_caller]
    pub fn hold<T>(
        &mut self,
        key: KeyPress,
        what: &str,
        limit: Duration,
        done: impl FnMut(&mut Page) -> Option<T>,
    ) {
        self.move_hand_to(Hand::Keyboard);
        self.spend(Effort { thoughts: 1, keys: 1, ..Effort::default() });
        self.page.key_down(key);
        self.wait(WaitsFor::Robot, what, limit, done);
        self.page.key_up(key);
    }

    /// Waits until a condition gives a value.
    #[track_caller]
    pub fn wait<T>(
        &mut self,
        waits_for: WaitsFor,
        what: &str,
        limit: Duration,
        mut condition: impl FnMut(&mut Page) -> Option<T>,
    ) -> T {
        let begun = Instant::now();
        let value = wait_for(what, limit, || condition(&mut self.page));
        match waits_for {
            WaitsFor::Robot => self.step().robot += begun.elapsed(),
            WaitsFor::Platform => self.step().platform += begun.elapsed(),
        }
        value
    }

    /// Waits for an enabled control, and scrolls the card that holds it until it is in sight. Returns its middle.
    #[track_caller]
    pub fn reveal(&mut self, role: &str, name: &str) -> At {
        let mut at = self.place_at_rest(role, name);
        let [width, height] = self.page.size();
        let deadline = Instant::now() + CONTROL_LIMIT;
        while let Some(sign) = scroll_towards(at, [width, height]) {
            let over = At { y: 0.6 * height, ..at };
            self.page.move_to(over);
            self.page.wheel(over, sign * SCROLL_PX);
            let before = std::mem::replace(&mut at, self.place_at_rest(role, name));
            // What does not scroll is in sight.
            if (before.y - at.y).abs() < 1.0 {
                break;
            }
            self.spend(Effort { keys: 1, ..Effort::default() });
            assert!(Instant::now() < deadline, "{role} “{name}” cannot be scrolled into sight");
        }
        at
    }

    /// The middle of an enabled control once it does not move any more.
    #[track_caller]
    fn place_at_rest(&mut self, role: &str, name: &str) -> At {
        let mut last = None;
        wait_for(&format!("an enabled {role} “{name}”"), CONTROL_LIMIT, || {
            let control = self.page.find(role, name).filter(|control| !control.disabled);
            let at = control.and_then(|control| self.page.middle(&control));
            if at.is_some() && std::mem::replace(&mut last, at) == at {
                return at;
            }
            self.page.wait_for_frame();
            None
        })
    }

    /// Prints what each step cost. Returns the person's time, seconds.
    pub fn report(&self) -> f64 {
        let times = KeystrokeTimes::default();
        let mut all = Effort::default();
        let (mut robot, mut platform) = (Duration::ZERO, Duration::ZERO);
        for step in &self.steps {
            let seconds = step.effort.seconds(&times);
            let (legs, waits) = (step.robot.as_secs_f64(), step.platform.as_secs_f64());
            println!(
                "{:<44} {seconds:6.1} s  robot {legs:5.0} s  platform {waits:5.0} s  {}",
                step.name, step.effort
            );
            all += step.effort;
            robot += step.robot;
            platform += step.platform;
        }
        println!(
            "{:<44} {:6.1} s  robot {:5.0} s  platform {:5.0} s  {all}",
            format!("{} steps", self.steps.len()),
            all.seconds(&times),
            robot.as_secs_f64(),
            platform.as_secs_f64(),
        );
        all.seconds(&times)
    }
}

/// In which direction a list has to be scrolled so that this place in it is in sight: 1 down, -1 up.
fn scroll_towards(at: At, [width, height]: [f64; 2]) -> Option<f64> {
    if at.y < TOP_BAR_PX || at.x < RAIL_PX {
        return None;
    }
    if at.y > height - LIST_BOTTOM_PX {
        return Some(1.0);
    }
    (at.y < LIST_TOP_PX && at.x > width - CARD_PX).then_some(-1.0)
}
