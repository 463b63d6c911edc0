//! The meaning of a column's values.

use super::arrow_schema::Field;
use crate::sheet::Cells;
use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::errors::ParquetError;
use parquet::schema::types::{ColumnDescPtr, ColumnDescriptor};

/// A column, as described in the footer.
#[derive(Debug)]
pub struct Described {
    pub name: String,
    pub unit: Option<String>,
    pub kind: Kind,
    pub descriptor: ColumnDescPtr,
}

/// The meaning of a column's values.
#[derive(Debug)]
pub enum Kind {
    /// Numbers, to be divided by this power of ten.
    Number { digits: i32, unsigned: bool },
    /// A half-precision number in two bytes.
    Half,
    /// Durations or times of day, in this many units per second.
    Seconds { per_second: i64 },
    /// Times since 1970, in this many units per second.
    Time { per_second: i64, utc: bool },
    /// Days since 1970.
    Date,
    /// Text.
    Text,
}

impl Kind {
    pub fn of(column: &ColumnDescriptor, field: &Field) -> Result<Self, &'static str> {
        let number = Self::Number { digits: 0, unsigned: false };
        let per_second = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => 1_000,
            TimeUnit::MICROS => 1_000_000,
            TimeUnit::NANOS => 1_000_000_000,
        };
        if let Some(per_second) = field.durations_per_second
            && column.physical_type() == Type::INT64
        {
            return Ok(Self::Seconds { per_second });
        }
        Ok(match column.logical_type_ref() {
            Some(LogicalType::Integer(int)) => Self::Number { digits: 0, unsigned: !int.is_signed },
            Some(LogicalType::Decimal(decimal)) => {
                Self::Number { digits: decimal.scale, unsigned: false }
            }
            Some(LogicalType::Timestamp(time)) => {
                let utc = time.is_adjusted_to_u_t_c;
                Self::Time { per_second: per_second(&time.unit), utc }
            }
            Some(LogicalType::Time(time)) => Self::Seconds { per_second: per_second(&time.unit) },
            Some(LogicalType::Date) => Self::Date,
            Some(LogicalType::String | LogicalType::Enum | LogicalType::Json) => Self::Text,
            Some(LogicalType::Float16) => Self::Half,
            Some(LogicalType::Unknown) => number,
            Some(LogicalType::Uuid) => return Err("holds identifiers (UUID)"),
            Some(_) => return Err("is of a type that holds neither numbers, text nor times"),
            None => match column.converted_type() {
                ConvertedType::UINT_8
                | ConvertedType::UINT_16
                | ConvertedType::UINT_32
                | ConvertedType::UINT_64 => Self::Number { digits: 0, unsigned: true },
                ConvertedType::DECIMAL => {
                    Self::Number { digits: column.type_scale(), unsigned: false }
                }
                // Timestamps were UTC before the format could mark them as local.
                ConvertedType::TIMESTAMP_MILLIS => Self::Time { per_second: 1_000, utc: true },
                ConvertedType::TIMESTAMP_MICROS => Self::Time { per_second: 1_000_000, utc: true },
                ConvertedType::TIME_MILLIS => Self::Seconds { per_second: 1_000 },
                ConvertedType::TIME_MICROS => Self::Seconds { per_second: 1_000_000 },
                ConvertedType::DATE => Self::Date,
                ConvertedType::INTERVAL => return Err("holds intervals of months and days"),
                _ => match column.physical_type() {
                    Type::INT96 => Self::Time { per_second: 1_000_000_000, utc: false },
                    Type::BYTE_ARRAY => Self::Text,
                    Type::FIXED_LEN_BYTE_ARRAY => return Err("is binary"),
                    _ => number,
                },
            },
        })
    }

    /// The value of an integer of the column, widened according to its sign.
    pub fn integer(&self, value: i64) -> f64 {
        match *self {
            Self::Number { digits, unsigned: true } => value as u64 as f64 / 10f64.powi(digits),
            Self::Number { digits, .. } => value as f64 / 10f64.powi(digits),
            Self::Seconds { per_second } | Self::Time { per_second, .. } => {
                // Whole seconds are converted separately, because not all nanoseconds since 1970 fit into a number.
                let (whole, part) = (value.div_euclid(per_second), value.rem_euclid(per_second));
                whole as f64 + part as f64 / per_second as f64
            }
            Self::Date => value as f64 * 86_400.0,
            Self::Half | Self::Text => f64::NAN,
        }
    }

    pub fn is_unsigned(&self) -> bool {
        matches!(self, Self::Number { unsigned: true, .. })
    }

    /// The value of the bytes of a cell, if they are a number.
    pub fn bytes(&self, bytes: &[u8]) -> parquet::errors::Result<f64> {
        match (self, bytes) {
            (Self::Half, [low, high]) => Ok(half(u16::from_le_bytes([*low, *high]))),
            // Decimals are big-endian in two's complement.
            (Self::Number { digits, .. }, [first, rest @ ..]) => {
                let first = f64::from(*first as i8);
                let whole = rest.iter().fold(first, |sum, byte| sum * 256.0 + f64::from(*byte));
                Ok(whole / 10f64.powi(*digits))
            }
            _ => Err(ParquetError::General(format!("a number of {} bytes", bytes.len()))),
        }
    }

    /// Numbers of the column, as cells.
    pub fn cells(&self, numbers: Vec<f64>) -> Cells {
        match *self {
            Self::Time { utc, .. } => Cells::Times { seconds: numbers, utc },
            Self::Date => Cells::Times { seconds: numbers, utc: false },
            _ => Cells::Numbers(numbers),
        }
    }
}

/// A half-precision number.
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    match exponent {
        0 => sign * fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => sign * f64::INFINITY,
        31 => f64::NAN,
        _ => sign * (1.0 + fraction / 1024.0) * 2f64.powi(exponent - 15),
    }
}
