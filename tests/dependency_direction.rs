//! Tests of the dependencies between crates. ARCHITECTURE.md describes the layers; the tables here enforce them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::support::{rust_files, workspace_root};

/// For each of our crates, the others of ours that it may depend on.
///
/// The absent ones matter: `sim` and `stack` do not depend on each other, so the stack cannot use the ground truth. In `server` only the
/// program and the runtime depend on `stack`. `web` depends on plain data, and on `missions`, which plans and previews in the browser as on
/// the robot.
const OURS: &[(&str, &[&str])] = &[
    ("vocab", &[]),
    ("messages", &["site_model", "vocab"]),
    ("api", &["site_model", "vocab"]),
    ("map_codec", &["vocab"]),
    ("site_model", &["vocab"]),
    ("scan_codec", &["messages", "vocab"]),
    ("time_zones", &[]),
    ("readings", &[]),
    //
    ("geometry", &["vocab"]),
    ("factors", &["geometry"]),
    ("points", &["geometry", "vocab"]),
    ("registration", &["geometry", "points"]),
    ("odometry", &["geometry", "points", "registration", "vocab"]),
    ("mapping", &["factors", "geometry", "points", "registration", "vocab"]),
    ("localisation", &["geometry", "mapping", "points", "registration", "vocab"]),
    ("navigation", &["geometry", "points", "registration", "vocab"]),
    ("topomap", &["geometry", "mapping", "navigation", "site_model", "vocab"]),
    ("object_identity", &["geometry"]),
    ("changes", &["geometry", "object_identity", "points", "registration"]),
    ("gauges", &[]),
    ("picture_changes", &["gauges", "geometry"]),
    ("executive", &["geometry", "localisation", "messages", "navigation", "site_model", "vocab"]),
    ("missions", &["site_model", "time_zones", "vocab"]),
    (
        "stack",
        &[
            "executive",
            "geometry",
            "localisation",
            "mapping",
            "messages",
            "missions",
            "navigation",
            "odometry",
            "points",
            "site_model",
            "vocab",
        ],
    ),
    ("sim", &["geometry", "messages", "vocab"]),
    ("lockstep", &["messages", "scan_codec", "sim", "site_model", "stack", "vocab"]),
    //
    ("accounts", &["api"]),
    ("ports", &["api", "messages", "site_model", "vocab"]),
    ("watchdog", &[]),
    ("formats", &["messages", "vocab"]),
    ("links", &["geometry", "messages", "ports", "scan_codec", "sim", "site_model", "vocab"]),
    ("site_files", &["sim", "vocab"]),
    ("gauge_file", &["gauges", "site_model", "vocab"]),
    ("recorder", &["formats", "geometry", "messages", "ports", "scan_codec", "site_model", "vocab"]),
    (
        "store",
        &[
            "api",
            "formats",
            "geometry",
            "map_codec",
            "mapping",
            "messages",
            "missions",
            "ports",
            "site_model",
            "topomap",
            "vocab",
        ],
    ),
    (
        "runtime",
        &[
            "accounts",
            "api",
            "changes",
            "geometry",
            "map_codec",
            "messages",
            "missions",
            "object_identity",
            "ports",
            "site_model",
            "stack",
            "store",
            "topomap",
            "vocab",
            "watchdog",
        ],
    ),
    ("gateway", &["accounts", "api", "missions", "recorder", "site_model", "vocab", "watchdog"]),
    (
        "autoinspect",
        &[
            "accounts",
            "api",
            "changes",
            "factors",
            "formats",
            "gateway",
            "gauge_file",
            "gauges",
            "geometry",
            "links",
            "localisation",
            "lockstep",
            "mapping",
            "messages",
            "missions",
            "object_identity",
            "picture_changes",
            "points",
            "ports",
            "recorder",
            "runtime",
            "scan_codec",
            "sim",
            "site_files",
            "site_model",
            "stack",
            "store",
            "topomap",
            "vocab",
            "watchdog",
        ],
    ),
    //
    ("client_model", &["api", "missions", "readings", "site_model", "vocab"]),
    ("scene", &[]),
    ("panels", &["api", "client_model", "missions", "site_model", "vocab"]),
    ("app", &["api", "client_model", "map_codec", "panels", "scene", "site_model", "vocab"]),
    //
    ("bundler", &[]),
    ("xtask", &[]),
];

