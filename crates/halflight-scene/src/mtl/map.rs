//! Arguments of `map_Kd` and `map_d`: options, which begin with a dash, and a file.

use std::path::Path;

use glam::Vec2;

use crate::context::Context;
use crate::text::{first_number, first_word, trim};
use crate::{alpha, texture};

/// Transform of texture coordinates: scale, then offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct UvTransform {
    pub(crate) scale: Vec2,
    pub(crate) offset: Vec2,
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { scale: Vec2::ONE, offset: Vec2::ZERO }
    }
}

impl UvTransform {
    pub(crate) fn is_identity(&self) -> bool {
        *self == Self::default()
    }

    /// Bits of its numbers, for use as a key.
    pub(crate) fn bits(&self) -> [u32; 4] {
        [self.scale.x, self.scale.y, self.offset.x, self.offset.y].map(f32::to_bits)
    }
}

/// Texture map: its options and the name of its file.
#[derive(Default)]
pub(super) struct Map<'a> {
    uv: UvTransform,
    /// Options that change the image and are not supported.
    ignored: Vec<&'a [u8]>,
    /// Name as written in the file, possibly with a comment.
    name: &'a [u8],
}

/// The arguments of an option.
enum Arguments {
    /// Up to this many numbers.
    Numbers(usize),
    /// Word, with the value that has no effect.
    Word(&'static [u8]),
    /// Word that has no meaning for a colour.
    Unused,
}

fn arguments(option: &[u8]) -> Option<Arguments> {
    Some(match option {
        b"-s" | b"-o" | b"-t" => Arguments::Numbers(3),
        b"-mm" => Arguments::Numbers(2),
        b"-boost" => Arguments::Numbers(1),
        b"-blendu" | b"-blendv" => Arguments::Word(b"on"),
        b"-clamp" | b"-cc" => Arguments::Word(b"off"),
        b"-imfchan" | b"-texres" | b"-type" => Arguments::Word(b""),
        b"-bm" => Arguments::Unused,
        _ => return None,
    })
}

/// Reads the arguments of a map; `None` if they name no file.
pub(super) fn parse(arguments: &[u8]) -> Option<Map<'_>> {
    let mut map = Map::default();
    map.name = map.options(trim(arguments));
    (!first_word(map.name).0.is_empty()).then_some(map)
}

impl<'a> Map<'a> {
    /// Consumes the options at the start of `rest`.
    fn options(&mut self, mut rest: &'a [u8]) -> &'a [u8] {
        loop {
            let (option, after) = first_word(rest);
            let Some(arguments) = arguments(&option.to_ascii_lowercase()) else { return rest };
            rest = trim(match arguments {
                Arguments::Numbers(most) => self.numbers(option, after, most),
                Arguments::Word(without_effect) => {
                    let (value, after) = first_word(after);
                    if !value.eq_ignore_ascii_case(without_effect) {
                        self.ignored.push(option);
                    }
                    after
                }
                Arguments::Unused => first_word(after).1,
            });
        }
    }

    /// Consumes an option of at most `most` numbers; missing ones keep their values. Returns the remaining
    /// text.
    fn numbers(&mut self, option: &'a [u8], mut rest: &'a [u8], most: usize) -> &'a [u8] {
        let (start, neutral) = match option.to_ascii_lowercase().as_slice() {
            b"-s" => ([1.0, 1.0, 1.0], [1.0, 1.0, 1.0]),
            b"-mm" => ([0.0, 1.0, 0.0], [0.0, 1.0, 0.0]),
            _ => ([0.0; 3], [0.0; 3]),
        };
        let mut numbers = start;
        for place in numbers.iter_mut().take(most) {
            let Some((Some(number), after)) = first_number(rest) else { break };
            *place = number;
            rest = after;
        }
        let pair = Vec2::new(numbers[0] as f32, numbers[1] as f32);
        match option.to_ascii_lowercase().as_slice() {
            b"-s" if pair.is_finite() => self.uv.scale = pair,
            b"-o" if pair.is_finite() => self.uv.offset = pair,
            _ if numbers == neutral => {}
            _ => self.ignored.push(option),
        }
        rest
    }

    /// Map whose options follow the file name, as some programs write it; `None` if there are none.
    fn with_trailing_options(&self) -> Option<Self> {
        let starts = (1..self.name.len()).filter(|&at| self.name[at] == b'-' && self.name[at - 1] <= b' ');
        let start = starts.into_iter().find(|&at| arguments(first_word(&self.name[at..]).0).is_some())?;
        let mut map = Self { uv: self.uv, ignored: self.ignored.clone(), name: trim(&self.name[..start]) };
        let rest = map.options(&self.name[start..]);
        first_word(rest).0.is_empty().then_some(map)
    }
}

/// Statement that names an image.
#[derive(Clone, Copy)]
pub(super) enum Keyword {
    Kd,
    Alpha,
}

impl Keyword {
    /// Texture or alpha image that a library names, and the transform of texture coordinates; `None`, with a warning, if it is
    /// missing or cannot be decoded.
    pub(super) fn look_up(
        self,
        library: &Path,
        statement: Option<&(usize, Vec<u8>)>,
        context: &mut Context,
    ) -> (Option<u32>, UvTransform) {
        let parsed = statement.and_then(|(line, arguments)| Some((line, parse(arguments)?)));
        let Some((line, map)) = parsed else { return (None, UvTransform::default()) };
        let place = format!("{}:{line}: ", library.display());
        let folder = library.parent().unwrap_or(Path::new(""));
        let mut find = |map: &Map<'_>| texture::find(folder, map.name, context);
        let (found, map) = match find(&map) {
            Some(found) => (Some(found), map),
            None => match map.with_trailing_options() {
                Some(trailing) => (find(&trailing), trailing),
                None => (None, map),
            },
        };
        let (name, image) = match self {
            Self::Kd => ("map_Kd", texture::load(folder, map.name, found, &place, context)),
            Self::Alpha => ("map_d", alpha::load(folder, map.name, found, &place, context)),
        };
        let Some(image) = image else { return (None, UvTransform::default()) };
        for option in &map.ignored {
            let (library, option) = (library.display(), String::from_utf8_lossy(option));
            context.warn(format!("{library}: option {option} of {name} is not supported"));
        }
        (Some(image), map.uv)
    }
}
