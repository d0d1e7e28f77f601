//! Files of results: fetched from the server, and decoded by the browser, so that the bundle holds no decoder.

use crate::browser;
use crate::downloads::fetch_bytes;
use crate::inbox::Inbox;
use crate::png16;
use crate::texts;
use client_model::ResultFileKind;
use egui::{ColorImage, Context};
use panels::{ResultFileContent, ResultFiles};
use std::cell::RefCell;
use std::rc::Rc;
use vocab::BlobHash;
use wasm_bindgen::{JsCast, JsValue};
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{
    Blob, CanvasRenderingContext2d, HtmlCanvasElement, ImageBitmap, ReadableWritablePair, RequestInit,
    Response,
};

/// Parameters of pictures that are read.
struct PictureFileConfig {
    /// Longest side of a picture that is shown, pixels. Chosen: a larger one takes more than 256 MB.
    max_side_px: u32,
}

const CONFIG: PictureFileConfig = PictureFileConfig { max_side_px: 8_192 };

type Fetched = (BlobHash, Result<ResultFileContent, String>);

/// The files that were fetched and not put in yet.
pub(crate) struct ResultFileLoader {
    inbox: Inbox,
    fetched: Rc<RefCell<Vec<Fetched>>>,
}

impl ResultFileLoader {
    /// Every file that comes requests a frame through `inbox`.
    pub(crate) fn new(inbox: Inbox) -> Self {
        Self { inbox, fetched: Rc::default() }
    }

    /// Puts in what has come.
    pub(crate) fn put_in(&self, ctx: &Context, files: &mut ResultFiles) {
        for (blob, content) in self.fetched.take() {
            files.insert(ctx, blob, content);
        }
    }

    /// Fetches and decodes a file.
    pub(crate) fn fetch(&self, blob: BlobHash, kind: ResultFileKind) {
        let (inbox, fetched) = (self.inbox.clone(), Rc::clone(&self.fetched));
        spawn_local(async move {
            let content = fetch(blob, kind).await;
            fetched.borrow_mut().push((blob, content));
            inbox.request_frame();
        });
    }
}

async fn fetch(blob: BlobHash, kind: ResultFileKind) -> Result<ResultFileContent, String> {
    let path = api::paths::BLOB_PATH.replace("{hash}", &blob.to_string());
    let bytes = fetch_bytes(&path, &RequestInit::new()).await?;
    let unreadable = || texts::FILE_UNREADABLE.to_owned();
    match kind {
        ResultFileKind::Spectrum => {
            serde_json::from_slice(&bytes).map(ResultFileContent::Spectrum).map_err(|_| unreadable())
        }
        ResultFileKind::Picture => {
            decode_picture(&bytes).await.map(ResultFileContent::Picture).map_err(|_| unreadable())
        }
        ResultFileKind::Temperatures => {
            let picture = png16::parse(&bytes).ok_or_else(unreadable)?;
            let rows = inflate(&picture.compressed).await.map_err(|_| unreadable())?;
            let values = png16::unfilter(&picture, rows).ok_or_else(unreadable)?;
            Ok(ResultFileContent::Temperatures(picture.size, values))
        }
    }
}

/// Decodes a JPEG or PNG.
async fn decode_picture(bytes: &[u8]) -> Result<ColorImage, JsValue> {
    let window = browser::window().ok_or(JsValue::NULL)?;
    let parts = js_sys::Array::of1(&js_sys::Uint8Array::from(bytes));
    let blob = Blob::new_with_u8_array_sequence(&parts)?;
    let bitmap: ImageBitmap =
        JsFuture::from(window.create_image_bitmap_with_blob(&blob)?).await?.dyn_into()?;
    let (width, height) = (bitmap.width(), bitmap.height());
    if width.max(height) > CONFIG.max_side_px {
        return Err(JsValue::NULL);
    }
    let canvas: HtmlCanvasElement = browser::create("canvas").ok_or(JsValue::NULL)?.dyn_into()?;
    canvas.set_width(width);
    canvas.set_height(height);
    let context: CanvasRenderingContext2d = canvas.get_context("2d")?.ok_or(JsValue::NULL)?.dyn_into()?;
    context.draw_image_with_image_bitmap(&bitmap, 0.0, 0.0)?;
    let pixels = context.get_image_data(0.0, 0.0, f64::from(width), f64::from(height))?.data();
    bitmap.close();
    Ok(ColorImage::from_rgba_unmultiplied([width as usize, height as usize], &pixels))
}

/// Decompresses a zlib stream. `web-sys` has no stable binding of the browser's decompressor.
async fn inflate(bytes: &[u8]) -> Result<Vec<u8>, JsValue> {
    let parts = js_sys::Array::of1(&js_sys::Uint8Array::from(bytes));
    let constructor = js_sys::Reflect::get(&js_sys::global(), &"DecompressionStream".into())?;
    let constructor: js_sys::Function = constructor.dyn_into()?;
    let arguments = js_sys::Array::of1(&JsValue::from_str("deflate"));
    let decompressor: JsValue = js_sys::Reflect::construct(&constructor, &arguments)?;
    let through: ReadableWritablePair = decompressor.unchecked_into();
    let readable = Blob::new_with_u8_array_sequence(&parts)?.stream().pipe_through(&through);
    let response = Response::new_with_opt_readable_stream(Some(&readable))?;
    Ok(js_sys::Uint8Array::new(&JsFuture::from(response.array_buffer()?).await?).to_vec())
}
