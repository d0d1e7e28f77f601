//! Test of the files of each crate: none uses a file that uses it in turn, directly or over others. What two files need of each other stands in a third.

use crate::support::workspace_root;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The names on the path of a module in its crate; empty for `lib.rs` and `main.rs`.
type Module = Vec<String>;

/// The modules of a crate, each with its code.
type Modules = BTreeMap<Module, String>;

#[test]
fn no_files_of_a_crate_use_each_other_in_a_circle() {
    let mut circles = Vec::new();
    for folder in source_folders() {
        let modules = read_modules(&folder);
        let name = folder.strip_prefix(workspace_root()).unwrap().display().to_string();
        circles.extend(find_circle(&uses(&modules)).map(|circle| format!("{name}: {}", circle.join(" -> "))));
    }
    assert!(circles.is_empty(), "\n{}", circles.join("\n"));
}

#[test]
fn a_circle_is_found_through_reexports_and_groups() {
    let modules = |files: &[(&str, &str)]| -> Modules {
        files.iter().map(|(path, text)| (module(Path::new(path)), code(text))).collect()
    };
    let lib = ("lib.rs", "mod a;\nmod b;\npub use b::B;\n");
    let uses_b = ("a.rs", "use crate::{B, c::C};\npub struct A;\n");
    assert_eq!(find_circle(&uses(&modules(&[lib, uses_b, ("b.rs", "pub struct B;\n")]))), None);
    let back = ("b.rs", "pub struct B(super::a::A);\n");
    let circle = find_circle(&uses(&modules(&[lib, uses_b, back])));
    assert_eq!(circle, Some(["a.rs", "b.rs", "a.rs"].map(str::to_owned).to_vec()));
    let in_test = ("b.rs", "pub struct B;\n#[cfg(test)]\nmod tests {\n    use crate::a::A;\n}\n");
    assert_eq!(find_circle(&uses(&modules(&[lib, uses_b, in_test]))), None);
    let group = ("b.rs", "use crate::d::{D};\npub struct B;\n");
    let child = [
        lib,
        uses_b,
        group,
        ("d/mod.rs", "pub use e::D;\nuse crate::a::A;\n"),
        ("d/e.rs", "pub struct D;\n"),
    ];
    assert_eq!(find_circle(&uses(&modules(&child))), None, "only the file of the item is used");
    let parent = [("lib.rs", ""), ("a/mod.rs", "use c::C;\npub struct A;\n"), ("a/c.rs", "use super::A;\n")];
    assert!(find_circle(&uses(&modules(&parent))).is_some(), "a parent and its child");
}

/// The `src` folders of all crates.
fn source_folders() -> Vec<std::path::PathBuf> {
    let root = workspace_root();
    let mut folders: Vec<_> = ["shared", "autonomy", "server", "web"]
        .iter()
        .flat_map(|group| fs::read_dir(root.join(group)).unwrap())
        .map(|entry| entry.unwrap().path().join("src"))
        .chain([root.join("benches/src"), root.join("xtask/src")])
        .filter(|folder| folder.is_dir())
        .collect();
    folders.sort();
    folders
}

fn read_modules(source: &Path) -> Modules {
    let mut modules = Modules::new();
    let mut folders = vec![source.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.to_string_lossy().into_owned();
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".rs") && !name.ends_with("tests.rs") {
                let text = fs::read_to_string(&path).unwrap();
                modules.insert(module(path.strip_prefix(source).unwrap()), code(&text));
            }
        }
    }
    modules
}

/// The module of a file, by its path in `src`.
fn module(path: &Path) -> Module {
    let path = path.with_extension("");
    let mut names: Module = path.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    if names.last().is_some_and(|name| name == "mod") || names == ["lib"] || names == ["main"] {
        names.pop();
    }
    names
}

/// A file without comments and without what is compiled for tests only.
fn code(text: &str) -> String {
    let mut kept = String::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if !line.trim_start().starts_with("#[cfg(test)]") {
            kept.push_str(line.split("//").next().unwrap_or_default());
            kept.push('\n');
            continue;
        }
        // The item ends with its first line, or with the closing brace at the same indentation.
        let indent = &line[..line.len() - line.trim_start().len()];
        let mut item = lines.by_ref().skip_while(|line| line.trim_start().starts_with("#["));
        let is_whole = item.next().is_none_or(|first| first.trim_end().ends_with([';', '}', ',']));
        if !is_whole {
            lines.by_ref().find(|line| line.strip_prefix(indent).is_some_and(|rest| rest.starts_with('}')));
        }
    }
    kept
}

