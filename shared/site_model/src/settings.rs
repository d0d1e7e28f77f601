//! What holds for the whole site.

use serde::{Deserialize, Serialize};
use vocab::MapId;

/// Settings of the site.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SiteSettings {
    /// Name of the site.
    pub name: String,
    /// Time zone of its schedules: a name of the IANA database, such as `Europe/London`.
    pub time_zone: String,
    /// The saved map to which poses refer; none before the first map.
    #[serde(default)]
    pub map: Option<MapId>,
}

impl SiteSettings {
    /// Settings of a site that nobody has named, with its map.
    pub fn of_unnamed(map: MapId) -> Self {
        Self { name: "Site".to_owned(), time_zone: "UTC".to_owned(), map: Some(map) }
    }
}
