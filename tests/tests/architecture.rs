//! The arrows between the modules of `core` and between the packages, held against the tables of
//! `ARCHITECTURE.md`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use meshcolor_tests::repository::{backticked, file, root, table};

type Arrows = BTreeMap<String, BTreeSet<String>>;

/// A table's rows in order: the first cell's name, and the names in the last cell.
fn declared(first_heading: &str) -> (Vec<String>, Arrows) {
    let rows = table(&file("ARCHITECTURE.md"), first_heading);
    assert!(!rows.is_empty(), "ARCHITECTURE.md has no table that begins with \"{first_heading}\"");
    let row = |row: &Vec<String>| {
        let name = backticked(&row[0]).remove(0);
        (name, backticked(row.last().unwrap()).into_iter().collect())
    };
    let names = rows.iter().map(|cells| row(cells).0).collect();
    (names, rows.iter().map(row).collect())
}

fn compare(found: &Arrows, declared: &Arrows) -> Vec<String> {
    let mut wrong = Vec::new();
    let none = BTreeSet::new();
    for (from, targets) in found {
        for to in targets.difference(declared.get(from).unwrap_or(&none)) {
            wrong.push(format!("{from} uses {to}, which ARCHITECTURE.md does not allow"));
        }
    }
    for (from, targets) in declared {
        for to in targets.difference(found.get(from).unwrap_or(&none)) {
            wrong.push(format!("ARCHITECTURE.md says that {from} uses {to}, which it does not"));
        }
    }
    wrong
}

#[test]
fn modules_of_core_use_what_the_table_says() {
    let (modules, declared) = declared("module");
    let mut found: Arrows = modules.iter().map(|module| (module.clone(), BTreeSet::new())).collect();
    for source in Source::all(&root().join("core/src")) {
        // `lib.rs` is the list of modules itself.
        let Some(module) = source.path.first().cloned() else { continue };
        let targets = found.entry(module.clone()).or_default();
        targets.extend(source.modules_used().into_iter().filter(|target| *target != module));
    }
    let wrong = compare(&found, &declared);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_table_stands_in_the_order_of_the_journey() {
    let (modules, declared) = declared("module");
    let listed: Vec<String> = (file("core/src/lib.rs").lines())
        .filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';').map(str::to_owned))
        .collect();
    assert_eq!(modules, listed, "the table and core/src/lib.rs list the modules in another order");
    for (place, module) in modules.iter().enumerate() {
        let later = declared[module].iter().find(|target| !modules[..place].contains(target));
        assert_eq!(later, None, "{module} uses a module that does not stand above it");
    }
}

