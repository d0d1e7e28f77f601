//! Changes of the scene that are to be normal: the robot makes a new version of their map.

use super::SiteFeature;
use crate::shared::Context;
use crate::texts;
use site_model::SceneChangeId;
use vocab::UploadId;

impl SiteFeature {
    /// Asks for a version of the map of these changes in which they are normal.
    pub(super) fn make_normal(&self, changes: &[SceneChangeId], cx: &mut Context<'_>) {
        let Some(site) = self.site() else { return };
        let known: Vec<_> = site.scene_changes().filter(|change| changes.contains(&change.id)).collect();
        let Some(map) = known.first().map(|change| change.map) else { return };
        let name = cx.shared.maps.get(map).map_or(texts::UNNAMED_MAP, |map| map.name.as_str());
        let name = texts::normal_map_name(name);
        let upload = UploadId(cx.shared.ids.map().0);
        let changes = known.into_iter().filter(|change| change.map == map).map(|change| change.id);
        let changes = changes.take(api::MAX_ACCEPTED_CHANGES).collect();
        cx.send(api::Command::MakeNormal { upload, name, changes });
    }
}
