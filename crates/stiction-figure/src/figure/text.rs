//! Widths of texts, and their line breaks.

/// Distance of base lines in units of the font size.
pub(super) const LINE: f64 = 1.25;

/// Widths of the characters from space to tilde in DejaVu Sans, thousandths of the font size.
///
/// This is one of the widest sans-serif fonts, so text in the reader's font also fits.
#[rustfmt::skip]
const WIDTHS: [u16; 95] = [
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337,
    636, 636, 636, 636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531,
    1000, 684, 686, 698, 770, 632, 575, 775, 752, 295, 295, 656, 557, 863, 748, 787,
    603, 787, 695, 635, 611, 732, 684, 989, 685, 611, 685, 390, 337, 390, 838, 500,
    500, 613, 635, 550, 635, 615, 352, 635, 634, 278, 278, 579, 278, 974, 634, 612,
    635, 635, 411, 521, 392, 634, 592, 818, 592, 592, 525, 636, 337, 636, 838,
];

/// Bold letters are wider by about this factor.
pub(super) const BOLD: f64 = 1.12;

fn char_width(c: char) -> f64 {
    let thousandths = match c {
        ' '..='~' => WIDTHS[c as usize - ' ' as usize],
        '⁰'..='₉' | '²' | '³' | '¹' => 420,
        '\u{2190}'..='\u{22ff}' | '×' | '±' => 838,
        // Latin and Greek letters are narrower than this, ideographs need a full em.
        '\u{0}'..='\u{6ff}' => 700,
        _ => 1000,
    };
    f64::from(thousandths) / 1000.0
}

/// Width of one line of text, px.
pub(super) fn width(text: &str, size: f64) -> f64 {
    text.chars().map(char_width).sum::<f64>() * size
}

/// Breaks `text` at spaces so that no line is wider than `room`; longer words are split.
pub(super) fn wrap(text: &str, size: f64, room: f64) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in text.split_whitespace() {
        let joined = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if width(&joined, size) <= room {
            line = joined;
            continue;
        }
        if !line.is_empty() {
            lines.push(std::mem::take(&mut line));
        }
        for c in word.chars() {
            if !line.is_empty() && width(&line, size) + char_width(c) * size > room {
                lines.push(std::mem::take(&mut line));
            }
            line.push(c);
        }
    }
    if !line.is_empty() {
        lines.push(line);
    }
    lines
}

/// `text` without characters that XML forbids.
pub(super) fn printable(text: &str) -> String {
    let clean =
        |c: char| if c.is_control() || c == '\u{fffe}' || c == '\u{ffff}' { ' ' } else { c };
    text.chars().map(clean).collect()
}
