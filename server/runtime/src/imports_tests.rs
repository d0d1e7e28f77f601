//! Requests that are refused, and names. The whole path of an import is tested in `core_tests/imports.rs`.

use super::*;
use uuid::Uuid;

fn request(number: u128) -> ImportRequest {
    let upload = UploadId(Uuid::from_u128(number));
    let by = Principal::operator(vocab::ClientId(Uuid::from_u128(5)));
    let source = ImportSource::File { frame: None };
    ImportRequest { upload, by, address: None, name: "Hall".to_owned(), source }
}

#[test]
fn one_request_waits_and_the_next_is_refused() {
    let (imports, requests) = ImportQueue::new();
    assert_eq!(imports.begin(request(1)), Ok(()));
    assert_eq!(imports.begin(request(2)), Err(texts::IMPORT_BUSY.to_owned()));
    assert_eq!(requests.try_recv().expect("the first waits").upload, UploadId(Uuid::from_u128(1)));
    assert_eq!(imports.begin(request(3)), Ok(()));
    drop(requests);
    assert_eq!(imports.begin(request(4)), Err(texts::PLATFORM_ENDING.to_owned()));
    assert_eq!(ImportQueue::none().begin(request(5)), Err(texts::NO_IMPORTER.to_owned()));
}

#[test]
fn the_worker_learns_which_import_is_cancelled() {
    let (imports, _requests) = ImportQueue::new();
    let cancelled = imports.cancelled();
    let upload = UploadId(Uuid::from_u128(1));
    imports.clone().cancel(upload);
    assert_eq!(*cancelled.lock().expect("no panic"), Some(upload));
}

#[test]
fn names_fit_on_one_line() {
    assert_eq!(display_name(" Pump\u{7} hall\n"), "Pump hall");
    assert_eq!(display_name("\u{7} \n"), texts::UNNAMED_MAP);
    assert_eq!(display_name(&"ä".repeat(200)), "ä".repeat(CONFIG.max_name_chars));
}
