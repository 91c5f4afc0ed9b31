//! Keyframe track of a quantity.

/// Linear interpolation of values. Between equal values the result is exactly that value.
pub(super) trait Mix: Copy {
    /// Interpolates to the other value; `part` is 0 … 1.
    fn mix(self, to: Self, part: f32) -> Self;
}

/// Values at increasing times, the first of them 0.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Track<T> {
    first: T,
    /// Times in seconds, above 0, and values.
    keys: Vec<(f32, T)>,
}

impl<T: Mix> Track<T> {
    pub(super) fn new(first: T, keys: Vec<(f32, T)>) -> Self {
        Self { first, keys }
    }

    /// Value at `time`, interpolated linearly between keys; the first value before time 0, the last one after
    /// all keys.
    pub(super) fn at(&self, time: f32) -> T {
        let next = self.keys.partition_point(|&(at, _)| at <= time);
        let (start, from) = if next == 0 { (0.0, self.first) } else { self.keys[next - 1] };
        match self.keys.get(next) {
            Some(&(end, to)) if time > start => from.mix(to, (time - start) / (end - start)),
            _ => from,
        }
    }

    /// Time of the last key.
    pub(super) fn end(&self) -> f32 {
        self.keys.last().map_or(0.0, |&(time, _)| time)
    }

    pub(super) fn keys(&self) -> impl Iterator<Item = T> {
        self.keys.iter().map(|&(_, value)| value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_go_evenly_from_key_to_key_and_stay_at_the_ends() {
        let track = Track::new(1.0f32, vec![(2.0, 5.0), (3.0, 4.0)]);
        let expected = [
            (f32::NEG_INFINITY, 1.0),
            (-1.0, 1.0),
            (0.0, 1.0),
            (0.5, 2.0),
            (2.0, 5.0),
            (2.75, 4.25),
            (3.0, 4.0),
            (99.0, 4.0),
            (f32::INFINITY, 4.0),
        ];
        for (time, value) in expected {
            assert_eq!(track.at(time), value, "at {time}");
        }
        assert_eq!((track.end(), Track::new(1.0f32, Vec::new()).at(7.0)), (3.0, 1.0));
    }

    #[test]
    fn what_does_not_change_is_exact() {
        let track = Track::new(0.1f32, vec![(3.0, 0.1)]);
        assert!((0..30).all(|step| track.at(step as f32 * 0.1) == 0.1));
    }
}
