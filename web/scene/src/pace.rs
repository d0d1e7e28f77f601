//! How much to draw so that movement stays smooth on slow machines.
//!
//! There is no asking a browser how long the GPU took, but a machine that cannot follow delays the next frame. While
//! frames come late the effort falls; while they come in time it recovers; once nothing moves the picture is drawn
//! again with more effort.

use crate::renderer::Renderer;
use crate::view::{Options, View};

/// Frames that come later than this one after the other mean too much work, seconds. Scans at 10 Hz come sooner.
const LATE_S: f64 = 0.13;
/// Frames sooner than this leave room for more, seconds.
const EARLY_S: f64 = 0.11;
/// A gap longer than this is a pause and says nothing about speed, seconds.
const PAUSE_S: f64 = 8.0;
/// After this long without a frame the picture is refined, seconds.
const REST_S: f64 = 0.4;
/// How much more effort a picture at rest is worth.
const REST_GAIN: f32 = 4.0;
const EFFORT_MIN: f32 = 0.06;
/// The effort falls with the delay, but not by more than this at once: one slow frame may be chance.
const LESS_MIN: f32 = 0.35;
const MORE: f32 = 1.06;

/// Adapts [`Options::point_budget`] and [`Options::resolution`] to the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// What was wanted last, what was drawn for it, and when (seconds).
    last: Option<(View, View, f64)>,
    /// Share of the full work that is left out during movement; 0 on a quick machine.
    saved: f32,
    /// Whether the last picture is as good as it gets.
    refined: bool,
}

impl Pace {
    /// Begins with a share of the full effort (0 to 1), for machines known to be slow.
    pub fn starting_at(effort: f32) -> Self {
        Self { saved: 1.0 - effort.clamp(EFFORT_MIN, 1.0), ..Self::default() }
    }

    /// The view to draw for a wanted one, and in how many seconds another frame should be asked for to refine it.
    ///
    /// `now`: seconds on a steady clock. Call once for each frame of the page, whether or not anything changed.
    pub fn view(&mut self, now: f64, wanted: &View, renderer: &Renderer) -> (View, Option<f64>) {
        self.decide(now, wanted, renderer.changed())
    }

    /// [`Self::view`], given whether the scene changed since it was last drawn.
    pub(crate) fn decide(&mut self, now: f64, wanted: &View, changed: bool) -> (View, Option<f64>) {
        let Some((last_wanted, last_drawn, drawn_at)) = self.last else {
            return self.draw(now, wanted);
        };
        if changed || last_wanted != *wanted {
            self.learn(now - drawn_at);
            return self.draw(now, wanted);
        }
        let rest = REST_S - (now - drawn_at);
        if self.refined {
            return (last_drawn, None);
        }
        if rest > 0.0 {
            return (last_drawn, Some(rest));
        }
        let refined = with_effort(wanted, (self.effort() * REST_GAIN).min(1.0));
        self.refined = true;
        self.last = Some((*wanted, refined, now));
        (refined, None)
    }

    fn draw(&mut self, now: f64, wanted: &View) -> (View, Option<f64>) {
        let drawn = with_effort(wanted, self.effort());
        self.refined = self.saved <= 0.0;
        self.last = Some((*wanted, drawn, now));
        (drawn, (!self.refined).then_some(REST_S))
    }

    /// Takes in that a frame came so many seconds after the one before.
    fn learn(&mut self, since: f64) {
        // The frame after a refined one waited for that, not for movement.
        let after_refinement = self.refined && self.saved > 0.0;
        let effort = match since {
            _ if after_refinement || since >= PAUSE_S => return,
            _ if since > LATE_S => self.effort() * ((LATE_S / since) as f32).max(LESS_MIN),
            _ if since < EARLY_S => self.effort() * MORE,
            _ => return,
        };
        self.saved = 1.0 - effort.clamp(EFFORT_MIN, 1.0);
    }

    fn effort(&self) -> f32 {
        1.0 - self.saved
    }
}

/// The first cuts go to points; pixels only when that was not enough.
fn with_effort(wanted: &View, effort: f32) -> View {
    let options = &wanted.options;
    let options = Options {
        point_budget: (options.point_budget as f32 * effort) as u32,
        resolution: options.resolution * (effort * 2.5).clamp(0.5, 1.0),
        ..*options
    };
    View { options, ..*wanted }
}
