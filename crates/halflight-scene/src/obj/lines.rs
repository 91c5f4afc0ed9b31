//! The lines of an OBJ file, checked before tobj sees them.

use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};

use crate::error::{Place, SceneError};
use crate::report::LoadReport;

/// Faces that tobj gets in one piece: it needs over a hundred bytes for each until the piece is done.
const FACES_PER_PIECE: usize = 1 << 16;

/// Hands an OBJ file to tobj line by line.
///
/// tobj's own errors name no line, so that numbers and indices are checked here; with mixed faces (some corners with
/// texture coordinates or normals, some without) its arrays go out of step, so that a new group begins wherever the
/// layout of the faces changes. Statements that are not used stay here.
pub(crate) struct CheckedLines<R> {
    inner: R,
    path: PathBuf,
    /// The line last read, counted from 1.
    line: usize,
    raw: Vec<u8>,
    /// What tobj reads next, from `at` on.
    out: Vec<u8>,
    at: usize,
    /// Positions, texture coordinates and normals so far.
    counts: [usize; 3],
    layout: Layout,
    faces_in_piece: usize,
    corners: Vec<Corner>,
    /// Names and lines of the materials in use, the first of each run.
    pub(crate) materials: Vec<(String, usize)>,
    /// Why reading stopped.
    pub(crate) fault: Option<SceneError>,
    notes: Vec<(&'static str, usize)>,
}

/// Indices into positions, texture coordinates and normals, counted from 1. The first is always there.
type Corner = [Option<i64>; 3];

/// Whether the corners of a face have texture coordinates and normals.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
struct Layout {
    uv: bool,
    normal: bool,
}

impl<R: BufRead> CheckedLines<R> {
    pub(crate) fn new(path: &Path, inner: R) -> Self {
        Self {
            inner,
            path: path.to_path_buf(),
            line: 0,
            raw: Vec::new(),
            out: Vec::new(),
            at: 0,
            counts: [0; 3],
            layout: Layout::default(),
            faces_in_piece: 0,
            corners: Vec::new(),
            materials: Vec::new(),
            fault: None,
            notes: Vec::new(),
        }
    }

    /// Says what was left out, once each.
    pub(crate) fn report(&self, report: &mut LoadReport) {
        for (note, line) in &self.notes {
            report.warn(format!("{}: {note}, first on line {line}", self.path.display()));
        }
    }

    fn note(&mut self, note: &'static str) {
        if !self.notes.iter().any(|(known, _)| *known == note) {
            self.notes.push((note, self.line));
        }
    }

    fn invalid(&self, message: impl Into<String>) -> SceneError {
        SceneError::invalid(&self.path, Place::Line(self.line), message)
    }

    /// Reads lines until one is for tobj; `out` stays empty at the end of the file.
    fn advance(&mut self) -> Result<(), SceneError> {
        self.out.clear();
        self.at = 0;
        while self.out.is_empty() {
            self.raw.clear();
            let mut continued = 0;
            loop {
                let read = self.inner.read_until(b'\n', &mut self.raw);
                if read.map_err(|source| SceneError::Read { path: self.path.clone(), source })? == 0 {
                    break;
                }
                continued += 1;
                // A backslash at its end continues a line.
                let end = self.raw.trim_ascii_end().len();
                if self.raw[..end].last() != Some(&b'\\') || self.raw.trim_ascii_start().starts_with(b"#") {
                    break;
                }
                self.raw.truncate(end - 1);
                self.raw.push(b' ');
            }
            if continued == 0 {
                return Ok(());
            }
            self.line += 1;
            let raw = std::mem::take(&mut self.raw);
            self.statement(raw.trim_ascii())?;
            self.raw = raw;
            // Faults name the first of the lines that belong together.
            self.line += continued - 1;
        }
        Ok(())
    }

