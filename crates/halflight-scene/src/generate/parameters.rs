//! Reads a generator's parameters, each with a default and a checked range.

use std::ops::RangeInclusive;

use super::GenerateError;

/// Parameters given to one generator; reading a key removes it.
pub(super) struct Parameters {
    generator: &'static str,
    given: toml::Table,
    known: Vec<&'static str>,
}

impl Parameters {
    pub(super) fn new(generator: &'static str, given: toml::Table) -> Self {
        Self { generator, given, known: Vec::new() }
    }

    /// Integer within `range`.
    pub(super) fn count(
        &mut self,
        key: &'static str,
        default: u32,
        range: RangeInclusive<u32>,
    ) -> Result<u32, GenerateError> {
        self.known.push(key);
        let Some(value) = self.given.remove(key) else { return Ok(default) };
        let whole = value.as_integer().and_then(|n| u32::try_from(n).ok());
        whole.filter(|n| range.contains(n)).ok_or_else(|| {
            self.bad(key, &value, format!("a whole number from {} to {}", range.start(), range.end()))
        })
    }

    /// A number within `range`.
    pub(super) fn number(
        &mut self,
        key: &'static str,
        default: f32,
        range: RangeInclusive<f32>,
    ) -> Result<f32, GenerateError> {
        self.known.push(key);
        let Some(value) = self.given.remove(key) else { return Ok(default) };
        let number = value.as_float().or_else(|| value.as_integer().map(|n| n as f64)).map(|n| n as f32);
        // NaN is in no range.
        number.filter(|n| range.contains(n)).ok_or_else(|| {
            self.bad(key, &value, format!("a number from {} to {}", range.start(), range.end()))
        })
    }

    /// Index of one of some names; the first by default.
    pub(super) fn choice(&mut self, key: &'static str, names: &[&str]) -> Result<usize, GenerateError> {
        self.known.push(key);
        let Some(value) = self.given.remove(key) else { return Ok(0) };
        let place = names.iter().position(|name| value.as_str() == Some(name));
        place.ok_or_else(|| self.bad(key, &value, format!("one of {}", names.join(", "))))
    }

    /// Refuses keys that were never read; to be called after all parameters were read.
    pub(super) fn finish(&self) -> Result<(), GenerateError> {
        match self.given.keys().next() {
            None => Ok(()),
            Some(key) => Err(GenerateError::UnknownParameter {
                generator: self.generator,
                key: key.clone(),
                known: self.known.clone(),
            }),
        }
    }

    fn bad(&self, key: &'static str, value: &toml::Value, expected: String) -> GenerateError {
        GenerateError::BadParameter { generator: self.generator, key, found: value.to_string(), expected }
    }
}
