//! Opening a data directory after a process that was killed.

use super::*;
use std::fs;
use std::thread;

#[test]
fn a_process_that_is_about_to_end_is_waited_for() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let dying = Store::open(dir.path()).expect("opens");
    let thread = thread::spawn(move || {
        // Less than the patience, and longer than an attempt.
        thread::sleep(Duration::from_millis(100));
        drop(dying);
    });
    let store = Store::open(dir.path()).expect("opens once the other has ended");
    thread.join().expect("ended");
    assert!(matches!(Store::open(dir.path()), Err(StoreError::InUse { .. })));
    drop(store);
}

#[test]
fn half_written_documents_are_removed() {
    let dir = tempfile::tempdir().expect("temporary directory");
    drop(Store::open(dir.path()).expect("opens"));
    for name in ["stop.part", "place.part"] {
        fs::write(dir.path().join(name), "{").expect("written");
    }
    let store = Store::open(dir.path()).expect("opens");
    let left: Vec<_> =
        files::entries(dir.path()).expect("listed").into_iter().filter(|path| path.is_file()).collect();
    assert_eq!(left, Vec::<PathBuf>::new());
    drop(store);
}

#[test]
fn an_import_that_still_writes_does_not_keep_the_robot_from_starting() {
    let dir = tempfile::tempdir().expect("temporary directory");
    drop(Store::open(dir.path()).expect("opens"));
    let uploads = dir.path().join("uploads");
    // An import that goes on writing.
    let map = "00000000-0000-0000-0000-000000000001.map";
    let (stop, stopped) = std::sync::mpsc::channel::<()>();
    let writer = thread::spawn(move || {
        for number in 0.. {
            if stopped.try_recv() != Err(std::sync::mpsc::TryRecvError::Empty) {
                return;
            }
            let _ = fs::create_dir_all(uploads.join(map));
            let _ = fs::write(uploads.join(map).join((number % 64).to_string()), [0; 64]);
        }
    });
    for _ in 0..20 {
        drop(Store::open(dir.path()).expect("opens"));
    }
    drop(stop);
    writer.join().expect("ended");
}
