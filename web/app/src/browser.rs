//! The browser's page: elements, storage, time, randomness, address. Events and timers are those of `gloo`;
//! docs/decisions/browser-wrappers.md explains why its other modules are not used.

use panels::PageClock;
use site_model::Utc;
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

/// Time since the page was opened, ms, monotonic.
pub(crate) fn now_ms() -> f64 {
    window().and_then(|window| window.performance()).map_or(0.0, |performance| performance.now())
}

/// Random bits of the browser's cryptographic generator.
pub(crate) fn random_u128() -> u128 {
    uuid::Uuid::new_v4().as_u128() ^ uuid::Uuid::new_v4().as_u128().rotate_left(64)
}

/// A random number, uniform in 0..1.
pub(crate) fn random_unit() -> f64 {
    js_sys::Math::random()
}

/// A parameter of the page's address, such as `gpu` in `?gpu=webgl`.
pub(crate) fn query(name: &str) -> Option<String> {
    let search = window()?.location().search().ok()?;
    web_sys::UrlSearchParams::new_with_str(&search).ok()?.get(name)
}

/// The address of a WebSocket with this path on the page's server.
pub(crate) fn socket_url(path: &str) -> Option<String> {
    let location = window()?.location();
    let scheme = if location.protocol().ok()? == "https:" { "wss" } else { "ws" };
    Some(format!("{scheme}://{}{path}", location.host().ok()?))
}

/// Tells the scripts of the page that something has happened.
pub(crate) fn dispatch(name: &str) {
    if let Some(window) = window()
        && let Ok(event) = web_sys::Event::new(name)
    {
        // Fails only for an event that is being dispatched already.
        let _ = window.dispatch_event(&event);
    }
}

/// The calendar clock, and the time zone of the operator's machine.
pub(crate) fn clock() -> PageClock {
    let format = js_sys::Intl::DateTimeFormat::new(&js_sys::Array::new(), &js_sys::Object::new());
    let zone = js_sys::Reflect::get(&format.resolved_options(), &"timeZone".into());
    PageClock {
        utc: utc(),
        utc_offset_s: -60 * js_sys::Date::new_0().get_timezone_offset() as i64,
        zone: zone.ok().and_then(|zone| zone.as_string()).unwrap_or_default(),
    }
}

/// The calendar clock, to the millisecond.
pub(crate) fn utc() -> Utc {
    Utc(js_sys::Date::now() as i64 * 1_000_000)
}

/// Whether the operator's system asks for reduced motion.
pub(crate) fn reduced_motion() -> bool {
    window()
        .and_then(|window| window.match_media("(prefers-reduced-motion: reduce)").ok().flatten())
        .is_some_and(|query| query.matches())
}

/// Size of the page, physical px.
pub(crate) fn window_px() -> [u32; 2] {
    let Some(window) = window() else { return [1, 1] };
    let scale = window.device_pixel_ratio();
    [window.inner_width(), window.inner_height()].map(|side| {
        let points = side.ok().and_then(|side| side.as_f64()).unwrap_or(0.0);
        (points * scale).round().max(1.0) as u32
    })
}

/// Whether the page is hidden: another tab is in front of it, or the window is minimised.
pub(crate) fn hidden() -> bool {
    document().is_some_and(|document| document.hidden())
}

/// Storage that lasts until the tab is closed.
pub(crate) fn tab_storage() -> Option<Storage> {
    window()?.session_storage().ok().flatten()
}

/// Storage that lasts until the user clears it.
pub(crate) fn lasting_storage() -> Option<Storage> {
    window()?.local_storage().ok().flatten()
}

/// Writes a warning to the browser's console.
pub(crate) fn log_warning(message: &str) {
    web_sys::console::warn_1(&message.into());
}

/// Adds a font to the page, for its text inputs. If that fails, they use the system's font.
pub(crate) fn add_font(family: &str, file: &'static [u8]) {
    let buffer = js_sys::Uint8Array::from(file).buffer();
    if let (Some(document), Ok(font)) =
        (document(), web_sys::FontFace::new_with_array_buffer(family, &buffer))
    {
        // The font needs no loading, because its bytes were given.
        let _ = document.fonts().add(&font);
    }
}

/// Marks a moment in the browser's performance timeline, beside its downloads and frames.
pub(crate) fn mark(name: &str) {
    if let Some(performance) = window().and_then(|window| window.performance()) {
        // A browser without a timeline only loses the mark.
        let _ = performance.mark(name);
    }
}
