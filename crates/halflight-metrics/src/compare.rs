//! Error measures, and the noise of a reference.

use serde::{Deserialize, Serialize};

use crate::{
    flip::flip,
    grain::grain_of,
    pair::{CompareError, Pair},
    percentile::p99,
    ssim::ssim,
    view::Image,
};

/// Error measures of an image against its reference, over the unmasked pixels and all three channels.
///
/// *Peak* is the largest absolute channel value of the reference; N is the number of unmasked pixels.
/// Serialised under its field names. An infinite `psnr` (no difference at all) becomes `null` in JSON and an
/// empty cell in CSV, and is read back as infinity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Sum of squared errors Σ (a − b)², in the square of the image's unit. Grows with the image's size and
    /// brightness.
    pub sse: f64,
    /// Error measure of Koa17 §5: Σ (a − b)² / Σ |b| after both images are divided by the peak. Reported for
    /// comparison with that paper; it depends on the brightness of the image relative to its peak and is not
    /// used as a target.
    pub nmse: f64,
    /// Normalised squared error Σ (a − b)² / Σ b². Dimensionless, independent of exposure and size: the
    /// measure of error targets.
    pub nmse2: f64,
    /// Root mean squared error √(sse / 3N), in the image's unit.
    pub rmse: f64,
    /// Mean of (a − b)² / (b² + ε) with ε = (peak / 100)²: errors in dark and bright pixels have equal
    /// weight, down to a hundredth of the peak.
    pub relmse: f64,
    /// Largest |a − b| of any channel, in the image's unit.
    pub max: f64,
    /// Peak signal-to-noise ratio 20 log₁₀(peak / rmse) in dB; infinite where the images are equal.
    #[serde(with = "infinity_as_none")]
    pub psnr: f64,
    /// Mean structural similarity of the luminance (Wang et al. 2004; 11×11 Gaussian window of σ 1.5 pixels,
    /// K₁ 0.01, K₂ 0.03) after both are divided by the peak. 1 is identical. Windows are cut off and
    /// reweighted at the image's edge and at masked pixels.
    pub ssim: f64,
    /// Mean LDR-ꟻLIP (Andersson et al. 2020) at 67 pixels per degree, 0 (identical) to 1. Exposure: both
    /// divided by the peak and clamped to 0..1. Tone curve: sRGB. Masked pixels are black in both and do not
    /// count.
    pub flip: f64,
    /// 99th percentile, by nearest rank, of the ꟻLIP of the unmasked pixels: the worst hundredth of the image, which the
    /// mean hides. 0 (identical) to 1.
    pub flip_p99: f64,
    /// Grain: visible noise of the penumbra, as a contrast; 0 (smooth) without an upper bound. The error in luminance
    /// without its low frequencies (a Gaussian of σ 6 pixels over the penumbra's pixels alone), over the reference's
    /// luminance in the mean of that Gaussian plus a floor of 2 % of the peak; absolute value, 99th percentile by nearest
    /// rank over the unmasked pixels in the [`PENUMBRA`](crate::PENUMBRA). `None`, which is `null` in JSON and an empty
    /// cell in CSV, where no pixel lies in it or the reference does not tell its
    /// [visible fractions](Image::with_visible_fractions).
    pub grain: Option<f64>,
}

/// Fraction of the peak below which [`Comparison::relmse`] stops growing.
const RELMSE_FLOOR: f64 = 0.01;

/// Measures `image` against `reference`.
///
/// A mask of only one image holds for both; two masks must be equal.
///
/// # Errors
/// [`CompareError`] if sizes or masks differ, an unmasked pixel is not finite, all pixels are masked, or the
/// reference is all zero.
pub fn compare(image: Image<'_>, reference: Image<'_>) -> Result<Comparison, CompareError> {
    let pair = Pair::new(image, reference)?;
    let peak = pair.peak;
    let floor = (RELMSE_FLOOR * peak).powi(2);
    let (mut sse, mut sum, mut sum_of_squares, mut relative, mut max) = (0.0, 0.0, 0.0, 0.0, 0.0_f64);
    for (a, b) in pair.values() {
        let difference = (a - b).abs();
        let squared = difference * difference;
        sse += squared.element_sum();
        sum += b.abs().element_sum();
        sum_of_squares += (b * b).element_sum();
        relative += (squared / (b * b + floor)).element_sum();
        max = max.max(difference.max_element());
    }
    let channels = 3.0 * pair.count as f64;
    let rmse = (sse / channels).sqrt();
    let mut flip = flip(&pair);
    Ok(Comparison {
        sse,
        nmse: sse / (peak * sum),
        nmse2: sse / sum_of_squares,
        rmse,
        relmse: relative / channels,
        max,
        psnr: 20.0 * (peak / rmse).log10(),
        ssim: ssim(&pair),
        flip: flip.iter().sum::<f64>() / pair.count as f64,
        flip_p99: p99(&mut flip).ok_or(CompareError::NoPixels)?,
        grain: grain_of(&pair),
    })
}

/// Computes [`Comparison::nmse2`] alone, which takes far less time than all measures.
///
/// # Errors
/// See [`compare`].
pub fn nmse2(image: Image<'_>, reference: Image<'_>) -> Result<f64, CompareError> {
    let pair = Pair::new(image, reference)?;
    let sums = pair.values().map(|(a, b)| ((a - b).length_squared(), b.length_squared()));
    let (sse, sum) = sums.fold((0.0, 0.0), |total, one| (total.0 + one.0, total.1 + one.1));
    Ok(sse / sum)
}

/// Estimates the NMSE₂ of the mean of two independent, unbiased halves of a rendering against the true image.
///
/// With a variance σ² in each pixel of a half, the halves differ by 2σ² in the mean square, while their mean
/// has an error of σ²/2: a quarter of it. The estimate is therefore Σ (a − b)² / 4 over Σ m², where m is the
/// mean of the halves. Halves that share samples, or have a common bias, make the estimate too low.
///
/// # Errors
/// See [`compare`]; [`CompareError::ZeroReference`] if either half is zero at every pixel.
pub fn halves_noise(half_a: Image<'_>, half_b: Image<'_>) -> Result<f64, CompareError> {
    let pair = Pair::new(half_a, half_b)?;
    let (mut difference, mut signal) = (0.0, 0.0);
    for (a, b) in pair.values() {
        difference += (a - b).length_squared();
        signal += (0.5 * (a + b)).length_squared();
    }
    if signal == 0.0 {
        return Err(CompareError::ZeroReference);
    }
    Ok(0.25 * difference / signal)
}

/// Serialisation of infinity as `None`, since JSON has no infinity.
mod infinity_as_none {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        value.is_finite().then_some(*value).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
    }
}