    fn statement(&mut self, line: &[u8]) -> Result<(), SceneError> {
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        let (keyword, rest) = (&line[..end], line[end..].trim_ascii());
        match keyword {
            b"v" => self.position(rest),
            b"vt" => self.texture_coordinate(rest),
            b"vn" => self.normal(rest),
            b"f" => self.face(rest),
            b"usemtl" => {
                let name = String::from_utf8_lossy(rest).into_owned();
                if name.is_empty() {
                    return Err(self.invalid("usemtl without a name, expected: usemtl NAME"));
                }
                self.put("usemtl", &name);
                self.materials.push((name, self.line));
                Ok(())
            }
            b"mtllib" => {
                let name = String::from_utf8_lossy(rest).into_owned();
                self.put("mtllib", &name);
                Ok(())
            }
            b"curv" | b"curv2" | b"surf" => {
                self.note("curves and free-form surfaces are not supported");
                Ok(())
            }
            // Groups, smoothing, points, lines and whatever else is there does not change the triangles.
            _ => Ok(()),
        }
    }

    fn put(&mut self, keyword: &str, rest: &str) {
        self.out.extend_from_slice(keyword.as_bytes());
        self.out.push(b' ');
        self.out.extend_from_slice(rest.as_bytes());
        self.out.push(b'\n');
    }

    /// The numbers of a line, at most eight: how many there are, and the numbers.
    fn numbers<'r>(&self, rest: &'r [u8], what: &str) -> Result<(usize, [f32; 8], &'r str), SceneError> {
        let mut numbers = [0.0; 8];
        let mut count = 0;
        let text = str::from_utf8(rest).ok();
        let fault = || {
            let shown = String::from_utf8_lossy(rest);
            self.invalid(format!("`{what} {shown}`, expected numbers after {what}"))
        };
        let text = text.ok_or_else(fault)?.split('#').next().unwrap_or_default().trim_ascii_end();
        for word in text.split_ascii_whitespace() {
            let number: f32 = word.parse().map_err(|_| fault())?;
            if count < numbers.len() {
                numbers[count] = number;
            }
            count += 1;
        }
        Ok((count, numbers, text))
    }

    fn position(&mut self, rest: &[u8]) -> Result<(), SceneError> {
        let (count, numbers, text) = self.numbers(rest, "v")?;
        // A fourth number divides the others; three after the position are a colour.
        let divisor = if count == 4 { numbers[3] } else { 1.0 };
        if count < 3 {
            return Err(self.invalid(format!("`v {text}`, expected three coordinates")));
        }
        if !numbers[..3].iter().all(|number| (number / divisor).is_finite()) || !divisor.is_finite() {
            return Err(self.invalid(format!("`v {text}` is not a finite position")));
        }
        if count > 4 {
            self.note("vertex colours are not used");
        }
        let [x, y, z] = [numbers[0], numbers[1], numbers[2]].map(|number| number / divisor);
        self.counts[0] += 1;
        if count == 3 {
            self.put("v", text);
        } else {
            self.put("v", &format!("{x} {y} {z}"));
        }
        Ok(())
    }

    fn texture_coordinate(&mut self, rest: &[u8]) -> Result<(), SceneError> {
        let (count, numbers, text) = self.numbers(rest, "vt")?;
        if count == 0 || !numbers[..2].iter().all(|number| number.is_finite()) {
            return Err(self.invalid(format!("`vt {text}`, expected one to three finite numbers")));
        }
        self.counts[1] += 1;
        if count >= 2 {
            self.put("vt", text);
        } else {
            self.put("vt", &format!("{text} 0"));
        }
        Ok(())
    }

    fn normal(&mut self, rest: &[u8]) -> Result<(), SceneError> {
        let (count, numbers, text) = self.numbers(rest, "vn")?;
        if count < 3 {
            return Err(self.invalid(format!("`vn {text}`, expected three numbers")));
        }
        self.counts[2] += 1;
        // Exporters write NaN for the normals of triangles without an area. Zero is "to be computed".
        let finite = numbers[..3].iter().all(|number| number.is_finite());
        self.put("vn", if finite { text } else { "0 0 0" });
        Ok(())
    }

