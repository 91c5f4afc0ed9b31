//! Drawings put into files.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use anyhow::{Result, anyhow};
use halflight_metrics::{write_file, write_png};
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

use super::canvas::{Canvas, Drawn, FONT, SIZE};

/// Chart of any kind.
pub trait Drawing {
    /// Returns the title.
    fn title(&self) -> &str;

    /// Returns width and height, units.
    fn size(&self) -> (u32, u32) {
        SIZE
    }

    /// Draws the chart.
    ///
    /// # Errors
    /// Errors of the backend.
    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn<DB>;

    /// Returns the drawing as SVG.
    ///
    /// # Errors
    /// Drawing failed.
    fn svg(&self) -> Result<String> {
        check_font(self)?;
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, self.size()).into_drawing_area();
            drawn(self, self.draw(&Canvas { area: &area, scale: 1 }))?;
            drawn(self, area.present())?;
        }
        Ok(svg)
    }

    /// Returns width, height and sRGB pixels of the drawing.
    ///
    /// # Errors
    /// Drawing failed.
    fn pixels(&self) -> Result<(u32, u32, Vec<[u8; 3]>)> {
        check_font(self)?;
        // Twice the size of the SVG, for screens on which a unit is two pixels.
        const SCALE: u32 = 2;
        let size = (self.size().0 * SCALE, self.size().1 * SCALE);
        let mut bytes = vec![255; size.0 as usize * size.1 as usize * 3];
        {
            let area = BitMapBackend::with_buffer(&mut bytes, size).into_drawing_area();
            drawn(self, self.draw(&Canvas { area: &area, scale: SCALE as i32 }))?;
            drawn(self, area.present())?;
        }
        Ok((size.0, size.1, bytes.as_chunks().0.to_vec()))
    }

    /// Writes `path.svg` and `path.png`; the path itself may hold dots.
    ///
    /// # Errors
    /// Drawing or writing failed.
    fn write(&self, path: &Path) -> Result<()> {
        let ending = |ending: &str| {
            let mut name = path.as_os_str().to_os_string();
            name.push(ending);
            PathBuf::from(name)
        };
        let svg = self.svg()?;
        write_file(&ending(".svg"), svg.as_bytes())?;
        let (width, height, pixels) = self.pixels()?;
        write_png(&ending(".png"), width, height, &pixels)?;
        Ok(())
    }
}

/// Registers the font of the bitmap backend, which has none of its own. SVG viewers use theirs, with the measures of this one.
fn check_font(drawing: &(impl Drawing + ?Sized)) -> Result<()> {
    static FONT_REGISTERED: OnceLock<bool> = OnceLock::new();
    let there = *FONT_REGISTERED
        .get_or_init(|| register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).is_ok());
    drawn(drawing, if there { Ok(()) } else { Err("the font cannot be read") })
}

fn drawn<E: std::fmt::Display>(drawing: &(impl Drawing + ?Sized), result: Result<(), E>) -> Result<()> {
    result.map_err(|fault| anyhow!("chart {}: {fault}", drawing.title()))
}
