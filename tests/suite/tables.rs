//! The tables of ARCHITECTURE.md and CONTRIBUTING.md against the files that they describe.

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

/// All source files of a folder and its folders.
fn sources(folder: PathBuf) -> Vec<PathBuf> {
    let (folders, files): (Vec<_>, Vec<_>) =
        read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).partition(|path| path.is_dir());
    files.into_iter().chain(folders.into_iter().flat_map(sources)).collect()
}

/// The rooms that each room imports outside of unit tests and comments.
fn imports() -> BTreeMap<String, BTreeSet<String>> {
    let mut imports = BTreeMap::<String, BTreeSet<String>>::new();
    for path in sources(root().join("src")) {
        let place = path.strip_prefix(root().join("src")).unwrap();
        let room = place.iter().next().unwrap().to_str().unwrap().trim_end_matches(".rs").to_owned();
        let code = read_to_string(&path).unwrap();
        let code = code.split("#[cfg(test)]\nmod ").next().unwrap();
        let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
        let names = lines.flat_map(|line| line.split("crate::").skip(1)).map(|rest| {
            rest.split(|c: char| !(c.is_ascii_lowercase() || c == '_')).next().unwrap().to_owned()
        });
        imports.entry(room).or_default().extend(names.filter(|name| !name.is_empty()));
    }
    imports.remove("lib");
    imports
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

/// Comments of the source end at column 110; tables and code of doc comments may be wider.
#[test]
fn comments_of_the_source_are_within_110_columns() {
    let mut wide = Vec::new();
    for path in sources(root().join("src")) {
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