#[test]
fn packages_point_one_way() {
    let (packages, declared) = declared("package");
    let folders = ["core", "shaders", "service", "tests"];
    let mut found = Arrows::new();
    for folder in folders {
        let manifest = file(&format!("{folder}/Cargo.toml"));
        let name = manifest.lines().find_map(|line| line.strip_prefix("name = ")).unwrap();
        // Every kind of dependency counts: a test that looks back is an arrow back.
        let names = manifest.lines().filter_map(|line| line.split(['.', ' ', '=']).next());
        let ours = names.filter(|name| packages.iter().any(|package| package == name));
        found.insert(name.trim_matches('"').to_owned(), ours.map(str::to_owned).collect());
    }
    let wrong = compare(&found, &declared);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn core_touches_nothing_outside_itself() {
    let outside = ["env::", "net::", "fs::", "process::", "time::", "thread::"];
    for source in Source::all(&root().join("core/src")) {
        for word in outside {
            let path = format!("std::{word}");
            assert!(!source.code.contains(&path), "{} uses {path}", source.file.display());
        }
        let prints = ["println!", "print!", "dbg!"].into_iter().find(|word| source.code.contains(word));
        assert_eq!(prints, None, "{}", source.file.display());
    }
}

#[test]
fn one_file_of_the_service_knows_the_shaders() {
    let users = Source::all(&root().join("service/src"))
        .into_iter()
        .filter(|source| source.code.contains("meshcolor_shaders"))
        .map(|source| source.path.join("/"));
    assert_eq!(users.collect::<Vec<_>>(), ["sheet"]);
}

/// A source file without its tests and comments.
struct Source {
    file: PathBuf,
    /// The module's path from the crate's root, which itself is empty.
    path: Vec<String>,
    code: String,
}

impl Source {
    /// All files below a folder that are not tests.
    fn all(folder: &Path) -> Vec<Self> {
        let mut sources = Vec::new();
        let mut tests = BTreeSet::new();
        let mut folders = vec![folder.to_owned()];
        while let Some(next) = folders.pop() {
            let mut entries: Vec<PathBuf> = fs::read_dir(&next).unwrap().map(|e| e.unwrap().path()).collect();
            entries.sort();
            for entry in entries {
                if entry.is_dir() {
                    folders.push(entry);
                } else if entry.extension().is_some_and(|ending| ending == "rs") {
                    let source = Self::read(folder, &entry);
                    tests.extend(source.test_modules());
                    sources.push(source);
                }
            }
        }
        assert!(sources.len() > 1, "{} holds no sources", folder.display());
        sources.retain(|source| !(1..=source.path.len()).any(|end| tests.contains(&source.path[..end])));
        for source in &mut sources {
            let end = source.code.find("#[cfg(test)]\nmod tests {").unwrap_or(source.code.len());
            source.code.truncate(end);
        }
        sources
    }

    fn read(folder: &Path, file: &Path) -> Self {
        let inside = file.strip_prefix(folder).unwrap().with_extension("");
        let mut path: Vec<String> =
            inside.components().map(|part| part.as_os_str().to_str().unwrap().to_owned()).collect();
        if path.last().is_some_and(|name| ["mod", "lib", "main"].contains(&name.as_str())) {
            path.pop();
        }
        let text = fs::read_to_string(file).unwrap();
        let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
        Self { file: file.to_owned(), path, code: lines.collect::<Vec<_>>().join("\n") }
    }

    /// Modules that this file declares for tests alone.
    fn test_modules(&self) -> Vec<Vec<String>> {
        let after = self.code.split("#[cfg(test)]").skip(1);
        let declared = after.filter_map(|rest| {
            let name = rest.trim_start().trim_start_matches("pub ").strip_prefix("mod ")?.split_once(';')?.0;
            name.chars().all(is_word).then(|| name.to_owned())
        });
        declared.map(|name| [&self.path[..], &[name]].concat()).collect()
    }

    /// The modules of the crate's root that the file names, by `crate::` or by enough `super::`.
    fn modules_used(&self) -> BTreeSet<String> {
        let mut used = BTreeSet::new();
        for (at, _) in self.code.match_indices("crate::") {
            if !self.code[..at].ends_with(|c| is_word(c) || c == '$') {
                names_at(&self.code[at + "crate::".len()..], &mut used);
            }
        }
        let climb = "super::".repeat(self.path.len());
        for (at, _) in self.code.match_indices(&climb) {
            if !self.code[..at].ends_with("super::") {
                names_at(&self.code[at + climb.len()..], &mut used);
            }
        }
        used.into_iter().map(|name| of_root(&name)).collect()
    }
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The first name of a path, or all first names of a braced list.
fn names_at(rest: &str, names: &mut BTreeSet<String>) {
    let word = |text: &str| text.chars().take_while(|c| is_word(*c)).collect::<String>();
    let Some(list) = rest.strip_prefix('{') else {
        names.insert(word(rest));
        return;
    };
    let mut depth = 0;
    let mut starts = true;
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => starts = true,
            c if starts && is_word(c) => {
                names.insert(word(&list[at..]));
                starts = false;
            }
            _ => {}
        }
    }
}

/// What the root hands on (`crate::Error`) belongs to the module that defines it.
fn of_root(name: &str) -> String {
    match name {
        "Error" | "ErrorCode" | "Result" => "error".to_owned(),
        name => name.to_owned(),
    }
}

#[test]
fn paths_are_found_in_every_form() {
    let source = Source {
        file: PathBuf::new(),
        path: vec!["read".into(), "gltf".into()],
        code: "use crate::math::x;\nuse crate::{image::{a, b}, mesh};\nlet c = crate::Error::x();\n\
               use super::super::colors::y;\nuse super::own::z;\nuse mycrate::asset;"
            .to_owned(),
    };
    let used: Vec<String> = source.modules_used().into_iter().collect();
    assert_eq!(used, ["colors", "error", "image", "math", "mesh"]);
}
