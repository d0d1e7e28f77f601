//! Texts that are saved as files of the operator's machine, as downloads of the browser.

use crate::browser;
use wasm_bindgen::{JsCast, JsValue};
use web_sys::{Blob, BlobPropertyBag, HtmlAnchorElement, Url};

/// Saves a text as a file of this name and media type. A browser that refuses is noted in its console.
pub(crate) fn save(name: &str, media_type: &str, text: &str) {
    if download(name, media_type, text).is_none() {
        browser::log_warning(&format!("{name} could not be saved"));
    }
}

fn download(name: &str, media_type: &str, text: &str) -> Option<()> {
    let parts = js_sys::Array::of1(&JsValue::from_str(text));
    let properties = BlobPropertyBag::new();
    properties.set_type(media_type);
    let blob = Blob::new_with_str_sequence_and_options(&parts, &properties).ok()?;
    let url = Url::create_object_url_with_blob(&blob).ok()?;
    let link: HtmlAnchorElement = browser::create("a")?.dyn_into().ok()?;
    link.set_href(&url);
    link.set_download(name);
    link.click();
    // The browser keeps the data until the download has ended.
    let _ = Url::revoke_object_url(&url);
    Some(())
}
