//! The graphics backend: WebGL2, unless WebGPU is requested or was found usable.
//!
//! A browser may offer WebGPU on a software device that reports success but displays no image. WebGPU is therefore chosen
//! only if its adapter is hardware. Requesting the adapter initialises WebGPU, which takes 0.5 s on a software device. So the
//! first visit draws with WebGL2, requests the adapter once the map is on the screen, and stores the result for the next visit.

use crate::browser;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use std::time::Duration;
use wasm_bindgen::JsCast;
use wasm_bindgen_futures::JsFuture;

/// The interface to draw with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GraphicsBackend {
    /// WebGL2, which every browser has.
    WebGl,
    /// WebGPU, on secure origins with hardware.
    WebGpu,
}

/// Storage key of the backend that was found usable at the last visit; loader.js reads it too.
const STORAGE_KEY: &str = "autoinspect.gpu";
/// Its value if that was WebGPU.
const WEBGPU: &str = "webgpu";

/// Parameters of the choice of the backend and of its first images.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GraphicsConfig {
    /// Delay of the request for the WebGPU adapter after the start, longer than the time to the first image of the map. Chosen as a round number: earlier, the request
    /// would compete with the first tiles.
    probe_delay: Duration,
    /// Quality of the first images on a software device, where an image at full quality takes 1 s. Chosen: a tenth of the points takes about a tenth of the
    /// time.
    software_quality: f32,
}

impl Default for GraphicsConfig {
    fn default() -> Self {
        Self { probe_delay: Duration::from_secs(10), software_quality: 0.1 }
    }
}

/// The backend of the parameter `?gpu=webgl` or `?gpu=webgpu`; without it the one that was usable at the last visit, if it still is.
pub(crate) async fn choose_backend() -> GraphicsBackend {
    match browser::query("gpu").as_deref() {
        Some("webgpu") => GraphicsBackend::WebGpu,
        Some("webgl") => GraphicsBackend::WebGl,
        _ if was_webgpu_usable() && webgpu_on_hardware().await.unwrap_or(false) => GraphicsBackend::WebGpu,
        _ => GraphicsBackend::WebGl,
    }
}

/// Stores for the next visit whether WebGPU is usable.
pub(crate) async fn probe_webgpu(config: GraphicsConfig) {
    gloo_timers::future::sleep(config.probe_delay).await;
    let usable = webgpu_on_hardware().await.unwrap_or(false);
    let Some(storage) = browser::lasting_storage() else { return };
    // Without storage every visit draws with WebGL2.
    let _ = if usable { storage.set_item(STORAGE_KEY, WEBGPU) } else { storage.remove_item(STORAGE_KEY) };
}

fn was_webgpu_usable() -> bool {
    let stored = browser::lasting_storage().and_then(|storage| storage.get_item(STORAGE_KEY).ok().flatten());
    stored.as_deref() == Some(WEBGPU)
}

/// Whether the WebGPU adapter is hardware. Its attributes are read by name, because they are newer than the bindings.
async fn webgpu_on_hardware() -> Option<bool> {
    let get = |object: &wasm_bindgen::JsValue, name: &str| js_sys::Reflect::get(object, &name.into()).ok();
    let navigator = browser::window()?.navigator();
    let gpu = get(navigator.as_ref(), "gpu").filter(wasm_bindgen::JsValue::is_object)?;
    let request: js_sys::Function = get(&gpu, "requestAdapter")?.dyn_into().ok()?;
    let promise: js_sys::Promise = request.call0(&gpu).ok()?.dyn_into().ok()?;
    let adapter = JsFuture::from(promise).await.ok().filter(wasm_bindgen::JsValue::is_object)?;
    let info = get(&adapter, "info")?;
    let software = get(&info, "isFallbackAdapter").and_then(|v| v.as_bool()).unwrap_or(false);
    let architecture = get(&info, "architecture").and_then(|v| v.as_string()).unwrap_or_default();
    Some(!software && !architecture.is_empty() && architecture != "swiftshader")
}

/// eframe's options for a backend.
pub(crate) fn web_options(back_end: GraphicsBackend) -> eframe::WebOptions {
    let backends = match back_end {
        GraphicsBackend::WebGl => wgpu::Backends::GL,
        GraphicsBackend::WebGpu => wgpu::Backends::BROWSER_WEBGPU,
    };
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends = backends;
    eframe::WebOptions {
        dithering: false,
        wgpu_options: WgpuConfiguration {
            wgpu_setup: WgpuSetup::CreateNew(setup),
            ..WgpuConfiguration::default()
        },
        ..eframe::WebOptions::default()
    }
}

/// The frame pacer for a graphics adapter: it begins with a low quality on software devices.
pub(crate) fn initial_frame_pacer(config: GraphicsConfig, adapter: &wgpu::AdapterInfo) -> scene::FramePacer {
    const SOFTWARE_DEVICES: [&str; 4] = ["swiftshader", "llvmpipe", "softpipe", "software"];
    let name = format!("{} {}", adapter.name, adapter.driver_info).to_lowercase();
    let slow = adapter.device_type == wgpu::DeviceType::Cpu
        || SOFTWARE_DEVICES.iter().any(|word| name.contains(word));
    if slow {
        scene::FramePacer::new(scene::FramePacingConfig::default(), config.software_quality)
    } else {
        scene::FramePacer::default()
    }
}
