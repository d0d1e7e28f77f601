//! The client in the browser: an eframe shell round [`client_model`], [`panels`] and [`scene`], with its sockets,
//! downloads and the mirror of its controls in ARIA.
//!
//! The page calls [`start`]. Off the browser this crate is empty.

#[cfg(target_arch = "wasm32")]
mod aria;
#[cfg(target_arch = "wasm32")]
mod browser;
#[cfg(target_arch = "wasm32")]
mod client;
#[cfg(target_arch = "wasm32")]
mod core;
#[cfg(target_arch = "wasm32")]
mod fetch;
#[cfg(target_arch = "wasm32")]
mod gpu;
#[cfg(target_arch = "wasm32")]
mod inbox;
#[cfg(target_arch = "wasm32")]
mod inputs;
#[cfg(target_arch = "wasm32")]
mod labels;
#[cfg(target_arch = "wasm32")]
mod sockets;
#[cfg(target_arch = "wasm32")]
mod stage;
#[cfg(target_arch = "wasm32")]
mod upload;
#[cfg(target_arch = "wasm32")]
mod viewport;

#[cfg(target_arch = "wasm32")]
pub use web::start;

#[cfg(target_arch = "wasm32")]
mod web {
    use crate::client::{self, Client};
    use crate::core::reach_server;
    use crate::{browser, gpu};
    use eframe::WebRunner;
    use wasm_bindgen::prelude::*;

    /// Starts the client on the canvas of this id. Resolves once the first frame is due; rejects with a sentence.
    #[wasm_bindgen]
    pub async fn start(canvas_id: String) -> Result<(), JsValue> {
        let canvas = browser::element::<web_sys::HtmlCanvasElement>(&canvas_id)
            .ok_or_else(|| JsValue::from_str("the page has no canvas of that name"))?;
        let core = client::connect();
        // Making a graphics context blocks the page for up to a second where the processor draws.
        reach_server(&core).await;
        let back_end = gpu::choose().await;
        let create = Box::new(|context: &eframe::CreationContext<'_>| Client::create(core, context));
        WebRunner::new().start(canvas, gpu::options(back_end), create).await?;
        wasm_bindgen_futures::spawn_local(gpu::find_out());
        Ok(())
    }
}
