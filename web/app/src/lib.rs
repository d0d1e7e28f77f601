//! The client in the browser: the eframe application of [`client_model`], [`panels`] and [`scene`], with sockets, downloads, text inputs
//! and the ARIA mirror of its controls.
//!
//! The page calls [`start`]. Off the browser this crate is empty.

#[cfg(target_arch = "wasm32")]
mod aria;
#[cfg(target_arch = "wasm32")]
mod browser;
#[cfg(target_arch = "wasm32")]
mod camera_inset;
#[cfg(target_arch = "wasm32")]
mod change_clouds;
#[cfg(target_arch = "wasm32")]
mod change_overlay;
#[cfg(target_arch = "wasm32")]
mod client_app;
#[cfg(target_arch = "wasm32")]
mod decode_queue;
#[cfg(target_arch = "wasm32")]
mod downloads;
#[cfg(target_arch = "wasm32")]
mod effects;
#[cfg(target_arch = "wasm32")]
mod file_dialog;
#[cfg(target_arch = "wasm32")]
mod gesture_context;
#[cfg(target_arch = "wasm32")]
mod graph_clicks;
#[cfg(target_arch = "wasm32")]
mod graph_gestures;
#[cfg(target_arch = "wasm32")]
mod graph_overlay;
#[cfg(target_arch = "wasm32")]
mod graph_preview;
#[cfg(target_arch = "wasm32")]
mod graphics;
#[cfg(target_arch = "wasm32")]
mod inbox;
#[cfg(target_arch = "wasm32")]
mod mission_overlay;
#[cfg(target_arch = "wasm32")]
mod plan_files;
#[cfg(any(target_arch = "wasm32", test))]
mod ply_points;
#[cfg(any(target_arch = "wasm32", test))]
mod png16;
#[cfg(target_arch = "wasm32")]
mod result_files;
#[cfg(target_arch = "wasm32")]
mod runtime;
#[cfg(target_arch = "wasm32")]
mod saved_file;
#[cfg(target_arch = "wasm32")]
mod scene_labels;
#[cfg(target_arch = "wasm32")]
mod scene_sync;
#[cfg(target_arch = "wasm32")]
mod sockets;
#[cfg(target_arch = "wasm32")]
mod storage;
#[cfg(target_arch = "wasm32")]
mod text_inputs;
#[cfg(target_arch = "wasm32")]
mod texts;
#[cfg(target_arch = "wasm32")]
mod uploads;
#[cfg(target_arch = "wasm32")]
mod vector;
#[cfg(target_arch = "wasm32")]
mod viewport;
#[cfg(target_arch = "wasm32")]
mod zone_gestures;
#[cfg(target_arch = "wasm32")]
mod zone_overlay;

#[cfg(target_arch = "wasm32")]
pub use web::start;

#[cfg(target_arch = "wasm32")]
mod web {
    use crate::client_app::{self, ClientApp};
    use crate::runtime::wait_for_first_tile;
    use crate::{browser, graphics};
    use eframe::WebRunner;
    use wasm_bindgen::prelude::*;

    /// Starts the client on the canvas with this id. Resolves once the first frame is due; rejects with an error message.
    #[wasm_bindgen]
    pub async fn start(canvas_id: String) -> Result<(), JsValue> {
        let canvas = browser::element::<web_sys::HtmlCanvasElement>(&canvas_id)
            .ok_or_else(|| JsValue::from_str("the page has no canvas of that name"))?;
        let runtime = client_app::connect();
        // Making a graphics context blocks the page for up to a second on a software device.
        wait_for_first_tile(&runtime).await;
        let back_end = graphics::choose_backend().await;
        let create = Box::new(|context: &eframe::CreationContext<'_>| ClientApp::create(runtime, context));
        WebRunner::new().start(canvas, graphics::web_options(back_end), create).await?;
        wasm_bindgen_futures::spawn_local(graphics::probe_webgpu(graphics::GraphicsConfig::default()));
        Ok(())
    }
}
