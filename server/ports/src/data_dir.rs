//! Layout of the data directory.
//!
//! ```text
//! tiles/ab/<hash>          encoded tiles, named by the BLAKE3 of their bytes, immutable
//! blobs/ab/<hash>          files that actions have gathered, named by the BLAKE3 of their bytes, immutable
//! run-clouds/<run>/<hash>  clouds seen on a run of a mission, named by the BLAKE3 of their bytes, with index.jsonl; see the store
//! maps/<map id>/           one immutable directory per map version; see the store
//! maps/.<anything>         incomplete maps, to be deleted
//! bin/<map id>/            deleted maps, kept for a week; see the store
//! bin/.<anything>          maps that are being deleted for good
//! sessions/<session>/      clouds and journal of a mapping session, until it is saved or discarded; see the store
//! uploads/<id>             uploaded files that wait to be imported; see the store
//! uploads/<id>.json        what is known of an uploaded file
//! uploads/<id>.part        a file that is being received
//! uploads/<id>.map/        the map that is being made of a file
//! place.json               last pose of the robot in the map in use
//! docks.json               docks of the saved maps
//! stop.json                whether motion is stopped, and by whom
//! ledger.db                what people have made of the site and what the robot did, an SQLite database; see the store
//! recordings/<time>/       inputs of the stack in one run, in segments; see the store. Names sort by time
//! run/lock                 held by the process that owns the directory
//! run/core.sock            the core's Unix socket for the gateway
//! run/first-admin          secret of the link that makes the first admin, while there is none
//! ```

use api::TileHash;
use site_model::RunId;
use std::path::{Path, PathBuf};
use vocab::{BlobHash, MapId, UploadId};

/// Longest path of a Unix socket that every system accepts, bytes.
const MAX_SOCKET_PATH: usize = 100;

/// Paths under one data directory. Nothing is created or checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DataDir {
    root: PathBuf,
}

impl DataDir {
    /// The layout under `root`.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }

    /// The directory itself.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Directory of all tiles.
    pub fn tiles(&self) -> PathBuf {
        self.root.join("tiles")
    }

    /// File of one tile.
    pub fn tile(&self, hash: TileHash) -> PathBuf {
        let name = hash.to_string();
        self.tiles().join(&name[..2]).join(name)
    }

    /// Directory of all files that actions have gathered.
    pub fn blobs(&self) -> PathBuf {
        self.root.join("blobs")
    }

    /// One of them.
    pub fn blob(&self, hash: BlobHash) -> PathBuf {
        let name = hash.to_string();
        self.blobs().join(&name[..2]).join(name)
    }

    /// Directory of the clouds of all runs.
    pub fn run_clouds(&self) -> PathBuf {
        self.root.join("run-clouds")
    }

    /// What was last seen of each place, while a run is compared with it.
    pub fn background(&self) -> PathBuf {
        self.root.join("background")
    }

    /// Clouds of a run.
    pub fn clouds_of_run(&self, run: RunId) -> PathBuf {
        self.run_clouds().join(run.to_string())
    }

    /// List of the clouds of a run, one JSON object a line.
    pub fn run_cloud_index(&self, run: RunId) -> PathBuf {
        self.run_clouds().join(run.to_string()).join("index.jsonl")
    }

    /// A cloud of a run.
    pub fn run_cloud(&self, run: RunId, hash: BlobHash) -> PathBuf {
        self.run_clouds().join(run.to_string()).join(hash.to_string())
    }

    /// Directory of all map versions.
    pub fn maps(&self) -> PathBuf {
        self.root.join("maps")
    }

    /// Directory of one map version.
    pub fn map(&self, map: MapId) -> PathBuf {
        self.maps().join(map.to_string())
    }

    /// A map version's [`api::MapSummary`] as JSON. Its presence makes the directory a map.
    pub fn map_summary(&self, map: MapId) -> PathBuf {
        self.map(map).join("map.json")
    }

    /// A map version's pose graph, an [`api::Graph`] as JSON.
    pub fn map_graph(&self, map: MapId) -> PathBuf {
        self.map(map).join("graph.json")
    }

