//! The programs of the pages print what the pages say. Each program is compiled with the library of this test.

use crate::pages::{pages, root};
use std::fs::{create_dir_all, read_to_string, write};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A page, its program, and the lines that it says the program prints.
type Program = (String, String, Vec<String>);

/// The programs of a page that are followed by "It prints" and a block of text. Lines of a page may begin with "# ": rustdoc
/// does not show them.
fn programs(page: &str, text: &str) -> Vec<Program> {
    let (mut found, mut last) = (Vec::new(), String::new());
    for (before, block) in
        text.split("\n```").collect::<Vec<_>>().chunks(2).filter_map(|pair| Some((pair[0], *pair.get(1)?)))
    {
        let (kind, code) = block.split_once('\n').unwrap_or((block, ""));
        if kind.starts_with("rust") {
            last = code
                .lines()
                .map(|line| line.strip_prefix("# ").unwrap_or(line))
                .collect::<Vec<_>>()
                .join("\n");
        } else if before.trim_end().lines().last().is_some_and(|line| line.starts_with("It prints")) {
            found.push((page.to_owned(), last.clone(), code.lines().map(str::to_owned).collect()));
        }
    }
    found
}

/// A line without times of the clock, which vary.
fn timeless(line: &str) -> String {
    let is_time = |word: &str| {
        let number = word.trim_end_matches(['n', 'µ', 'm', 's']);
        number.len() < word.len() && word.ends_with('s') && number.parse::<f64>().is_ok()
    };
    line.split(' ').map(|word| if is_time(word) { "(time)" } else { word }).collect::<Vec<_>>().join(" ")
}

/// The library of the crate that was built last.
fn library(folder: &Path) -> PathBuf {
    let files = folder.read_dir().unwrap().map(|entry| entry.unwrap().path());
    let is_it = |file: &PathBuf| {
        let file = file.file_name().unwrap().to_string_lossy().into_owned();
        file.starts_with("libgear_dynamics-") && file.ends_with(".rlib")
    };
    files.filter(is_it).max_by_key(|file| file.metadata().unwrap().modified().unwrap()).unwrap()
}

/// What the program prints.
fn printed(code: &str, name: &str) -> Result<Vec<String>, String> {
    let libraries = std::env::current_exe().unwrap().parent().unwrap().to_path_buf();
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("printed");
    create_dir_all(&folder).unwrap();
    let (source, program) = (folder.join(format!("{name}.rs")), folder.join(name));
    write(&source, code).unwrap();
    let mut compile = Command::new(std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned()));
    compile.args(["--edition", "2024", "-C", "opt-level=3", "-o"]).arg(&program).arg(&source);
    compile.arg("-L").arg(format!("dependency={}", libraries.display()));
    compile.arg("--extern").arg(format!("gear_dynamics={}", library(&libraries).display()));
    let compiled = compile.output().unwrap();
    if !compiled.status.success() {
        return Err(String::from_utf8_lossy(&compiled.stderr).into_owned());
    }
    let run = Command::new(&program).output().unwrap();
    if !run.status.success() {
        return Err(String::from_utf8_lossy(&run.stderr).into_owned());
    }
    Ok(String::from_utf8_lossy(&run.stdout).lines().map(timeless).collect())
}

#[test]
#[ignore = "compiles fifteen programs: cargo test --release --test suite printed_by_pages -- --ignored"]
fn programs_print_what_pages_say() {
    let of_page =
        |page: PathBuf| programs(&page.display().to_string(), &read_to_string(root().join(&page)).unwrap());
    let programs: Vec<Program> = pages().into_iter().flat_map(of_page).collect();
    assert!(programs.len() >= 14, "{} programs", programs.len());
    let mut wrong = Vec::new();
    for (i, (page, code, expected)) in programs.iter().enumerate() {
        let expected: Vec<String> = expected.iter().map(|line| timeless(line)).collect();
        match printed(code, &format!("program_{i}")) {
            Ok(lines) if lines == expected => {}
            Ok(lines) => {
                wrong.push(format!("{page}: prints\n{}\nnot\n{}", lines.join("\n"), expected.join("\n")))
            }
            Err(error) => wrong.push(format!("{page}: {error}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}
