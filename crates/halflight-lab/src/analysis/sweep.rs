//! Errors against one constant of a backend.

use crate::experiment::parameter;
use crate::results::Finished;

/// Rows of a setting that differ in the constant alone, by ascending value.
pub struct Curve<'a> {
    /// Backend and the other constants.
    pub name: String,
    /// Values of the constant and rows.
    pub points: Vec<(f64, &'a Finished)>,
}

/// Curves of the rows of a setting, in the order of their first rows; those of one row are left out.
pub fn curves<'a>(rows: &[&'a Finished], constant: &str) -> Vec<Curve<'a>> {
    let mut curves: Vec<Curve> = Vec::new();
    for row in rows {
        let Some((value, rest)) = parameter(&row.record.parameters, constant) else { continue };
        let name = format!("{} {rest}", row.record.visibility).trim_end().to_string();
        match curves.iter_mut().find(|curve| curve.name == name) {
            Some(curve) => curve.points.push((value, row)),
            None => curves.push(Curve { name, points: vec![(value, row)] }),
        }
    }
    curves.retain(|curve| curve.points.len() > 1);
    curves.iter_mut().for_each(|curve| curve.points.sort_by(|a, b| a.0.total_cmp(&b.0)));
    curves
}
