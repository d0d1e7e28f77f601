//! The frame of a report: a document that needs nothing from elsewhere, and its foot. A file that people pass on may run no scripts and fetch nothing.

use super::context::ReportContext;
use super::html::Html;
use super::{format, texts};
use std::io;

/// What a report may do in a browser: show its own pictures and styles. Nothing else is loaded or run.
pub(super) const CONTENT_SECURITY_POLICY: &str =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";

/// Begins the document.
pub(super) fn begin(html: &mut Html<'_>, title: &str) -> io::Result<()> {
    html.markup("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n")?;
    html.markup("<meta http-equiv=\"Content-Security-Policy\" content=\"")?;
    html.text(CONTENT_SECURITY_POLICY)?;
    html.markup("\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n")?;
    html.element("title", "", title)?;
    html.markup("<style>\n")?;
    html.markup(include_str!("style.css"))?;
    html.markup("</style>\n</head>\n<body>\n")
}

/// Ends the document with its foot. `ids`: further facts for it.
pub(super) fn end(html: &mut Html<'_>, cx: &ReportContext, ids: &[(&str, &str)]) -> io::Result<()> {
    html.markup("<footer>\n<dl>\n")?;
    let (made, revision) = (cx.made(), cx.site_revision().to_string());
    let made = format!("{}, {}", format::date_and_time(cx.local(made)), cx.zone_at(made));
    let always = [(texts::SITE_REVISION, revision.as_str()), (texts::MADE, made.as_str())];
    for (name, value) in ids.iter().chain(&always) {
        fact(html, name, value)?;
    }
    html.markup("</dl>\n")?;
    html.element("p", "note", texts::LIMITS_NOTE)?;
    html.markup("</footer>\n</body>\n</html>\n")
}

/// A fact in a list of definitions.
pub(super) fn fact(html: &mut Html<'_>, name: &str, value: &str) -> io::Result<()> {
    html.open("div", "")?;
    html.element("dt", "", name)?;
    html.element("dd", "", value)?;
    html.close("div")
}
