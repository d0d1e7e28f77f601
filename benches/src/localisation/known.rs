//! A simulated site and the map that the stack made of it.

use crate::Arguments;
use anyhow::{Context, Result};
use benches::stack_walk::{Plan, StackWalk};
use geometry::{Isometry, Rotation, isometry_from_pose};
use localisation::Guide;
use mapping::Place;
use messages::{Effect, Publication};
use points::Downsampler;
use sim::{Site, SiteName};
use std::collections::BTreeMap;
use std::sync::Arc;
use vocab::Span;

/// A site with its map.
pub struct KnownSite {
    pub site: Arc<Site>,
    pub guide: Arc<Guide>,
    pub site_from_map: Isometry,
}

impl KnownSite {
    /// Walks the site's round and keeps the map.
    pub fn map(name: SiteName, arguments: &Arguments) -> Result<Self> {
        let site = Arc::new(Site::new(name));
        let plan = Plan {
            seed: arguments.seed,
            columns: arguments.columns,
            people: arguments.people,
            keep_truth: true,
        };
        let mut places = BTreeMap::new();
        let mut downsampler = Downsampler::default();
        let mut heard = |_, _, effects: &[Effect]| {
            for effect in effects {
                let Effect::Publish(Publication::Keyframe(keyframe)) = effect else { continue };
                let rotation = isometry_from_pose(&keyframe.map_from_keyframe)
                    .map_or_else(Rotation::identity, |pose| pose.rotation);
                let place = Place::new(&keyframe.cloud.xyz, &rotation, keyframe.lidar, &mut downsampler);
                places.insert(keyframe.id, place);
            }
        };
        let mut walk = StackWalk::new(&site, "round", &plan, &mut heard)?;
        walk.walk(Span::from_secs_f64(arguments.minutes * 60.0), &mut heard)?;
        let (finished, truth) = walk.finish(&mut heard)?;
        let (mut keyframes, mut pairs) = (Vec::new(), Vec::new());
        for node in &finished.graph.nodes {
            let map_from_keyframe =
                isometry_from_pose(&node.map_from_keyframe).context("a keyframe has no pose")?;
            let place = places.remove(&node.id).context("a keyframe has no cloud")?;
            let site_from_keyframe = truth.at(node.stamp).context("no truth was kept")?;
            pairs.push((site_from_keyframe.translation.vector, map_from_keyframe.translation.vector));
            keyframes.push((map_from_keyframe, place));
        }
        let alignment = geometry::umeyama(&pairs, false).context("the walk was too short")?;
        let site_from_map = alignment.truth_from_estimate;
        Ok(Self { site, guide: Arc::new(Guide::new(keyframes)), site_from_map })
    }
}
