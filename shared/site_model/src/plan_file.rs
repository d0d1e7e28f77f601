//! Missions and schedules as a local file, such as one that a browser saves and loads.

use crate::{Change, Edit, EditId, Mission, Object, Schedule, Site};
use serde::{Deserialize, Serialize};

/// Version of the form that this program writes.
pub const PLAN_FILE_VERSION: u32 = 1;

/// Missions and schedules in a file of their own. They keep their ids, so that a file that is loaded twice changes nothing the second time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanFile {
    /// Version of the form.
    pub format_version: u32,
    /// Missions.
    #[serde(default)]
    pub missions: Vec<Mission>,
    /// Schedules.
    #[serde(default)]
    pub schedules: Vec<Schedule>,
}

/// Why a file cannot be loaded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanFileError {
    /// A later program has written it.
    #[error("the file has version {0}, which a later program writes; update AutoInspect")]
    TooNew(u32),
}

impl PlanFile {
    /// All missions and schedules of a site.
    pub fn of(site: &Site) -> Self {
        Self {
            format_version: PLAN_FILE_VERSION,
            missions: site.missions().cloned().collect(),
            schedules: site.schedules().cloned().collect(),
        }
    }

    /// The edit, named `id`, that puts what the file has into a site. What the site has beside it stays.
    ///
    /// # Errors
    /// When a later program has written the file.
    pub fn edit(&self, site: &Site, id: EditId) -> Result<Edit, PlanFileError> {
        if self.format_version > PLAN_FILE_VERSION {
            return Err(PlanFileError::TooNew(self.format_version));
        }
        let missions = self.missions.iter().cloned().map(Object::Mission);
        let objects = missions.chain(self.schedules.iter().cloned().map(Object::Schedule));
        let is_new = |object: &Object| site.get(object.id()).is_none_or(|known| known.object != *object);
        let put = |object: Object| Change::Put { base: site.revision(object.id()), object };
        Ok(Edit { id, changes: objects.filter(is_new).map(put).collect() })
    }
}
