//! Bars of two quantities of each row, side by side.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::canvas::{Canvas, Drawn, INK, NOISE, SIZE};
use super::drawing::Drawing;

/// Bar chart from 0, one line a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Bars {
    /// Title.
    pub title: String,
    /// Names of the quantities.
    pub quantities: [String; 2],
    /// Unit of both.
    pub unit: String,
    /// Line below the bars.
    pub note: String,
    /// Rows, top to bottom.
    pub bars: Vec<Bar>,
}

/// Bars of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// Name of the row.
    pub name: String,
    /// Values of the quantities.
    pub values: [f64; 2],
    /// Colour, sRGB.
    pub rgb: [u8; 3],
}

/// Left and right ends of the names and of each quantity's bars; figures stand right of the bars.
const NAMES: i32 = 400;
const COLUMNS: [(i32, i32); 2] = [(416, 820), (930, 1310)];
/// Top of the first line, and lowest bottom of the last.
const LINES: (i32, i32) = (110, 716);
/// Largest height of a line.
const TALLEST: i32 = 34;

impl Drawing for Bars {
    fn title(&self) -> &str {
        &self.title
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn<DB> {
        canvas.area.fill(&WHITE)?;
        canvas.text(&self.title, (24, 14), 22, INK, HPos::Left)?;
        canvas.text(&self.unit, (24, 44), 15, INK, HPos::Left)?;
        canvas.text(&self.note, (24, SIZE.1 as i32 - 30), 14, NOISE, HPos::Left)?;
        let height = ((LINES.1 - LINES.0) / (self.bars.len() as i32).max(1)).clamp(1, TALLEST);
        let size = (height - 2).clamp(6, 15);
        for (column, ((left, right), quantity)) in COLUMNS.into_iter().zip(&self.quantities).enumerate() {
            canvas.text(quantity, (left, LINES.0 - 26), 15, INK, HPos::Left)?;
            let finite = self.bars.iter().map(|bar| bar.values[column]).filter(|value| value.is_finite());
            let longest = finite.fold(0.0, f64::max);
            for (line, bar) in (0..).zip(&self.bars) {
                let value = bar.values[column];
                let share = if longest > 0.0 { (value / longest).clamp(0.0, 1.0) } else { 0.0 };
                let end = left + (share * f64::from(right - left)).round() as i32;
                let (top, bottom) =
                    (LINES.0 + line * height, LINES.0 + (line + 1) * height - 3.min(height - 1));
                let [r, g, b] = bar.rgb;
                canvas
                    .polygon([(left, top), (end, top), (end, bottom), (left, bottom)], RGBColor(r, g, b))?;
                let middle = (top + bottom - size) / 2;
                canvas.text(&format!("{value:.2e}"), (end + 8, middle), size, INK, HPos::Left)?;
                if column == 0 {
                    canvas.text(&bar.name, (NAMES, middle), size, INK, HPos::Right)?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bars(count: usize) -> Bars {
        let bar = |index: usize| Bar {
            name: format!("row {index}"),
            values: [index as f64, 10.0 * index as f64],
            rgb: [0, 114, 178],
        };
        Bars {
            title: "A hall".to_string(),
            quantities: ["mean".to_string(), "most".to_string()],
            unit: "metres".to_string(),
            note: "a note".to_string(),
            bars: (0..count).map(bar).collect(),
        }
    }

    #[test]
    fn the_svg_names_everything_and_lengths_are_shares_of_the_longest() {
        let svg = bars(3).svg().unwrap();
        for words in ["A hall", "mean", "most", "metres", "a note", "row 0", "row 2", "2.00e0", "2.00e1"] {
            assert!(svg.contains(words), "{words} is missing");
        }
        // From 416 to 820, half of it, and nothing.
        for points in ["820,", "618,"] {
            assert!(svg.contains(points), "{points} is missing");
        }
    }

    #[test]
    fn none_many_and_what_is_not_finite_are_drawn() {
        let mut odd = bars(200);
        odd.bars[3].values = [f64::NAN, f64::INFINITY];
        for bars in [bars(0), odd] {
            let (width, height, pixels) = bars.pixels().unwrap();
            assert_eq!(pixels.len(), (width * height) as usize);
            assert!(pixels.iter().any(|pixel| pixel[0] < 128), "there is ink");
        }
    }
}
