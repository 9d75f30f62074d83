//! The pages against the tree. Links and pictures: a forge follows the definitions at the end of a page, rustdoc those of
//! docs/links.md, which stand before each page in src/lib.rs.

use crate::common::source_files::source_files;
use gear_dynamics::branches::{Continuation, Family};
use gear_dynamics::trains::SpurPair;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{read_dir, read_to_string};
use std::path::{Path, PathBuf};

pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// All pages below the root that a reader may open, as paths from the root.
pub fn pages() -> Vec<PathBuf> {
    let folders = ["", "docs", "docs/course"];
    let entries = folders.into_iter().flat_map(|folder| read_dir(root().join(folder)).unwrap());
    let pages = entries.map(|entry| entry.unwrap().path().strip_prefix(root()).unwrap().to_owned());
    let pages: Vec<_> = pages
        .filter(|page| page.extension().is_some_and(|end| end == "md") && !page.ends_with("links.md"))
        .collect();
    assert!(pages.len() > 30);
    pages
}

/// The text of a page without code.
fn prose(page: &Path) -> String {
    let text = read_to_string(root().join(page)).unwrap();
    let blocks = text.split("\n```").step_by(2);
    blocks.collect::<Vec<_>>().join("\n")
}

/// The labels that a text defines, with their targets.
fn definitions(text: &str) -> BTreeMap<&str, &str> {
    let lines = text.lines().filter_map(|line| line.strip_prefix('[')?.split_once("]: "));
    lines.collect()
}

/// The labels to which the links of a text refer, whatever their case and line breaks.
fn labels(text: &str) -> BTreeSet<String> {
    let lines = text.lines().filter(|line| !(line.starts_with('[') && line.contains("]: ")));
    let text = lines.collect::<Vec<_>>().join("\n");
    let links = text.split('[').skip(1).filter_map(|rest| rest.split_once(']'));
    let links = links.filter(|(_, after)| !after.starts_with(['(', '[']));
    links.map(|(label, _)| label.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase()).collect()
}

/// The pages that src/lib.rs includes for rustdoc, as paths from the root.
fn pages_of_rustdoc() -> Vec<PathBuf> {
    let library = read_to_string(root().join("src/lib.rs")).unwrap();
    let files = library.lines().filter_map(|line| line.split_once("include_str!(\"../")?.1.split('"').next());
    let files: Vec<_> = files.filter(|file| file.ends_with(".md") && *file != "README.md").collect();
    let (links, pages): (Vec<_>, Vec<_>) =
        files.chunks(2).map(|pair| (pair[0], PathBuf::from(pair[1]))).unzip();
    assert!(
        links.iter().all(|file| *file == "docs/links.md"),
        "docs/links.md stands before each page: {files:?}"
    );
    pages
}

