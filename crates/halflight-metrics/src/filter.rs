//! Separable filters on planes of `f64`. Rows are filtered in parallel; each value is one fixed sum, so that
//! the result does not depend on the number of threads.

use rayon::prelude::*;

/// Values that a filter reads beyond the image's edge.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Border {
    /// Nearest pixel of the image.
    Clamp,
    /// Zero.
    Zero,
}

/// Correlates a plane with the product of two odd-sized kernels, one across the columns and one down the
/// rows.
pub(crate) fn correlate(
    plane: &[f64],
    width: usize,
    across: &[f64],
    down: &[f64],
    border: Border,
) -> Vec<f64> {
    correlate_columns(&correlate_rows(plane, width, across, border), width, down, border)
}

fn correlate_rows(plane: &[f64], width: usize, taps: &[f64], border: Border) -> Vec<f64> {
    let radius = taps.len() / 2;
    let mut out = vec![0.0; plane.len()];
    let rows = out.par_chunks_exact_mut(width).zip(plane.par_chunks_exact(width));
    rows.for_each_init(Vec::new, |padded, (out, row)| {
        let (left, right) = match border {
            Border::Clamp => (row[0], row[width - 1]),
            Border::Zero => (0.0, 0.0),
        };
        padded.clear();
        padded.resize(radius, left);
        padded.extend_from_slice(row);
        padded.resize(width + 2 * radius, right);
        weighted_sum(out, taps, |k| &padded[k..k + width]);
    });
    out
}

fn correlate_columns(plane: &[f64], width: usize, taps: &[f64], border: Border) -> Vec<f64> {
    let radius = taps.len() / 2;
    let last = plane.len() / width - 1;
    let outside = vec![0.0; width];
    let mut out = vec![0.0; plane.len()];
    out.par_chunks_exact_mut(width).enumerate().for_each(|(y, out)| {
        weighted_sum(out, taps, |k| {
            let inside = (radius..=last + radius).contains(&(y + k));
            if border == Border::Zero && !inside {
                return &outside;
            }
            let start = (y + k).saturating_sub(radius).min(last) * width;
            &plane[start..start + width]
        });
    });
    out
}

/// Sets `out` to the sum of `taps[k] · source(k)`, a block of columns at a time so that the sums stay in
/// registers.
fn weighted_sum<'a>(out: &mut [f64], taps: &[f64], source: impl Fn(usize) -> &'a [f64]) {
    const BLOCK: usize = 8;
    let (blocks, rest) = out.as_chunks_mut::<BLOCK>();
    let first_of_rest = blocks.len() * BLOCK;
    for (i, block) in blocks.iter_mut().enumerate() {
        let mut sums = [0.0; BLOCK];
        for (k, tap) in taps.iter().enumerate() {
            let values = &source(k)[i * BLOCK..][..BLOCK];
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += tap * value;
            }
        }
        *block = sums;
    }
    for (i, out) in rest.iter_mut().enumerate() {
        *out = taps.iter().enumerate().map(|(k, tap)| tap * source(k)[first_of_rest + i]).sum();
    }
}

/// Samples `f` at the integers −radius..=radius.
pub(crate) fn kernel(radius: usize, f: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=2 * radius).map(|i| f(i as f64 - radius as f64)).collect()
}

/// A Gaussian of the given standard deviation in pixels whose taps sum to 1.
pub(crate) fn gaussian(radius: usize, sigma: f64) -> Vec<f64> {
    let mut taps = kernel(radius, |x| (-x * x / (2.0 * sigma * sigma)).exp());
    let sum: f64 = taps.iter().sum();
    taps.iter_mut().for_each(|tap| *tap /= sum);
    taps
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Correlation straight from its definition.
    fn direct(plane: &[f64], width: isize, across: &[f64], down: &[f64], border: Border) -> Vec<f64> {
        let height = plane.len() as isize / width;
        let (rx, ry) = (across.len() as isize / 2, down.len() as isize / 2);
        let at = |x: isize, y: isize| {
            let inside = (0..width).contains(&x) && (0..height).contains(&y);
            let index = y.clamp(0, height - 1) * width + x.clamp(0, width - 1);
            if inside || border == Border::Clamp { plane[index as usize] } else { 0.0 }
        };
        let mut out = Vec::new();
        for y in 0..height {
            for x in 0..width {
                let mut sum = 0.0;
                for dy in -ry..=ry {
                    for dx in -rx..=rx {
                        sum += across[(dx + rx) as usize] * down[(dy + ry) as usize] * at(x + dx, y + dy);
                    }
                }
                out.push(sum);
            }
        }
        out
    }

    #[test]
    fn separable_equals_the_definition() {
        let across = [0.5, -1.0, 2.0, 0.25, 3.0];
        let down = [1.0, 0.0, -4.0];
        // Kernels larger than the image included.
        for (width, height) in [(7, 5), (1, 9), (9, 1), (1, 1), (2, 2)] {
            let plane: Vec<f64> = (0..width * height).map(|i| f64::from((i * i * 7 + 3) % 11)).collect();
            for border in [Border::Clamp, Border::Zero] {
                let expected = direct(&plane, width as isize, &across, &down, border);
                // Small dyadic numbers: both orders of summation are exact.
                assert_eq!(correlate(&plane, width as usize, &across, &down, border), expected);
            }
        }
    }
}
