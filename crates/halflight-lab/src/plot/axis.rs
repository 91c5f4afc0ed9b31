//! Axes of charts.

use super::chart::Scale;

/// Distance of the outermost points from the frame, in parts of the plot.
const MARGIN: f64 = 0.05;
/// Least extent of an axis: a factor of two and a half, or 0.4 units.
const NARROWEST: f64 = 0.4;

/// Returns a quantity on a scale.
fn apply(scale: Scale, value: f64) -> f64 {
    match scale {
        Scale::Linear => value,
        Scale::Log => value.log10(),
    }
}

/// Axis: maps a quantity to pixels.
pub(super) struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    from: i32,
    to: i32,
}

impl Axis {
    /// Returns an axis over values, from a pixel to another.
    pub(super) fn new(scale: Scale, values: impl Iterator<Item = f64>, from: i32, to: i32) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.map(|value| apply(scale, value)).filter(|value| value.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        // Wide enough for two ticks at least.
        let margin = ((high - low) * MARGIN).max(0.5 * (NARROWEST - (high - low)));
        Self { scale, low: low - margin, high: high + margin, from, to }
    }

    /// Returns the pixel of a value that lies on the axis.
    pub(super) fn pixel(&self, value: f64) -> Option<i32> {
        let part = (apply(self.scale, value) - self.low) / (self.high - self.low);
        (0.0..=1.0)
            .contains(&part)
            .then(|| self.from + (part * f64::from(self.to - self.from)).round() as i32)
    }

    /// Returns values to label: powers of ten, with round numbers between them where there are few.
    pub(super) fn ticks(&self) -> Vec<f64> {
        match self.scale {
            Scale::Log => {
                const FACTORS: [&[f64]; 3] =
                    [&[1.0], &[1.0, 2.0, 5.0], &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]];
                let decades = self.low.floor() as i32..=self.high.ceil() as i32;
                let ticks = |factors: &[f64]| -> Vec<f64> {
                    let decades = decades.clone();
                    let ticks =
                        decades.flat_map(|decade| factors.iter().map(move |f| f * 10f64.powi(decade)));
                    ticks.filter(|&tick| self.pixel(tick).is_some()).collect()
                };
                let fine = ticks(FACTORS[2]);
                FACTORS.into_iter().map(ticks).find(|ticks| ticks.len() >= 4).unwrap_or(fine)
            }
            Scale::Linear => {
                let rough = (self.high - self.low) / 6.0;
                let decade = 10f64.powf(rough.log10().floor());
                let step =
                    [1.0, 2.0, 5.0, 10.0].iter().map(|factor| factor * decade).find(|&step| step >= rough);
                let step = step.unwrap_or(rough);
                let first = (self.low / step).ceil() as i64;
                (first..).map(|index| index as f64 * step).take_while(|&tick| tick <= self.high).collect()
            }
        }
    }
}

/// Returns a number for a tick: plain, in thousands or millions, or as 2e-4.
pub(super) fn short(value: f64) -> String {
    let rounded = |value: f64| ((value * 1e4).round() / 1e4).to_string();
    match value.abs() {
        size if size >= 1e6 => format!("{} M", rounded(value / 1e6)),
        size if size >= 1e4 => format!("{} k", rounded(value / 1e3)),
        size if size >= 1e-3 || size == 0.0 => rounded(value),
        _ => format!("{value:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_keep_order_and_leave_out_what_has_no_logarithm() {
        let axis = Axis::new(Scale::Log, [1.0, 10.0, 0.0, f64::NAN].into_iter(), 0, 1000);
        assert!(axis.pixel(1.0) < axis.pixel(2.0) && axis.pixel(2.0) < axis.pixel(10.0));
        assert_eq!((axis.pixel(0.0), axis.pixel(1e6)), (None, None));
        assert_eq!(axis.ticks(), [1.0, 2.0, 5.0, 10.0]);
        let narrow = Axis::new(Scale::Log, [25.0, 50.0].into_iter(), 0, 1000);
        assert_eq!(narrow.ticks(), [30.0, 40.0, 50.0]);
    }

    #[test]
    fn linear_ticks_are_round() {
        let axis = Axis::new(Scale::Linear, [1.0, 7.0].into_iter(), 0, 1000);
        assert_eq!(axis.ticks(), [2.0, 4.0, 6.0]);
    }

    #[test]
    fn tick_labels_are_short() {
        assert_eq!(
            [0.5, 100.0, 2e-4, 1e-6, 5e5, 2e7].map(short),
            ["0.5", "100", "2e-4", "1e-6", "500 k", "20 M"]
        );
    }
}
