//! Errors against one constant of a backend.

use indexmap::IndexMap;

use crate::experiment::parameter;
use crate::results::Finished;

/// Rows of a setting that differ in the constant alone, by ascending value.
pub struct Curve<'a> {
    /// Backend and the other constants.
    pub name: String,
    /// Values of the constant and rows.
    pub points: Vec<(f64, &'a Finished)>,
}

/// Returns the curves of the rows of a setting, in the order of their first rows; those of one row are left out.
pub fn curves<'a>(rows: &[&'a Finished], constant: &str) -> Vec<Curve<'a>> {
    let mut found: IndexMap<String, Vec<(f64, &Finished)>> = IndexMap::new();
    for &row in rows {
        let Some((value, rest)) = parameter(&row.record.parameters, constant) else { continue };
        let name = format!("{} {rest}", row.record.visibility).trim_end().to_string();
        found.entry(name).or_default().push((value, row));
    }
    let several = found.into_iter().filter(|(_, points)| points.len() > 1);
    let curve = |(name, mut points): (String, Vec<(f64, &'a Finished)>)| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Curve { name, points }
    };
    several.map(curve).collect()
}
