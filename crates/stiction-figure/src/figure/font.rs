//! The outlines of letters, from the TrueType files in `font/`.
//!
//! It reads only these two files, which contain letters by the Unicode table of format 4, and outlines of points or of
//! shifted other outlines.

use super::geometry::Point;

const REGULAR: &[u8] = include_bytes!("../../font/DejaVuSans.ttf");
const BOLD: &[u8] = include_bytes!("../../font/DejaVuSans-Bold.ttf");

/// Units to the font size.
const UNITS: f64 = 2048.0;
/// Straight strokes per curve. At the size of a title they deviate by less than a tenth of a pixel.
const CHORDS: usize = 8;
/// Depth limit of outlines composed of other outlines.
const DEPTH: usize = 4;

/// Draws `text` along x from the origin, in units of the font size, y downwards, and returns its width.
///
/// A character that the font lacks is drawn as the font's box for missing characters.
pub(super) fn set(text: &str, bold: bool, draw: &mut impl FnMut(Vec<Point>)) -> f64 {
    let font = Font { data: if bold { BOLD } else { REGULAR } };
    let mut pen = 0.0;
    for c in text.chars() {
        let glyph = font.glyph(c).unwrap_or(0);
        // A file that ended too early would show nothing.
        let _ = font.outline(glyph, (0, 0), DEPTH, &mut |outline: &[Knot]| {
            let place = |p: Point| Point::new(pen + p.x / UNITS, -p.y / UNITS);
            draw(flat(outline).into_iter().map(place).collect());
        });
        pen += font.advance(glyph).unwrap_or(0.0);
    }
    pen
}

/// A point of an outline, and whether the outline passes through it or only bends towards it.
#[derive(Debug, Clone, Copy)]
struct Knot {
    at: Point,
    through: bool,
}

#[derive(Clone, Copy)]
struct Font {
    data: &'static [u8],
}

impl Font {
    fn table(self, name: &[u8; 4]) -> Option<Bytes> {
        let file = Bytes(self.data);
        let mut records = (0..usize::from(file.u16(4)?)).map(|i| 12 + 16 * i);
        let record = records.find(|at| self.data.get(*at..at + 4) == Some(name))?;
        file.from(file.u32(record + 8)?)
    }

    /// The index of the letter's outline.
    fn glyph(self, c: char) -> Option<u16> {
        let c = u16::try_from(u32::from(c)).ok()?;
        let cmap = self.table(b"cmap")?;
        // All subtables of the files are the same.
        let cmap = cmap.from(cmap.u32(8)?)?;
        let twice = usize::from(cmap.u16(6)?);
        let segment =
            (14..14 + twice).step_by(2).find(|at| cmap.u16(*at).is_some_and(|end| c <= end))?;
        let (first, delta) = (segment + twice + 2, segment + 2 * twice + 2);
        let (start, delta, offsets) = (cmap.u16(first)?, cmap.u16(delta)?, delta + twice);
        let from_start = c.checked_sub(start)?;
        match cmap.u16(offsets)? {
            0 => Some(c.wrapping_add(delta)),
            offset => {
                let glyph =
                    cmap.u16(offsets + usize::from(offset) + 2 * usize::from(from_start))?;
                (glyph != 0).then(|| glyph.wrapping_add(delta))
            }
        }
    }

    /// The distance of the next letter, in units of the font size.
    fn advance(self, glyph: u16) -> Option<f64> {
        let given = self.table(b"hhea")?.u16(34)?;
        // The last width applies to all that follow.
        let at = 4 * usize::from(glyph.min(given.checked_sub(1)?));
        Some(f64::from(self.table(b"hmtx")?.u16(at)?) / UNITS)
    }

    /// Passes on each closed line of an outline, moved by `by`, y upwards.
    fn outline(
        self,
        glyph: u16,
        by: (i32, i32),
        depth: usize,
        draw: &mut impl FnMut(&[Knot]),
    ) -> Option<()> {
        let loca = self.table(b"loca")?;
        let glyph = usize::from(glyph);
        let (start, end) = (loca.u16(2 * glyph)?, loca.u16(2 * glyph + 2)?);
        if start == end {
            return Some(());
        }
        let mut bytes = self.table(b"glyf")?.from(2 * usize::from(start))?;
        let lines = bytes.next_i16()?;
        bytes.skip(8)?;
        match usize::try_from(lines) {
            Ok(lines) => knots(bytes, lines, by)?.iter().for_each(|line| draw(line)),
            Err(_) => self.assembled(bytes, by, depth.checked_sub(1)?, draw)?,
        }
        Some(())
    }

    /// Draws an outline that is composed of others.
    fn assembled(
        self,
        mut bytes: Bytes,
        by: (i32, i32),
        depth: usize,
        draw: &mut dyn FnMut(&[Knot]),
    ) -> Option<()> {
        const WORDS: u16 = 0x01;
        const MORE: u16 = 0x20;
        loop {
            let (flags, glyph) = (bytes.next_u16()?, bytes.next_u16()?);
            let (x, y) = if flags & WORDS != 0 {
                (i32::from(bytes.next_i16()?), i32::from(bytes.next_i16()?))
            } else {
                let signed = |byte: u8| i32::from(byte as i8);
                (signed(bytes.next()?), signed(bytes.next()?))
            };
            self.outline(glyph, (by.0 + x, by.1 + y), depth, &mut |line: &[Knot]| draw(line))?;
            if flags & MORE == 0 {
                return Some(());
            }
        }
    }
}

