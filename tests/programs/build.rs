//! Writes the programs of the pages as files of Rust, without the lines of doc tests.

use std::path::Path;
use std::{env, error::Error, fs};

/// Name of the program, page, and number of its block of Rust on the page, from 0.
const PROGRAMS: [(&str, &str, usize); 5] = [
    ("readme", "README.md", 0),
    ("certificate", "docs/certificates.md", 0),
    ("planetary", "docs/planetary.md", 0),
    ("own_model", "docs/own-model.md", 0),
    ("formula", "docs/start.md", 0),
];

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(&env::var("CARGO_MANIFEST_DIR")?).join("../..");
    let out = env::var("OUT_DIR")?;
    for (name, page, number) in PROGRAMS {
        let path = root.join(page);
        println!("cargo::rerun-if-changed={}", path.display());
        let text = fs::read_to_string(&path)?;
        let block = text.split("```rust").nth(number + 1).and_then(|rest| rest.split_once('\n'));
        let block = block.and_then(|(_, rest)| rest.split_once("```")).ok_or("no block of Rust")?.0;
        fs::write(Path::new(&out).join(format!("{name}.rs")), program(block))?;
    }
    Ok(())
}

/// A block of a page as a program.
fn program(block: &str) -> String {
    let shown = |line: &str| line.strip_prefix("# ").unwrap_or(line).to_string();
    let lines: Vec<String> = block.lines().filter(|line| *line != "#").map(shown).collect();
    if block.contains("fn main()") {
        return lines.join("\n");
    }
    let body: Vec<&str> =
        lines.iter().map(String::as_str).filter(|line| !line.starts_with("Ok::<")).collect();
    format!("fn main() -> Result<(), Box<dyn std::error::Error>> {{\n{}\nOk(())\n}}\n", body.join("\n"))
}
