//! Sub-samples of pixels: their offsets from the centre, and cameras that look through them.

use glam::Vec2;

use crate::camera::Camera;

/// Numbers of sub-samples that a pixel can have; one is its centre.
pub const COUNTS: [u32; 4] = [1, 4, 8, 16];

/// Number of sub-samples that a pixel cannot have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} sub-samples a pixel asked for: choose 1 (no antialiasing), 4, 8 or 16")]
pub struct SubSampleError(pub u32);

/// Offsets of 4 sub-samples in eighths of a pixel: a rotated grid.
const FOUR: [[i8; 2]; 4] = [[-1, -3], [3, -1], [-3, 1], [1, 3]];

/// Offsets of 8 sub-samples in sixteenths of a pixel.
const EIGHT: [[i8; 2]; 8] = [[1, -3], [-1, 3], [5, 1], [-3, -5], [-5, 5], [-7, -1], [3, 7], [7, -7]];

/// Cells of 16 sub-samples, their lower corners in sixteenths of a pixel.
const SIXTEEN: [[i8; 2]; 16] = [
    [1, 1],
    [-1, -3],
    [-3, 2],
    [4, -1],
    [-5, -2],
    [2, 5],
    [5, 3],
    [3, -5],
    [-2, 6],
    [0, -7],
    [-4, -6],
    [-6, 4],
    [-8, 0],
    [7, -4],
    [6, 7],
    [-7, -8],
];

/// Returns the offsets of cells `unit` pixels wide, `shift` of a cell away from their corners.
const fn scaled<const N: usize>(cells: [[i8; 2]; N], shift: f32, unit: f32) -> [Vec2; N] {
    let mut offsets = [Vec2::ZERO; N];
    let mut index = 0;
    while index < N {
        let [x, y] = cells[index];
        offsets[index] = Vec2::new((x as f32 + shift) * unit, (y as f32 + shift) * unit);
        index += 1;
    }
    offsets
}

/// Returns the offsets of `count` sub-samples from a pixel's centre, in pixels to the right and down.
///
/// All lie within half a pixel and are exact in binary. Their mean is zero, and each of `count` columns and rows of a pixel has one of
/// them, so that edges near the axes get as many shades as there are sub-samples. The patterns of 8 and 16 are the standard multisample
/// positions of Direct3D 11, those of 16 moved to the middle of their cells.
///
/// # Errors
/// The count is none of [`COUNTS`].
pub fn offsets(count: u32) -> Result<&'static [Vec2], SubSampleError> {
    static OFFSETS_4: [Vec2; 4] = scaled(FOUR, 0.0, 0.125);
    static OFFSETS_8: [Vec2; 8] = scaled(EIGHT, 0.0, 0.0625);
    static OFFSETS_16: [Vec2; 16] = scaled(SIXTEEN, 0.5, 0.0625);
    match count {
        1 => Ok(&[Vec2::ZERO]),
        4 => Ok(&OFFSETS_4),
        8 => Ok(&OFFSETS_8),
        16 => Ok(&OFFSETS_16),
        _ => Err(SubSampleError(count)),
    }
}

/// Returns the camera whose rays through the centres of pixels are those of `camera` through points `offset` away from the centres, in
/// pixels to the right and down, in an image of this size.
#[must_use]
pub fn shifted(camera: &Camera, offset: Vec2, width: u32, height: u32) -> Camera {
    let halves = Vec2::new(2.0 * offset.x / width as f32, -2.0 * offset.y / height as f32);
    Camera { shift: camera.shift + halves, ..*camera }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::View;

    #[test]
    fn every_column_and_row_has_one_offset_and_their_mean_is_zero() {
        for count in COUNTS {
            let offsets = offsets(count).unwrap();
            assert_eq!(offsets.len(), count as usize);
            assert_eq!(offsets.iter().sum::<Vec2>(), Vec2::ZERO);
            for axis in 0..2 {
                let mut strata: Vec<i32> = offsets
                    .iter()
                    .map(|offset| ((offset[axis] + 0.5) * count as f32).floor() as i32)
                    .collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..count as i32).collect::<Vec<_>>(), "{count}");
            }
        }
        assert_eq!(offsets(0), Err(SubSampleError(0)));
        let message = offsets(5).unwrap_err().to_string();
        assert!(message.contains("5 sub-samples") && message.contains("4, 8 or 16"), "{message}");
    }

    #[test]
    fn shifted_cameras_look_through_the_offsets() {
        let (width, height) = (64, 48);
        let camera = Camera { shift: Vec2::new(0.1, -0.2), ..Camera::default() };
        let view = View::new(&camera, width, height);
        for &offset in offsets(16).unwrap() {
            let moved = View::new(&shifted(&camera, offset, width, height), width, height);
            for (x, y) in [(0, 0), (63, 0), (20, 47)] {
                let point = [f64::from(offset.x) + x as f64 + 0.5, f64::from(offset.y) + y as f64 + 0.5];
                assert!(moved.direction(x, y).distance(view.through(point[0], point[1])) < 1e-6, "{offset}");
            }
        }
    }
}
