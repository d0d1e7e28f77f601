//! Files of results on their way to the screen: panels ask for them by their content, the page fetches and decodes them.

use crate::thermal::ThermalPicture;
use client_model::ResultFileKind;
use egui::{ColorImage, Context, TextureHandle, TextureOptions};
use site_model::GammaSpectrum;
use std::collections::BTreeMap;
use vocab::BlobHash;

/// Parameters of the files that are kept.
struct ResultFilesConfig {
    /// Bytes of decoded files that are kept at most. Those that were not shown for the longest time are dropped first. Chosen: 80 photos of 640 x 480 pixels, four bytes
    /// each.
    max_bytes: usize,
}

const CONFIG: ResultFilesConfig = ResultFilesConfig { max_bytes: 96 << 20 };

/// What a file holds.
#[derive(Debug)]
pub enum ResultFileContent {
    /// A picture.
    Picture(ColorImage),
    /// Columns and rows, and the temperature of each pixel in hundredths of a kelvin, row by row.
    Temperatures([usize; 2], Vec<u16>),
    /// A gamma spectrum.
    Spectrum(GammaSpectrum),
}

/// A file that panels show.
pub(crate) enum ResultFile {
    /// It is fetched.
    Loading,
    /// A sentence that says why it cannot be shown.
    Failed(String),
    /// A picture.
    Picture(TextureHandle),
    /// A thermal picture.
    Thermal(ThermalPicture),
    /// A gamma spectrum.
    Spectrum(GammaSpectrum),
}

struct Entry {
    file: ResultFile,
    bytes: usize,
    /// The frame in which it was shown last.
    shown: u64,
}

/// The files that panels show, and those that they wait for.
#[derive(Default)]
pub struct ResultFiles {
    entries: BTreeMap<BlobHash, Entry>,
    wanted: Vec<(BlobHash, ResultFileKind)>,
    frame: u64,
}

impl std::fmt::Debug for ResultFiles {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ResultFiles").field("files", &self.entries.len()).finish_non_exhaustive()
    }
}

impl ResultFiles {
    /// Takes the files that are to be fetched. Each is named once.
    pub fn take_wanted(&mut self) -> Vec<(BlobHash, ResultFileKind)> {
        std::mem::take(&mut self.wanted)
    }

    /// Puts in what was fetched, or a sentence that says why not.
    pub fn insert(&mut self, ctx: &Context, blob: BlobHash, content: Result<ResultFileContent, String>) {
        let (file, bytes) = match content {
            Err(sentence) => (ResultFile::Failed(sentence), 0),
            Ok(ResultFileContent::Picture(image)) => {
                let bytes = image.pixels.len() * 4;
                let texture = ctx.load_texture(blob.to_string(), image, TextureOptions::LINEAR);
                (ResultFile::Picture(texture), bytes)
            }
            Ok(ResultFileContent::Temperatures(size, centikelvin)) => {
                let bytes = 6 * centikelvin.len();
                (ResultFile::Thermal(ThermalPicture::new(size, centikelvin)), bytes)
            }
            Ok(ResultFileContent::Spectrum(spectrum)) => {
                let bytes = 4 * spectrum.counts.len();
                (ResultFile::Spectrum(spectrum), bytes)
            }
        };
        self.entries.insert(blob, Entry { file, bytes, shown: self.frame });
        self.drop_oldest();
    }

    /// The file as it is now. It is fetched if that was not asked for yet.
    pub(crate) fn get(&mut self, blob: BlobHash, kind: ResultFileKind) -> &mut ResultFile {
        let frame = self.frame;
        let entry = self.entries.entry(blob).or_insert_with(|| {
            self.wanted.push((blob, kind));
            Entry { file: ResultFile::Loading, bytes: 0, shown: frame }
        });
        entry.shown = frame;
        &mut entry.file
    }

    /// A frame begins.
    pub(crate) fn begin_frame(&mut self) {
        self.frame += 1;
    }

    fn drop_oldest(&mut self) {
        let mut bytes: usize = self.entries.values().map(|entry| entry.bytes).sum();
        while bytes > CONFIG.max_bytes {
            let oldest = self.entries.iter().filter(|(_, entry)| entry.bytes > 0);
            let Some((blob, _)) = oldest.min_by_key(|(_, entry)| entry.shown) else { return };
            let blob = *blob;
            bytes -= self.entries.remove(&blob).map_or(0, |entry| entry.bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_asked_for_once_and_those_not_shown_for_long_are_dropped() {
        let ctx = Context::default();
        let mut files = ResultFiles::default();
        let blob = |number: u8| BlobHash([number; 32]);
        assert!(matches!(files.get(blob(1), ResultFileKind::Spectrum), ResultFile::Loading));
        files.get(blob(1), ResultFileKind::Spectrum);
        assert_eq!(files.take_wanted(), [(blob(1), ResultFileKind::Spectrum)]);
        files.insert(&ctx, blob(1), Err("The server does not answer.".into()));
        assert!(matches!(files.get(blob(1), ResultFileKind::Spectrum), ResultFile::Failed(_)));
        let picture = || ResultFileContent::Temperatures([4096, 2048], vec![29_315; 4096 * 2048]);
        for number in 2..=4 {
            files.begin_frame();
            files.insert(&ctx, blob(number), Ok(picture()));
        }
        assert!(!files.entries.contains_key(&blob(2)) && files.entries.contains_key(&blob(4)));
        files.get(blob(2), ResultFileKind::Temperatures);
        assert_eq!(files.take_wanted().len(), 1, "asked for again");
    }
}
