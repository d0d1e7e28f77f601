//! How a command line names a site, and how a site is read from files and written to them.

use crate::error::SiteFileError;
use crate::{glb, sidecar, texts};
use sim::{BuildingModelConfig, SimulatedSite, SiteName, TessellationConfig};
use std::fmt;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

/// End of the names of model files.
const GLB: &str = "glb";
/// End of the name of the file beside a model.
const SIDECAR: &str = "site.json";

/// A site, as named on a command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SiteSource {
    /// One that the simulator builds.
    BuiltIn(SiteName),
    /// A building in a GLB file.
    File(PathBuf),
}

impl SiteSource {
    /// Builds or reads the site.
    ///
    /// # Errors
    /// When its files cannot be used.
    pub fn load(&self) -> Result<Arc<SimulatedSite>, SiteFileError> {
        match self {
            Self::BuiltIn(name) => Ok((*name).into()),
            Self::File(file) => read_site(file).map(Arc::new),
        }
    }
}

impl fmt::Display for SiteSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BuiltIn(name) => write!(f, "{name}"),
            Self::File(file) => write!(f, "{}", file.display()),
        }
    }
}

impl FromStr for SiteSource {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let file = Path::new(text);
        if file.extension().is_some_and(|end| end.eq_ignore_ascii_case(GLB)) {
            return Ok(Self::File(file.to_owned()));
        }
        text.parse().map(Self::BuiltIn).map_err(|error| format!("{error}, or FILE.glb"))
    }
}

/// Reads a building from a GLB file, and from its sidecar if it has one.
///
/// # Errors
/// When one of both files cannot be used, or when they do not make a site.
pub fn read_site(file: &Path) -> Result<SimulatedSite, SiteFileError> {
    let config = BuildingModelConfig::default();
    let bytes = fs::read(file).map_err(|error| SiteFileError::new(file, texts::not_read(&error)))?;
    let document =
        glb::read(&bytes, config.max_triangles).map_err(|reason| SiteFileError::new(file, reason))?;
    drop(bytes);
    let beside = file.with_extension(SIDECAR);
    let sidecar = match fs::read_to_string(&beside) {
        Ok(text) => sidecar::parse(&text).map_err(|reason| SiteFileError::new(&beside, reason))?,
        Err(error) if error.kind() == ErrorKind::NotFound => sidecar::Sidecar::default(),
        Err(error) => return Err(SiteFileError::new(&beside, texts::not_read(&error))),
    };
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let model =
        sidecar::model(name, &document, &sidecar).map_err(|reason| SiteFileError::new(&beside, reason))?;
    SimulatedSite::from_model(model, &config).map_err(|error| SiteFileError::new(file, error.to_string()))
}

/// Writes a site as `NAME.glb` and `NAME.site.json` into a folder, which is made if it is missing. Returns the first file.
///
/// # Errors
/// When a file cannot be written.
pub fn write_site(folder: &Path, site: &SimulatedSite) -> Result<PathBuf, SiteFileError> {
    let failed = |file: &Path, error: &dyn fmt::Display| SiteFileError::new(file, texts::not_written(error));
    fs::create_dir_all(folder).map_err(|error| failed(folder, &error))?;
    let model = site.to_model(&TessellationConfig::default());
    // The colon of "generated:7" is not allowed in the names of files everywhere.
    let name = site.name().replace(':', "-");
    let file = folder.join(format!("{name}.{GLB}"));
    let beside = file.with_extension(SIDECAR);
    let bytes = glb::write(&model.parts).map_err(|reason| SiteFileError::new(&file, reason))?;
    fs::write(&file, bytes).map_err(|error| failed(&file, &error))?;
    let text = sidecar::to_text(&model).map_err(|reason| SiteFileError::new(&beside, reason))?;
    fs::write(&beside, text).map_err(|error| failed(&beside, &error))?;
    Ok(file)
}
