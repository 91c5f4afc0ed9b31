//! Percentiles over pixels.

/// Returns the 99th percentile by nearest rank: the least value that at least 99 of 100 values do not exceed. Reorders
/// the values; `None` where there are none.
pub(crate) fn p99(values: &mut [f64]) -> Option<f64> {
    let rank = (values.len() * 99).div_ceil(100).checked_sub(1)?;
    let (_, value, _) = values.select_nth_unstable_by(rank, f64::total_cmp);
    Some(*value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_the_nearest() {
        let descending = |count: u32| -> Vec<f64> { (1..=count).rev().map(f64::from).collect() };
        for (count, expected) in
            [(0, None), (1, Some(1.0)), (99, Some(99.0)), (100, Some(99.0)), (101, Some(100.0))]
        {
            assert_eq!(p99(&mut descending(count)), expected, "{count}");
        }
    }
}