/// Further crates that the tests of a crate may depend on.
const OURS_IN_TESTS: &[(&str, &[&str])] = &[
    ("autoinspect", &["client_model", "map_codec"]),
    ("changes", &["sim"]),
    ("factors", &["formats"]),
    ("lockstep", &["geometry", "mapping", "points"]),
    ("mapping", &["messages", "odometry", "sim"]),
    ("odometry", &["messages", "sim"]),
    ("runtime", &["links", "sim"]),
    ("site_files", &["geometry"]),
];

/// Crates that may depend on all others, because they compare or test the whole.
const SEES_EVERYTHING: &[&str] = &["benches", "fuzzing", "tests"];

/// External crates with restricted use, and the only crates of ours that may use them outside tests.
const HOMES: &[(&str, &[&str])] = &[
    ("argon2", &["accounts"]),
    ("axum", &["gateway"]),
    ("eframe", &["app"]),
    ("egui", &["app", "panels"]),
    ("gltf", &["site_files"]),
    ("mcap", &["recorder"]),
    ("rcgen", &["gateway"]),
    ("ring", &["gateway"]),
    ("rusqlite", &["formats", "store"]),
    ("tokio", &["autoinspect", "gateway"]),
    ("tokio-rustls", &["gateway"]),
    ("wasm-bindgen", &["app"]),
    ("wgpu", &["app", "scene"]),
];

/// External crates that the core may use: mathematics and bytes, none with access to files, threads or clocks.
const AUTONOMY_MAY_USE: &[&str] = &[
    "blake3",
    // The calendar and its time zones, without its clock: `missions` reads no zone from the system.
    "jiff",
    "nalgebra",
    // Letters as constant pictures, for the labels that the simulated cameras see.
    "noto-sans-mono-bitmap",
    "ordered-float",
    // `astar` and `dijkstra_reach` hash without a random seed, so they give the same path in every process.
    "pathfinding",
    "postcard",
    "rand_core",
    "rand_pcg",
    "thiserror",
    // Ids; random ones need a feature that no crate of the core enables.
    "uuid",
    // Bodies of the ledger's rows and parameters of actions as JSON. Maps are written in a fixed order.
    "serde",
    "serde_json",
];

/// Words that the core's code may not contain, with the reason or replacement.
const AUTONOMY_NEVER_SAYS: &[(&str, &str)] = &[
    ("Instant", "the only clock is the `at` of `Stack::step`"),
    ("SystemTime", "the only clock is the `at` of `Stack::step`"),
    ("HashMap", "its order differs between processes; use BTreeMap or points' hashed maps"),
    ("HashSet", "its order differs between processes; use BTreeSet or points' hashed maps"),
    ("dijkstra_all", "its order differs between processes; use dijkstra_reach"),
    ("dijkstra_partial", "its order differs between processes; use dijkstra_reach"),
    ("astar_bag", "its order differs between processes; use astar"),
    ("std::fs", "the core does no IO"),
    ("std::net", "the core does no IO"),
    ("std::env", "configuration arrives in the boot record"),
    ("available_parallelism", "the core does not learn the core count"),
];

struct Package {
    name: String,
    /// Folder of the manifest.
    folder: PathBuf,
    dependencies: Vec<Dependency>,
}

struct Dependency {
    name: String,
    ours: bool,
    for_tests: bool,
}

fn packages() -> Vec<Package> {
    let output = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(workspace_root())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let dependency = |value: &Value| Dependency {
        name: text(&value["name"]),
        ours: value["path"].is_string(),
        for_tests: value["kind"] == "dev",
    };
    let package = |value: &Value| Package {
        name: text(&value["name"]),
        folder: Path::new(value["manifest_path"].as_str().unwrap()).parent().unwrap().to_owned(),
        dependencies: value["dependencies"].as_array().unwrap().iter().map(dependency).collect(),
    };
    metadata["packages"].as_array().unwrap().iter().map(package).collect()
}

/// Violations of the tables by `packages`, one sentence each.
fn violations(packages: &[Package]) -> Vec<String> {
    let ours: BTreeMap<_, _> = OURS.iter().copied().collect();
    let ours_in_tests: BTreeMap<_, _> = OURS_IN_TESTS.iter().copied().collect();
    let homes: BTreeMap<_, _> = HOMES.iter().copied().collect();
    let mut violations = Vec::new();
    for package in packages.iter().filter(|package| !SEES_EVERYTHING.contains(&package.name.as_str())) {
        let name = package.name.as_str();
        let Some(allowed) = ours.get(name) else {
            violations.push(format!("{name} is not in the table of tests/dependency_direction.rs"));
            continue;
        };
        let in_autonomy = package.folder.parent().is_some_and(|group| group.ends_with("autonomy"));
        for dependency in &package.dependencies {
            let other = dependency.name.as_str();
            let in_tests =
                dependency.for_tests && ours_in_tests.get(name).is_some_and(|more| more.contains(&other));
            if dependency.ours && !allowed.contains(&other) && !in_tests {
                violations.push(format!("{name} may not depend on {other}"));
            }
            if dependency.for_tests || dependency.ours {
                continue;
            }
            if homes.get(other).is_some_and(|homes| !homes.contains(&name)) {
                violations
                    .push(format!("{name} may not use {other}; its home is {}", homes[other].join(", ")));
            }
            if in_autonomy && !AUTONOMY_MAY_USE.contains(&other) {
                violations.push(format!("{name} may not use {other}: it is not among what the core may use"));
            }
        }
    }
    violations
}

