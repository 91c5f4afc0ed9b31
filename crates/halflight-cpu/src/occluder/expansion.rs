//! Exact sums and products of double-precision numbers (Shewchuk 1997).

/// Capacity of an [`Expansion`] in parts: more than the 17 that span products of three single-precision
/// numbers, or the 34 that span products of two such.
const PARTS: usize = 64;

/// Sum of parts that do not overlap, the smallest first. Results are exact as long as no product of two parts
/// overflows or is subnormal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expansion {
    parts: [f64; PARTS],
    count: usize,
}

/// Rounded sum of two numbers, and its error.
#[inline]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let share = sum - a;
    (sum, (a - (sum - share)) + (b - share))
}

/// Upper and lower half of a number's digits.
#[inline]
fn split(a: f64) -> (f64, f64) {
    let wide = 134_217_729.0 * a;
    let high = wide - (wide - a);
    (high, a - high)
}

/// Rounded product of two numbers, and its error.
#[inline]
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    let error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low);
    (product, error)
}

impl Expansion {
    /// Zero.
    pub(crate) const ZERO: Self = Self { parts: [0.0; PARTS], count: 0 };

    /// Adds a number.
    pub(crate) fn add(&mut self, term: f64) {
        let (mut sum, mut kept) = (term, 0);
        for index in 0..self.count {
            let (total, error) = two_sum(sum, self.parts[index]);
            sum = total;
            if error != 0.0 {
                self.parts[kept] = error;
                kept += 1;
            }
        }
        if sum != 0.0 {
            self.parts[kept] = sum;
            kept += 1;
        }
        self.count = kept;
        if kept == PARTS {
            self.compress();
        }
    }

    /// Adds the product of three numbers. The product of the first two must be exact, as that of
    /// single-precision numbers is.
    pub(crate) fn add_product(&mut self, a: f64, b: f64, c: f64) {
        let (product, error) = two_product(a * b, c);
        self.add(error);
        self.add(product);
    }

    /// Adds another expansion.
    pub(crate) fn add_all(&mut self, other: &Self) {
        other.parts[..other.count].iter().for_each(|&part| self.add(part));
    }

    /// Returns the product of two expansions.
    pub(crate) fn times(&self, other: &Self) -> Self {
        let mut product = Self::ZERO;
        for &a in &self.parts[..self.count] {
            for &b in &other.parts[..other.count] {
                let (high, low) = two_product(a, b);
                product.add(low);
                product.add(high);
            }
        }
        product
    }

    /// Returns the negated number.
    pub(crate) fn negated(mut self) -> Self {
        self.parts[..self.count].iter_mut().for_each(|part| *part = -*part);
        self
    }

    /// Joins parts so that every part but the smallest has all of its digits (Shewchuk 1997, figure 15).
    fn compress(&mut self) {
        let mut bottom = self.count - 1;
        let mut sum = self.parts[bottom];
        for index in (0..self.count - 1).rev() {
            let (total, error) = two_sum(sum, self.parts[index]);
            sum = total;
            if error != 0.0 {
                self.parts[bottom] = total;
                bottom -= 1;
                sum = error;
            }
        }
        self.parts[bottom] = sum;
        let mut top = 0;
        for index in bottom + 1..self.count {
            let (total, error) = two_sum(self.parts[index], sum);
            sum = total;
            if error != 0.0 {
                self.parts[top] = error;
                top += 1;
            }
        }
        self.parts[top] = sum;
        self.count = top + 1;
    }

    /// Value of the sum, wrong by a few units in the last place at most.
    pub(crate) fn value(&self) -> f64 {
        self.parts[..self.count].iter().sum()
    }

    /// Number with the same sign as the sum, 0 for zero: the sign of the largest part.
    pub(crate) fn sign(&self) -> f64 {
        self.parts[..self.count].last().map_or(0.0, |part| part.signum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_lost() {
        let mut sum = Expansion::ZERO;
        for power in [0, 200, -200, 100, -300] {
            sum.add(2f64.powi(power));
        }
        for power in [200, 100, 0, -200] {
            assert_eq!(sum.sign(), 1.0);
            sum.add(-(2f64.powi(power)));
        }
        assert_eq!(sum.value(), 2f64.powi(-300));
        sum.add(-(2f64.powi(-299)));
        assert_eq!((sum.sign(), sum.value()), (-1.0, -(2f64.powi(-300))));
        sum.add(2f64.powi(-300));
        assert_eq!((sum.sign(), sum.count), (0.0, 0));
    }

    #[test]
    fn products_are_exact() {
        // (1 + 2⁻³⁰)(1 − 2⁻³⁰) = 1 − 2⁻⁶⁰, which double precision rounds to 1.
        let (mut a, mut b) = (Expansion::ZERO, Expansion::ZERO);
        [1.0, 2f64.powi(-30)].iter().for_each(|&part| a.add(part));
        [1.0, -(2f64.powi(-30))].iter().for_each(|&part| b.add(part));
        let mut difference = a.times(&b);
        difference.add(-1.0);
        assert_eq!(difference.value(), -(2f64.powi(-60)));
        let mut product = Expansion::ZERO;
        let odd = f64::from(1.0 + f32::EPSILON);
        product.add_product(odd, odd, odd);
        for (factor, power) in [(1.0, 0), (3.0, -23), (3.0, -46), (1.0, -69)] {
            product.add(-factor * 2f64.powi(power));
        }
        assert_eq!(product.sign(), 0.0);
        assert_eq!(a.negated().value(), -a.value());
    }

    #[test]
    fn many_parts_are_compressed() {
        let mut sum = Expansion::ZERO;
        for step in 0..200 {
            sum.add(2f64.powi(600 - 6 * step));
            assert!(sum.count < PARTS);
        }
        for step in 0..200 {
            sum.add(-(2f64.powi(600 - 6 * step)));
        }
        assert_eq!(sum.sign(), 0.0);
    }
}
