//! Pareto fronts: points that no other beats.

/// Returns the indices of the points that no other point beats, by ascending `x`. Smaller is better in both coordinates; a point is
/// beaten by one that is nowhere worse and somewhere better, so equal points stay together. Points that are not finite
/// never take part.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
    let finite = |point: &(f64, f64)| point.0.is_finite() && point.1.is_finite();
    let mut front: Vec<usize> = (0..points.len())
        .filter(|&i| finite(&points[i]))
        .filter(|&i| !points.iter().any(|&other| finite(&other) && beats(other, points[i])))
        .collect();
    front.sort_by(|&a, &b| points[a].partial_cmp(&points[b]).unwrap_or(std::cmp::Ordering::Equal));
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dominated_points_go_and_tied_ones_stay() {
        let points = [
            (4.0, 1.0), // most accurate
            (1.0, 8.0), // fastest
            (2.0, 3.0),
            (2.0, 3.0), // tied in both
            (2.0, 4.0), // as fast, less accurate
            (3.0, 3.0), // slower, as accurate
            (5.0, 5.0), // worse in both
            (0.5, f64::NAN),
            (f64::INFINITY, 0.1),
        ];
        assert_eq!(front(&points), [1, 2, 3, 0]);
    }

    #[test]
    fn nothing_has_no_front() {
        assert!(front(&[]).is_empty());
    }
}
