//! Turns the client's compiled WASM into the files that the server sends.
//!
//! Input: the `.wasm` file of the compiler. Output, in one folder: the JavaScript glue and the WASM, each named after its content so that
//! browsers may cache it for ever, and each with a `.br` and a `.gz` form. `manifest.json` is the only file with a fixed name. It contains
//! the names of the others for the page's loader. It is written last and by rename, so a page that loads meanwhile gets either the old
//! client or the new one, never a mixture.
//!
//! It is a program apart from `xtask`, because a WASM parser takes a minute to compile.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};
use wasm_bindgen_cli_support::Bindgen;

mod compress;
mod import_names;

use compress::{CompressionEffort, Sizes};

/// Name of the client in the files and in the page.
const NAME: &str = "autoinspect_client";

/// The WASM features that `wasm-opt` may use: those of rustc's `wasm32-unknown-unknown`, which every browser has since 2023. With
/// `--all-features` it would write a file that no browser loads.
const WASM_FEATURES: [&str; 6] = [
    "--enable-bulk-memory",
    "--enable-sign-ext",
    "--enable-mutable-globals",
    "--enable-nontrapping-float-to-int",
    "--enable-reference-types",
    "--enable-multivalue",
];

struct Options {
    wasm: PathBuf,
    out: PathBuf,
    effort: CompressionEffort,
    /// Path of a `wasm-opt` in JavaScript, run with node.
    wasm_opt: Option<PathBuf>,
    /// Largest size of WASM and glue together, compressed with brotli, bytes. A larger client is an error.
    max_brotli_bytes: Option<u64>,
}

fn main() -> ExitCode {
    match options().and_then(|options| bundle(&options)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn options() -> Result<Options> {
    use lexopt::prelude::*;

    let mut positional: Vec<OsString> = Vec::new();
    let mut options = Options {
        wasm: PathBuf::new(),
        out: PathBuf::new(),
        effort: CompressionEffort::Quick,
        wasm_opt: None,
        max_brotli_bytes: None,
    };
    let mut parser = lexopt::Parser::from_env();
    while let Some(argument) = parser.next()? {
        match argument {
            Long("smallest") => options.effort = CompressionEffort::Smallest,
            Long("wasm-opt") => options.wasm_opt = Some(parser.value()?.into()),
            Long("brotli-max") => options.max_brotli_bytes = Some(parser.value()?.parse()?),
            Value(value) => positional.push(value),
            other => return Err(other.unexpected().into()),
        }
    }
    let Ok([wasm, out]) = <[OsString; 2]>::try_from(positional) else {
        bail!("usage: bundler INPUT.wasm OUT_DIR [--smallest] [--wasm-opt FILE] [--brotli-max BYTES]");
    };
    options.wasm = wasm.into();
    options.out = out.into();
    Ok(options)
}

fn bundle(options: &Options) -> Result<()> {
    let staging = staging_folder(&options.wasm)?;
    Bindgen::new()
        .input_path(&options.wasm)
        .web(true)?
        .typescript(false)
        .out_name(NAME)
        .generate(&staging)
        .with_context(|| format!("could not bind {}", options.wasm.display()))?;

    let wasm_path = staging.join(format!("{NAME}_bg.wasm"));
    if let Some(wasm_opt) = &options.wasm_opt {
        optimise(wasm_opt, &wasm_path)?;
    }
    let wasm = fs::read(&wasm_path).with_context(|| format!("could not read {}", wasm_path.display()))?;
    let glue = fs::read_to_string(staging.join(format!("{NAME}.js")))
        .context("could not read the generated glue")?;
    let (glue, wasm) = import_names::number_imports(&glue, &wasm);
    let wasm_name = format!("{NAME}_bg-{}.wasm", content_name(&wasm));
    let glue = glue.replace(&format!("{NAME}_bg.wasm"), &wasm_name);
    let glue_name = format!("{NAME}-{}.js", content_name(glue.as_bytes()));
    let manifest = format!(
        "{{\n  \"js\": \"{glue_name}\",\n  \"wasm\": \"{wasm_name}\",\n  \"wasm_bytes\": {}\n}}\n",
        wasm.len()
    );

    let mut written = BTreeSet::new();
    let mut total = Sizes::default();
    let mut publish = |name: &str, content: &[u8]| -> Result<()> {
        let sizes = compress::write_with_variants(&options.out, name, content, options.effort, &mut written)?;
        eprintln!("  {sizes}  {name}");
        total += sizes;
        Ok(())
    };
    eprintln!("  {}", Sizes::HEADINGS);
    publish(&wasm_name, &wasm)?;
    publish(&glue_name, glue.as_bytes())?;
    for snippet in files_below(&staging.join("snippets"))? {
        let name =
            snippet.strip_prefix(&staging)?.to_str().context("a snippet's name is not UTF-8")?.to_owned();
        publish(&name, &fs::read(&snippet)?)?;
    }
    eprintln!("  {total}  in all");

    replace(&options.out.join("manifest.json"), manifest.as_bytes())?;
    written.insert(options.out.join("manifest.json"));
    for stale in files_below(&options.out)?.into_iter().filter(|path| !written.contains(path)) {
        fs::remove_file(&stale).with_context(|| format!("could not remove {}", stale.display()))?;
    }
    match options.max_brotli_bytes {
        Some(limit) if total.brotli > limit => {
            bail!("the client is {} bytes compressed with brotli; the limit is {limit}", total.brotli)
        }
        _ => Ok(()),
    }
}

/// An empty folder beside the compiler's output, for intermediate files.
fn staging_folder(wasm: &Path) -> Result<PathBuf> {
    let staging = wasm.with_extension("bundle");
    match fs::remove_dir_all(&staging) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("could not empty {}", staging.display()))?
        }
        _ => {}
    }
    fs::create_dir_all(&staging).with_context(|| format!("could not create {}", staging.display()))?;
    Ok(staging)
}

/// Runs `wasm-opt` on `wasm`, in place.
fn optimise(wasm_opt: &Path, wasm: &Path) -> Result<()> {
    let status = Command::new("node")
        .arg(wasm_opt)
        .args(WASM_FEATURES)
        // Twice: of a client of 2,175,870 bytes after brotli, the second pass saved 9 kB.
        .args(["-Os", "-Os", "--output"])
        .args([wasm, wasm])
        .status()
        .context("could not start node for wasm-opt")?;
    if !status.success() {
        bail!("wasm-opt failed ({status})");
    }
    Ok(())
}

/// The part of a file's name that changes with its content.
fn content_name(content: &[u8]) -> String {
    blake3::hash(content).to_hex()[..16].to_owned()
}

fn replace(path: &Path, content: &[u8]) -> Result<()> {
    let new = path.with_extension("new");
    fs::write(&new, content).with_context(|| format!("could not write {}", new.display()))?;
    fs::rename(&new, path).with_context(|| format!("could not replace {}", path.display()))
}

/// Every file below `folder`, in name order; none if the folder is missing.
fn files_below(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    if !folder.exists() {
        return Ok(files);
    }
    for entry in fs::read_dir(folder).with_context(|| format!("could not list {}", folder.display()))? {
        let path = entry?.path();
        if path.is_dir() { files.extend(files_below(&path)?) } else { files.push(path) }
    }
    files.sort();
    Ok(files)
}
