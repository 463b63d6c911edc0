//! The pages of a column chunk, decompressed.
//!
//! The parquet crate has its own reader of pages, but that one trusts the sizes in page headers. Here they are
//! checked before anything is allocated. That reader would also need C code to decompress Zstandard.

use super::thrift::Fields;
use bytes::Bytes;
use parquet::basic::{Compression, Encoding, Type};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};
use parquet::schema::types::ColumnDescriptor;
use std::io::Read;

/// The largest window a Zstandard stream may ask for is 2^27 bytes, as in its reference decoder.
const MAX_ZSTD_WINDOW_LOG: u8 = 27;

/// Snappy copies at most 64 bytes for 3.
const MAX_SNAPPY_EXPANSION: usize = 22;

/// LZ4 copies at most 255 bytes for one.
const MAX_LZ4_EXPANSION: usize = 255;

/// The pages of a column chunk, in order.
pub(super) struct Pages {
    /// The bytes of the remaining pages.
    rest: Bytes,
    compression: Compression,
    /// Whether cells may be null. If so, levels precede the values.
    optional: bool,
    /// Minimum number of bytes per value of a dictionary.
    value_bytes: usize,
    /// Limit for the size of a page.
    limit: usize,
}

/// The header of a page of cells.
struct DataHeader {
    num_values: u32,
    encoding: Encoding,
    v2: Option<V2>,
}

/// Additional fields of version 2.
struct V2 {
    num_nulls: u32,
    num_rows: u32,
    def_levels_byte_len: u32,
    rep_levels_byte_len: u32,
    is_compressed: bool,
}

fn broken(what: impl Into<String>) -> ParquetError {
    ParquetError::General(what.into())
}

impl Pages {
    /// The pages of a column chunk from its `bytes`, none larger than `limit`.
    pub(super) fn new(
        bytes: Bytes,
        column: &ColumnDescriptor,
        compression: Compression,
        limit: usize,
    ) -> Result<Self> {
        let value_bytes = match (column.physical_type(), column.type_length()) {
            // There are two dictionaries, which is invalid.
            (Type::BOOLEAN, _) => usize::MAX,
            (Type::INT32 | Type::FLOAT | Type::BYTE_ARRAY, _) => 4,
            (Type::INT64 | Type::DOUBLE, _) => 8,
            (Type::INT96, _) => 12,
            (Type::FIXED_LEN_BYTE_ARRAY, length @ 1..=1024) => length as usize,
            (Type::FIXED_LEN_BYTE_ARRAY, length) => {
                return Err(broken(format!("its cells are {length} bytes wide")));
            }
        };
        let optional = column.max_def_level() > 0;
        Ok(Self { rest: bytes, compression, optional, value_bytes, limit })
    }

    /// The next page that has cells or a dictionary.
    fn next_page(&mut self) -> Result<Option<Page>> {
        while !self.rest.is_empty() {
            let rest = self.rest.clone();
            let (header, length) =
                Fields::read(&rest).ok_or_else(|| broken("a page header is damaged"))?;
            let size = |number| header.size(number).ok_or_else(|| broken("a page has no size"));
            let (full, stored) = (size(2)?, size(3)?);
            if stored > rest.len() - length {
                return Err(broken("a page ends after its column; the file is cut short"));
            }
            if full > self.limit {
                return Err(broken(format!(
                    "a page of {full} bytes is too large for a file of this size"
                )));
            }
            let body = rest.slice(length..length + stored);
            self.rest = rest.slice(length + stored..);
            let page = match header.int(1) {
                Some(0) => header.fields(5).and_then(DataHeader::v1),
                Some(3) => header.fields(8).and_then(DataHeader::v2),
                Some(2) => return self.dictionary(&header, &body, full).map(Some),
                // An index, or an unknown kind.
                _ => continue,
            };
            let page = page.ok_or_else(|| broken("a page header is incomplete"))?;
            if page.num_values > 0 {
                return self.data(page, &body, full).map(Some);
            }
        }
        Ok(None)
    }

