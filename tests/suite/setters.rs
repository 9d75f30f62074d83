//! The rules of CONTRIBUTING.md for names, read from the source: a setter is the noun of its field, and
//! takes `with_` where that noun is the getter; a type has a name of its own in its room.

use crate::common::source_files::source_files;
use std::collections::BTreeMap;
use std::fs::read_to_string;
use std::path::{Path, PathBuf};

/// The public methods of the types of a file: type, name, and signature with body.
fn methods(code: &str) -> Vec<(&str, &str, &str)> {
    let mut all = Vec::new();
    for block in code.split("\nimpl").skip(1) {
        let block = block.split("\n}").next().unwrap();
        let head = block.split(" {\n").next().unwrap();
        let named = head.rsplit(" for ").next().unwrap().trim_start_matches(|c: char| !c.is_uppercase());
        // impl<G: Shape> Type<G>: the type follows the bounds.
        let named =
            head.strip_prefix('<').map_or(named, |rest| rest.split_once("> ").map_or(named, |it| it.1));
        let of = named.split(|c: char| !c.is_alphanumeric()).next().unwrap();
        for method in block.split("    pub fn ").skip(1) {
            let body = method.split("\n    }").next().unwrap();
            all.push((of, body.split(['(', '<']).next().unwrap(), body));
        }
    }
    all
}

#[test]
fn setters_and_getters_have_one_noun() {
    let (mut getters, mut setters) = (BTreeMap::new(), Vec::new());
    for path in source_files(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../src")) {
        let code = read_to_string(path).unwrap();
        for (of, name, body) in methods(&code) {
            // with_ sets: what makes a value of others is of_.
            let sets = !name.starts_with("with_")
                || ["(self", "(&self", "(mut self"].iter().any(|it| body.contains(it));
            assert!(sets && !name.starts_with("from_"), "{of}::{name} is neither a setter nor of_ something");
            // fn getter(&self) -> T { self.field }
            let returned = body.split_once("{\n        self.").map(|(_, rest)| rest.trim());
            let field = returned.filter(|rest| rest.chars().all(|c| c.is_alphanumeric() || c == '_'));
            if let Some(field) = field.filter(|_| body.contains("(&self)")) {
                getters.insert((of.to_owned(), field.to_owned()), name.to_owned());
            }
            // fn setter(self, ..) -> Self { Type { field: .., ..self } } of one field
            let built = body.split_once(&format!("{of} {{")).filter(|_| body.contains("(self, "));
            let Some((fields, _)) = built.and_then(|(_, rest)| rest.split_once("..self")) else { continue };
            let field = fields.trim().split([':', ',']).next().unwrap();
            // A preposition says nothing of what is set.
            let first = name.split('_').next().unwrap();
            assert!(!["at", "on"].contains(&first), "the setter {of}::{name} is no noun of {field}");
            // What is computed from the old value is not set: Wave::per_turn multiplies the order.
            if !body.contains(&format!("self.{field}")) {
                setters.push((of.to_owned(), field.to_owned(), name.to_owned()));
            }
        }
    }
    assert!(setters.len() > 40, "only {} setters are recognised", setters.len());
    let mut pairs = 0;
    for (of, field, setter) in setters {
        let Some(getter) = getters.get(&(of.clone(), field)) else { continue };
        assert_eq!(setter, format!("with_{getter}"), "the setter of {of}::{getter}");
        pairs += 1;
    }
    assert!(pairs >= 7, "only {pairs} pairs are recognised"); // InvoluteGear alone has seven
}

/// The type that a line of code outside all blocks defines.
fn type_of(line: &str) -> Option<&str> {
    let line =
        ["pub ", "pub(crate) ", "pub(super) "].iter().find_map(|it| line.strip_prefix(it)).unwrap_or(line);
    let kinds = ["struct ", "enum ", "trait ", "type ", "union "];
    kinds.iter().find_map(|kind| line.strip_prefix(kind))?.split(|c: char| !c.is_alphanumeric()).next()
}

#[test]
fn types_of_a_room_have_names_of_their_own() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../src");
    let mut types: BTreeMap<_, Vec<PathBuf>> = BTreeMap::new();
    for path in source_files(src.clone()) {
        let file = path.strip_prefix(&src).unwrap();
        let room = file.iter().next().unwrap().to_owned();
        for name in read_to_string(&path).unwrap().lines().filter_map(type_of) {
            types.entry((room.clone(), name.to_owned())).or_default().push(file.to_owned());
        }
    }
    assert!(types.len() > 700, "only {} types are recognised", types.len());
    let twice: Vec<_> = types.iter().filter(|(_, files)| files.len() > 1).collect();
    assert!(twice.is_empty(), "{twice:#?}");
}
