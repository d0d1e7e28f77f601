//! Files of a result: pictures within the document, spectra as plots, and others by name and length.

use super::context::{ReportContext, legible_name};
use super::html::Html;
use super::{spectrum, texts};
use crate::blobs::blob_path;
use site_model::{GammaSpectrum, ReportFile};
use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;

/// Longest picture that a report holds, bytes. Chosen: a mail server takes a report with one.
const MAX_PICTURE_BYTES: u64 = 16 << 20;
/// Longest file of a spectrum that is read, bytes. Chosen: a hundred times that of common instruments.
const MAX_SPECTRUM_BYTES: u64 = 4 << 20;
/// Temperatures as numbers. Beside them is a picture of them in colours.
const TEMPERATURES: &str = "temperatures_centikelvin.png";
/// First bytes of pictures that browsers show, and their types.
const PICTURES: [(&[u8], &str); 2] = [(b"\xff\xd8\xff", "image/jpeg"), (b"\x89PNG\r\n\x1a\n", "image/png")];

/// What a report shows of a file.
enum FileView {
    /// A picture of this type.
    Picture(File, &'static str),
    Spectrum(GammaSpectrum),
    /// Its name, with why it is no more than that where it could be.
    Name(Option<&'static str>),
}

/// Writes the files of a result. `is_pictured`: whether pictures and spectra are shown, not only named. `at`: when it was gathered.
pub(super) fn write_files(
    html: &mut Html<'_>,
    cx: &ReportContext,
    files: &[ReportFile],
    is_pictured: bool,
    (place, at): (&str, &str),
) -> io::Result<()> {
    let view = |file| if is_pictured { open(cx.data_dir(), file) } else { FileView::Name(None) };
    let (mut pictures, mut spectra, mut named) = (Vec::new(), Vec::new(), Vec::new());
    for file in files {
        match view(file) {
            FileView::Picture(content, media_type) => {
                pictures.push((legible_name(&file.name), content, media_type))
            }
            FileView::Spectrum(found) => spectra.push(found),
            FileView::Name(why) => named.push((file, why)),
        }
    }
    if !pictures.is_empty() {
        html.open("div", "figures")?;
        for (name, content, media_type) in pictures {
            write_picture(html, content, media_type, &name, (place, at))?;
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
    content: File,
    media_type: &'static str,
    name: &str,
    (place, at): (&str, &str),
) -> io::Result<()> {
    html.markup("<figure><img alt=\"")?;
    html.text(&texts::picture_of(name, place))?;
    html.markup("\" src=\"")?;
    // A file that grows meanwhile does not make the report longer.
    html.data_address(media_type, content.take(MAX_PICTURE_BYTES))?;
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

/// What is shown of a file, by its bytes.
fn open(data_dir: &Path, file: &ReportFile) -> FileView {
    if file.name == TEMPERATURES {
        return FileView::Name(None);
    }
    let path = blob_path(data_dir, &file.blob.to_string());
    // A directory or a pipe is no file, and is not opened.
    let length = path.metadata().ok().filter(std::fs::Metadata::is_file).map(|found| found.len());
    let Some((length, Ok(content))) = length.map(|length| (length, File::open(&path))) else {
        return FileView::Name(Some(texts::FILE_MISSING));
    };
    if file.media_type.starts_with("image/") {
        return picture(content, length);
    }
    if file.name == "spectrum.json" && length <= MAX_SPECTRUM_BYTES {
        let found: Option<GammaSpectrum> = serde_json::from_reader(io::BufReader::new(content)).ok();
        return found.filter(spectrum::is_drawable).map_or(FileView::Name(None), FileView::Spectrum);
    }
    FileView::Name(None)
}

/// A file of a picture, if a browser shows its kind and it is not too long.
fn picture(mut content: File, length: u64) -> FileView {
    if length > MAX_PICTURE_BYTES {
        return FileView::Name(Some(texts::FILE_TOO_LARGE));
    }
    let mut start = Vec::new();
    let is_read = content.by_ref().take(8).read_to_end(&mut start).is_ok() && content.rewind().is_ok();
    let known = PICTURES.into_iter().find(|(first, _)| is_read && start.starts_with(first));
    match known {
        Some((_, media_type)) => FileView::Picture(content, media_type),
        None => FileView::Name(Some(texts::FILE_NO_PICTURE)),
    }
}
