//! The tables of ARCHITECTURE.md and CONTRIBUTING.md against the files that they describe.

use crate::common::source_files::source_files;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{read_dir, read_to_string};
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn text(file: &str) -> String {
    read_to_string(root().join(file)).unwrap()
}

/// The names of the files of a folder that have one of the endings, without the ending if `bare`.
fn files(folder: &str, ending: &str) -> BTreeSet<String> {
    let names = read_dir(root().join(folder)).unwrap();
    let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter_map(|name| name.strip_suffix(ending).map(str::to_owned)).collect()
}

/// The words between backquotes.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// The rows of the table of a text that begins after the line `head`, each as its cells.
fn table<'t>(text: &'t str, head: &str) -> Vec<Vec<&'t str>> {
    let lines = text.split_once(head).unwrap_or_else(|| panic!("no table {head}")).1.lines().skip(2);
    let rows = lines.take_while(|line| line.starts_with('|'));
    rows.map(|row| row.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

/// What a table lacks and what it has too many.
fn differences(what: &str, table: &BTreeSet<String>, tree: &BTreeSet<String>) -> Option<String> {
    let missing: Vec<_> = tree.difference(table).collect();
    let surplus: Vec<_> = table.difference(tree).collect();
    (table != tree).then(|| format!("{what}: missing {missing:?}, too many {surplus:?}"))
}

fn assert_same(what: &str, table: &BTreeSet<String>, tree: &BTreeSet<String>) {
    assert_eq!(differences(what, table, tree), None);
}

/// The source files outside of unit tests and comments, each by its module path.
fn modules() -> BTreeMap<String, String> {
    let src = root().join("src");
    let code_of = |path: PathBuf| {
        let place = path.strip_prefix(&src).unwrap().with_extension("");
        let names: Vec<_> = place.iter().map(|name| name.to_str().unwrap()).filter(|n| *n != "mod").collect();
        let code = read_to_string(&path).unwrap();
        let code = code.split("#[cfg(test)]\nmod ").next().unwrap();
        let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
        (names.join("::"), lines.collect::<Vec<_>>().join("\n"))
    };
    source_files(src.clone()).into_iter().map(code_of).collect()
}

/// The paths after `crate::` that code names; a list in braces counts as its members.
fn paths(code: &str) -> BTreeSet<String> {
    let mut paths = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(rest.len());
        let (stem, rest) = rest.split_at(end);
        match rest.strip_prefix('{').and_then(|list| list.split_once('}')) {
            Some((list, _)) => paths.extend(list.split(',').map(|name| format!("{stem}{}", name.trim()))),
            None => _ = paths.insert(stem.to_owned()),
        }
    }
    paths
}

/// The longest part of a path that is a file.
fn file_of<'m>(modules: &'m BTreeMap<String, String>, path: &str) -> Option<&'m String> {
    let ends = path.match_indices("::").map(|(end, _)| end).chain([path.len()]);
    ends.filter_map(|end| modules.get_key_value(&path[..end])).last().map(|(name, _)| name)
}

/// The rooms that each room imports.
fn imports() -> BTreeMap<String, BTreeSet<String>> {
    let mut imports = BTreeMap::<String, BTreeSet<String>>::new();
    for (module, code) in modules().iter().filter(|(module, _)| *module != "lib") {
        let room = |path: &str| path.split("::").next().unwrap().to_owned();
        let rooms = paths(code).into_iter().map(|path| room(&path));
        let rooms = rooms.filter(|name| name.starts_with(|c: char| c.is_ascii_lowercase()));
        imports.entry(room(module)).or_default().extend(rooms);
    }
    imports
}