#[test]
fn every_crate_depends_only_on_permitted_crates() {
    let violations = violations(&packages());
    assert!(violations.is_empty(), "\n{}", violations.join("\n"));
}

#[test]
fn a_forbidden_dependency_is_reported() {
    let package = |name: &str, group: &str, dependencies: &[(&str, bool)]| Package {
        name: name.to_owned(),
        folder: Path::new("/").join(group).join(name),
        dependencies: dependencies
            .iter()
            .map(|&(name, ours)| Dependency { name: name.to_owned(), ours, for_tests: false })
            .collect(),
    };
    let broken = [
        package("sim", "autonomy", &[("stack", true), ("tokio", false)]),
        package("panels", "web", &[("egui", false), ("wgpu", false)]),
        package("newcomer", "server", &[]),
    ];
    assert_eq!(
        violations(&broken),
        [
            "sim may not depend on stack",
            "sim may not use tokio; its home is autoinspect, gateway",
            "sim may not use tokio: it is not among what the core may use",
            "panels may not use wgpu; its home is app, scene",
            "newcomer is not in the table of tests/dependency_direction.rs",
        ]
    );
}

#[test]
fn the_tables_name_only_existing_crates() {
    let packages = packages();
    for (name, _) in OURS {
        assert!(packages.iter().any(|package| package.name == *name), "there is no crate {name} any more");
    }
}

#[test]
fn the_tables_permit_only_what_is_used() {
    let packages = packages();
    let mut unused = Vec::new();
    for (table, for_tests) in [(OURS, false), (OURS_IN_TESTS, true)] {
        for (name, permitted) in table {
            let Some(package) = packages.iter().find(|package| package.name == *name) else { continue };
            for other in *permitted {
                let is_used = package
                    .dependencies
                    .iter()
                    .any(|dependency| dependency.name == *other && dependency.for_tests == for_tests);
                if !is_used {
                    unused.push(format!("{name} does not depend on {other}"));
                }
            }
        }
    }
    assert!(unused.is_empty(), "\n{}", unused.join("\n"));
}

#[test]
fn the_core_uses_no_clock_file_or_random_hash_order() {
    let mut violations = Vec::new();
    for file in rust_files(&workspace_root().join("autonomy")) {
        let text = fs::read_to_string(&file).unwrap();
        violations.extend(forbidden_words(&text).map(|complaint| format!("{}:{complaint}", file.display())));
    }
    assert!(violations.is_empty(), "\n{}", violations.join("\n"));
}

#[test]
fn a_forbidden_word_is_reported() {
    let complaints: Vec<_> = forbidden_words(
        "// An Instant in a comment is fine.\nlet at = Instant::now();\nlet instantly = 1;\n#[cfg(test)]\nuse std::fs;\n",
    )
    .collect();
    assert_eq!(complaints, ["2: Instant: the only clock is the `at` of `Stack::step`"]);
}

/// Forbidden words in the code of `text`, with line numbers. Comments and the tests at a file's end are left out.
fn forbidden_words(text: &str) -> impl Iterator<Item = String> {
    text.lines()
        .enumerate()
        .take_while(|(_, line)| !line.starts_with("#[cfg(test)]"))
        .map(|(index, line)| (index + 1, line.split("//").next().unwrap_or_default()))
        .flat_map(|(number, code)| {
            let found = AUTONOMY_NEVER_SAYS.iter().filter(move |(word, _)| says(code, word));
            found.map(move |(word, instead)| format!("{number}: {word}: {instead}"))
        })
}

/// Whether `code` contains `word` as a whole name.
fn says(code: &str, word: &str) -> bool {
    let part_of_name = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(word).any(|(start, _)| {
        !code[..start].ends_with(part_of_name) && !code[start + word.len()..].starts_with(part_of_name)
    })
}
