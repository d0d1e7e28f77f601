//! Files of the person's own: chosen with the browser's dialogue, and sent.
//!
//! With `XMLHttpRequest`, because no browser says of `fetch` how much of a body has been sent.

use crate::browser;
use crate::inbox::{InboundMessage, Inbox};
use client_model::ClientEvent;
use std::cell::RefCell;
use std::rc::Rc;
use uuid::Uuid;
use vocab::UploadId;
use wasm_bindgen::JsCast;
use wasm_bindgen::prelude::Closure;
use web_sys::{File, HtmlInputElement, ProgressEvent, XmlHttpRequest};

/// What the dialogue offers first.
const KINDS: &str = ".pcd,.ply,.las,.laz,.e57,.ptx";
/// The page's input for files.
const INPUT: &str = "map-file";

/// The dialogue, and what is on its way.
pub(crate) struct Uploads {
    inbox: Inbox,
    input: Option<HtmlInputElement>,
    under_way: Rc<RefCell<Option<UnderWay>>>,
}

struct UnderWay {
    upload: UploadId,
    request: XmlHttpRequest,
    _told: [Closure<dyn FnMut(ProgressEvent)>; 3],
}

impl Uploads {
    pub(crate) fn new(inbox: Inbox) -> Self {
        Self { inbox, input: None, under_way: Rc::default() }
    }

    /// Opens the browser's dialogue; what is chosen in it is sent.
    pub(crate) fn pick(&mut self) {
        if self.input.is_none() {
            self.input = self.make_input();
        }
        match &self.input {
            Some(input) => {
                // The same file may be chosen again.
                input.set_value("");
                input.click();
            }
            None => browser::log_warning("the page has no input for files"),
        }
    }

    /// Gives up what is on its way.
    pub(crate) fn cancel(&self, upload: UploadId) {
        let given_up = self.under_way.borrow_mut().take_if(|it| it.upload == upload);
        if let Some(UnderWay { request, .. }) = given_up {
            // Whatever state it is in, it is not waited for.
            let _ = request.abort();
        }
    }

    fn make_input(&self) -> Option<HtmlInputElement> {
        let input: HtmlInputElement = browser::create("input")?.dyn_into().ok()?;
        input.set_type("file");
        input.set_id(INPUT);
        input.set_accept(KINDS);
        input.set_hidden(true);
        let (inbox, under_way, chosen) = (self.inbox.clone(), Rc::clone(&self.under_way), input.clone());
        let changed = Closure::<dyn FnMut()>::new(move || {
            if let Some(file) = chosen.files().and_then(|files| files.get(0)) {
                send(&inbox, &under_way, &file);
            }
        });
        input.add_event_listener_with_callback("change", changed.as_ref().unchecked_ref()).ok()?;
        // As long as the page.
        changed.forget();
        browser::document()?.body()?.append_child(&input).ok()?;
        Some(input)
    }
}

fn send(inbox: &Inbox, under_way: &Rc<RefCell<Option<UnderWay>>>, file: &File) {
    let upload = UploadId(Uuid::from_u128(browser::random_u128()));
    inbox.leave(InboundMessage::Event(ClientEvent::UploadStarted { upload, file: file.name() }));
    match begin(inbox, under_way, upload, file) {
        Some(begun) => *under_way.borrow_mut() = Some(begun),
        None => tell(inbox, upload, Err("This browser cannot send files.".to_owned())),
    }
}

fn tell(inbox: &Inbox, upload: UploadId, result: Result<(), String>) {
    inbox.leave(InboundMessage::Event(ClientEvent::UploadFinished { upload, result }));
}

fn begin(
    inbox: &Inbox,
    under_way: &Rc<RefCell<Option<UnderWay>>>,
    upload: UploadId,
    file: &File,
) -> Option<UnderWay> {
    let request = XmlHttpRequest::new().ok()?;
    let path = api::paths::UPLOAD_PATH.replace("{id}", &upload.to_string());
    request.open("PUT", &path).ok()?;
    request.set_request_header("content-type", "application/octet-stream").ok()?;
    let progress = {
        let inbox = inbox.clone();
        Closure::<dyn FnMut(ProgressEvent)>::new(move |event: ProgressEvent| {
            let share = (event.loaded() / event.total().max(1.0)) as f32;
            inbox.leave(InboundMessage::Event(ClientEvent::UploadProgress { upload, share }));
        })
    };
    let (loaded, failed) = [true, false]
        .map(|answered| {
            let (inbox, under_way, request) = (inbox.clone(), Rc::clone(under_way), request.clone());
            Closure::<dyn FnMut(ProgressEvent)>::new(move |_| {
                let result = if answered { outcome(&request) } else { Err(UNREACHABLE.to_owned()) };
                tell(&inbox, upload, result);
                // Later: these very closures are in it.
                let under_way = Rc::clone(&under_way);
                wasm_bindgen_futures::spawn_local(async move {
                    under_way.borrow_mut().take_if(|it| it.upload == upload);
                });
            })
        })
        .into();
    request.upload().ok()?.set_onprogress(Some(progress.as_ref().unchecked_ref()));
    request.set_onload(Some(loaded.as_ref().unchecked_ref()));
    request.set_onerror(Some(failed.as_ref().unchecked_ref()));
    request.send_with_opt_blob(Some(file)).ok()?;
    Some(UnderWay { upload, request, _told: [progress, loaded, failed] })
}

const UNREACHABLE: &str = "The robot's server did not take all of it. Check the network, then try again.";

/// What the server answered.
fn outcome(request: &XmlHttpRequest) -> Result<(), String> {
    let status = request.status().unwrap_or(0);
    if (200..300).contains(&status) {
        return Ok(());
    }
    let body = request.response_text().ok().flatten().unwrap_or_default();
    Err(match serde_json::from_str::<api::Problem>(&body) {
        Ok(problem) => problem.detail,
        Err(_) => format!("The robot's server answered with error {status}. Try again."),
    })
}