    fn dictionary(&self, header: &Fields, body: &Bytes, full: usize) -> Result<Page> {
        let buf = decompress(body, self.compression, full)?;
        let count = header.fields(7).and_then(|page| page.size(1));
        match count {
            Some(count) if count <= buf.len() / self.value_bytes => Ok(Page::DictionaryPage {
                buf,
                num_values: count as u32,
                encoding: Encoding::PLAIN,
                is_sorted: false,
            }),
            _ => Err(broken("its dictionary is shorter than stated")),
        }
    }

    fn data(&self, page: DataHeader, body: &Bytes, full: usize) -> Result<Page> {
        let DataHeader { num_values, encoding, v2 } = page;
        let Some(v2) = v2 else {
            let buf = decompress(body, self.compression, full)?;
            let values = if self.optional { after_levels(&buf) } else { Some(&buf[..]) };
            let values = values.ok_or_else(|| broken("a page ends within its levels"))?;
            check_encoding(encoding, values, num_values)?;
            return Ok(Page::DataPage {
                buf,
                num_values,
                encoding,
                def_level_encoding: Encoding::RLE,
                rep_level_encoding: Encoding::RLE,
                statistics: None,
            });
        };
        // The levels precede the values and are never compressed.
        let levels = v2.def_levels_byte_len as usize + v2.rep_levels_byte_len as usize;
        if levels > body.len() || levels > full {
            return Err(broken("a page ends within its levels"));
        }
        let compression =
            if v2.is_compressed { self.compression } else { Compression::UNCOMPRESSED };
        let values = decompress(&body.slice(levels..), compression, full - levels)?;
        check_encoding(encoding, &values, num_values)?;
        Ok(Page::DataPageV2 {
            buf: [&body[..levels], &values].concat().into(),
            num_values,
            encoding,
            num_nulls: v2.num_nulls,
            num_rows: v2.num_rows,
            def_levels_byte_len: v2.def_levels_byte_len,
            rep_levels_byte_len: v2.rep_levels_byte_len,
            is_compressed: false,
            statistics: None,
        })
    }
}

impl Iterator for Pages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_page().transpose()
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        self.next_page()
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        Err(broken("pages are read one after another"))
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.next_page().map(|_| ())
    }
}

impl DataHeader {
    fn v1(page: &Fields) -> Option<Self> {
        let num_values = page.size(1)?.try_into().ok()?;
        Some(Self { num_values, encoding: encoding(page.int(2)?)?, v2: None })
    }

    fn v2(page: &Fields) -> Option<Self> {
        let count = |number| page.size(number).and_then(|n| u32::try_from(n).ok());
        let v2 = V2 {
            num_nulls: count(2)?,
            num_rows: count(3)?,
            def_levels_byte_len: count(5)?,
            rep_levels_byte_len: count(6)?,
            is_compressed: page.bool(7).unwrap_or(true),
        };
        Some(Self { num_values: count(1)?, encoding: encoding(page.int(4)?)?, v2: Some(v2) })
    }
}

fn encoding(code: i64) -> Option<Encoding> {
    Some(match code {
        0 => Encoding::PLAIN,
        2 => Encoding::PLAIN_DICTIONARY,
        3 => Encoding::RLE,
        5 => Encoding::DELTA_BINARY_PACKED,
        6 => Encoding::DELTA_LENGTH_BYTE_ARRAY,
        7 => Encoding::DELTA_BYTE_ARRAY,
        8 => Encoding::RLE_DICTIONARY,
        9 => Encoding::BYTE_STREAM_SPLIT,
        _ => return None,
    })
}

/// The bytes after the definition levels of a page of version 1.
fn after_levels(page: &[u8]) -> Option<&[u8]> {
    let (length, rest) = page.split_first_chunk()?;
    rest.get(u32::from_le_bytes(*length) as usize..)
}

