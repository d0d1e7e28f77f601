//! What the page gives: elements, storage, time, randomness, its address.

use wasm_bindgen::JsCast;
use web_sys::{Document, HtmlElement, Storage, Window};

/// The window; `None` outside a page.
pub(crate) fn window() -> Option<Window> {
    web_sys::window()
}

/// The document.
pub(crate) fn document() -> Option<Document> {
    window()?.document()
}

/// The element of this id, if it is of this type.
pub(crate) fn element<T: JsCast>(id: &str) -> Option<T> {
    document()?.get_element_by_id(id)?.dyn_into().ok()
}

/// A new element.
pub(crate) fn create(tag: &str) -> Option<HtmlElement> {
    document()?.create_element(tag).ok()?.dyn_into().ok()
}

/// Milliseconds since the page was opened, monotonic.
pub(crate) fn now_ms() -> f64 {
    window().and_then(|window| window.performance()).map_or(0.0, |performance| performance.now())
}

/// Lets the page do other things for so many milliseconds.
pub(crate) async fn pause(ms: i32) {
    let promise = js_sys::Promise::new(&mut |resolve, _| {
        let Some(window) = window() else { return };
        // Without timers the page could not have come this far.
        let _ = window.set_timeout_with_callback_and_timeout_and_arguments_0(&resolve, ms);
    });
    // It never fails.
    let _ = wasm_bindgen_futures::JsFuture::from(promise).await;
}

/// Random bits, as good as the browser's.
pub(crate) fn random_u128() -> u128 {
    uuid::Uuid::new_v4().as_u128() ^ uuid::Uuid::new_v4().as_u128().rotate_left(64)
}

/// Uniform in 0..1.
pub(crate) fn random_unit() -> f64 {
    js_sys::Math::random()
}

/// A parameter of the page's address, such as `gpu` in `?gpu=webgl`.
pub(crate) fn query(name: &str) -> Option<String> {
    let search = window()?.location().search().ok()?;
    web_sys::UrlSearchParams::new_with_str(&search).ok()?.get(name)
}

/// The page's address as a WebSocket's, with this path.
pub(crate) fn socket_url(path: &str) -> Option<String> {
    let location = window()?.location();
    let scheme = if location.protocol().ok()? == "https:" { "wss" } else { "ws" };
    Some(format!("{scheme}://{}{path}", location.host().ok()?))
}

/// The offset of local time from UTC, seconds.
pub(crate) fn utc_offset_s() -> i64 {
    -60 * js_sys::Date::new_0().get_timezone_offset() as i64
}

/// Whether the person asked for less motion.
pub(crate) fn reduced_motion() -> bool {
    window()
        .and_then(|window| window.match_media("(prefers-reduced-motion: reduce)").ok().flatten())
        .is_some_and(|query| query.matches())
}

/// Size of the page, physical pixels.
pub(crate) fn window_px() -> [u32; 2] {
    let Some(window) = window() else { return [1, 1] };
    let scale = window.device_pixel_ratio();
    [window.inner_width(), window.inner_height()].map(|side| {
        let points = side.ok().and_then(|side| side.as_f64()).unwrap_or(0.0);
        (points * scale).round().max(1.0) as u32
    })
}

/// Whether nobody can see the page.
pub(crate) fn hidden() -> bool {
    document().is_some_and(|document| document.hidden())
}

/// Storage that lasts as long as the tab.
pub(crate) fn tab_storage() -> Option<Storage> {
    window()?.session_storage().ok().flatten()
}

/// Storage that stays.
pub(crate) fn lasting_storage() -> Option<Storage> {
    window()?.local_storage().ok().flatten()
}

/// Says something in the browser's console, for whoever looks after the client.
pub(crate) fn log_warning(what: &str) {
    web_sys::console::warn_1(&what.into());
}

/// Makes a font known to the page, for its own inputs. Where that fails they use the system's.
pub(crate) fn add_font(family: &str, file: &'static [u8]) {
    let buffer = js_sys::Uint8Array::from(file).buffer();
    if let (Some(document), Ok(font)) =
        (document(), web_sys::FontFace::new_with_array_buffer(family, &buffer))
    {
        // Already loaded: the bytes are here.
        let _ = document.fonts().add(&font);
    }
}

/// Notes a moment of the page's start in the browser's own timeline, beside its downloads and frames.
pub(crate) fn mark(moment: &str) {
    if let Some(performance) = window().and_then(|window| window.performance()) {
        // A browser that keeps no timeline only loses the note.
        let _ = performance.mark(moment);
    }
}
