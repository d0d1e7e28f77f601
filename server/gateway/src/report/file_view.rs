//! What a report shows of a file: a picture, a spectrum, or its name.

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
pub(super) enum FileView {
    Picture(OpenedPicture),
    Spectrum(GammaSpectrum),
    /// Its name, with why it is no more than that where it could be.
    Name(Option<&'static str>),
}

/// A picture that browsers show.
pub(super) struct OpenedPicture {
    content: File,
    media_type: &'static str,
}

impl OpenedPicture {
    /// Writes it as the address of a picture.
    pub(super) fn write_address(self, html: &mut Html<'_>) -> io::Result<()> {
        // A file that grows meanwhile does not make the report longer.
        html.data_address(self.media_type, self.content.take(MAX_PICTURE_BYTES))
    }
}

/// What is shown of a file, by its bytes.
pub(super) fn open(data_dir: &Path, file: &ReportFile) -> FileView {
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
        Some((_, media_type)) => FileView::Picture(OpenedPicture { content, media_type }),
        None => FileView::Name(Some(texts::FILE_NO_PICTURE)),
    }
}