/// The closed lines of an outline of points.
fn knots(mut bytes: Bytes, lines: usize, by: (i32, i32)) -> Option<Vec<Vec<Knot>>> {
    const THROUGH: u8 = 0x01;
    const REPEATED: u8 = 0x08;
    let ends: Vec<usize> =
        (0..lines).map(|_| Some(usize::from(bytes.next_u16()?) + 1)).collect::<Option<_>>()?;
    let instructions = bytes.next_u16()?;
    bytes.skip(usize::from(instructions))?;
    let count = ends.last().copied().unwrap_or(0);
    let mut flags = Vec::with_capacity(count);
    while flags.len() < count {
        let flag = bytes.next()?;
        let times = if flag & REPEATED != 0 { usize::from(bytes.next()?) + 1 } else { 1 };
        flags.extend(std::iter::repeat_n(flag, times));
    }
    // Each coordinate is a step from the one before, as a byte and a sign, a word, or nothing.
    let mut steps = |short: u8, same: u8, start: i32| {
        let mut at = start;
        let step = |flag: &u8| {
            at += match (flag & short != 0, flag & same != 0) {
                (true, true) => i32::from(bytes.next()?),
                (true, false) => -i32::from(bytes.next()?),
                (false, true) => 0,
                (false, false) => i32::from(bytes.next_i16()?),
            };
            Some(f64::from(at))
        };
        flags.iter().map(step).collect::<Option<Vec<f64>>>()
    };
    let (x, y) = (steps(0x02, 0x10, by.0)?, steps(0x04, 0x20, by.1)?);
    let knot = |i: usize| Knot { at: Point::new(x[i], y[i]), through: flags[i] & THROUGH != 0 };
    let starts = std::iter::once(0).chain(ends.iter().copied());
    Some(starts.zip(&ends).map(|(start, end)| (start..*end).map(knot).collect()).collect())
}

/// A closed line without bends.
fn flat(line: &[Knot]) -> Vec<Point> {
    let mut points = Vec::new();
    for (i, knot) in line.iter().enumerate() {
        if knot.through {
            points.push(knot.at);
            continue;
        }
        // Between two control points, the line passes through their midpoint.
        let end = |other: Knot| if other.through { other.at } else { knot.at.middle(other.at) };
        let from = end(line[(i + line.len() - 1) % line.len()]);
        let to = end(line[(i + 1) % line.len()]);
        points.extend((0..=CHORDS).map(|k| {
            let t = k as f64 / CHORDS as f64;
            let (a, b, c) = ((1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t);
            let bend = knot.at;
            Point::new(a * from.x + b * bend.x + c * to.x, a * from.y + b * bend.y + c * to.y)
        }));
    }
    points
}

/// Big-endian numbers.
#[derive(Clone, Copy)]
struct Bytes(&'static [u8]);

impl Bytes {
    fn from(self, at: usize) -> Option<Self> {
        self.0.get(at..).map(Self)
    }

    fn u16(self, at: usize) -> Option<u16> {
        self.from(at)?.next_u16()
    }

    fn u32(self, at: usize) -> Option<usize> {
        let bytes = self.0.get(at..at + 4)?;
        Some(u32::from_be_bytes(bytes.try_into().ok()?) as usize)
    }

    fn skip(&mut self, count: usize) -> Option<()> {
        *self = self.from(count)?;
        Some(())
    }

    fn next(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn next_u16(&mut self) -> Option<u16> {
        Some(u16::from_be_bytes([self.next()?, self.next()?]))
    }

    fn next_i16(&mut self) -> Option<i16> {
        self.next_u16().map(|bits| bits as i16)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::text;

    /// Left, top, right and bottom of the ink, and the width.
    fn ink(text: &str, bold: bool) -> ([f64; 4], f64) {
        let mut sides = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        let width = set(text, bold, &mut |line| {
            for p in line {
                sides =
                    [sides[0].min(p.x), sides[1].min(p.y), sides[2].max(p.x), sides[3].max(p.y)];
            }
        });
        (sides, width)
    }

    #[test]
    fn letters_are_as_wide_as_layout_believes() {
        for c in ' '..='~' {
            let (_, width) = ink(&c.to_string(), false);
            assert!((width - text::width(&c.to_string(), 1.0)).abs() < 6e-4, "{c}: {width}");
        }
    }

    #[test]
    fn letters_of_all_kinds_are_there() {
        let (_, missing) = ink("\u{e000}", false);
        for bold in [false, true] {
            for c in "AbgÄßñłŠπΩΔτЖй⁻¹²³₀₉−×·±≤≥≈→←°µ½…–—‰€".chars()
            {
                let font = Font { data: if bold { BOLD } else { REGULAR } };
                assert!(font.glyph(c).is_some_and(|glyph| glyph > 0), "{c}");
                let ([left, top, right, bottom], width) = ink(&c.to_string(), bold);
                assert!(left > -0.1 && right < width + 0.1 && left < right, "{c}");
                assert!(top > -1.1 && bottom < 0.3 && top < bottom, "{c}");
            }
        }
        let ([left, _, right, _], width) = ink("漢", false);
        assert!(left < right && width == missing, "a box stands for what is not there");
        assert_eq!(ink("", false).1, 0.0);
    }

    #[test]
    fn outlines_have_the_known_measures() {
        // Of DejaVu Sans: the height of H, which stands on the base line, and the depth of p.
        let ([_, top, _, bottom], _) = ink("H", false);
        assert_eq!((top, bottom), (-1493.0 / UNITS, 0.0));
        assert_eq!(ink("p", false).0[3], 426.0 / UNITS);
    }
}
