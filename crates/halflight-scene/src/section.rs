//! Table of a scene file, read key by key, so that every fault names its line and a valid value.

use glam::{DVec3, Vec3};
use serde::Deserialize;
use serde::de::IntoDeserializer;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{Place, SceneError};

/// Text of a scene file and the name that error messages use.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) name: &'a str,
    pub(crate) text: &'a str,
    /// Byte offsets of its line ends, from [`line_ends`].
    pub(crate) line_ends: &'a [usize],
}

/// Byte offsets of the line ends of `text`, by which lines are found without counting.
pub(crate) fn line_ends(text: &str) -> Vec<usize> {
    text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n').map(|(at, _)| at).collect()
}

impl Source<'_> {
    /// Line, counted from 1, that contains byte `offset`.
    pub(crate) fn line(self, offset: usize) -> usize {
        1 + self.line_ends.partition_point(|&end| end < offset)
    }

    /// A fault on `line`.
    pub(crate) fn fault(self, line: usize, message: impl Into<String>) -> SceneError {
        SceneError::Invalid { file: self.name.to_string(), place: Place::Line(line), message: message.into() }
    }
}

/// Table whose keys are taken one by one.
pub(crate) struct Section<'a> {
    pub(crate) source: Source<'a>,
    /// Name of the table in messages: `[camera]`.
    title: String,
    /// Line of the table's header, for keys that are missing.
    pub(crate) line: usize,
    table: DeTable<'a>,
}

/// Value that was found under a key.
pub(crate) struct Found<T> {
    pub(crate) value: T,
    pub(crate) line: usize,
}

impl<'a> Section<'a> {
    /// Section of the table in `value`, or a fault if it is not a table.
    pub(crate) fn new(
        source: Source<'a>,
        title: &str,
        value: Spanned<DeValue<'a>>,
    ) -> Result<Self, SceneError> {
        let line = source.line(value.span().start);
        match value.into_inner() {
            DeValue::Table(table) => Ok(Self::of_table(source, title, line, table)),
            other => Err(source.fault(line, format!("{title} is {}, expected a table", describe(&other)))),
        }
    }

    pub(crate) fn of_table(source: Source<'a>, title: &str, line: usize, table: DeTable<'a>) -> Self {
        Self { source, title: title.to_string(), line, table }
    }

    /// A fault on `line`, its message beginning with the section's title.
    pub(crate) fn fault(&self, line: usize, message: impl AsRef<str>) -> SceneError {
        self.source.fault(line, format!("{} {}", self.title, message.as_ref()))
    }

    /// Refuses keys other than `known`. Comes before any key is taken, so that a misspelt key is called that
    /// and not missing.
    pub(crate) fn allow(&self, known: &[&str]) -> Result<(), SceneError> {
        let unknown = self.table.keys().filter(|key| !known.contains(&key.get_ref().as_ref()));
        match unknown.min_by_key(|key| key.span().start) {
            None => Ok(()),
            Some(key) => {
                let line = self.source.line(key.span().start);
                let message =
                    format!("has an unknown key `{}`; known keys: {}", key.get_ref(), known.join(", "));
                Err(self.fault(line, message))
            }
        }
    }

