//! What a task costs a practised person: the keystroke-level model of Card, Moran and Newell (Communications of the ACM 23(7), 1980).
//!
//! The model adds the times of elementary actions. It holds for people who know the program and make no mistakes. Its rules would drop some of the mental
//! preparations, such as that before the second of two things that belong together. Here every click, drag and text has one, so the times are upper bounds.

use std::fmt;
use std::ops::{Add, AddAssign, Sub};

/// Times of the elementary actions, seconds, from the paper.
#[derive(Clone, Copy, Debug)]
pub struct KeystrokeTimes {
    /// K: a key, for an average typist of 40 words a minute who is no secretary.
    pub key_s: f64,
    /// P: pointing at something on the screen.
    pub point_s: f64,
    /// B: pressing or releasing a button of the mouse.
    pub button_s: f64,
    /// H: moving the hand between mouse and keyboard.
    pub home_s: f64,
    /// M: mental preparation.
    pub think_s: f64,
}

impl Default for KeystrokeTimes {
    fn default() -> Self {
        Self { key_s: 0.28, point_s: 1.1, button_s: 0.1, home_s: 0.4, think_s: 1.35 }
    }
}

/// Numbers of elementary actions, and what they made up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    pub keys: u32,
    pub points: u32,
    /// Presses and releases.
    pub buttons: u32,
    pub homings: u32,
    pub thoughts: u32,
    pub clicks: u32,
    pub drags: u32,
}

impl Effort {
    /// The time that it takes, seconds.
    pub fn seconds(&self, times: &KeystrokeTimes) -> f64 {
        f64::from(self.keys) * times.key_s
            + f64::from(self.points) * times.point_s
            + f64::from(self.buttons) * times.button_s
            + f64::from(self.homings) * times.home_s
            + f64::from(self.thoughts) * times.think_s
    }
}

impl Add for Effort {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            keys: self.keys + other.keys,
            points: self.points + other.points,
            buttons: self.buttons + other.buttons,
            homings: self.homings + other.homings,
            thoughts: self.thoughts + other.thoughts,
            clicks: self.clicks + other.clicks,
            drags: self.drags + other.drags,
        }
    }
}

impl AddAssign for Effort {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Effort {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            keys: self.keys - other.keys,
            points: self.points - other.points,
            buttons: self.buttons - other.buttons,
            homings: self.homings - other.homings,
            thoughts: self.thoughts - other.thoughts,
            clicks: self.clicks - other.clicks,
            drags: self.drags - other.drags,
        }
    }
}

impl fmt::Display for Effort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:3} clicks, {:2} drags, {:3} keys; K {} P {} B {} H {} M {}",
            self.clicks,
            self.drags,
            self.keys,
            self.keys,
            self.points,
            self.buttons,
            self.homings,
            self.thoughts
        )
    }
}

#[test]
fn the_times_of_the_model_add_up() {
    // The paper's way of writing a word with the mouse in hand: M, P, two B, H, five K.
    let effort =
        Effort { keys: 5, points: 1, buttons: 2, homings: 1, thoughts: 1, clicks: 1, ..Effort::default() };
    let seconds = (effort + Effort::default()).seconds(&KeystrokeTimes::default());
    assert!((seconds - (5.0 * 0.28 + 1.1 + 0.2 + 0.4 + 1.35)).abs() < 1e-9, "{seconds}");
    assert_eq!(effort + effort - effort, effort);
}
