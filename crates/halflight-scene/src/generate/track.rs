//! The line of the roller-coaster's track: a closed uniform B-spline, banked in its bends.

use glam::Vec3;

/// Control points of the line, x, height and z in metres: station, lift hill, drops and turns.
const CONTROLS: [[f32; 3]; 40] = [
    [-24.0, 2.0, 15.0],
    [-18.0, 2.0, 15.0],
    [-12.0, 2.0, 15.0],
    [-6.0, 2.0, 15.0],
    [-1.0, 3.0, 15.0],
    [4.0, 6.5, 15.0],
    [9.0, 10.2, 15.0],
    [14.0, 13.8, 15.0],
    [19.0, 16.0, 14.5],
    [23.5, 15.5, 11.5],
    [25.5, 14.5, 7.0],
    [25.5, 9.5, 2.0],
    [25.5, 3.0, -3.0],
    [24.5, 0.9, -8.0],
    [20.0, 1.6, -12.5],
    [14.5, 3.8, -14.0],
    [9.0, 8.6, -14.0],
    [4.5, 11.8, -14.0],
    [0.0, 10.6, -14.0],
    [-4.5, 5.4, -14.0],
    [-9.0, 1.2, -14.0],
    [-14.0, 1.8, -13.5],
    [-19.5, 5.6, -11.5],
    [-23.0, 8.6, -7.0],
    [-22.5, 9.0, -1.5],
    [-18.0, 7.4, 2.0],
    [-12.5, 3.0, 1.0],
    [-7.5, 1.6, -2.0],
    [-2.5, 5.0, -4.5],
    [2.5, 7.2, -6.0],
    [8.0, 4.2, -6.5],
    [14.0, 2.0, -5.0],
    [18.0, 3.4, -0.5],
    [16.5, 4.8, 5.0],
    [10.5, 4.6, 7.5],
    [4.0, 2.4, 7.5],
    [-3.0, 4.6, 7.5],
    [-11.0, 2.4, 7.5],
    [-20.0, 3.0, 7.8],
    [-28.0, 2.6, 11.0],
];

/// Samples of the line on each piece of the spline.
const FINE: usize = 64;

/// Point on the track: the midpoint between its rails and three unit directions.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) middle: Vec3,
    pub(super) ahead: Vec3,
    /// Direction to the right, `ahead × up`.
    pub(super) side: Vec3,
    pub(super) up: Vec3,
}

impl Place {
    /// Horizontal direction to the right.
    pub(super) fn level_side(&self) -> Vec3 {
        self.ahead.cross(Vec3::Y).normalize_or(Vec3::X)
    }
}

/// The closed line, with its length up to each sample.
pub(super) struct Track {
    places: Vec<Place>,
    lengths: Vec<f32>,
}

impl Track {
    pub(super) fn new() -> Self {
        let count = CONTROLS.len() * FINE;
        let points: Vec<Vec3> = (0..count).map(spline).collect();
        let around = |i: usize, by: isize| (i as isize + by).rem_euclid(count as isize) as usize;
        // Change of direction per metre.
        let bend = |i: usize| {
            let [a, b, c] = [-8, 0, 8].map(|by| points[around(i, by)]);
            let (before, after) = (b - a, c - b);
            (after.normalize_or(Vec3::X) - before.normalize_or(Vec3::X)) / before.length().max(1e-3)
        };
        let places = (0..count)
            .map(|i| {
                let ahead = (points[around(i, 1)] - points[around(i, -1)]).normalize_or(Vec3::X);
                // The mean over half a piece on either side, so that the banking comes and goes gently.
                let reach = FINE as isize / 2;
                let bends: Vec3 = (-reach..=reach).step_by(4).map(|by| bend(around(i, by))).sum();
                let bend = bends / (2 * reach / 4 + 1) as f32;
                // A train that comes from the highest point has v² = 2 g h; the track's banking compensates
                // only part of it.
                let fall = (17.0 - points[i].y).max(1.0);
                let lean = Vec3::new(bend.x, 0.0, bend.z) * (0.7 * fall);
                let up = Vec3::Y + lean.clamp_length_max(0.8);
                let up = (up - ahead * up.dot(ahead)).normalize_or(Vec3::Y);
                Place { middle: points[i], ahead, side: ahead.cross(up), up }
            })
            .collect();
        let mut lengths = vec![0.0];
        let mut length = 0.0;
        for i in 0..count {
            length += points[i].distance(points[around(i, 1)]);
            lengths.push(length);
        }
        Self { places, lengths }
    }

    pub(super) fn length(&self) -> f32 {
        self.lengths[self.places.len()]
    }

    /// Point at `length` from the start, once around at most.
    pub(super) fn at(&self, length: f32) -> Place {
        let count = self.places.len();
        let after = self.lengths.partition_point(|&l| l <= length).clamp(1, count);
        let (low, high) = (self.lengths[after - 1], self.lengths[after]);
        let t = ((length - low) / (high - low)).clamp(0.0, 1.0);
        let (a, b) = (&self.places[after - 1], &self.places[after % count]);
        let ahead = a.ahead.lerp(b.ahead, t).normalize_or(a.ahead);
        let up = a.up.lerp(b.up, t);
        let up = (up - ahead * up.dot(ahead)).normalize_or(a.up);
        Place { middle: a.middle.lerp(b.middle, t), ahead, side: ahead.cross(up), up }
    }

    /// Height of the highest stretch that passes under `place` (at `length`) within `reach` to the side and
    /// at least `clear` below it.
    pub(super) fn highest_below(&self, place: &Place, length: f32, reach: f32, clear: f32) -> Option<f32> {
        let apart = |other: f32| {
            let along = (other - length).abs();
            along.min(self.length() - along)
        };
        self.places
            .iter()
            .zip(&self.lengths)
            .filter(|(other, along)| {
                let away = other.middle - place.middle;
                apart(**along) > 4.0 * reach && away.y < -clear && away.x.hypot(away.z) < reach
            })
            .map(|(other, _)| other.middle.y)
            .max_by(f32::total_cmp)
    }
}

/// A point of the spline; every [`FINE`] samples begin a new piece.
fn spline(sample: usize) -> Vec3 {
    let (piece, t) = (sample / FINE, (sample % FINE) as f32 / FINE as f32);
    let [a, b, c, d] = [0, 1, 2, 3].map(|k| Vec3::from_array(CONTROLS[(piece + k) % CONTROLS.len()]));
    let u = 1.0 - t;
    let inner = [3.0 * t * t * t - 6.0 * t * t + 4.0, 3.0 * u * u * u - 6.0 * u * u + 4.0];
    (a * (u * u * u) + b * inner[0] + c * inner[1] + d * (t * t * t)) / 6.0
}
