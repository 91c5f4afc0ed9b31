//! Positions of light samples, a vector of samples at a time.

use glam::Vec3;
use halflight_core::light::AreaLight;
use halflight_core::pattern::{Pattern, PatternKind};

use crate::simd::Lanes;
use crate::vector::Vector;

/// Number of light samples that are evaluated together.
pub(crate) const LANES: usize = 16;

/// Lane indices 0, 1, 2 …
const COUNT: [f32; LANES] =
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

/// Positions of samples `first .. first + LANES`, one array per axis.
#[inline(always)]
pub(crate) fn positions<L: Lanes>(
    light: &AreaLight,
    pattern: Pattern,
    key: u32,
    first: usize,
) -> [[f32; LANES]; 3] {
    let mut out = [[0.0; LANES]; 3];
    for at in (0..LANES).step_by(L::WIDTH) {
        points::<L>(light, pattern, key, first + at).store(&mut out, at);
    }
    out
}

/// Positions of samples `first .. first + L::WIDTH`: bit for bit those of [`Pattern::position`] and
/// [`AreaLight::point`]. Lanes past the end of the pattern are finite and meaningless.
#[inline(always)]
pub(crate) fn points<L: Lanes>(light: &AreaLight, pattern: Pattern, key: u32, first: usize) -> Vector<L> {
    let (columns, rows) = (f32::from(pattern.columns), f32::from(pattern.rows));
    let (scale_u, scale_v) = (L::splat(1.0 / columns), L::splat(1.0 / rows));
    let half = L::splat(0.5);
    let index = L::load(&COUNT).add(L::splat(first as f32));
    // Half a sample keeps the quotient away from integers by more than its rounding error.
    let row = index.add(half).mul(scale_u).truncate();
    let column = index.sub(row.mul(L::splat(columns)));
    let (du, dv) = match pattern.kind {
        PatternKind::Grid => (half, half),
        PatternKind::ShiftedRows => L::jitter(key, row),
        PatternKind::Jittered => L::jitter(key, index),
    };
    let u = column.add(du).mul(scale_u);
    let v = row.add(dv).mul(scale_v);
    let frame = light.frame();
    let along = Vector::splat(frame.u).mul(Vector { x: u, y: u, z: u });
    let across = Vector::splat(frame.v).mul(Vector { x: v, y: v, z: v });
    Vector::splat(frame.origin).add(along).add(across)
}

/// Geometry terms `cosθx cosθy / r²` of samples at `d` relative to the receiver, 0 below either horizon;
/// `facing` is the light's normal on the side of the receiver.
#[inline(always)]
pub(crate) fn geometry_terms<L: Lanes>(d: Vector<L>, normal: Vec3, facing: Vec3) -> L {
    let zero = L::splat(0.0);
    let receiver = d.dot(Vector::splat(normal)).max(zero);
    let emitter = d.dot(Vector::splat(-facing)).max(zero);
    let squared = d.dot(d);
    let terms = receiver.mul(emitter).div(squared.mul(squared));
    // 0/0 where the receiver lies on the sample itself.
    zero.select(zero.lt(squared), terms)
}

/// Unit normal of the light on the side of `origin`, or `None` if the light emits nothing towards it.
#[inline]
pub(crate) fn facing(light: &AreaLight, normal: Vec3, origin: Vec3) -> Option<Vec3> {
    if !light.emits_towards(origin) {
        return None;
    }
    Some(if normal.dot(origin - light.frame().origin) < 0.0 { -normal } else { normal })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Isa, Kernel, Simd};

    /// Positions of sixteen samples by both widths of an instruction set.
    struct Both(AreaLight, Pattern, usize);

    impl Kernel for Both {
        type Output = [[[f32; LANES]; 3]; 2];
        #[inline(always)]
        fn run<S: Simd>(self) -> Self::Output {
            let Self(light, pattern, first) = self;
            [
                positions::<S::Eight>(&light, pattern, 77, first),
                positions::<S::Wide>(&light, pattern, 77, first),
            ]
        }
    }

    #[test]
    fn blocks_are_the_positions_of_single_samples() {
        let (corner, u, v) = (Vec3::new(0.3, 4.0, -2.0), Vec3::new(1.1, 0.2, 0.0), Vec3::new(0.0, 0.1, 1.7));
        let light = AreaLight::parallelogram(corner, u, v, Vec3::ONE);
        let shapes = [(8, 8), (4, 4), (5, 3), (64, 64), (63, 61), (4093, 1), (1, 4096), (1365, 3)];
        for kind in [PatternKind::Grid, PatternKind::ShiftedRows, PatternKind::Jittered] {
            for (columns, rows) in shapes {
                let pattern = Pattern { kind, columns, rows };
                for first in (0..pattern.len()).step_by(LANES) {
                    for isa in Isa::available() {
                        for block in isa.run(Both(light, pattern, first)) {
                            for sample in first..(first + LANES).min(pattern.len()) {
                                let expected = light.point(pattern.position(sample, 77));
                                let found = Vec3::from_array(block.map(|axis| axis[sample - first]));
                                assert_eq!(
                                    found, expected,
                                    "{isa:?} {kind:?} {columns}x{rows} sample {sample}"
                                );
                            }
                        }
                    }
                }
            }
        }
    }
}
