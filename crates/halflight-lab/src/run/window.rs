//! Window in which two pictures differ most.

use crate::results::WINDOW;

/// Returns left and top of the [`WINDOW`] with the largest sum of squared differences of two pictures, in sRGB; the first of
/// several in order of rows.
pub(super) fn worst(width: u32, height: u32, picture: &[[u8; 3]], reference: &[[u8; 3]]) -> [u32; 2] {
    let (width, height) = (width as usize, height as usize);
    let [across, down] = WINDOW.map(|side| side as usize);
    let (across, down) = (across.min(width), down.min(height));
    let difference = |(a, b): (&[u8; 3], &[u8; 3])| -> u64 {
        a.iter().zip(b).map(|(&a, &b)| u64::from(a.abs_diff(b)).pow(2)).sum()
    };
    // Sums over everything left of and above a pixel's corner.
    let mut sums = vec![0u64; (width + 1) * (height + 1)];
    let at = |x: usize, y: usize| y * (width + 1) + x;
    for y in 0..height {
        let mut row = 0;
        for x in 0..width {
            let pixel = y * width + x;
            row += difference((&picture[pixel], &reference[pixel]));
            sums[at(x + 1, y + 1)] = sums[at(x + 1, y)] + row;
        }
    }
    let sum = |x: usize, y: usize| {
        let (right, bottom) = (x + across, y + down);
        sums[at(right, bottom)] + sums[at(x, y)] - sums[at(right, y)] - sums[at(x, bottom)]
    };
    let (mut worst, mut most) = ([0, 0], 0);
    for y in 0..=height - down {
        for x in 0..=width - across {
            if sum(x, y) > most {
                (worst, most) = ([x as u32, y as u32], sum(x, y));
            }
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_holds_most_of_the_difference() {
        let (width, height) = (3 * WINDOW[0], 2 * WINDOW[1]);
        let reference = vec![[9; 3]; (width * height) as usize];
        let mut picture = reference.clone();
        assert_eq!(worst(width, height, &picture, &reference), [0, 0]);
        // One large difference outweighs two small ones that lie elsewhere.
        for (x, y, value) in [(3, 5, 40), (8, 5, 40), (200, 100, 200)] {
            picture[(y * width + x) as usize] = [value; 3];
        }
        assert_eq!(worst(width, height, &picture, &reference), [129, 47]);
    }

    #[test]
    fn small_pictures_are_shown_whole() {
        let reference = vec![[0; 3]; 6];
        let mut picture = reference.clone();
        picture[5] = [1, 0, 0];
        assert_eq!(worst(3, 2, &picture, &reference), [0, 0]);
    }
}
