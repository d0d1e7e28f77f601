//! Buildings of other programs, and what is changed at a site.

use crate::assert_sentence;
use sim::{BuildingModel, BuildingModelConfig, Material, Mobility, ModelPart, ModelTriangle, SimulatedSite};
use site_files::SiteChanges;
use std::sync::OnceLock;

/// A GLB file with its sidecar. The input is the length of the sidecar, two bytes, the sidecar, and the GLB file.
pub fn site(bytes: &[u8]) {
    let Some((length, rest)) = bytes.split_first_chunk::<2>() else { return };
    let (sidecar, model) = rest.split_at(usize::from(u16::from_le_bytes(*length)).min(rest.len()));
    if let Err(error) = site_files::fuzzing::read_model(model, sidecar) {
        assert_sentence(&error);
    }
}

/// The JSON file of what is changed at a site. What is read is written and read again, and made at a site that has nothing but a floor.
///
/// # Panics
/// When something else is read again than was written.
pub fn site_changes(bytes: &[u8]) {
    static FLOOR: OnceLock<SimulatedSite> = OnceLock::new();
    let changes = match SiteChanges::parse(bytes) {
        Ok(changes) => changes,
        Err(sentence) => return assert_sentence(&Sentence(sentence)),
    };
    let text = changes.to_text().expect("plain data becomes JSON");
    let again = SiteChanges::parse(text.as_bytes()).expect("what was written can be read");
    let counts = |changes: &SiteChanges| (changes.objects.len(), changes.conditions.len());
    assert_eq!(counts(&changes), counts(&again));
    if let Err(sentence) = changes.apply(FLOOR.get_or_init(floor)) {
        assert_sentence(&Sentence(sentence));
    }
}

/// A sentence as an error.
#[derive(Debug)]
struct Sentence(String);

impl std::fmt::Display for Sentence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Sentence {}

/// A floor of 10 x 10 m.
fn floor() -> SimulatedSite {
    let [a, b, c, d] = [[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [5.0, 5.0, 0.0], [-5.0, 5.0, 0.0]];
    let triangle = |corners| ModelTriangle { corners, material: Material::Concrete };
    let triangles = vec![triangle([a, b, c]), triangle([a, c, d])];
    let part = ModelPart { name: "floor".to_owned(), mobility: Mobility::Fixed, triangles };
    let model = BuildingModel { name: "floor".to_owned(), parts: vec![part], ..BuildingModel::default() };
    SimulatedSite::from_model(model, &BuildingModelConfig::default()).expect("a floor is a site")
}
