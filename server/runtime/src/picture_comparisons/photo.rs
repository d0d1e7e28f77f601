//! The photo of a result.

use api::StoredResult;
use serde::Deserialize;
use site_model::{ActionReport, InspectionPointId};
use vocab::BlobHash;

/// The action whose pictures are compared. Thermal pictures show heat, which changes with every load.
pub(super) const PHOTO: &str = "photo";

/// A photo of an inspection point.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Photo {
    /// Number of its result.
    pub(super) result: u64,
    pub(super) point: InspectionPointId,
    /// Its file.
    pub(super) picture: BlobHash,
    pub(super) report: ActionReport,
}

/// What the body of a result says of its place and of what was found.
#[derive(Deserialize)]
struct Details {
    inspection_point: InspectionPointId,
    value: ActionReport,
}

impl Photo {
    /// The photo of a result; none if it has none, or is of no inspection point.
    pub(super) fn of(result: &StoredResult) -> Option<Self> {
        let Details { inspection_point, value } = serde_json::from_str(&result.body).ok()?;
        let file = value.files.iter().find(|file| file.media_type.starts_with("image/"))?;
        let is_photo = result.kind == PHOTO;
        is_photo.then(|| Self {
            result: result.number,
            point: inspection_point,
            picture: file.blob,
            report: value.clone(),
        })
    }
}
