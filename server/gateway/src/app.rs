//! What every connection of one gateway shares.

use crate::GatewayConfig;
use crate::edit_places::EditPlaces;
use crate::hub::Hub;
use crate::limits::{FIXED, Limits};
use crate::reserved_places::ReservedPlaces;
use crate::tls::Encryption;
use std::path::PathBuf;
use std::sync::Arc;
use tokio::sync::{Semaphore, mpsc, watch};

/// Shared by all connections. When the last holder drops it, everything has ended.
pub(crate) struct App {
    pub(crate) hub: Arc<Hub>,
    pub(crate) limits: Limits,
    /// How connections are encrypted; none: they are not.
    pub(crate) encryption: Option<Encryption>,
    /// Places of connections that come when all others are taken.
    pub(crate) reserved_places: ReservedPlaces,
    pub(crate) data_dir: PathBuf,
    pub(crate) static_dir: PathBuf,
    /// One permit for each file that may be on its way.
    pub(crate) uploading: Semaphore,
    /// One permit for each control socket of which the first message may be read.
    pub(crate) greeting: Semaphore,
    /// Places of edits over HTTP that are being read.
    pub(crate) editing: EditPlaces,
    /// One permit for each run that may be downloaded.
    pub(crate) downloading: Arc<Semaphore>,
    stopping: watch::Receiver<bool>,
    _alive: mpsc::Sender<()>,
}

impl App {
    /// `stopping` turns true when all should end; `alive` is held until all has.
    pub(crate) fn new(
        config: &GatewayConfig,
        limits: Limits,
        hub: Arc<Hub>,
        encryption: Option<Encryption>,
        stopping: watch::Receiver<bool>,
        alive: mpsc::Sender<()>,
    ) -> Self {
        Self {
            hub,
            limits,
            reserved_places: ReservedPlaces::new(limits.reserved_connections),
            encryption,
            data_dir: config.data_dir.clone(),
            static_dir: config.static_dir.clone(),
            uploading: Semaphore::new(FIXED.max_uploads_at_a_time),
            greeting: Semaphore::new(FIXED.max_greetings_at_a_time),
            editing: EditPlaces::default(),
            downloading: Arc::new(Semaphore::new(FIXED.max_downloads_at_a_time)),
            stopping,
            _alive: alive,
        }
    }

    /// Returns when the gateway stops.
    pub(crate) async fn shutdown(&self) {
        // An error means that the server is gone altogether, which is a stop too.
        self.stopping.clone().wait_for(|stopping| *stopping).await.ok();
    }
}