#[test]
fn links_and_pictures_of_pages_exist() {
    let mut dead = Vec::new();
    for page in pages() {
        let text = prose(&page);
        let inline = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        for target in inline.chain(definitions(&text).into_values()) {
            let file = target.split('#').next().unwrap();
            if !target.contains("://") && !root().join(&page).with_file_name(file).exists() {
                dead.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(dead.is_empty(), "{dead:#?}");
}

/// A registry shows README.md and the package holds CHANGELOG.md: their links do not lead out of the package.
#[test]
fn links_of_the_readme_and_the_changes_hold_in_the_package() {
    let manifest = read_to_string(root().join("Cargo.toml")).unwrap();
    let line = manifest.lines().find_map(|line| line.strip_prefix("exclude = [")).unwrap();
    let excluded: Vec<&str> = line.split('"').filter_map(|path| path.strip_prefix('/')).collect();
    assert!(excluded.contains(&"tests"), "{excluded:?}");
    for page in ["README.md", "CHANGELOG.md"] {
        let text = prose(Path::new(page));
        let links = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
        let links: Vec<&str> = links.filter(|link| !link.contains("://") && !link.is_empty()).collect();
        assert!(!links.is_empty(), "{page}");
        let leaves = |link: &&str| excluded.iter().any(|path| Path::new(link).starts_with(path));
        assert!(!links.iter().any(leaves), "{page}: {links:?}");
    }
}

#[test]
fn links_of_pages_lead_somewhere_in_rustdoc() {
    let rustdoc = read_to_string(root().join("docs/links.md")).unwrap();
    let known: BTreeSet<_> = definitions(&rustdoc).into_keys().collect();
    let mut wrong = Vec::new();
    for page in pages_of_rustdoc() {
        let text = prose(&page);
        let own: BTreeSet<_> = definitions(&text).into_keys().collect();
        let without = own.difference(&known).map(|label| format!("docs/links.md lacks [{label}]"));
        let lower: BTreeSet<_> = own.iter().map(|label| label.to_lowercase()).collect();
        let unknown = known.iter().filter(|label| !lower.contains(&label.to_lowercase()));
        let used = labels(&text);
        let undefined = unknown.filter(|label| used.contains(&label.to_lowercase()));
        let undefined = undefined.map(|label| format!("the page does not define [{label}]"));
        let unused = lower.difference(&used).map(|label| format!("nothing refers to [{label}]"));
        let inline = text.split("](").skip(1).filter(|rest| !rest.starts_with("https://"));
        let inline = inline.map(|rest| format!("a link to {:?}", rest.split(')').next()));
        let all = without.chain(undefined).chain(unused).chain(inline);
        wrong.extend(all.map(|what| format!("{}: {what}", page.display())));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn paths_of_rustdoc_stand_in_its_definitions_only() {
    let wrong: Vec<_> = pages().into_iter().filter(|page| prose(page).contains("(crate::")).collect();
    assert!(wrong.is_empty(), "links that a forge does not follow: {wrong:?}");
}

/// The sources of the library.
fn sources() -> Vec<String> {
    source_files(root().join("src")).into_iter().map(|path| read_to_string(path).unwrap()).collect()
}

/// The public enums whose names end in `Error`: name and variants, each variant with its attributes and fields.
fn errors() -> Vec<(String, Vec<String>)> {
    let mut errors = Vec::new();
    for source in sources() {
        for code in source.split("\npub enum ").skip(1) {
            let (name, rest) = code.split_once(" {\n").unwrap();
            let body = rest.split("\n}").next().unwrap();
            // A variant begins with its comment, at the depth of one level.
            let is_comment = |line: &str| line.starts_with("    ///");
            let mut variants = Vec::<String>::new();
            let mut before = false;
            for line in body.lines() {
                if is_comment(line) && !before {
                    variants.push(String::new());
                }
                before = is_comment(line);
                if !line.trim_start().starts_with("///") {
                    variants.last_mut().unwrap().push_str(&format!("{line}\n"));
                }
            }
            if name.ends_with("Error") {
                errors.push((name.to_owned(), variants));
            }
        }
    }
    assert!(errors.len() > 15 && errors.iter().all(|(_, variants)| !variants.is_empty()), "{errors:?}");
    errors
}

#[test]
fn every_public_error_stands_on_the_page_of_errors() {
    let page = read_to_string(root().join("docs/errors.md")).unwrap();
    let mut names: Vec<_> = errors().into_iter().map(|(name, _)| name).collect();
    names.extend(["Inconsistency".to_owned(), "Exhausted".to_owned()]);
    names.retain(|name| !page.contains(&format!("`{name}")));
    assert!(names.is_empty(), "docs/errors.md does not say what to do on {names:?}");
}

/// The table of CONTRIBUTING.md, "Conventions": one name for one meaning.
#[test]
fn variants_of_errors_have_the_names_of_the_table() {
    let other_names = [
        "Budget",
        "Cancelled",
        "Spent",
        "Limit",
        "Flow",
        "Integration",
        "Failed",
        "Undetermined",
        "Diverges",
        "Unconverged",
        "Setting",
        "Settings",
        "Invalid",
        "NoStart",
        "NaN",
    ];
    // What a variant wraps or contains, and the name that it must have.
    let wrapped = [
        ("IntegrateError", "Integrate"),
        ("#[from] ParameterError", "Parameter"),
        ("exhausted: ", "Exhausted"),
        ("Exhausted)", "Exhausted"),
    ];
    let (mut wrong, mut named) = (Vec::new(), BTreeMap::<&str, usize>::new());
    let errors = errors();
    for (error, variants) in &errors {
        for variant in variants {
            let mut lines = variant.lines().filter_map(|line| line.strip_prefix("    "));
            let name = lines.find(|line| line.starts_with(char::is_uppercase)).unwrap_or("");
            let name = name.split(['(', ' ', ',']).next().unwrap();
            if name.is_empty() || other_names.contains(&name) {
                wrong.push(format!("{error}::{name}"));
            }
            // The message names fields, too: only the fields count.
            let fields = variant.split_once(&format!("    {name}")).map_or("", |(_, fields)| fields);
            for (what, wanted) in wrapped {
                if fields.contains(what) {
                    *named.entry(wanted).or_default() += 1;
                    if name != wanted {
                        wrong.push(format!("{error}::{name} contains {what}: {wanted}"));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    // The fence sees the variants that it is for.
    assert!(named["Integrate"] >= 5 && named["Exhausted"] >= 6 && named["Parameter"] >= 15, "{named:?}");
}

/// What was computed before a failure is the field `last`, and `last()` returns it.
#[test]
fn errors_with_a_last_iterate_return_it() {
    let without: Vec<_> = sources()
        .into_iter()
        .filter(|source| source.contains("Error {\n") && source.contains("\n        last: "))
        .filter(|source| !source.contains("pub fn last(&self) -> Option<"))
        .collect();
    assert!(without.is_empty(), "{without:#?}");
}

/// The program of README.md prints what README.md says.
#[test]
fn the_readme_prints_what_it_says() -> Result<(), Box<dyn std::error::Error>> {
    let pair = SpurPair::of_numbers(0.05, 0.1, &[0.2], &[0.05])?.parts()?.build("driver", 1.0)?;
    let branch = Continuation::new(0.4, 1.4).run(&Family::over(&pair, ["speed"])?, None)?.to_string();
    let page = read_to_string(root().join("README.md"))?;
    assert!(page.contains(branch.trim_end()), "README.md does not show:\n{branch}");
    Ok(())
}

/// The template of a project holds the program of README.md and the profile of docs/start.md.
#[test]
fn the_template_is_that_of_the_pages() -> Result<(), Box<dyn std::error::Error>> {
    let block = |page: &str, language: &str, has: &str| -> Result<String, Box<dyn std::error::Error>> {
        let text = read_to_string(root().join(page))?;
        let fence = format!("```{language}\n");
        let mut blocks = text.split(&fence).skip(1).filter_map(|rest| rest.split("```").next());
        Ok(blocks.find(|block| block.contains(has)).ok_or("no such block")?.to_owned())
    };
    let program = read_to_string(root().join("examples/template/src/main.rs"))?;
    assert!(program.ends_with(&block("README.md", "rust", "fn main()")?), "{program}");
    let manifest = read_to_string(root().join("examples/template/Cargo.toml"))?;
    assert!(manifest.contains(&block("docs/start.md", "toml", "[profile.release]")?), "{manifest}");
    Ok(())
}

/// The words `Type::name` between backquotes, where the type is public in the library: a function, a variant, a field or a
/// constant of this name stands in a source that names the type.
#[test]
fn names_on_pages_exist_in_the_source() {
    let sources = sources();
    let is_word = |word: &str| !word.is_empty() && word.chars().all(|c| c.is_alphanumeric() || c == '_');
    let mut types = BTreeSet::new();
    for line in sources.iter().flat_map(|source| source.lines()) {
        let kinds = ["pub struct ", "pub enum ", "pub trait ", "pub type "];
        let rest = kinds.iter().find_map(|kind| line.strip_prefix(kind));
        types.extend(rest.and_then(|rest| rest.split(|c: char| !c.is_alphanumeric()).next()));
    }
    let exists = |of: &str, name: &str| {
        let declared = [
            format!("fn {name}("),
            format!("fn {name}<"),
            format!("    {name},\n"),
            format!("    {name} {{"),
            format!("    {name}("),
            format!("    pub {name}: "),
            format!("const {name}: "),
        ];
        sources.iter().any(|source| source.contains(of) && declared.iter().any(|text| source.contains(text)))
    };
    let (mut checked, mut unknown) = (0, Vec::new());
    let pages =
        pages().into_iter().filter(|page| !page.ends_with("history.md") && !page.ends_with("CHANGELOG.md"));
    for page in pages {
        let text = prose(&page);
        for quoted in text.split('`').skip(1).step_by(2) {
            let code = quoted.split('(').next().unwrap();
            let mut words = code.rsplit("::");
            let (Some(name), Some(of)) = (words.next(), words.next()) else { continue };
            if !is_word(name) || !is_word(of) || !of.starts_with(char::is_uppercase) || !types.contains(of) {
                continue;
            }
            checked += 1;
            if !exists(of, name) {
                unknown.push(format!("{}: {of}::{name}", page.display()));
            }
        }
    }
    assert!(unknown.is_empty(), "{unknown:#?}");
    assert!(checked > 100, "{checked}");
}

/// Words between backquotes that name nothing in the library: other programs, their functions, folders of this
/// repository, prefixes of names.
const FOREIGN: [&str; 37] = [
    "AVERAGE",
    "CORREL",
    "COUNTIF",
    "ElastoBacklash",
    "LSODA",
    "MultiRotor",
    "PERCENTILE",
    "RAND",
    "Radau",
    "STDEV",
    "_callback",
    "backlash",
    "benches",
    "deval",
    "examples",
    "float_roundtrip",
    "fuzz",
    "gear_dynamics",
    "located_edges",
    "multiprocessing",
    "ode15s",
    "ode45",
    "ode78",
    "ode_solvers",
    "odeset",
    "of_",
    "parfor",
    "peers",
    "plots",
    "savetxt",
    "scipy",
    "serde_json",
    "series_lanes",
    "solve_ivp",
    "unsafe",
    "with_",
    "writematrix",
];

/// The single words between backquotes occur in the code of the library or of the plots, whose comments do not count.
#[test]
fn single_names_on_pages_exist_in_the_code() {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let files = ["src", "plots/src"].into_iter().flat_map(|folder| source_files(root().join(folder)));
    let mut words = BTreeSet::new();
    for file in files {
        let text = read_to_string(file).unwrap();
        let code = text.lines().map(|line| line.split("//").next().unwrap());
        words.extend(code.flat_map(|line| line.split(|c| !is_part(c))).map(str::to_owned));
    }
    let (mut checked, mut unknown) = (0, Vec::new());
    for page in
        pages().into_iter().filter(|page| !page.ends_with("history.md") && !page.ends_with("CHANGELOG.md"))
    {
        for quoted in prose(&page).split('`').skip(1).step_by(2) {
            let name = quoted.split('(').next().unwrap();
            if name.is_empty() || !name.chars().all(is_part) || FOREIGN.contains(&name) {
                continue;
            }
            checked += 1;
            // A number is not a name.
            if !words.contains(name) && !name.starts_with(char::is_numeric) {
                unknown.push(format!("{}: {name}", page.display()));
            }
        }
    }
    assert!(unknown.is_empty(), "{unknown:#?}");
    assert!(checked > 500, "{checked}");
}

/// Each chapter of the course has one program, shorter than 40 lines, whose lines fit a screen.
#[test]
fn programs_of_the_course_are_short() {
    let chapters: Vec<_> = pages().into_iter().filter(|page| page.starts_with("docs/course")).collect();
    assert_eq!(chapters.len(), 10);
    for chapter in chapters {
        let text = read_to_string(root().join(&chapter)).unwrap();
        let programs: Vec<_> = text.split("\n```rust\n").skip(1).collect();
        let [program] = programs[..] else { panic!("{}: {} programs", chapter.display(), programs.len()) };
        let program = program.split("\n```").next().unwrap();
        let (lines, width) =
            (program.lines().count(), program.lines().map(|line| line.chars().count()).max());
        assert!(lines < 40 && width <= Some(120), "{}: {lines} lines, width {width:?}", chapter.display());
        assert!(program.contains("fn main()") && program.contains("assert"), "{}", chapter.display());
    }
}
