//! Which graphics interface to draw with: WebGL2 unless WebGPU is asked for or known to be good.
//!
//! A browser may offer WebGPU on a software device whose pictures never reach the screen, and report success all the
//! while. WebGPU is therefore chosen by itself only when its adapter is real hardware. Asking for the adapter starts all of
//! WebGPU, which takes half a second where the processor draws: the first visit draws with WebGL2 and asks once the map is on the
//! screen, for the next visit to know.

use crate::browser;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use wasm_bindgen::JsCast;
use wasm_bindgen_futures::JsFuture;

/// What to draw with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GraphicsBackend {
    /// WebGL2: everywhere.
    WebGl,
    /// WebGPU: on secure origins with hardware.
    WebGpu,
}

/// Where it is kept that WebGPU was good at the last visit, and what is written there then.
const KEPT_KEY: &str = "autoinspect.gpu";
const GOOD: &str = "webgpu";
/// The first map is on the screen long before, milliseconds.
const ASK_AFTER_MS: i32 = 10_000;

/// `?gpu=webgl` and `?gpu=webgpu` decide; else what was good at the last visit, if it still is.
pub(crate) async fn choose_backend() -> GraphicsBackend {
    match browser::query("gpu").as_deref() {
        Some("webgpu") => GraphicsBackend::WebGpu,
        Some("webgl") => GraphicsBackend::WebGl,
        _ if was_webgpu_usable() && webgpu_on_hardware().await.unwrap_or(false) => GraphicsBackend::WebGpu,
        _ => GraphicsBackend::WebGl,
    }
}

/// Finds out for the next visit whether WebGPU is good.
pub(crate) async fn probe_webgpu() {
    browser::pause(ASK_AFTER_MS).await;
    let good = webgpu_on_hardware().await.unwrap_or(false);
    let Some(storage) = browser::lasting_storage() else { return };
    // A browser that stores nothing draws with WebGL2 every time.
    let _ = if good { storage.set_item(KEPT_KEY, GOOD) } else { storage.remove_item(KEPT_KEY) };
}

fn was_webgpu_usable() -> bool {
    let kept = browser::lasting_storage().and_then(|storage| storage.get_item(KEPT_KEY).ok().flatten());
    kept.as_deref() == Some(GOOD)
}

/// Whether WebGPU has an adapter that is no software one. Read by name: the attributes are younger than the bindings.
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

/// How eframe shall set up its canvas.
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

/// Quality of the first images on a software device, where an image at full quality takes a second.
const SOFTWARE_QUALITY: f32 = 0.1;

/// The frame pacer for a graphics adapter: it begins with a low quality on software devices.
pub(crate) fn initial_frame_pacer(adapter: &wgpu::AdapterInfo) -> scene::FramePacer {
    const ON_THE_PROCESSOR: [&str; 4] = ["swiftshader", "llvmpipe", "softpipe", "software"];
    let name = format!("{} {}", adapter.name, adapter.driver_info).to_lowercase();
    let slow = adapter.device_type == wgpu::DeviceType::Cpu
        || ON_THE_PROCESSOR.iter().any(|word| name.contains(word));
    if slow {
        scene::FramePacer::new(scene::FramePacingConfig::default(), SOFTWARE_QUALITY)
    } else {
        scene::FramePacer::default()
    }
}