    fn face(&mut self, rest: &[u8]) -> Result<(), SceneError> {
        let Ok(text) = str::from_utf8(rest) else {
            return Err(
                self.invalid("a face that is not text, expected indices such as: f 1/1/1 2/2/2 3/3/3")
            );
        };
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        let text = text.split('#').next().unwrap_or_default();
        for word in text.split_ascii_whitespace() {
            corners.push(self.corner(word)?);
        }
        if corners.len() < 3 {
            self.note("faces of fewer than three corners are left out");
        } else {
            self.put_face(&corners);
        }
        self.corners = corners;
        Ok(())
    }

    fn put_face(&mut self, corners: &[Corner]) {
        let layout = Layout {
            uv: corners.iter().all(|corner| corner[1].is_some()),
            normal: corners.iter().all(|corner| corner[2].is_some()),
        };
        self.faces_in_piece += 1;
        if layout != self.layout || self.faces_in_piece > FACES_PER_PIECE {
            self.out.extend_from_slice(b"g\n");
            self.layout = layout;
            self.faces_in_piece = 1;
        }
        self.out.push(b'f');
        for [position, uv, normal] in corners {
            self.out.push(b' ');
            self.put_index(*position);
            if layout.uv || layout.normal {
                self.out.push(b'/');
                self.put_index(uv.filter(|_| layout.uv));
            }
            if layout.normal {
                self.out.push(b'/');
                self.put_index(*normal);
            }
        }
        self.out.push(b'\n');
    }

    fn put_index(&mut self, index: Option<i64>) {
        if let Some(index) = index {
            let mut digits = [0; 20];
            let mut at = digits.len();
            let mut rest = index;
            while rest > 0 {
                at -= 1;
                digits[at] = b'0' + (rest % 10) as u8;
                rest /= 10;
            }
            self.out.extend_from_slice(&digits[at..]);
        }
    }

    /// A corner's indices into positions, texture coordinates and normals, counted from 1.
    fn corner(&self, word: &str) -> Result<Corner, SceneError> {
        let mut indices = [None; 3];
        let mut parts = word.split('/');
        for (kind, index) in indices.iter_mut().enumerate() {
            *index = match parts.next() {
                None | Some("") => None,
                Some(part) => Some(self.index(part, kind)?),
            };
        }
        if indices[0].is_none() || parts.next().is_some() {
            let message = format!("face corner `{word}`, expected VERTEX, VERTEX/UV or VERTEX/UV/NORMAL");
            return Err(self.invalid(message));
        }
        Ok(indices)
    }

    fn index(&self, part: &str, kind: usize) -> Result<i64, SceneError> {
        let count = self.counts[kind] as i64;
        let what = ["vertex", "texture coordinate", "normal"][kind];
        let index: i64 = part
            .parse()
            .map_err(|_| self.invalid(format!("face index `{part}`, expected a whole number")))?;
        match index {
            1.. if index <= count => Ok(index),
            // Negative indices count back from the latest.
            ..=-1 if -count <= index => Ok(count + 1 + index),
            _ => {
                let message = format!(
                    "face refers to {what} {index}, but {count} are defined so far, which count from 1 (or back from -1)"
                );
                Err(self.invalid(message))
            }
        }
    }
}

impl<R: BufRead> Read for CheckedLines<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(into)?;
        self.consume(read);
        Ok(read)
    }
}

impl<R: BufRead> BufRead for CheckedLines<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.at >= self.out.len()
            && let Err(fault) = self.advance()
        {
            self.fault = Some(fault);
            return Err(io::ErrorKind::InvalidData.into());
        }
        Ok(&self.out[self.at..])
    }

    fn consume(&mut self, count: usize) {
        self.at += count;
    }
}
