//! Test of the glossary: every name in its *code* column is declared in the crate of its row.

use crate::support::{rust_files, workspace_root};
use std::fs;

/// The rows of all tables with five columns, as (code, crate).
fn entries(text: &str) -> Vec<(String, String)> {
    let cells =
        |line: &str| line.split(" | ").map(|cell| cell.trim_matches(['|', ' ', '`']).to_owned()).collect();
    let rows = text.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| ---"));
    let rows = rows.map(cells).filter(|cells: &Vec<String>| cells.len() == 5 && cells[0] != "term");
    rows.map(|cells| (cells[1].clone(), cells[2].clone())).collect()
}

fn is_declared(name: &str, source: &str) -> bool {
    ["struct", "enum", "trait", "fn", "mod"].iter().any(|kind| {
        source.match_indices(&format!("{kind} {name}")).any(|(at, found)| {
            let next = source[at + found.len()..].chars().next();
            next.is_none_or(|next| !next.is_alphanumeric() && next != '_')
        })
    })
}

#[test]
fn every_name_in_the_glossary_is_declared_in_its_crate() {
    let root = workspace_root();
    let entries = entries(&fs::read_to_string(root.join("docs/glossary.md")).unwrap());
    assert!(entries.len() > 40, "{} entries", entries.len());
    let mut missing = Vec::new();
    for (name, crate_name) in entries {
        let groups = ["shared", "autonomy", "server", "web"];
        let folder =
            groups.map(|group| root.join(group).join(&crate_name)).into_iter().find(|path| path.is_dir());
        let Some(folder) = folder else {
            missing.push(format!("there is no crate {crate_name}"));
            continue;
        };
        let files = rust_files(&folder.join("src"));
        let is_there = name == crate_name
            || files.iter().any(|file| is_declared(&name, &fs::read_to_string(file).unwrap()));
        if !is_there {
            missing.push(format!("{name} in {crate_name}"));
        }
    }
    assert_eq!(missing, Vec::<String>::new());
}

#[test]
fn names_are_found_as_whole_words() {
    let source = "pub struct PoseTracker<'a> {}\npub fn plan(a: u8) {}\nmod se3;\n";
    for name in ["PoseTracker", "plan", "se3"] {
        assert!(is_declared(name, source), "{name}");
    }
    for name in ["Pose", "pla", "Tracker", "planner"] {
        assert!(!is_declared(name, source), "{name}");
    }
}
