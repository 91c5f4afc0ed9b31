//! Files of a run: a table, a page and pictures.

use std::path::Path;

use anyhow::Result;
use glam::Vec3;
use halflight_image::picture;
use halflight_metrics::{Image, tone_map, write_file, write_png};

use super::cases::Case;
use super::measure::Ready;
use super::methods::{self, Method};
use super::{Cell, Row, page};
use crate::results::{Provenance, Table};

/// Pixels a side to which small pictures are enlarged.
const SHOWN: u32 = 192;

/// Columns between the three parts of a picture, pixels.
const GAP: usize = 4;

/// Writes `robustness.csv` and `robustness.html`, which names the `command` that made it.
///
/// # Errors
/// A file cannot be written.
pub fn write(rows: &[Row], out: &Path, provenance: &Provenance, command: &str) -> Result<()> {
    table(rows, provenance).write_csv(&out.join("robustness.csv"))?;
    let html = page::whole(rows, provenance, command);
    write_file(&out.join("robustness.html"), html.as_bytes())?;
    Ok(())
}

/// Returns a table with a line for each case and method.
pub fn table(rows: &[Row], provenance: &Provenance) -> Table {
    let columns = [
        "case",
        "refiner",
        "visibility",
        "upsampler",
        "shading",
        "nmse2",
        "worst",
        "verdict",
        "times",
        "unshadowed",
        "why",
        "mends",
        "picture",
        "commit",
        "machine",
    ];
    let line = |row: &Row, cell: &Cell| {
        let [refiner, visibility, upsampler, shading] = cell.method.stages();
        let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.4e}"));
        [
            row.case.to_string(),
            refiner,
            visibility,
            upsampler,
            shading,
            number(cell.figure.map(|figure| figure.nmse2)),
            number(cell.figure.map(|figure| figure.worst)),
            cell.verdict.word().to_string(),
            cell.verdict.times().map_or(String::new(), |times| format!("{times:.1}")),
            number(Some(row.unshadowed)),
            cell.why.clone(),
            methods::set(&cell.mends),
            cell.picture.clone().unwrap_or_default(),
            provenance.commit.clone(),
            provenance.machine.clone(),
        ]
    };
    Table::new(columns, rows.iter().flat_map(|row| row.cells.iter().map(move |cell| line(row, cell))))
}

/// Writes the last picture, its reference and the error between them, side by side. Returns the file's name.
pub(super) fn picture(
    out: &Path,
    case: &Case,
    method: &Method,
    pictures: &[Vec<Vec3>],
    ready: &Ready,
) -> Result<String> {
    let folder = out.join("pictures").join(case.name);
    fs_err::create_dir_all(&folder)?;
    let name = format!("pictures/{}/{}.png", case.name, method.slug());
    let [width, height] = case.size;
    let last = |images: &[Vec<Vec3>]| images.last().cloned().unwrap_or_default();
    let (image, reference, brightest) = (last(pictures), last(&ready.references), last(&ready.unshadowed));
    let peak = brightest.iter().fold(0.0f32, |peak, value| peak.max(value.max_element()));
    let exposure = if peak > 0.0 { 1.0 / peak } else { 1.0 };
    let view = |pixels| Image::new(width, height, pixels)?.with_mask(&ready.mask);
    // Black references and broken pictures have no map.
    let map = picture::error(view(&image)?, view(&reference)?, picture::ERROR_SCALE);
    let map = map.unwrap_or_else(|_| vec![[96; 3]; image.len()]);
    let parts = [tone_map(&image, exposure), tone_map(&reference, exposure), map];
    let (side, rgb) = side_by_side(&parts, case.size);
    write_png(&out.join(&name), side[0], side[1], &rgb)?;
    Ok(name)
}

/// Returns three pictures of one size in a row, small ones enlarged by a whole factor.
fn side_by_side(parts: &[Vec<[u8; 3]>; 3], [width, height]: [u32; 2]) -> ([u32; 2], Vec<[u8; 3]>) {
    let zoom = (SHOWN / width.max(height)).max(1) as usize;
    let (columns, rows) = (width as usize, height as usize);
    let mut rgb = Vec::new();
    for y in 0..rows * zoom {
        for (number, part) in parts.iter().enumerate() {
            if number > 0 {
                rgb.extend([[255; 3]; GAP]);
            }
            rgb.extend((0..columns * zoom).map(|x| part[y / zoom * columns + x / zoom]));
        }
    }
    ([(3 * columns * zoom + 2 * GAP) as u32, (rows * zoom) as u32], rgb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_stand_side_by_side_enlarged() {
        let part = |value: u8| vec![[value; 3], [value + 1; 3]];
        let ([width, height], rgb) = side_by_side(&[part(10), part(20), part(30)], [2, 1]);
        assert_eq!([width, height], [3 * SHOWN + 2 * GAP as u32, SHOWN / 2]);
        assert_eq!(rgb.len(), (width * height) as usize);
        let row = &rgb[..width as usize];
        let part = SHOWN as usize;
        assert_eq!([row[0][0], row[part - 1][0], row[part][0]], [10, 11, 255]);
        assert_eq!([row[part + GAP][0], row[width as usize - 1][0]], [20, 31]);
    }
}
