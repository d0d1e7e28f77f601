//! Tests of the parameters of algorithms: each field of a `…Config` has a docstring that says what it is and where its value comes from.

use crate::support::{rust_files, workspace_root};
use std::fs;
use std::path::PathBuf;

/// A sentence that once stood for the sources of all fields of a struct. Each field names its own.
const BLANKET: &str = "Where a field names no source, its value was chosen.";
/// Folders with the crates of the product.
const GROUPS: [&str; 4] = ["autonomy", "server", "shared", "web"];
/// Words besides those of the name of the field in the shortest docstring that says more than it.
const MIN_WORDS: usize = 2;

/// The name of the struct that begins on this line, if it is a `…Config` with named fields.
fn config_name(line: &str) -> Option<&str> {
    let (before, after) = line.trim().split_once("struct ")?;
    let is_declaration = before.is_empty() || before.starts_with("pub");
    let name = after.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
    (is_declaration && name.ends_with("Config") && after.ends_with('{')).then_some(name)
}

/// The name of the field that is declared on this line.
fn field_name(line: &str) -> Option<&str> {
    let (head, _) = line.trim().split_once(": ")?;
    let name = head.rsplit(' ').next()?;
    name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_').then_some(name)
}

/// The text of a line of a docstring.
fn doc_line(line: &str) -> Option<&str> {
    line.trim().strip_prefix("///").map(str::trim)
}

/// Whether a docstring is a sentence that says more than the name of its field.
fn is_sentence(doc: &str, field: &str) -> bool {
    let is_of_name = |word: &str| {
        let word = word.to_lowercase();
        field.split('_').any(|part| word.trim_end_matches(|c: char| !c.is_alphanumeric()) == part)
    };
    let ends = doc.ends_with(['.', ')', '?']);
    ends && doc.split(' ').filter(|word| !is_of_name(word)).count() >= MIN_WORDS
}

/// The fields of all `…Config` of a source file, with their docstrings on one line.
fn fields(source: &str) -> Vec<(String, String)> {
    let (mut found, mut inside, mut doc) = (Vec::new(), None, Vec::new());
    for line in source.lines() {
        match (inside, doc_line(line)) {
            (None, _) => inside = config_name(line),
            (Some(_), Some(text)) => doc.push(text),
            (Some(_), None) if line.trim() == "}" => inside = None,
            (Some(_), None) if line.trim().starts_with("#[") => {}
            (Some(name), None) => {
                let of_field = std::mem::take(&mut doc).join(" ");
                found.extend(field_name(line).map(|field| (format!("{name}::{field}"), of_field)));
            }
        }
    }
    found
}

/// What is wrong with the parameters in a source file.
fn problems(source: &str) -> Vec<String> {
    let missing = fields(source).into_iter().filter(|(path, doc)| {
        let field = path.rsplit(':').next().unwrap_or_default();
        !is_sentence(doc, field)
    });
    let docs: Vec<&str> = source.lines().filter_map(doc_line).collect();
    let blanket = docs.join(" ").contains(BLANKET).then(|| format!("\"{BLANKET}\""));
    missing.map(|(path, _)| format!("{path} has no sentence")).chain(blanket).collect()
}

#[test]
fn every_parameter_has_a_docstring_of_its_own() {
    let root = workspace_root();
    let files: Vec<PathBuf> = GROUPS.iter().flat_map(|group| rust_files(&root.join(group))).collect();
    let read = |file: &PathBuf| fs::read_to_string(file).unwrap();
    let count: usize = files.iter().map(|file| fields(&read(file)).len()).sum();
    assert!(count > 1_000, "{count} fields");
    let mut found: Vec<String> = files
        .iter()
        .flat_map(|file| {
            let at = file.strip_prefix(&root).unwrap().display().to_string();
            problems(&read(file)).into_iter().map(move |problem| format!("{at}: {problem}"))
        })
        .collect();
    found.sort();
    assert_eq!(found, Vec::<String>::new());
}

#[test]
fn a_missing_sentence_is_found() {
    let source = |doc: &str| {
        format!("/// Parameters.\npub struct WalkConfig {{\n    {doc}\n    pub max_speed_m_s: f64,\n}}\n")
    };
    assert_eq!(problems(&source("/// Greatest speed, m/s. Chosen: a slow walk.")), Vec::<String>::new());
    for doc in ["", "/// Max speed.", "/// Greatest speed of the robot, m/s", "// Greatest speed of a robot."]
    {
        assert_eq!(problems(&source(doc)), ["WalkConfig::max_speed_m_s has no sentence"], "{doc}");
    }
}

#[test]
fn the_blanket_sentence_is_found_also_over_two_lines() {
    let source =
        "/// Parameters. Where a field names no\n/// source, its value was chosen.\nstruct WalkConfig {}\n";
    assert_eq!(problems(source).len(), 1);
}