/// The files outside of the faces of folders, each with the files that it imports.
fn imported_files() -> BTreeMap<String, BTreeSet<String>> {
    let modules = modules();
    let mut exported = BTreeMap::new();
    // A name on the face of a folder stands for the file that defines it.
    for (face, code) in modules.iter().filter(|(name, code)| *name != "lib" && code.contains("pub use ")) {
        for path in paths(code) {
            let name = path.rsplit("::").next().unwrap();
            exported.insert(format!("{face}::{name}"), path.clone());
        }
    }
    let files = modules.iter().filter(|(name, code)| *name != "lib" && !code.contains("pub(crate) mod "));
    let imports = |(name, code): (&String, &String)| {
        let paths = paths(code).into_iter().map(|path| exported.get(&path).cloned().unwrap_or(path));
        let files = paths.filter_map(|path| file_of(&modules, &path).cloned());
        (name.clone(), files.filter(|file| file != name).collect())
    };
    files.map(imports).collect()
}

/// What lies on circles, and between circles, of a relation.
fn circles(mut above: BTreeMap<String, BTreeSet<String>>) -> BTreeMap<String, BTreeSet<String>> {
    // What imports none of the others is taken away, then what imports none of the rest: circles remain.
    loop {
        let left: BTreeSet<String> = above.keys().cloned().collect();
        above.retain(|_, imported| !imported.is_disjoint(&left));
        if above.len() == left.len() {
            break;
        }
    }
    // What none of the others imports stands below a circle.
    loop {
        let imported: BTreeSet<String> = above.values().flatten().cloned().collect();
        let before = above.len();
        above.retain(|name, _| imported.contains(name));
        if above.len() == before {
            return above;
        }
    }
}

#[test]
fn files_do_not_import_one_another_in_a_circle() {
    let circles = circles(imported_files());
    assert!(circles.is_empty(), "circles of files: {circles:#?}");
}

/// An import between two files is one between the two neighbours, files or folders of one folder, in which
/// they lie.
#[test]
fn neighbours_of_a_folder_do_not_import_one_another_in_a_circle() {
    let mut folders = BTreeMap::<String, BTreeMap<String, BTreeSet<String>>>::new();
    for (file, imported) in imported_files() {
        for other in imported {
            let (own, its): (Vec<_>, Vec<_>) = (file.split("::").collect(), other.split("::").collect());
            let shared = own.iter().zip(&its).take_while(|(a, b)| a == b).count();
            // Rooms are compared with the table of ARCHITECTURE.md.
            if let (1.., Some(one), Some(other)) = (shared, own.get(shared), its.get(shared)) {
                let folder = folders.entry(own[..shared].join("::")).or_default();
                folder.entry((*one).to_owned()).or_default().insert((*other).to_owned());
            }
        }
    }
    let found: BTreeMap<_, _> = folders
        .into_iter()
        .map(|(folder, above)| (folder, circles(above)))
        .filter(|(_, c)| !c.is_empty())
        .collect();
    assert!(found.is_empty(), "circles in folders: {found:#?}");
}

#[test]
fn no_folder_has_more_than_ten_files_besides_its_face() {
    let mut folders = BTreeMap::<PathBuf, usize>::new();
    for path in source_files(root().join("src")).iter().filter(|path| !path.ends_with("mod.rs")) {
        *folders.entry(path.parent().unwrap().to_owned()).or_default() += 1;
    }
    folders.remove(&root().join("src"));
    folders.retain(|_, files| *files > 10);
    assert!(folders.is_empty(), "{folders:#?}");
}