/// What each module uses of the others. A module that makes items of its children public does not use them by that.
fn uses(modules: &Modules) -> BTreeMap<Module, BTreeSet<Module>> {
    let statements: BTreeMap<&Module, _> =
        modules.iter().map(|(module, code)| (module, use_statements(code))).collect();
    let mut reexports = BTreeMap::new();
    for (module, (statements, _)) in &statements {
        for path in statements.iter().filter(|(public, _)| *public).flat_map(|(_, tree)| expand(tree)) {
            if let Some((target, Some(item))) = resolve(modules, module, &path) {
                reexports.insert(((*module).clone(), item.clone()), (target, item));
            }
        }
    }
    let mut used = BTreeMap::new();
    for module in modules.keys() {
        let (trees, code) = &statements[module];
        let named =
            trees.iter().flat_map(|(public, tree)| expand(tree).into_iter().map(move |path| (*public, path)));
        let inline = inline_paths(code).into_iter().map(|path| (false, path));
        let targets = named.chain(inline).filter_map(|(public, path)| {
            let (mut target, mut item) = resolve(modules, module, &path)?;
            if public && target.starts_with(module) {
                return None;
            }
            while let Some(name) = item {
                let Some((next, original)) = reexports.get(&(target.clone(), name)) else { break };
                (target, item) = (next.clone(), Some(original.clone()));
            }
            (target != *module).then_some(target)
        });
        used.insert(module.clone(), targets.collect());
    }
    used
}

/// The trees of all `use` statements, each with whether it is public, and the code without them.
fn use_statements(code: &str) -> (Vec<(bool, String)>, String) {
    let (mut found, mut others) = (Vec::new(), String::new());
    let mut rest = code;
    while let Some(at) = rest.find("use ") {
        let line = rest[..at].rsplit('\n').next().unwrap_or_default().trim_start();
        let after = &rest[at + 4..];
        others.push_str(&rest[..at]);
        if line.is_empty() || line.starts_with("pub") {
            let end = after.find(';').unwrap_or(after.len());
            found.push((!line.is_empty(), after[..end].split_whitespace().collect::<Vec<_>>().join(" ")));
            rest = &after[end..];
        } else {
            rest = after;
        }
    }
    others.push_str(rest);
    (found, others)
}

/// The paths of a tree with groups: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn expand(tree: &str) -> Vec<String> {
    let Some(open) = tree.find('{') else {
        let path = tree.split(" as ").next().unwrap_or_default().trim();
        return if path.is_empty() { Vec::new() } else { vec![path.to_owned()] };
    };
    let (mut depth, mut part, mut paths) = (0, String::new(), Vec::new());
    for letter in tree[open..].chars() {
        depth += i32::from(letter == '{') - i32::from(letter == '}');
        let is_end = (letter == ',' && depth == 1) || depth == 0;
        if is_end {
            paths.extend(expand(&part).into_iter().map(|path| format!("{}{path}", &tree[..open])));
            part.clear();
        } else if !(letter == '{' && depth == 1) {
            part.push(letter);
        }
        if depth == 0 {
            break;
        }
    }
    paths
}

/// Paths that begin with `crate`, `super` or `self`.
fn inline_paths(code: &str) -> Vec<String> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    code.split(|c: char| !is_part(c))
        .map(|path| path.trim_end_matches(':'))
        .filter(|path| ["crate::", "super::", "self::"].iter().any(|start| path.starts_with(start)))
        .map(str::to_owned)
        .collect()
}

/// The module of a path, and the item in it; `None` for paths into other crates.
fn resolve(modules: &Modules, at: &Module, path: &str) -> Option<(Module, Option<String>)> {
    let mut names = path.split("::").map(str::trim).peekable();
    let mut target = match *names.peek()? {
        "crate" => Module::new(),
        "self" | "super" => at.clone(),
        child => {
            let mut module = at.clone();
            module.push(child.to_owned());
            modules.contains_key(&module).then_some(())?;
            at.clone()
        }
    };
    for name in names {
        match name {
            "crate" | "self" => {}
            "super" => {
                target.pop();
            }
            name => {
                target.push(name.to_owned());
                if !modules.contains_key(&target) {
                    target.pop();
                    return Some((target, Some(name.to_owned())));
                }
            }
        }
    }
    Some((target, None))
}

/// A circle of modules, from its first one round to that again.
fn find_circle(used: &BTreeMap<Module, BTreeSet<Module>>) -> Option<Vec<String>> {
    let mut done = BTreeSet::new();
    used.keys().find_map(|module| follow(used, module, &mut Vec::new(), &mut done))
}

fn follow<'a>(
    used: &'a BTreeMap<Module, BTreeSet<Module>>,
    module: &'a Module,
    path: &mut Vec<&'a Module>,
    done: &mut BTreeSet<&'a Module>,
) -> Option<Vec<String>> {
    if let Some(start) = path.iter().position(|earlier| *earlier == module) {
        let circle = path[start..].iter().copied().chain([module]);
        return Some(circle.map(|module| format!("{}.rs", module.join("/"))).collect());
    }
    if !done.insert(module) {
        return None;
    }
    path.push(module);
    let circle = used.get(module)?.iter().find_map(|next| follow(used, next, path, done));
    path.pop();
    circle
}
