//! Reader of the numbers of a PLY file.

use super::header::{Format, Property, Scalar};
use crate::text::{first_number, first_word, shown};

/// Reason for which a number cannot be read.
pub(super) enum Fault {
    /// End of the file.
    End,
    /// Other content.
    Other(String),
}

/// Reads numbers in the order of the file.
pub(super) struct Values<'a> {
    format: Format,
    rest: &'a [u8],
}

impl<'a> Values<'a> {
    pub(super) fn new(format: Format, rest: &'a [u8]) -> Self {
        Self { format, rest }
    }

    /// Number of bytes that are left, an upper limit on the number of values.
    pub(super) fn left(&self) -> usize {
        self.rest.len()
    }

    /// Reads the next number. Numbers in text are not rounded to their type.
    #[inline]
    pub(super) fn next(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        match self.format {
            Format::Ascii => self.next_word(),
            Format::LittleEndian => Ok(match scalar {
                Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
                Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
                Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
                Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
                Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
                Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
                Scalar::I64 => i64::from_le_bytes(self.take()?) as f64,
                Scalar::U64 => u64::from_le_bytes(self.take()?) as f64,
                Scalar::F32 => f32::from_le_bytes(self.take()?).into(),
                Scalar::F64 => f64::from_le_bytes(self.take()?),
            }),
            Format::BigEndian => Ok(match scalar {
                Scalar::I8 => i8::from_be_bytes(self.take()?).into(),
                Scalar::U8 => u8::from_be_bytes(self.take()?).into(),
                Scalar::I16 => i16::from_be_bytes(self.take()?).into(),
                Scalar::U16 => u16::from_be_bytes(self.take()?).into(),
                Scalar::I32 => i32::from_be_bytes(self.take()?).into(),
                Scalar::U32 => u32::from_be_bytes(self.take()?).into(),
                Scalar::I64 => i64::from_be_bytes(self.take()?) as f64,
                Scalar::U64 => u64::from_be_bytes(self.take()?) as f64,
                Scalar::F32 => f32::from_be_bytes(self.take()?).into(),
                Scalar::F64 => f64::from_be_bytes(self.take()?),
            }),
        }
    }

    /// Reads the length of a list.
    pub(super) fn count(&mut self, scalar: Scalar) -> Result<usize, Fault> {
        let count = self.next(scalar)?;
        match count {
            ..0.0 => Err(Fault::Other("Negative list count".to_string())),
            _ if count.fract() != 0.0 => Err(Fault::Other(format!("{count} is no length of a list"))),
            _ => Ok(count as usize),
        }
    }

    /// Skips the value of a property that is not used.
    pub(super) fn skip(&mut self, property: &Property) -> Result<(), Fault> {
        let count = property.count.map_or(Ok(1), |count| self.count(count))?;
        if self.format != Format::Ascii {
            let bytes = count.checked_mul(property.scalar.size()).filter(|&bytes| bytes <= self.rest.len());
            self.rest = &self.rest[bytes.ok_or(Fault::End)?..];
            return Ok(());
        }
        for _ in 0..count {
            self.next_word()?;
        }
        Ok(())
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let (bytes, rest) = self.rest.split_first_chunk().ok_or(Fault::End)?;
        self.rest = rest;
        Ok(*bytes)
    }

    fn next_word(&mut self) -> Result<f64, Fault> {
        match first_number(self.rest) {
            Some((Some(number), rest)) => {
                self.rest = rest;
                Ok(number)
            }
            Some((None, _)) if first_word(self.rest).0.is_empty() && !self.rest.contains(&b'#') => {
                Err(Fault::End)
            }
            _ => Err(Fault::Other(format!("`{}`, expected a number", shown(first_word(self.rest).0)))),
        }
    }
}
