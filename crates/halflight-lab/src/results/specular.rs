//! Rows of specular passes.

use super::table::Table;

/// Measurements of a specular pass in a setting.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecularRow {
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
    /// Name of the pass and the constants that the experiment sets.
    pub label: String,
    /// Pixels of glossy surfaces, once for each light.
    pub glossy: u64,
    /// Of these, pixels in fragments that were discarded.
    pub discarded: u64,
    /// Fragments gathered at each level, 0 first.
    pub rendered: Vec<u64>,
    /// Of these, fragments whose lobe was sampled by a grid.
    pub sampled: u64,
    /// Shadow rays.
    pub rays: u64,
    /// Time of the pass, the median, ms.
    pub ms: f64,
    /// NMSE₂ of the reflected radiance against converged lobes, without occluders where the pass has none.
    pub nmse2: f64,
    /// NMSE₂ against converged lobes with exact visibility.
    pub nmse2_visible: f64,
    /// Estimated NMSE₂ of these references themselves.
    pub noise: [f64; 2],
    /// Worker threads.
    pub threads: usize,
    /// Commit of the program.
    pub commit: String,
    /// Processor, cores and system.
    pub machine: String,
}

impl SpecularRow {
    /// Files of the picture and of the map of levels in the folder of the row's setting.
    pub fn pictures(&self) -> [String; 2] {
        [format!("{}.png", self.slug), format!("{}-fragments.png", self.slug)]
    }
}

/// Returns a table with a line for each row.
pub fn table(rows: &[SpecularRow]) -> Table {
    let line = |row: &SpecularRow| {
        let last = row.rendered.iter().rposition(|&count| count > 0).map_or(0, |level| level + 1);
        let levels: Vec<String> = row.rendered[..last].iter().map(u64::to_string).collect();
        [
            row.experiment.clone(),
            row.scene.clone(),
            row.size[0].to_string(),
            row.size[1].to_string(),
            row.label.clone(),
            row.glossy.to_string(),
            row.discarded.to_string(),
            row.rendered.iter().sum::<u64>().to_string(),
            levels.join(";"),
            row.sampled.to_string(),
            row.rays.to_string(),
            format!("{:.3}", row.ms),
            format!("{:.4e}", row.nmse2),
            format!("{:.4e}", row.nmse2_visible),
            format!("{:.1e}", row.noise[0]),
            format!("{:.1e}", row.noise[1]),
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
        "pass",
        "glossy",
        "discarded",
        "rendered",
        "rendered_by_level",
        "grids",
        "rays",
        "ms",
        "nmse2",
        "nmse2_visible",
        "reference_noise",
        "reference_noise_visible",
        "threads",
        "commit",
        "machine",
    ];
    Table::new(columns, rows.iter().map(line))
}
