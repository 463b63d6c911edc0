//! Numbers, words and lists as bytes, little endian. Reading never passes the end.

use crate::error::{Error, Result};

/// Appends to bytes.
#[derive(Default)]
pub struct Writer(pub Vec<u8>);

impl Writer {
    pub fn u8(&mut self, value: u8) {
        self.0.push(value);
    }

    pub fn u16(&mut self, value: u16) {
        self.0.extend(value.to_le_bytes());
    }

    pub fn u32(&mut self, value: u32) {
        self.0.extend(value.to_le_bytes());
    }

    pub fn u64(&mut self, value: u64) {
        self.0.extend(value.to_le_bytes());
    }

    pub fn f32(&mut self, value: f32) {
        self.0.extend(value.to_le_bytes());
    }

    pub fn f64(&mut self, value: f64) {
        self.0.extend(value.to_le_bytes());
    }

    /// The length of a list, and each of its items.
    pub fn list<T>(
        &mut self,
        items: impl ExactSizeIterator<Item = T>,
        mut each: impl FnMut(&mut Self, T),
    ) {
        self.u32(items.len() as u32);
        items.for_each(|item| each(self, item));
    }

    pub fn text(&mut self, text: &str) {
        self.list(text.bytes(), Self::u8);
    }
}

/// Takes from the front of bytes.
pub struct Reader<'a>(pub &'a [u8]);

impl<'a> Reader<'a> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        let (front, rest) =
            self.0.split_first_chunk::<N>().ok_or_else(|| damaged("ends too early"))?;
        self.0 = rest;
        Ok(*front)
    }

    pub fn part(&mut self, length: usize) -> Result<&'a [u8]> {
        let (front, rest) =
            self.0.split_at_checked(length).ok_or_else(|| damaged("ends too early"))?;
        self.0 = rest;
        Ok(front)
    }

    pub fn u8(&mut self) -> Result<u8> {
        Ok(self.take::<1>()?[0])
    }

    pub fn u16(&mut self) -> Result<u16> {
        self.take().map(u16::from_le_bytes)
    }

    pub fn u32(&mut self) -> Result<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Result<u64> {
        self.take().map(u64::from_le_bytes)
    }

    pub fn f32(&mut self) -> Result<f32> {
        self.take().map(f32::from_le_bytes)
    }

    pub fn f64(&mut self) -> Result<f64> {
        self.take().map(f64::from_le_bytes)
    }

    /// A list whose items need at least `smallest` bytes each, so that an impossible length is refused.
    pub fn list<T>(
        &mut self,
        smallest: usize,
        mut each: impl FnMut(&mut Self) -> Result<T>,
    ) -> Result<Vec<T>> {
        let length = self.u32()? as usize;
        if length > self.0.len() / smallest.max(1) {
            return Err(damaged("has a list that is longer than its remaining bytes"));
        }
        let mut items = Vec::with_capacity(length);
        for _ in 0..length {
            items.push(each(self)?);
        }
        Ok(items)
    }

    pub fn text(&mut self) -> Result<String> {
        let bytes = self.list(1, Self::u8)?;
        String::from_utf8(bytes).map_err(|_| damaged("has a word that is not UTF-8"))
    }
}

/// The error for bytes that are not a model.
pub fn damaged(how: &str) -> Error {
    Error::Bundle(format!("its file {how}"))
}
