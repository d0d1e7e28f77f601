//! Points of the objects that have changed between visits: fetched from the server, and made the renderer's two clouds, of the earlier and of the later visit.

use crate::downloads::fetch_bytes;
use crate::inbox::Inbox;
use crate::ply_points::{Points, parse_ply};
use client_model::Model;
use scene::PointBlock;
use site_model::{SceneChange, SceneChangeKind};
use std::cell::RefCell;
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::rc::Rc;
use vocab::BlobHash;
use wasm_bindgen_futures::spawn_local;
use web_sys::RequestInit;

/// Parameters of the clouds.
struct ChangeCloudsConfig {
    /// Objects of which points are shown, those that were seen last. Chosen: the rows of the list.
    max_objects: usize,
    /// Edge of the renderer's lattice, m. Chosen: points of runs lie within half a centimetre, and a lattice of 65,536 cells spans 327 m.
    step_m: f32,
}

const CONFIG: ChangeCloudsConfig = ChangeCloudsConfig { max_objects: 100, step_m: 0.005 };

/// The clouds that were fetched, those under way, and what is on the screen.
pub(crate) struct ChangeClouds {
    inbox: Inbox,
    /// By blob; none: under way, or it cannot be had.
    fetched: Rc<RefCell<BTreeMap<BlobHash, Option<Points>>>>,
    /// The blobs on the screen, those of the earlier visit first.
    shown: [Vec<BlobHash>; 2],
}

/// Points on the renderer's lattice.
pub(crate) struct LatticeCloud {
    origin: [f32; 3],
    points: Vec<[u16; 4]>,
}

impl ChangeClouds {
    /// Every cloud that comes requests a frame through `inbox`.
    pub(crate) fn new(inbox: Inbox) -> Self {
        Self { inbox, fetched: Rc::default(), shown: [Vec::new(), Vec::new()] }
    }

    /// Fetches what is missing. Returns both clouds if what is on the screen has to change.
    pub(crate) fn update(&mut self, model: &Model) -> Option<[Option<LatticeCloud>; 2]> {
        let wanted = wanted(model);
        self.fetched.borrow_mut().retain(|blob, _| wanted.iter().flatten().any(|wanted| wanted == blob));
        for blob in wanted.iter().flatten() {
            self.fetch(*blob);
        }
        let fetched = self.fetched.borrow();
        let there = wanted.map(|mut blobs| {
            blobs.retain(|blob| fetched.get(blob).is_some_and(Option::is_some));
            blobs
        });
        if there == self.shown {
            return None;
        }
        let clouds = there.each_ref().map(|blobs| {
            let points = blobs.iter().filter_map(|blob| fetched.get(blob)?.as_ref());
            LatticeCloud::new(&points.flatten().copied().collect::<Points>())
        });
        self.shown = there;
        Some(clouds)
    }

    fn fetch(&self, blob: BlobHash) {
        if self.fetched.borrow().contains_key(&blob) {
            return;
        }
        self.fetched.borrow_mut().insert(blob, None);
        let (inbox, fetched) = (self.inbox.clone(), Rc::clone(&self.fetched));
        spawn_local(async move {
            let path = api::paths::BLOB_PATH.replace("{hash}", &blob.to_string());
            // A cloud that cannot be had is not shown; the box of its object is.
            let Ok(bytes) = fetch_bytes(&path, &RequestInit::new()).await else { return };
            if let Some(place) = fetched.borrow_mut().get_mut(&blob) {
                *place = parse_ply(&bytes);
            }
            inbox.request_frame();
        });
    }
}

/// The blobs of the earlier and of the later visit that are to be seen.
fn wanted(model: &Model) -> [Vec<BlobHash>; 2] {
    let map = model.saved_map_on_screen();
    let site = model.site.site().filter(|_| panels::shows_changes(model) && map.is_some());
    let is_shown = |change: &&SceneChange| map == Some(change.map) && !change.review.is_settled();
    let mut changes: Vec<&SceneChange> =
        site.into_iter().flat_map(|site| site.scene_changes()).filter(is_shown).collect();
    changes.sort_by_key(|change| (Reverse(change.last_seen), change.id));
    changes.truncate(CONFIG.max_objects);
    let mut wanted = [Vec::new(), Vec::new()];
    for change in changes {
        let Some(clouds) = change.clouds else { continue };
        let is_gone = change.kind == SceneChangeKind::Removed;
        wanted[usize::from(!is_gone)].push(clouds.object);
    }
    let visits = model.changes_view.shown().visits();
    for (blobs, is_shown) in wanted.iter_mut().zip(visits) {
        blobs.sort_unstable();
        if !is_shown {
            blobs.clear();
        }
    }
    wanted
}

impl LatticeCloud {
    /// None without points.
    fn new(points: &[[f32; 3]]) -> Option<Self> {
        let origin =
            points.iter().copied().reduce(|a, b| std::array::from_fn(|axis| a[axis].min(b[axis])))?;
        // A number that is too large becomes the largest one.
        let lattice = |point: &[f32; 3]| -> [u16; 4] {
            let [x, y, z] =
                std::array::from_fn(|axis| ((point[axis] - origin[axis]) / CONFIG.step_m).round() as u16);
            [x, y, z, 0]
        };
        Some(Self { origin, points: points.iter().map(lattice).collect() })
    }

    /// For the renderer.
    pub(crate) fn block(&self) -> PointBlock<'_> {
        PointBlock {
            origin: self.origin,
            step: CONFIG.step_m,
            spacing: 0.0,
            stamp: 0.0,
            points: &self.points,
        }
    }
}