#[test]
fn rooms_import_what_the_table_says_and_only_rooms_above_them() {
    let text = text("ARCHITECTURE.md");
    let rows = table(&text, "| room | content | uses, besides `error` |");
    let (mut above, mut listed, mut wrong) = (BTreeSet::new(), BTreeSet::new(), Vec::new());
    let imports = imports();
    for row in rows {
        let rooms: BTreeSet<String> = quoted(row[0])
            .map(|name| name.trim_end_matches('/').trim_end_matches(".rs").to_owned())
            .collect();
        let rooms: BTreeSet<String> = rooms.into_iter().filter(|room| room != "serde").collect();
        let uses: BTreeSet<String> =
            row[2].split(", ").filter(|name| !name.is_empty()).map(str::to_owned).collect();
        let mut found: BTreeSet<String> = rooms.iter().flat_map(|room| imports[room].clone()).collect();
        found.retain(|name| name != "error" && !rooms.contains(name));
        wrong.extend(differences(&format!("imports of {}", row[0]), &uses, &found));
        if !uses.is_subset(&above) {
            wrong.push(format!("{} uses {uses:?}, not all above it", row[0]));
        }
        above.extend(rooms.iter().cloned());
        listed.extend(rooms);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_same("rooms", &listed, &imports.into_keys().collect());
}

/// Lines of code, public types and public functions of each room.
fn amounts() -> BTreeMap<String, [usize; 3]> {
    let mut amounts = BTreeMap::<String, [usize; 3]>::new();
    for (module, code) in modules() {
        let room = amounts.entry(module.split("::").next().unwrap().to_owned()).or_default();
        for line in code.lines().map(str::trim).filter(|line| !line.is_empty()) {
            room[0] += 1;
            let mut words = line.split(' ').skip_while(|word| *word == "const");
            if words.next() != Some("pub") {
                continue;
            }
            match words.find(|word| *word != "const") {
                Some("struct" | "enum" | "trait" | "type") => room[1] += 1,
                Some("fn") => room[2] += 1,
                _ => {}
            }
        }
    }
    amounts
}

/// A room holds no more than ARCHITECTURE.md allows, and not far less.
#[test]
fn rooms_hold_what_the_table_says() {
    let text = text("ARCHITECTURE.md");
    let (mut amounts, mut wrong) = (amounts(), Vec::new());
    for row in table(&text, "| room | code | types | functions |") {
        let room = quoted(row[0]).next().unwrap().trim_end_matches('/').trim_end_matches(".rs");
        let Some(held) = amounts.remove(room) else {
            wrong.push(format!("no room {room}"));
            continue;
        };
        for ((most, held), what) in row[1..].iter().zip(held).zip(["lines of code", "types", "functions"]) {
            let most: usize = most.parse().unwrap();
            if held > most || 20 * (most - held) > most.max(20) {
                wrong.push(format!("{room} holds {held} {what}; the table says {most}"));
            }
        }
    }
    wrong.extend(amounts.keys().map(|room| format!("the table lacks {room}")));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The public functions with type parameters, without those of lifetimes alone.
fn generic_functions() -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for code in modules().values() {
        for line in code.lines().map(str::trim) {
            let Some(name) = line.strip_prefix("pub fn ").or_else(|| line.strip_prefix("pub const fn "))
            else {
                continue;
            };
            let Some((name, rest)) = name.split_once('<').filter(|(name, _)| !name.contains('(')) else {
                continue;
            };
            let is_type = |parameter: &str| !parameter.trim().starts_with('\'');
            if rest.split_once('>').is_some_and(|(list, _)| list.split(',').any(is_type)) {
                found.insert(name.to_owned());
            }
        }
    }
    found
}

/// ARCHITECTURE.md says what each public function with type parameters compiles in the program of a user.
#[test]
fn generic_functions_are_listed() {
    let text = text("ARCHITECTURE.md");
    let rows = table(&text, "| functions | what a program compiles |");
    let named = rows.iter().flat_map(|row| quoted(row[0])).map(|name| name.rsplit("::").next().unwrap());
    let named: BTreeSet<String> = named.map(str::to_owned).collect();
    let missing: Vec<String> = generic_functions().difference(&named).cloned().collect();
    assert!(missing.is_empty(), "ARCHITECTURE.md does not list {missing:?}");
}

/// The files that a recipe of CONTRIBUTING.md names exist.
#[test]
fn recipes_name_files_that_exist() {
    let text = text("CONTRIBUTING.md");
    let rows = table(&text, "| to add | files | tests | page |");
    assert!(rows.len() >= 7);
    let named = rows.iter().flat_map(|row| row[1..].iter()).flat_map(|cell| quoted(cell));
    let named = named.filter(|name| name.contains('/'));
    let missing: Vec<&str> = named.filter(|path| !root().join(path).exists()).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn every_dependency_has_its_reason() {
    let (manifest, text) = (text("Cargo.toml"), text("ARCHITECTURE.md"));
    let reasons = text.split_once("\n## Dependencies\n").unwrap().1;
    let words: BTreeSet<&str> =
        reasons.split(|c: char| !(c.is_alphanumeric() || c == '-' || c == '_')).collect();
    let dependencies = manifest.split_once("\n[dependencies]\n").unwrap().1.split_once("\n\n").unwrap().0;
    for line in dependencies.lines() {
        let name = line.split(' ').next().unwrap();
        assert!(words.contains(name), "ARCHITECTURE.md does not say what {name} is for");
    }
}

#[test]
fn every_test_and_bench_guards_a_promise() {
    let text = text("ARCHITECTURE.md");
    let rows = table(&text, "| promise | test | bench |");
    let named = |column: usize| rows.iter().flat_map(move |row| quoted(row[column]));
    let tests = named(1).filter_map(|name| name.strip_suffix(".rs"));
    let tests = tests.filter(|name| !name.contains('/')).map(str::to_owned).collect();
    let mut files = self::files("tests/suite", ".rs");
    ["main", "data", "tables"].iter().for_each(|name| assert!(files.remove(*name)));
    assert_same("tests of ARCHITECTURE.md", &tests, &files);
    let mut benches: BTreeSet<String> = named(2).map(str::to_owned).collect();
    benches.remove("peers");
    assert_same("benches of ARCHITECTURE.md", &benches, &self::files("benches", ".rs"));
}

#[test]
fn contributing_lists_all_reference_data_and_benches() {
    let text = text("CONTRIBUTING.md");
    let rows = table(&text, "| file | content |");
    let mut data: BTreeSet<String> = rows.iter().flat_map(|row| quoted(row[0])).map(str::to_owned).collect();
    let mut files = files("tests/data", "");
    files.remove("README.md");
    assert_same("reference data of CONTRIBUTING.md", &data, &files);
    let origins = self::text("tests/data/README.md");
    data.retain(|file| !origins.contains(&format!("`{file}`")));
    assert!(data.is_empty(), "tests/data/README.md does not state the origin of {data:?}");
    let rows = table(&text, "| command | what it measures |");
    let benches = rows.iter().filter_map(|row| row[0].split_once("--bench ")).map(|(_, name)| name);
    let benches = benches.map(|name| name.trim_end_matches('`').to_owned()).collect();
    assert_same("benches of CONTRIBUTING.md", &benches, &self::files("benches", ".rs"));
}

/// A file of the source has at most 400 lines.
#[test]
fn files_of_the_source_have_at_most_400_lines() {
    let lines = |path: &PathBuf| read_to_string(path).unwrap().lines().count();
    let long: Vec<PathBuf> =
        source_files(root().join("src")).into_iter().filter(|path| lines(path) > 400).collect();
    assert!(long.is_empty(), "{long:#?}");
}

/// Comments of the source end at column 110; tables and code of doc comments may be wider.
#[test]
fn comments_of_the_source_are_within_110_columns() {
    let mut wide = Vec::new();
    for path in source_files(root().join("src")) {
        let mut in_code = false;
        for (i, line) in read_to_string(&path).unwrap().lines().enumerate() {
            let Some(comment) = line.trim_start().strip_prefix("//") else {
                in_code = false;
                continue;
            };
            let comment = comment.trim_start_matches(['/', '!']).trim_start();
            in_code ^= comment.starts_with("```");
            if !in_code && !comment.starts_with('|') && line.chars().count() > 110 {
                wide.push(format!("{}:{}", path.display(), i + 1));
            }
        }
    }
    assert!(wide.is_empty(), "{wide:#?}");
}
