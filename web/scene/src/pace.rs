//! How much to draw so that movement stays smooth on slow machines.
//!
//! There is no asking a browser how long the GPU took, but a machine that cannot follow delays the next frame. While
//! frames come late the effort falls; while they come in time it recovers; once nothing moves the last picture is
//! drawn again in full.

use crate::view::Options;

/// Frames that come later than this one after the other mean too much work, seconds. Scans at 10 Hz come sooner.
const LATE_S: f64 = 0.13;
/// Frames sooner than this leave room for more, seconds.
const EARLY_S: f64 = 0.11;
/// A gap longer than this is a pause and says nothing about speed, seconds.
const PAUSE_S: f64 = 3.0;
/// After this long without a frame the picture is refined, seconds.
const REST_S: f64 = 0.4;
const EFFORT_MIN: f32 = 0.06;
/// Late frames weigh more than early ones, so that the effort settles instead of swinging.
const LESS: f32 = 0.75;
const MORE: f32 = 1.06;

/// Adapts [`Options::point_budget`] and [`Options::resolution`] to the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    effort: f32,
    /// When the last frame was drawn, seconds.
    drawn_at: Option<f64>,
    /// Whether the last frame was drawn in full.
    refined: bool,
}

impl Default for Pace {
    fn default() -> Self {
        Self { effort: 1.0, drawn_at: None, refined: true }
    }
}

impl Pace {
    /// Says that a frame is drawn now (seconds on any steady clock) because something changed.
    pub fn drew(&mut self, now: f64) {
        let since = self.drawn_at.map(|before| now - before).filter(|since| *since < PAUSE_S);
        match since {
            // The frame after a refined one waited for that, not for movement.
            Some(_) if self.refined && self.effort < 1.0 => {}
            Some(since) if since > LATE_S => self.effort = (self.effort * LESS).max(EFFORT_MIN),
            Some(since) if since < EARLY_S => self.effort = (self.effort * MORE).min(1.0),
            _ => {}
        }
        self.drawn_at = Some(now);
        self.refined = self.effort >= 1.0;
    }

    /// Whether the picture should now be drawn in full because nothing has moved for a while. Says so once for each rest;
    /// draw that frame with the options as they are, and do not report it to [`Self::drew`].
    pub fn refine(&mut self, now: f64) -> bool {
        let due = self.refine_in(now) == Some(0.0);
        self.refined |= due;
        due
    }

    /// Seconds until [`Self::refine`] will be due, so that the caller can ask for a frame then.
    pub fn refine_in(&self, now: f64) -> Option<f64> {
        let drawn_at = self.drawn_at.filter(|_| !self.refined)?;
        Some((drawn_at + REST_S - now).max(0.0))
    }

    /// The options for a frame during movement.
    pub fn apply(&self, options: &Options) -> Options {
        let budget = (options.point_budget as f32 * self.effort) as u32;
        // The first cuts go to points; pixels only when that was not enough.
        let resolution = options.resolution * (self.effort * 2.5).clamp(0.4, 1.0);
        Options { point_budget: budget, resolution, ..*options }
    }
}