/// Refuses values for which the parquet crate would allocate more than the page contains.
fn check_encoding(encoding: Encoding, values: &[u8], num_values: u32) -> Result<()> {
    match encoding {
        Encoding::DELTA_BINARY_PACKED | Encoding::DELTA_LENGTH_BYTE_ARRAY => {
            // Values per block, miniblocks per block, values.
            let mut rest = values.iter();
            let mut varint = || {
                let mut value = 0u64;
                for shift in (0..35).step_by(7) {
                    let byte = *rest.next()?;
                    value |= u64::from(byte & 0x7f) << shift;
                    if byte < 0x80 {
                        return Some(value);
                    }
                }
                None
            };
            let header = (varint(), varint(), varint());
            match header {
                (Some(block), Some(1..=1024), Some(count))
                    if block <= 1 << 20 && count <= u64::from(num_values) =>
                {
                    Ok(())
                }
                _ => Err(broken("a page of differences has a damaged header")),
            }
        }
        Encoding::DELTA_BYTE_ARRAY => Err(broken(
            "its text is stored as differences (DELTA_BYTE_ARRAY), which is not read; write the file without that \
             encoding",
        )),
        _ => Ok(()),
    }
}

/// `stored`, decompressed to exactly `full` bytes.
fn decompress(stored: &Bytes, compression: Compression, full: usize) -> Result<Bytes> {
    let within = |expansion: usize| full <= stored.len().saturating_mul(expansion) + 64;
    let bytes = match compression {
        Compression::UNCOMPRESSED => Ok(stored.clone()),
        _ if full == 0 => Ok(Bytes::new()),
        Compression::SNAPPY if within(MAX_SNAPPY_EXPANSION) => snappy(stored, full),
        Compression::LZ4_RAW if within(MAX_LZ4_EXPANSION) => {
            lz4_flex::block::decompress(stored, full).map(Bytes::from).map_err(|e| e.to_string())
        }
        Compression::SNAPPY | Compression::LZ4_RAW => Err("it is shorter than stated".to_owned()),
        Compression::GZIP(_) => to_end(flate2::read::MultiGzDecoder::new(&stored[..]), full),
        Compression::BROTLI(_) => {
            to_end(brotli_decompressor::Decompressor::new(&stored[..], 4096), full)
        }
        Compression::ZSTD(_) => zstandard(stored, full),
        other => Err(format!("{other} is not read; write it with snappy, gzip or zstd")),
    };
    let bytes = bytes.map_err(|e| broken(format!("a page cannot be decompressed: {e}")))?;
    match bytes.len() {
        length if length == full => Ok(bytes),
        length => Err(broken(format!("a page has {length} bytes instead of the stated {full}"))),
    }
}

fn snappy(stored: &[u8], full: usize) -> std::result::Result<Bytes, String> {
    match snap::raw::decompress_len(stored) {
        Ok(length) if length == full => {
            let bytes = snap::raw::Decoder::new().decompress_vec(stored);
            bytes.map(Bytes::from).map_err(|e| e.to_string())
        }
        Ok(length) => Err(format!("it states both {full} and {length} bytes")),
        Err(e) => Err(e.to_string()),
    }
}

/// The output of `input`, up to one byte more than `full`.
fn to_end(input: impl Read, full: usize) -> std::result::Result<Bytes, String> {
    let mut bytes = vec![];
    input.take(full as u64 + 1).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    Ok(bytes.into())
}

/// Decompresses block by block, because the decoder would otherwise keep as many bytes as its window.
fn zstandard(mut stored: &[u8], full: usize) -> std::result::Result<Bytes, String> {
    use ruzstd::decoding::{BlockDecodingStrategy::UptoBlocks, FrameDecoder};
    let mut bytes = vec![];
    while !stored.is_empty() {
        // Magic number (4 bytes), descriptor, and the window unless the frame is one segment.
        let single_segment = stored.get(4).is_some_and(|descriptor| descriptor & 0x20 != 0);
        if !single_segment && stored.get(5).is_none_or(|w| 10 + (w >> 3) > MAX_ZSTD_WINDOW_LOG) {
            return Err("its window is too large".to_owned());
        }
        let mut decoder = FrameDecoder::new();
        decoder.init(&mut stored).map_err(|e| e.to_string())?;
        if single_segment && decoder.content_size() > full as u64 {
            return Err("it is longer than stated".to_owned());
        }
        while !decoder.is_finished() {
            decoder.decode_blocks(&mut stored, UptoBlocks(1)).map_err(|e| e.to_string())?;
            bytes.extend(decoder.collect().unwrap_or_default());
            if bytes.len() > full {
                return Err("it is longer than stated".to_owned());
            }
        }
    }
    Ok(bytes.into())
}
