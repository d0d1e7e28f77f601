//! Quality of the map under construction: covered floor, accuracy, places worth a visit.

use super::Feature;
use crate::shared::Context;
use api::Quality;

/// The last report.
#[derive(Clone, Debug, Default)]
pub struct QualityFeature {
    quality: Quality,
}

impl QualityFeature {
    pub(crate) fn quality(&self) -> &Quality {
        &self.quality
    }
}

impl Feature for QualityFeature {
    fn on_event(&mut self, event: &api::Event, _cx: &mut Context<'_>) {
        if let api::Event::Quality(quality) = event {
            quality.clone_into(&mut self.quality);
        }
    }
}

#[cfg(test)]
mod tests;
