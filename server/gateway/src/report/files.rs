//! Files of a result: pictures within the document, spectra as plots, and others by name and length.

use super::compared::ComparedPhoto;
use super::context::{ReportContext, legible_name};
use super::file_view::{FileView, OpenedPicture, open};
use super::html::Html;
use super::{spectrum, texts};
use site_model::ReportFile;
use std::io;

/// Writes the files of a result. `is_pictured`: whether pictures and spectra are shown, not only named. `at`: when it was gathered.
pub(super) fn write_files(
    html: &mut Html<'_>,
    cx: &ReportContext,
    files: &[ReportFile],
    is_pictured: bool,
    (place, at): (&str, &str),
    compared: Option<&ComparedPhoto>,
) -> io::Result<()> {
    let view = |file| if is_pictured { open(cx.data_dir(), file) } else { FileView::Name(None) };
    let (mut pictures, mut spectra, mut named) = (Vec::new(), Vec::new(), Vec::new());
    for file in files {
        match view(file) {
            FileView::Picture(picture) => pictures.push((legible_name(&file.name), picture)),
            FileView::Spectrum(found) => spectra.push(found),
            FileView::Name(why) => named.push((file, why)),
        }
    }
    if !pictures.is_empty() {
        if let Some(compared) = compared {
            html.element("p", "reason", &compared.sentence())?;
        }
        html.open("div", "figures")?;
        // The first picture is the one that was compared.
        let mut compared = compared;
        for (name, picture) in pictures {
            match compared.take() {
                None => write_picture(html, picture, &name, (place, at))?,
                Some(compared) => {
                    compared.write_before(html, cx, place)?;
                    compared.write_after(html, picture, &texts::caption(place, at, &name))?;
                }
            }
        }
        html.close("div")?;
    }
    for found in spectra {
        html.open("figure", "spectrum")?;
        spectrum::write_spectrum(html, &found, place)?;
        html.element("figcaption", "", &texts::spectrum_total(spectrum::total(&found), found.live_time_s))?;
        html.close("figure")?;
    }
    write_names(html, &named)
}

fn write_picture(
    html: &mut Html<'_>,
    picture: OpenedPicture,
    name: &str,
    (place, at): (&str, &str),
) -> io::Result<()> {
    html.markup("<figure><img alt=\"")?;
    html.text(&texts::picture_of(name, place))?;
    html.markup("\" src=\"")?;
    picture.write_address(html)?;
    html.markup("\">")?;
    html.element("figcaption", "", &texts::caption(place, at, name))?;
    html.close("figure")
}

fn write_names(html: &mut Html<'_>, named: &[(&ReportFile, Option<&'static str>)]) -> io::Result<()> {
    if named.is_empty() {
        return Ok(());
    }
    html.open("ul", "files")?;
    for (file, why) in named {
        html.open("li", "")?;
        html.text(&texts::file(&legible_name(&file.name), file.bytes))?;
        if let Some(why) = why {
            html.text(" · ")?;
            html.text(why)?;
        }
        html.close("li")?;
    }
    html.close("ul")
}
