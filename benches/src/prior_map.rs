//! Makes the prior map of a mapping walk, in the form in which the stack reads it from disk.

use anyhow::{Context, Result};
use messages::{FinishedMap, PriorKeyframe, PriorMap, Publication, StackEffect};
use std::collections::BTreeMap;
use vocab::KeyframeId;

/// Collects the keyframes of a mapping walk.
#[derive(Debug, Default)]
pub struct PriorMapBuilder {
    keyframes: BTreeMap<KeyframeId, PriorKeyframe>,
}

impl PriorMapBuilder {
    /// Adds the keyframes among the effects of a step.
    pub fn insert(&mut self, effects: &[StackEffect]) {
        for effect in effects {
            let StackEffect::Publish(Publication::Keyframe(keyframe)) = effect else { continue };
            let (pose, xyz) = (&keyframe.map_from_keyframe, &keyframe.cloud.xyz);
            let encoded = stack::encode_prior_keyframe(pose, xyz, keyframe.lidar);
            self.keyframes.extend(encoded.map(|encoded| (keyframe.id, encoded)));
        }
    }

    /// The prior map of the finished walk.
    ///
    /// # Errors
    /// When a keyframe of the map was not collected.
    pub fn build(mut self, finished: &FinishedMap) -> Result<PriorMap> {
        let nodes = finished.graph.nodes.iter();
        let keyframes = nodes.map(|node| self.keyframes.remove(&node.id).context("a keyframe has no cloud"));
        let places = keyframes.collect::<Result<_>>()?;
        Ok(PriorMap { map: finished.map, graph: finished.graph.as_ref().clone(), keyframes: places })
    }
}
