//! Widths of text.

/// Widths of the printable ASCII characters in thousandths of the font size.   Source: DejaVu Sans 2.37, which is
/// wider than Helvetica and Arial: what fits in it fits in them.
#[rustfmt::skip]
const WIDTHS: [u16; 95] = [
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337, 636, 636, 636, 636, 636, 636,
    636, 636, 636, 636, 337, 337, 838, 838, 838, 531, 1000, 684, 686, 698, 770, 632, 575, 775, 752, 295, 295, 656,
    557, 863, 748, 787, 603, 787, 695, 635, 611, 732, 684, 989, 685, 611, 685, 390, 337, 390, 838, 500, 500, 613,
    635, 550, 635, 615, 352, 635, 634, 278, 278, 579, 278, 974, 634, 612, 635, 635, 411, 521, 392, 634, 592, 818,
    592, 592, 525, 636, 337, 636, 838,
];

/// Width of a text at a font size.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    let of = |c: char| match c {
        ' '..='~' => f64::from(WIDTHS[c as usize - 32]),
        '⁰' | '¹' | '²' | '³' | '⁴'..='⁹' | '₀'..='₉' => 401.0,
        '·' | '…' => 318.0,
        _ => 680.0,
    };
    text.chars().map(of).sum::<f64>() * size / 1000.0
}

/// Lines of at most `most` points of width, broken at spaces.
pub(crate) fn wrap(text: &str, size: f64, most: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        match lines.last_mut() {
            Some(line) if width(line, size) + width(" ", size) + width(word, size) <= most => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// An integer in superscript.
pub(crate) fn superscript(n: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => char::from_u32('⁰' as u32 + (c as u32 - '0' as u32)).unwrap_or(c),
    };
    n.to_string().chars().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_broken_at_spaces() {
        let lines = wrap("contact loss over speed and load", 10.0, 90.0);
        assert_eq!(lines.join(" "), "contact loss over speed and load");
        assert!(lines.len() > 1 && lines.iter().all(|line| width(line, 10.0) <= 90.0));
        assert_eq!(superscript(-120), "⁻¹²⁰");
    }
}
