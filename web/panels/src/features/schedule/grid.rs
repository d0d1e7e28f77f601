//! Where the days and hours of a week are on the screen.

use client_model::DaySegment;
use egui::{Pos2, Rect, pos2};

/// Height of an hour, points.
pub(super) const HOUR_HEIGHT: f32 = 48.0;
/// Width of a column of hours, points.
pub(super) const GUTTER_WIDTH: f32 = 48.0;

/// Where days and minutes are on the screen.
#[derive(Clone, Copy, Debug)]
pub(super) struct WeekGrid {
    /// All of it, scrolled.
    pub(super) rect: Rect,
    /// Width of the columns of hours together.
    pub(super) gutter: f32,
}

impl WeekGrid {
    pub(super) fn day_width(&self) -> f32 {
        (self.rect.width() - self.gutter) / 7.0
    }

    pub(super) fn day_left(&self, day: usize) -> f32 {
        self.rect.left() + self.gutter + day as f32 * self.day_width()
    }

    pub(super) fn y(&self, minute: f32) -> f32 {
        self.rect.top() + minute / 60.0 * HOUR_HEIGHT
    }

    /// The day at a position, and the minute.
    pub(super) fn at(&self, position: Pos2) -> Option<(usize, f32)> {
        let day = ((position.x - self.rect.left() - self.gutter) / self.day_width()).floor();
        let minute = (position.y - self.rect.top()) / HOUR_HEIGHT * 60.0;
        (0.0..7.0).contains(&day).then_some((day as usize, minute))
    }

    pub(super) fn segment(&self, segment: &DaySegment) -> Rect {
        let width = (self.day_width() - 6.0) / segment.lanes as f32;
        let left = self.day_left(segment.day) + 3.0 + segment.lane as f32 * width;
        let (top, bottom) = (self.y(segment.from_min as f32), self.y(segment.to_min as f32));
        Rect::from_min_max(pos2(left, top + 1.0), pos2(left + width - 2.0, bottom - 1.0))
    }
}