    /// A map version's tiles, an [`api::TileList`] as JSON.
    pub fn map_tiles(&self, map: MapId) -> PathBuf {
        self.map(map).join("tiles.json")
    }

    /// Directory of deleted maps.
    pub fn bin(&self) -> PathBuf {
        self.root.join("bin")
    }

    /// Directory of one deleted map.
    pub fn binned_map(&self, map: MapId) -> PathBuf {
        self.bin().join(map.to_string())
    }

    /// Directory of mapping sessions that run or were interrupted.
    pub fn sessions(&self) -> PathBuf {
        self.root.join("sessions")
    }

    /// Directory of files that clients have sent.
    pub fn uploads(&self) -> PathBuf {
        self.root.join("uploads")
    }

    /// One uploaded file.
    pub fn upload(&self, upload: UploadId) -> PathBuf {
        self.uploads().join(upload.to_string())
    }

    /// What is known of an uploaded file besides its bytes.
    pub fn upload_note(&self, upload: UploadId) -> PathBuf {
        self.uploads().join(format!("{upload}.json"))
    }

    /// Directory in which the map of an upload is made.
    pub fn upload_map(&self, upload: UploadId) -> PathBuf {
        self.uploads().join(format!("{upload}.map"))
    }

    /// Last known pose of the robot, a [`messages::PoseInMap`] as JSON.
    pub fn last_pose(&self) -> PathBuf {
        self.root.join("place.json")
    }

    /// Docks of the saved maps, a list of [`messages::PoseInMap`] as JSON.
    pub fn docks(&self) -> PathBuf {
        self.root.join("docks.json")
    }

    /// Whether motion is stopped and by whom, a [`messages::StopLatch`] as JSON.
    pub fn stop_latch(&self) -> PathBuf {
        self.root.join("stop.json")
    }

    /// The ledger, an SQLite database. SQLite keeps `ledger.db-wal` and `ledger.db-shm` beside it.
    pub fn ledger(&self) -> PathBuf {
        self.root.join("ledger.db")
    }

    /// Certificate authority of the robot's own and its key.
    pub fn tls(&self) -> PathBuf {
        self.root.join("tls")
    }

    /// Secret of the link that makes the first admin. It is there while there is no admin.
    pub fn first_admin_link(&self) -> PathBuf {
        self.root.join("run").join("first-admin")
    }

    /// Directory of all recordings.
    pub fn recordings(&self) -> PathBuf {
        self.root.join("recordings")
    }

    /// Socket on which the core listens for the gateway.
    pub fn core_socket(&self) -> PathBuf {
        self.socket("core.sock")
    }

    /// Socket on which the simulated robot listens for the core.
    pub fn robot_socket(&self) -> PathBuf {
        self.socket("robot.sock")
    }

    /// A socket in the data directory. If that path is too long for a socket, it is in the system's directory for temporary files, under a name
    /// derived from the path.
    fn socket(&self, name: &str) -> PathBuf {
        let inside = self.root.join("run").join(name);
        if inside.as_os_str().len() <= MAX_SOCKET_PATH {
            return inside;
        }
        // FNV-1a is stable between processes. In a collision the second core reports that the socket is in use.
        let hash =
            inside.as_os_str().as_encoded_bytes().iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
                (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
            });
        std::env::temp_dir().join(format!("autoinspect-{hash:016x}.sock"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_socket_of_a_deep_directory_has_a_path_short_enough_to_bind() {
        let deep = DataDir::new(format!("/{}", "long/".repeat(40)));
        let other = DataDir::new(format!("/{}", "lung/".repeat(40)));
        assert!(deep.core_socket().as_os_str().len() <= MAX_SOCKET_PATH);
        assert_ne!(deep.core_socket(), other.core_socket());
        assert_ne!(deep.core_socket(), deep.robot_socket());
        assert_eq!(DataDir::new("/data").core_socket(), Path::new("/data/run/core.sock"));
    }

    #[test]
    fn tiles_are_spread_over_directories_by_the_first_byte_of_their_name() {
        let hash = TileHash([0xab; 32]);
        assert_eq!(DataDir::new("/d").tile(hash), Path::new("/d/tiles/ab").join("ab".repeat(32)));
    }
}
