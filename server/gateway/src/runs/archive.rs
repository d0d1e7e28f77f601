//! What the archive of a run holds, under which names.

use super::documents::{result_document, run_document, step_document};
use super::names::{file_name, place_name, run_file_name, utc};
use super::stored_content::{CoreQueries, action_report, for_each_result, for_each_step, stored_json};
use crate::blobs::blob_path;
use crate::texts;
use api::{SiteState, StoredResult, StoredRun};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vocab::csv_field;
use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, ZipWriter};

/// A run that is written as an archive.
pub(super) struct Archive {
    run: StoredRun,
    site: Option<Arc<SiteState>>,
    data_dir: PathBuf,
    name: String,
}

type Zip<W> = ZipWriter<StreamWriter<W>>;

impl Archive {
    /// Names of places and of the mission are those of `site`.
    pub(super) fn new(run: StoredRun, site: Option<Arc<SiteState>>, data_dir: &Path) -> Self {
        let name = run_file_name(&run, site.as_ref().map(|state| &state.site));
        Self { name, run, site, data_dir: data_dir.to_owned() }
    }

    /// Name of the folder in the archive: ASCII letters, digits, `-` and `_`.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Writes the archive.
    ///
    /// # Errors
    /// When the core, the disk or whoever reads the archive fails.
    pub(super) fn write(&self, core: &dyn CoreQueries, sink: impl Write) -> io::Result<()> {
        let mut zip = ZipWriter::new_stream(sink);
        self.begin(&mut zip, "run.json")?;
        write_json(&mut zip, &run_document(self.run.clone()))?;
        self.begin(&mut zip, "steps.json")?;
        self.write_steps(core, &mut zip)?;
        self.begin(&mut zip, "results.json")?;
        let mut list = List::default();
        for_each_result(core, self.run.run, |result| list.push(&mut zip, &result_document(result)))?;
        list.end(&mut zip)?;
        self.begin(&mut zip, "readings.csv")?;
        writeln!(zip, "utc,place,action,attempt,reading,value,standard_deviation,unit")?;
        for_each_result(core, self.run.run, |result| self.write_readings(&mut zip, &result))?;
        let mut names = BTreeSet::new();
        let mut missing = Vec::new();
        for_each_result(core, self.run.run, |result| {
            self.write_files(&mut zip, &result, &mut names, &mut missing)
        })?;
        if !missing.is_empty() {
            self.begin(&mut zip, "missing-files.txt")?;
            writeln!(zip, "{}", missing.join("\n"))?;
        }
        zip.finish()?.flush()
    }

    /// Begins a file. Pictures are compressed already, and the rest is short, so nothing is.
    fn begin<W: Write>(&self, zip: &mut Zip<W>, path: &str) -> io::Result<()> {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        Ok(zip.start_file(format!("{}/{path}", self.name), options)?)
    }

    fn write_steps<W: Write>(&self, core: &dyn CoreQueries, zip: &mut Zip<W>) -> io::Result<()> {
        let mut list = List::default();
        for_each_step(core, self.run.run, |step| list.push(zip, &step_document(step)))?;
        list.end(zip)
    }

    fn write_readings<W: Write>(&self, zip: &mut Zip<W>, result: &StoredResult) -> io::Result<()> {
        let details = stored_json(&result.body);
        let Some(report) = action_report(&details) else { return Ok(()) };
        let at = utc(result.at.nanos());
        let place = self.place(&details);
        for reading in &report.readings {
            let deviation = reading.standard_deviation.map(|it| it.to_string()).unwrap_or_default();
            let (attempt, value) = (result.attempt.to_string(), reading.value.to_string());
            let [place, kind, name, unit] =
                [&place, &result.kind, &reading.name, &reading.unit].map(|text| csv_field(text));
            writeln!(zip, "{at},{place},{kind},{attempt},{name},{value},{deviation},{unit}")?;
        }
        Ok(())
    }

    fn write_files<W: Write>(
        &self,
        zip: &mut Zip<W>,
        result: &StoredResult,
        names: &mut BTreeSet<String>,
        missing: &mut Vec<String>,
    ) -> io::Result<()> {
        let details = stored_json(&result.body);
        let Some(report) = action_report(&details) else { return Ok(()) };
        let place = file_name(&self.place(&details));
        for file in &report.files {
            let name = format!("files/{:02}_{place}_{}", result.step + 1, file_name(&file.name));
            // An action that was done again has files of the same names.
            let name = if names.insert(name.clone()) {
                name
            } else {
                format!(
                    "files/{:02}_{place}_result-{}_{}",
                    result.step + 1,
                    result.number,
                    file_name(&file.name)
                )
            };
            let hash = file.blob.to_string();
            match File::open(blob_path(&self.data_dir, &hash)) {
                Ok(mut content) => {
                    self.begin(zip, &name)?;
                    io::copy(&mut content, zip)?;
                }
                Err(_) => missing.push(format!("{name} {hash}")),
            }
        }
        Ok(())
    }

    /// Name of the place of a result: its inspection point, or else its node.
    fn place(&self, details: &Value) -> String {
        let name = self.site.as_ref().and_then(|state| place_name(&state.site, details));
        name.unwrap_or(texts::UNNAMED_PLACE).to_owned()
    }
}

/// A JSON array that is written one entry after the other.
#[derive(Default)]
struct List {
    is_begun: bool,
}

impl List {
    fn push(&mut self, sink: &mut impl Write, entry: &impl Serialize) -> io::Result<()> {
        sink.write_all(if self.is_begun { b",\n" } else { b"[\n" })?;
        self.is_begun = true;
        write_json(sink, entry)
    }

    fn end(self, sink: &mut impl Write) -> io::Result<()> {
        sink.write_all(if self.is_begun { b"\n]\n" } else { b"[]\n" })
    }
}

fn write_json(sink: &mut impl Write, document: &impl Serialize) -> io::Result<()> {
    sink.write_all(&serde_json::to_vec_pretty(document)?)
}

#[cfg(test)]
#[path = "archive_tests.rs"]
mod tests;
