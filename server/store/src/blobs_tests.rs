//! Files of actions are whole or absent, and damage to them is found.

use super::*;
use std::time::SystemTime;

struct Found(Vec<String>);

impl StoredDataReport for Found {
    fn on_damage(&mut self, error: StoreError) {
        self.0.push(error.to_string());
    }
    fn on_read(&mut self, _bytes: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

fn damage(store: &Store) -> Vec<String> {
    let mut found = Found(Vec::new());
    store.check_stored_data(&[], &mut found).expect("readable");
    found.0
}

#[test]
fn a_file_is_named_by_its_bytes_and_stays_when_the_store_is_opened_again() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let config = BlobsConfig::default();
    let store = Store::open(dir.path()).expect("opens");
    let hash = store.put_blob(b"a picture", &config).expect("stored");
    assert_eq!(hash.0, *blake3::hash(b"a picture").as_bytes());
    assert_eq!(store.put_blob(b"a picture", &config).expect("stored"), hash);
    let path = store.dir().blob(hash);
    // One that was being written when the process was killed.
    let half = files::temporary_path(&path);
    fs::write(&half, b"a pic").expect("written");
    drop(store);
    let store = Store::open(dir.path()).expect("opens");
    assert_eq!(fs::read(&path).expect("read"), b"a picture");
    assert!(!half.exists());
    // No map refers to it, however old it is.
    let in_a_year = SystemTime::now() + std::time::Duration::from_secs(365 * 24 * 3600);
    store.remove_unused_tiles(in_a_year).expect("removed");
    assert!(path.exists() && damage(&store).is_empty());
}

#[test]
fn files_are_refused_where_they_are_too_long_or_the_disk_is_nearly_full() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let short = BlobsConfig { max_bytes: 3, min_free_bytes: 0 };
    assert!(matches!(store.put_blob(b"four", &short), Err(BlobError::TooLong { bytes: 4, max_bytes: 3 })));
    let full = BlobsConfig { min_free_bytes: u64::MAX, ..BlobsConfig::default() };
    assert!(matches!(store.put_blob(b"four", &full), Err(BlobError::DiskFull)));
    assert_eq!(files::entries(&store.dir().blobs()).expect("readable"), Vec::<PathBuf>::new());
}

#[test]
fn damage_of_every_kind_is_found_and_mended_by_storing_the_bytes_again() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let config = BlobsConfig::default();
    let store = Store::open(dir.path()).expect("opens");
    let path = store.dir().blob(store.put_blob(b"a spectrum", &config).expect("stored"));
    let other = store.dir().blob(store.put_blob(b"another one", &config).expect("stored"));
    let damages: [fn(&std::path::Path); 4] = [
        |path| fs::write(path, b"a spec").expect("cut"),
        |path| fs::write(path, b"a spectrun").expect("flipped"),
        |path| fs::write(path, b"").expect("emptied"),
        |path| {
            fs::remove_file(path).expect("removed");
            fs::create_dir(path).expect("made");
        },
    ];
    for apply in damages {
        apply(&path);
        let found = damage(&store);
        assert!(found.len() == 1 && found[0].contains(&path.display().to_string()), "{found:?}");
        store.put_blob(b"a spectrum", &config).expect("stored again");
        assert_eq!(damage(&store), Vec::<String>::new());
    }
    assert_eq!(fs::read(&other).expect("read"), b"another one");
}
