//! Positions of light samples, a block at a time, in a form the compiler turns into vector code.

use glam::Vec3;
use halflight_core::hash;
use halflight_core::light::AreaLight;
use halflight_core::pattern::{Pattern, PatternKind};

/// Light samples that are evaluated together.
pub(crate) const LANES: usize = 16;

/// Positions of samples `first .. first + LANES` as one array an axis: bit for bit those of [`Pattern::position`] and
/// [`AreaLight::point`]. Samples past the end of the pattern are finite and mean nothing.
#[inline(always)]
pub(crate) fn positions(light: &AreaLight, pattern: Pattern, key: u32, first: usize) -> [[f32; LANES]; 3] {
    let (columns, rows) = (u32::from(pattern.columns), u32::from(pattern.rows));
    let (scale_u, scale_v) = (1.0 / columns as f32, 1.0 / rows as f32);
    let mut u = [0.0f32; LANES];
    let mut v = [0.0f32; LANES];
    let mut column = [0u32; LANES];
    let mut row = [0u32; LANES];
    // Powers of two are the common case and need no division.
    if columns.is_power_of_two() {
        let shift = columns.trailing_zeros();
        for lane in 0..LANES {
            let index = (first + lane) as u32;
            (column[lane], row[lane]) = (index & (columns - 1), index >> shift);
        }
    } else {
        for lane in 0..LANES {
            let index = (first + lane) as u32;
            (column[lane], row[lane]) = (index % columns, index / columns);
        }
    }
    match pattern.kind {
        PatternKind::Grid => {
            for lane in 0..LANES {
                (u[lane], v[lane]) =
                    ((column[lane] as f32 + 0.5) * scale_u, (row[lane] as f32 + 0.5) * scale_v);
            }
        }
        PatternKind::ShiftedRows | PatternKind::Jittered => {
            let by_row = pattern.kind == PatternKind::ShiftedRows;
            for lane in 0..LANES {
                let index = if by_row { row[lane] } else { (first + lane) as u32 };
                let (du, dv) = hash::unit_pair(hash::sample_bits(key, index));
                (u[lane], v[lane]) =
                    ((column[lane] as f32 + du) * scale_u, (row[lane] as f32 + dv) * scale_v);
            }
        }
    }
    let mut out = [[0.0f32; LANES]; 3];
    for (axis, out) in out.iter_mut().enumerate() {
        let (corner, edge_u, edge_v) = (light.corner[axis], light.edge_u[axis], light.edge_v[axis]);
        for lane in 0..LANES {
            out[lane] = corner + edge_u * u[lane] + edge_v * v[lane];
        }
    }
    out
}

/// Geometry terms `cosθx cosθy / r²` of a block of samples, 0 below either horizon; `facing` is the light's normal with
/// its side resolved towards the receiver.
#[inline(always)]
pub(crate) fn geometry_terms(
    positions: &[[f32; LANES]; 3],
    origin: Vec3,
    normal: Vec3,
    facing: Vec3,
) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        let (x, y, z) =
            (positions[0][lane] - origin.x, positions[1][lane] - origin.y, positions[2][lane] - origin.z);
        let receiver = normal.x * x + normal.y * y + normal.z * z;
        let emitter = -(facing.x * x + facing.y * y + facing.z * z);
        let squared = x * x + y * y + z * z;
        let term = receiver.max(0.0) * emitter.max(0.0) / (squared * squared);
        // 0/0 where the receiver lies on the sample itself.
        out[lane] = if squared > 0.0 { term } else { 0.0 };
    }
    out
}

/// The light's unit normal on the side of `origin`, or `None` when it sends nothing there.
#[inline]
pub(crate) fn facing(light: &AreaLight, normal: Vec3, origin: Vec3) -> Option<Vec3> {
    if !light.emits_towards(origin) {
        return None;
    }
    Some(if normal.dot(origin - light.corner) < 0.0 { -normal } else { normal })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_the_positions_of_single_samples() {
        let light = AreaLight {
            corner: Vec3::new(0.3, 4.0, -2.0),
            edge_u: Vec3::new(1.1, 0.2, 0.0),
            edge_v: Vec3::new(0.0, 0.1, 1.7),
            radiance: Vec3::ONE,
            two_sided: false,
        };
        for kind in [PatternKind::Grid, PatternKind::ShiftedRows, PatternKind::Jittered] {
            for (columns, rows) in [(8, 8), (4, 4), (5, 3), (64, 64)] {
                let pattern = Pattern { kind, columns, rows };
                for first in (0..pattern.len()).step_by(LANES) {
                    let block = positions(&light, pattern, 77, first);
                    for sample in first..(first + LANES).min(pattern.len()) {
                        let expected = light.point(pattern.position(sample, 77));
                        let found = Vec3::from_array(block.map(|axis| axis[sample - first]));
                        assert_eq!(found, expected, "{kind:?} {columns}x{rows} sample {sample}");
                    }
                }
            }
        }
    }
}
