//! Rows of indirect light.

use super::table::Table;

/// Share of the reference's mean below which a pixel counts as dark.
pub const DARK: f64 = 0.01;

/// Share of the reference's mean above which light at a dark pixel is a leak.
pub const LEAK: f64 = 0.05;

/// Measurements of a method for indirect light in a setting. Errors are those of the luminance of the indirect irradiance over receiver pixels, against one diffuse
/// reflection.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IndirectRow {
    /// Name of the setting in file names.
    pub setting: String,
    /// Name of the row in file names.
    pub slug: String,
    /// Name of the experiment.
    pub experiment: String,
    /// Name of the scene.
    pub scene: String,
    /// Image width and height, pixels.
    pub size: [u32; 2],
    /// Name of the method and the constants that the experiment sets.
    pub label: String,
    /// Name of the pipeline that renders direct light.
    pub direct: String,
    /// Points on the surfaces.
    pub points: u64,
    /// Sides of points that direct light reaches.
    pub lit: u64,
    /// Receivers at which light was gathered.
    pub records: u64,
    /// Shadow rays from points to the lights.
    pub light_rays: u64,
    /// Shadow rays between receivers and points.
    pub gather_rays: u64,
    /// Time to place the points, in the first frame, ms. Times below are medians of later frames.
    pub place_ms: f64,
    /// Time of direct light at the points, ms.
    pub light_ms: f64,
    /// Time to gather, or to inject and propagate, ms.
    pub transport_ms: f64,
    /// Time to interpolate or look up at pixels, ms.
    pub lookup_ms: f64,
    /// Time of all of the indirect stage, ms.
    pub indirect_ms: f64,
    /// Time of the frame without the indirect stage, ms.
    pub direct_ms: f64,
    /// NMSE₂, with the noise of the reference.
    pub nmse2: f64,
    /// Estimated NMSE₂ of the reference itself.
    pub reference_noise: f64,
    /// Ratio of the means, less 1.
    pub bias: f64,
    /// Pixels brighter than [`LEAK`] times the reference's mean where the reference is darker than [`DARK`] times its mean.
    pub leaks: u64,
    /// Pixels that see geometry.
    pub receivers: u64,
    /// Mean flicker along the scene's animation, its 99th percentile over the pixels, and the mean that the reference's noise makes; `None` where the
    /// experiment does not ask for it.
    pub flicker: Option<[f64; 3]>,
    /// Worker threads.
    pub threads: usize,
    /// Commit of the program.
    pub commit: String,
    /// Processor, cores and system.
    pub machine: String,
}

impl IndirectRow {
    /// Returns the root of NMSE₂ less the reference's noise, which is independent of the row's error; 0 where the noise is the larger of the two.
    pub fn relative_error(&self) -> f64 {
        (self.nmse2 - self.reference_noise).max(0.0).sqrt()
    }

    /// Files of the pictures in the folder of the row's setting: indirect irradiance, error, and the image with direct light.
    pub fn pictures(&self) -> [String; 3] {
        ["", "-error", "-whole"].map(|ending| format!("{}{ending}.png", self.slug))
    }
}

/// Returns a table with a line for each row.
pub fn table(rows: &[IndirectRow]) -> Table {
    let time = |ms: f64| format!("{ms:.3}");
    let line = |row: &IndirectRow| {
        let [mean, p99, noise] = row
            .flicker
            .map_or([const { String::new() }; 3], |flicker| flicker.map(|value| format!("{value:.4e}")));
        [
            row.experiment.clone(),
            row.scene.clone(),
            row.size[0].to_string(),
            row.size[1].to_string(),
            row.label.clone(),
            row.direct.clone(),
            row.points.to_string(),
            row.lit.to_string(),
            row.records.to_string(),
            row.light_rays.to_string(),
            row.gather_rays.to_string(),
            time(row.place_ms),
            time(row.light_ms),
            time(row.transport_ms),
            time(row.lookup_ms),
            time(row.indirect_ms),
            time(row.direct_ms),
            format!("{:.4}", row.relative_error()),
            format!("{:.4}", row.bias),
            row.leaks.to_string(),
            row.receivers.to_string(),
            format!("{:.4e}", row.nmse2),
            format!("{:.1e}", row.reference_noise),
            mean,
            p99,
            noise,
            row.threads.to_string(),
            row.commit.clone(),
            row.machine.clone(),
        ]
    };
    let columns = [
        "experiment",
        "scene",
        "width",
        "height",
        "method",
        "direct",
        "points",
        "lit",
        "records",
        "light_rays",
        "gather_rays",
        "place_ms",
        "light_ms",
        "transport_ms",
        "lookup_ms",
        "indirect_ms",
        "direct_ms",
        "relative_error",
        "bias",
        "leaks",
        "receivers",
        "nmse2",
        "reference_noise",
        "flicker_mean",
        "flicker_p99",
        "flicker_noise",
        "threads",
        "commit",
        "machine",
    ];
    Table::new(columns, rows.iter().map(line))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A made-up row whose reference has a noise of 1e-4.
    pub(crate) fn row(label: &str, indirect_ms: f64, nmse2: f64) -> IndirectRow {
        IndirectRow {
            label: label.to_string(),
            indirect_ms,
            nmse2,
            reference_noise: 1e-4,
            ..IndirectRow::default()
        }
    }

    #[test]
    fn the_noise_of_the_reference_is_no_error_of_the_row() {
        // Squares of 0.03 and 0.01: independent errors add up by their squares.
        assert!((row("", 1.0, 9e-4 + 1e-4).relative_error() - 0.03).abs() < 1e-12);
        assert_eq!(row("", 1.0, 5e-5).relative_error(), 0.0);
    }

    #[test]
    fn every_column_has_a_cell() {
        let mut flickering = row("gather points=500", 2.0, 0.01);
        flickering.flicker = Some([0.5, 0.25, 0.125]);
        let table = table(&[row("lpv", 1.0, 0.04), flickering]);
        assert!(table.lines.iter().all(|line| line.cells.len() == table.columns.len()));
        let place = table.columns.iter().position(|column| column == "flicker_mean").unwrap();
        assert_eq!(
            (table.lines[0].cells[place].as_str(), table.lines[1].cells[place].as_str()),
            ("", "5.0000e-1")
        );
    }
}
