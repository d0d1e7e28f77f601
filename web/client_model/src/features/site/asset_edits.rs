//! Edits of assets, and of the things that lead to them, as operators make them: each a step of undo.

use super::{SiteEdit, SiteFeature};
use crate::texts;
use site_model::{Asset, AssetId, InspectionPoint, Object, ObjectId};
use std::collections::BTreeSet;

impl SiteFeature {
    /// All assets, by name.
    pub fn assets(&self) -> Vec<&Asset> {
        let objects = self.site().into_iter().flat_map(|site| site.objects());
        let mut assets: Vec<_> = objects
            .filter_map(|versioned| match &versioned.object {
                Object::Asset(asset) => Some(asset),
                _ => None,
            })
            .collect();
        assets.sort_by(|a, b| a.name.cmp(&b.name).then(a.id.cmp(&b.id)));
        assets
    }

    /// A new asset without tags.
    pub fn adding_asset(&self) -> (AssetId, SiteEdit) {
        let id = AssetId(self.new_id(0));
        let assets = self.assets();
        let names: BTreeSet<&str> = assets.iter().map(|asset| asset.name.as_str()).collect();
        let free = (1..).map(texts::asset_name).find(|name| !names.contains(name.as_str()));
        let asset = Asset { id, name: free.unwrap_or_default(), tags: BTreeSet::new() };
        (id, SiteEdit { put: vec![Object::Asset(asset)], removed: Vec::new() })
    }

    /// An asset after a change; nothing if that leaves it as it is.
    pub fn changing_asset(&self, id: AssetId, change: impl FnOnce(&mut Asset)) -> SiteEdit {
        let mut edit = SiteEdit::default();
        if let Some(asset) = self.assets().into_iter().find(|asset| asset.id == id) {
            let mut changed = asset.clone();
            change(&mut changed);
            if changed != *asset {
                edit.put.push(Object::Asset(changed));
            }
        }
        edit
    }

    /// The removal of an asset. The inspection points that belong to it stay, and belong to none.
    pub fn removing_asset(&self, id: AssetId) -> SiteEdit {
        let points = self.points_of_asset(id).into_iter();
        let put =
            points.map(|point| Object::InspectionPoint(InspectionPoint { asset: None, ..point.clone() }));
        SiteEdit { put: put.collect(), removed: vec![ObjectId::Asset(id)] }
    }

    /// The inspection points that belong to an asset, by name.
    pub fn points_of_asset(&self, id: AssetId) -> Vec<&InspectionPoint> {
        self.inspection_points().into_iter().filter(|point| point.asset == Some(id)).collect()
    }
}

/// The tags of a text in which they stand with commas between them.
pub fn tags_of(text: &str) -> BTreeSet<String> {
    text.split(',').map(str::trim).filter(|tag| !tag.is_empty()).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::Robot;
    use super::tags_of;
    use crate::testing::TestClient;
    use crate::{ClientCommand, SiteEdit};
    use vocab::{MapId, Vec3};

    #[test]
    fn an_asset_is_made_changed_and_removed_and_its_points_belong_to_none_then() {
        let robot = Robot::default();
        let mut client = TestClient::with_site(&robot);
        let map = MapId(uuid::Uuid::from_u128(3));
        let (node, edit) = client.model.site.adding_node(Vec3::default(), map, None);
        client.command(ClientCommand::EditSite(edit));
        let (point, edit) = client.model.site.adding_inspection_point(node, Vec3::new(2.0, 0.0, 1.0));
        client.command(ClientCommand::EditSite(edit));
        let (asset, edit) = client.model.site.adding_asset();
        client.command(ClientCommand::EditSite(edit));
        let edit = client.model.site.changing_inspection_point(point, |point| point.asset = Some(asset));
        client.command(ClientCommand::EditSite(edit));
        let tags = tags_of(" pump, , cooling water,pump");
        assert_eq!(tags.iter().map(String::as_str).collect::<Vec<_>>(), ["cooling water", "pump"]);
        let edit = client.model.site.changing_asset(asset, |asset| asset.tags.clone_from(&tags));
        client.command(ClientCommand::EditSite(edit));
        assert_eq!(client.model.site.changing_asset(asset, |asset| asset.tags = tags), SiteEdit::default());
        assert_eq!(client.model.site.points_of_asset(asset).len(), 1);

        client.command(ClientCommand::EditSite(client.model.site.removing_asset(asset)));
        assert!(client.model.site.assets().is_empty());
        assert_eq!(client.model.site.inspection_points()[0].asset, None);
        client.command(ClientCommand::Undo);
        assert_eq!(client.model.site.points_of_asset(asset).len(), 1);
    }
}
