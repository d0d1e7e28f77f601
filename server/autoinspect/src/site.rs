//! `autoinspect site export`: writes a simulated site as a building of other programs, with its sidecar.

use crate::failure::Failure;
use crate::{output, summaries};
use clap::Args;
use serde::Serialize;
use site_files::{SiteSource, write_site};
use std::path::PathBuf;

/// Write a site as SITE.glb and SITE.site.json.
#[derive(Args, Debug)]
#[command(
    after_help = "SITE.glb is a binary glTF file for Blender and others. SITE.site.json holds docks, routes, furniture and paths of people.

EXAMPLES:
  autoinspect site export b1 --out sites
  autoinspect up --robot sim:sites/b1.glb"
)]
pub struct SiteExportArgs {
    /// Site: b1, torus, plant, twins, generated:SEED, or FILE.glb.
    site: SiteSource,
    /// Folder to write into.
    #[arg(long)]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// The result, for people and programs.
#[derive(Debug, Serialize)]
struct Exported {
    file: PathBuf,
}

/// Runs `autoinspect site export`.
pub fn export(args: &SiteExportArgs) -> Result<(), Failure> {
    let site = args.site.load().map_err(Failure::usage)?;
    let file = write_site(&args.out, &site).map_err(Failure::failed)?;
    output::print_human(args.json, &summaries::site_written(&file));
    output::print_json(args.json, &Exported { file })
}
