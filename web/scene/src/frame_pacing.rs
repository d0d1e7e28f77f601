//! Frame pacing: lowers the rendering quality on slow machines so that movement stays smooth.
//!
//! A browser does not report the GPU time of a frame, but an overloaded GPU delays the next frame. Late frames lower the quality, and
//! frames in time raise it. Once nothing moves, the image is drawn again with a higher quality. Where even the lowest quality is too
//! much, frames that nobody waits for come seldom, so that the next press is answered at once.

use crate::renderer::Renderer;
use crate::view::{Options, View};

/// Parameters of [`FramePacer`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePacingConfig {
    /// An interval between frames above this one lowers the quality, s. Longer than the 0.1 s between live scans at 10 Hz. Chosen: a third longer.
    pub max_interval_s: f64,
    /// An interval below this one raises the quality, s. Chosen between both, so that the quality rests where frames come at 10 Hz or faster.
    pub min_interval_s: f64,
    /// A longer interval is a pause and is not a measure of the machine's speed, s. Chosen: longer than the slowest frame of a software device.
    pub pause_s: f64,
    /// Time without a change after which the image is refined, s. The refinement is repeated until the image has full quality. Chosen: people have stopped dragging by
    /// then.
    pub rest_s: f64,
    /// Factor by which one refinement raises the quality. Chosen: from the lowest quality three steps are enough.
    pub refinement_gain: f32,
    /// Lowest quality. Chosen: the shape of a room is still seen.
    pub min_quality: f32,
    /// Smallest factor by which one frame lowers the quality: one slow frame may be an outlier. Chosen: about a third; a machine that is ten times too slow is followed
    /// within three frames.
    pub max_decrease: f32,
    /// Factor by which one frame in time raises the quality. Chosen: twelve frames double the quality, so that it does not swing.
    pub increase: f32,
    /// Resolution for each unit of quality: points are reduced first, and pixels from a quality of 0.4 down. Chosen: one divided by 0.4.
    pub resolution_per_quality: f32,
    /// Interval of frames that show what the robot sends, s, where they are drawn in time. State arrives at 20 Hz and scans at 10 Hz. Chosen: a tenth of a second less the
    /// time of a frame.
    pub stream_interval_s: f64,
    /// The same where even the lowest quality is too much. Chosen: shorter than [`Self::rest_s`], or the image would be refined in between.
    pub overloaded_stream_interval_s: f64,
    /// Lowest resolution. Chosen: half; letters of labels are drawn apart.
    pub min_resolution: f32,
}

impl Default for FramePacingConfig {
    fn default() -> Self {
        Self {
            max_interval_s: 0.13,
            min_interval_s: 0.11,
            pause_s: 8.0,
            rest_s: 0.4,
            refinement_gain: 4.0,
            min_quality: 0.06,
            stream_interval_s: 0.09,
            overloaded_stream_interval_s: 0.35,
            max_decrease: 0.35,
            increase: 1.06,
            resolution_per_quality: 2.5,
            min_resolution: 0.5,
        }
    }
}

/// Adapts [`Options::point_budget`] and [`Options::resolution`] to the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePacer {
    config: FramePacingConfig,
    last: Option<LastFrame>,
    /// Share of the full quality during movement, from [`FramePacingConfig::min_quality`] to 1.
    quality: f32,
    /// Quality of the last image.
    drawn_quality: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct LastFrame {
    requested: View,
    drawn: View,
    drawn_at_s: f64,
}

impl Default for FramePacer {
    fn default() -> Self {
        Self::new(FramePacingConfig::default(), 1.0)
    }
}

impl FramePacer {
    /// `quality`: initial share of the full quality (0 to 1); less than 1 on machines known to be slow.
    pub fn new(config: FramePacingConfig, quality: f32) -> Self {
        Self { quality: quality.clamp(config.min_quality, 1.0), config, last: None, drawn_quality: 0.0 }
    }

    /// The view to draw for a requested one, and the time (s) after which another frame should be asked for to refine it.
    ///
    /// `now_s`: on a monotonic clock. Call once for each frame of the page, whether or not anything changed.
    pub fn next_view(&mut self, now_s: f64, requested: &View, renderer: &Renderer) -> (View, Option<f64>) {
        self.plan_frame(now_s, requested, renderer.changed())
    }

    /// [`Self::next_view`], given whether the scene changed since it was last drawn.
    pub(crate) fn plan_frame(&mut self, now_s: f64, requested: &View, changed: bool) -> (View, Option<f64>) {
        let Some(last) = self.last else {
            return self.draw(now_s, requested);
        };
        if changed || last.requested != *requested {
            self.update_quality(now_s - last.drawn_at_s);
            return self.draw(now_s, requested);
        }
        if self.drawn_quality >= 1.0 {
            return (last.drawn, None);
        }
        let remaining_s = self.config.rest_s - (now_s - last.drawn_at_s);
        if remaining_s > 0.0 {
            return (last.drawn, Some(remaining_s));
        }
        self.draw_at(now_s, requested, self.drawn_quality * self.config.refinement_gain)
    }

    /// Time from a frame to the next one that only shows what the robot sends, s.
    pub fn stream_interval_s(&self) -> f64 {
        if self.quality > self.config.min_quality {
            self.config.stream_interval_s
        } else {
            self.config.overloaded_stream_interval_s
        }
    }

    fn draw(&mut self, now_s: f64, requested: &View) -> (View, Option<f64>) {
        self.draw_at(now_s, requested, self.quality)
    }

    fn draw_at(&mut self, now_s: f64, requested: &View, quality: f32) -> (View, Option<f64>) {
        let quality = quality.min(1.0);
        let drawn = self.at_quality(requested, quality);
        self.drawn_quality = quality;
        self.last = Some(LastFrame { requested: *requested, drawn, drawn_at_s: now_s });
        (drawn, (quality < 1.0).then_some(self.config.rest_s))
    }

    /// Adapts the quality to the interval between this frame and the one before, s.
    fn update_quality(&mut self, interval_s: f64) {
        let config = &self.config;
        // The interval after a refinement measures how long nothing moved.
        let after_refinement = self.drawn_quality > self.quality;
        let quality = match interval_s {
            _ if after_refinement || interval_s >= config.pause_s => return,
            _ if interval_s > config.max_interval_s => {
                self.quality * ((config.max_interval_s / interval_s) as f32).max(config.max_decrease)
            }
            _ if interval_s < config.min_interval_s => self.quality * config.increase,
            _ => return,
        };
        self.quality = quality.clamp(config.min_quality, 1.0);
    }

    /// The requested view with fewer points, and with fewer pixels where that is not enough.
    fn at_quality(&self, requested: &View, quality: f32) -> View {
        let options = &requested.options;
        let resolution =
            (quality * self.config.resolution_per_quality).clamp(self.config.min_resolution, 1.0);
        let options = Options {
            point_budget: (options.point_budget as f32 * quality) as u32,
            resolution: options.resolution * resolution,
            ..*options
        };
        View { options, ..*requested }
    }
}