    /// True if there is a value under `key`.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// Takes the value of `key`, if it is there.
    pub(crate) fn take(&mut self, key: &str) -> Option<Spanned<DeValue<'a>>> {
        self.table.remove(key)
    }

    /// Takes `key` and reads it with `read`, which returns the expected format if the value does not fit.
    fn read<T>(
        &mut self,
        key: &str,
        expected: &str,
        read: impl FnOnce(&DeValue<'a>) -> Option<T>,
    ) -> Result<Option<Found<T>>, SceneError> {
        let Some(value) = self.take(key) else { return Ok(None) };
        let line = self.source.line(value.span().start);
        match read(value.get_ref()) {
            Some(value) => Ok(Some(Found { value, line })),
            None => {
                let found = describe(value.get_ref());
                Err(self.fault(line, format!("{key} is {found}, expected {expected}")))
            }
        }
    }

    /// Returns the value, or a fault with an example.
    pub(crate) fn require<T>(&self, key: &str, example: &str, found: Option<T>) -> Result<T, SceneError> {
        found.ok_or_else(|| {
            self.fault(self.line, format!("has no `{key}`; write for example: {key} = {example}"))
        })
    }

    /// Reads a finite number.
    pub(crate) fn number(&mut self, key: &str) -> Result<Option<Found<f32>>, SceneError> {
        self.read(key, "a finite number", number)
    }

    /// Reads an integer below `count`.
    pub(crate) fn index(&mut self, key: &str, count: usize) -> Result<Option<usize>, SceneError> {
        let expected = format!("a whole number from 0 to {}", count.saturating_sub(1));
        let read = |value: &DeValue<'_>| number(value).filter(|index| index.fract() == 0.0 && *index >= 0.0);
        let index = self.read(key, &expected, |value| {
            read(value).map(|index| index as usize).filter(|&index| index < count)
        })?;
        Ok(index.map(|index| index.value))
    }

    /// Reads three finite numbers.
    pub(crate) fn vector(&mut self, key: &str) -> Result<Option<Found<Vec3>>, SceneError> {
        self.read(key, "three finite numbers", vector)
    }

    /// Reads a list of triples of finite numbers.
    pub(crate) fn vectors(&mut self, key: &str) -> Result<Option<Found<Vec<Vec3>>>, SceneError> {
        self.read(key, "a list of triples of finite numbers", |value| {
            value.as_array()?.iter().map(|item| vector(item.get_ref())).collect()
        })
    }

    /// Reads three finite numbers in double precision.
    pub(crate) fn double_vector(&mut self, key: &str) -> Result<Option<Found<DVec3>>, SceneError> {
        self.read(key, "three finite numbers", double_vector)
    }

    /// Reads one finite number for all three axes, or three, in double precision.
    pub(crate) fn number_or_vector(&mut self, key: &str) -> Result<Option<Found<DVec3>>, SceneError> {
        self.read(key, "a finite number or three", |value| {
            double(value).map(DVec3::splat).or_else(|| double_vector(value))
        })
    }

    /// Reads a text.
    pub(crate) fn text(&mut self, key: &str) -> Result<Option<Found<String>>, SceneError> {
        self.read(key, "a text in quotes", |value| value.as_str().map(str::to_string))
    }

    /// Reads `true` or `false`.
    pub(crate) fn flag(&mut self, key: &str) -> Result<Option<Found<bool>>, SceneError> {
        self.read(key, "true or false", DeValue::as_bool)
    }

    /// Returns everything that was not taken, as plain values, and the line of each key.
    pub(crate) fn rest(self) -> Result<(toml::Table, Vec<(String, usize)>), SceneError> {
        let mut values = toml::Table::new();
        let mut lines = Vec::new();
        let (source, title) = (self.source, self.title);
        for (key, value) in self.table {
            let line = source.line(key.span().start);
            let key = key.into_inner().into_owned();
            let value = toml::Value::deserialize(value.into_deserializer())
                .map_err(|fault| source.fault(line, format!("{title} {key}: {}", fault.message())))?;
            lines.push((key.clone(), line));
            values.insert(key, value);
        }
        Ok((values, lines))
    }
}

/// The text of a decimal number.
fn decimal<'v>(value: &'v DeValue<'_>) -> Option<&'v str> {
    match value {
        DeValue::Float(float) => Some(float.as_str()),
        DeValue::Integer(integer) if integer.radix() == 10 => Some(integer.as_str()),
        _ => None,
    }
}

fn number(value: &DeValue<'_>) -> Option<f32> {
    decimal(value)?.parse().ok().filter(|number: &f32| number.is_finite())
}

fn double(value: &DeValue<'_>) -> Option<f64> {
    decimal(value)?.parse().ok().filter(|number: &f64| number.is_finite())
}

fn three<T>(value: &DeValue<'_>, read: impl Fn(&DeValue<'_>) -> Option<T>) -> Option<[T; 3]> {
    let items = value.as_array()?;
    let [x, y, z] = items.as_ref() else { return None };
    Some([read(x.get_ref())?, read(y.get_ref())?, read(z.get_ref())?])
}

fn vector(value: &DeValue<'_>) -> Option<Vec3> {
    three(value, number).map(Vec3::from_array)
}

fn double_vector(value: &DeValue<'_>) -> Option<DVec3> {
    three(value, double).map(DVec3::from_array)
}

/// Value as shown in messages.
fn describe(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("the text `{text}`"),
        DeValue::Integer(integer) => integer.to_string(),
        DeValue::Float(float) => float.to_string(),
        DeValue::Boolean(flag) => flag.to_string(),
        DeValue::Datetime(date) => format!("the date {date}"),
        DeValue::Array(items) => {
            let items: Vec<String> = items.iter().map(|item| describe(item.get_ref())).collect();
            format!("[{}]", items.join(", "))
        }
        DeValue::Table(_) => "a table".to_string(),
    }
}

/// Sections of the array of tables under `key`; `path` is the full dotted key.
pub(crate) fn tables<'a>(
    parent: &mut Section<'a>,
    key: &str,
    path: &str,
) -> Result<Vec<Section<'a>>, SceneError> {
    let Some(value) = parent.take(key) else { return Ok(Vec::new()) };
    let title = format!("[[{path}]]");
    let line = parent.source.line(value.span().start);
    match value.into_inner() {
        DeValue::Array(items) => {
            items.into_iter().map(|item| Section::new(parent.source, &title, item)).collect()
        }
        _ => {
            let message = format!("has a single [{path}]; write {title}, of which there may be several");
            Err(parent.fault(line, message))
        }
    }
}
