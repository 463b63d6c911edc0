//! Writes MATLAB's level 5 files by hand, in either byte order.
#![allow(dead_code, reason = "each test uses some of it")]

/// A writer in one byte order.
#[derive(Clone, Copy)]
pub struct Writer {
    pub big_endian: bool,
}

impl Writer {
    fn bytes<const N: usize>(self, mut little: [u8; N]) -> [u8; N] {
        if self.big_endian {
            little.reverse();
        }
        little
    }

    pub fn word(self, value: u32) -> Vec<u8> {
        self.bytes(value.to_le_bytes()).to_vec()
    }

    /// The header of a file, and `elements`.
    pub fn file(self, elements: &[Vec<u8>]) -> Vec<u8> {
        let mut file = b"MATLAB 5.0 MAT-file, by hand".to_vec();
        file.resize(124, b' ');
        file.extend(self.bytes(0x0100u16.to_le_bytes()));
        file.extend(self.bytes(*b"IM"));
        file.extend(elements.concat());
        file
    }

    pub fn element(self, kind: u32, data: &[u8]) -> Vec<u8> {
        let mut element = [self.word(kind), self.word(data.len() as u32), data.to_vec()].concat();
        element.resize(element.len().next_multiple_of(8), 0);
        element
    }

    /// A small element: at most four bytes, beside their tag.
    pub fn small(self, kind: u32, data: &[u8]) -> Vec<u8> {
        let mut element = self.word((data.len() as u32) << 16 | kind);
        element.extend(data);
        element.resize(8, 0);
        element
    }

    /// An array of a class, with these dimensions and elements.
    pub fn array(self, class: u32, dims: &[u32], name: &str, elements: &[Vec<u8>]) -> Vec<u8> {
        let flags = self.element(6, &[self.word(class), self.word(0)].concat());
        let dims: Vec<u8> = dims.iter().flat_map(|n| self.word(*n)).collect();
        let head = [flags, self.element(5, &dims), self.element(1, name.as_bytes())];
        self.element(14, &[head.concat(), elements.concat()].concat())
    }

    /// A row of doubles.
    pub fn doubles(self, name: &str, values: &[f64]) -> Vec<u8> {
        let data: Vec<u8> = values.iter().flat_map(|v| self.bytes(v.to_le_bytes())).collect();
        self.array(6, &[1, values.len() as u32], name, &[self.element(9, &data)])
    }

    /// A column of doubles stored as 16-bit integers, as MATLAB does where nothing is lost.
    pub fn shorts(self, name: &str, values: &[i16]) -> Vec<u8> {
        let data: Vec<u8> = values.iter().flat_map(|v| self.bytes(v.to_le_bytes())).collect();
        self.array(6, &[values.len() as u32, 1], name, &[self.element(3, &data)])
    }

    /// Text in UTF-16.
    pub fn text(self, name: &str, text: &str) -> Vec<u8> {
        let units: Vec<u16> = text.encode_utf16().collect();
        let data: Vec<u8> = units.iter().flat_map(|u| self.bytes(u.to_le_bytes())).collect();
        self.array(4, &[1, units.len() as u32], name, &[self.element(4, &data)])
    }

    /// A struct; its fields' own names are empty.
    pub fn structure(self, name: &str, names: &[&str], values: &[Vec<u8>]) -> Vec<u8> {
        self.structures(name, names, &[values.concat()])
    }

    /// An array of structs, each with the concatenated values of its fields.
    pub fn structures(self, name: &str, names: &[&str], values: &[Vec<u8>]) -> Vec<u8> {
        let mut table = vec![];
        for name in names {
            table.extend(name.as_bytes());
            table.resize(table.len().next_multiple_of(16), 0);
        }
        let head = [self.small(5, &self.word(16)), self.element(1, &table)];
        self.array(2, &[1, values.len() as u32], name, &[head.concat(), values.concat()])
    }

    pub fn cell(self, name: &str, values: &[Vec<u8>]) -> Vec<u8> {
        self.array(1, &[values.len() as u32, 1], name, values)
    }

    /// An object, which has no dimensions.
    pub fn object(self, name: &str, class: &str) -> Vec<u8> {
        let flags = self.element(6, &[self.word(17), self.word(0)].concat());
        let text = |text: &str| self.element(1, text.as_bytes());
        self.element(14, &[flags, text(name), text("MCOS"), text(class)].concat())
    }
}
