//! Verdict on one picture, with the errors that it is compared with and all limits.

use std::fmt;

use glam::Vec3;

/// NMSE₂ that counts as none: 0.3 % of the irradiance, half a step of an 8-bit picture of middle brightness. Smaller
/// yardsticks are raised to it, so that no method is called degraded for errors that nobody sees.
pub const NOTHING: f64 = 1e-5;

/// NMSE₂ that a method is granted in the easy case: 3 % of the irradiance. A larger error there does not excuse errors
/// elsewhere.
pub const GRANTED: f64 = 1e-3;

/// Share of the error of a picture without shadows from which on a shadow is lost: all of it but for rounding.
const NEARLY: f64 = 0.999;

/// Factor over the yardstick above which the NMSE₂ of a picture is degraded: twice the RMS error, well above what
/// another set of light samples would change.
pub const DEGRADED: f64 = 4.0;

/// NMSE₂ above which a picture fails: its RMS error is a tenth of the RMS irradiance, and shadows are plainly
/// missing, misplaced or added.
pub const FAILS: f64 = 1e-2;

/// Fault of a picture in itself, whatever it should look like. No method may have one.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// NaN or infinite.
    NotFinite {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
    /// Below zero.
    Negative {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// The least channel, W/m².
        value: f32,
    },
    /// The program panicked.
    Panic(String),
    /// The pipeline could not be built, or refused to render.
    Refused(String),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { x, y } => write!(f, "not finite at ({x}, {y})"),
            Self::Negative { x, y, value } => write!(f, "{value:.2e} at ({x}, {y})"),
            Self::Panic(message) => write!(f, "panic: {message}"),
            Self::Refused(message) => write!(f, "{message}"),
        }
    }
}

/// Distance of pictures from their references.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Σ (a − b)² / Σ b²; of the differences between pictures where there are several.
    pub nmse2: f64,
    /// The largest difference of a channel, over the largest channel of the reference.
    pub worst: f64,
}

/// Errors that a method's error is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yardsticks {
    /// NMSE₂ of the same method in the easy case.
    pub easy: f64,
    /// NMSE₂ of every pixel by exact rays in this case, with the same shading and as many light samples: what is hard for
    /// all.
    pub every_pixel: f64,
    /// NMSE₂ of the picture without any shadow.
    pub unshadowed: f64,
}

impl Yardsticks {
    /// Returns how many times the NMSE₂ is above what can be asked of the method: the larger of its own error in the easy case
    /// (up to [`GRANTED`]) and that of every pixel in this one, and no less than [`NOTHING`].
    pub fn times(&self, nmse2: f64) -> f64 {
        nmse2 / self.easy.min(GRANTED).max(self.every_pixel).max(NOTHING)
    }

    /// Returns whether the picture might as well have no shadow, where every pixel tells that there is one.
    fn shadow_is_lost(&self, nmse2: f64) -> bool {
        nmse2 >= self.unshadowed * NEARLY && self.unshadowed > DEGRADED * self.every_pixel.max(NOTHING)
    }
}

/// Verdict on a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// As good as can be asked.
    Pass,
    /// The error is this many times the yardstick.
    Degraded(f64),
    /// The error is this many times the yardstick, and above [`FAILS`] or no better than without any shadow.
    Wrong(f64),
    /// No picture is sound.
    Broken(Fault),
}

impl Verdict {
    /// Returns the word in tables.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Degraded(_) => "degraded",
            Self::Wrong(_) | Self::Broken(_) => "fails",
        }
    }

    /// Returns how many times the yardstick the error is, for sound pictures that do not pass.
    pub fn times(&self) -> Option<f64> {
        match self {
            &Self::Degraded(times) | &Self::Wrong(times) => Some(times),
            _ => None,
        }
    }

    /// Returns how bad the verdict is, to sort by: kind first, then times.
    pub fn badness(&self) -> (u8, f64) {
        match self {
            Self::Pass => (0, 0.0),
            &Self::Degraded(times) => (1, times),
            &Self::Wrong(times) => (2, times),
            Self::Broken(_) => (3, 0.0),
        }
    }
}

/// Refuses values that no picture of this width may have.
///
/// # Errors
/// The first fault.
pub fn sound(pixels: &[Vec3], width: u32) -> Result<(), Fault> {
    let place = |index: usize| (index as u32 % width.max(1), index as u32 / width.max(1));
    for (index, value) in pixels.iter().enumerate() {
        let (x, y) = place(index);
        if !value.is_finite() {
            return Err(Fault::NotFinite { x, y });
        }
        if value.min_element() < 0.0 {
            return Err(Fault::Negative { x, y, value: value.min_element() });
        }
    }
    Ok(())
}

/// Compares pictures with their references over the pixels that `mask` takes in. One picture is compared as it is, several
/// by how they change from one to the next. Where the references are black, errors are set against `unshadowed`; where
/// that is black as well, any error is infinite.
pub fn figure(
    pictures: &[Vec<Vec3>],
    references: &[Vec<Vec3>],
    unshadowed: &[Vec<Vec3>],
    mask: &[bool],
) -> Figure {
    let taken = || (0..mask.len()).filter(|&pixel| mask[pixel]);
    let strength = |images: &[Vec<Vec3>]| {
        let values = || images.iter().flat_map(|image| taken().map(|pixel| image[pixel].as_dvec3()));
        let energy: f64 = values().map(glam::DVec3::length_squared).sum();
        (energy, values().fold(0.0f64, |peak, value| peak.max(value.max_element())))
    };
    let (energy, peak) = match strength(references) {
        (0.0, _) => strength(unshadowed),
        found => found,
    };
    let (mut error, mut worst) = (0.0, 0.0f64);
    for index in usize::from(references.len() > 1)..references.len() {
        for pixel in taken() {
            let off = |index: usize| pictures[index][pixel].as_dvec3() - references[index][pixel].as_dvec3();
            let difference = if references.len() > 1 { off(index) - off(index - 1) } else { off(index) };
            error += difference.length_squared();
            worst = worst.max(difference.abs().max_element());
        }
    }
    let over = |part: f64, whole: f64| if part == 0.0 { 0.0 } else { part / whole };
    Figure { nmse2: over(error, energy), worst: over(worst, peak) }
}

/// Returns the verdict on a figure.
pub fn judge(figure: &Figure, yardsticks: &Yardsticks) -> Verdict {
    let times = yardsticks.times(figure.nmse2);
    if figure.nmse2 > FAILS || yardsticks.shadow_is_lost(figure.nmse2) {
        Verdict::Wrong(times)
    } else if times > DEGRADED {
        Verdict::Degraded(times)
    } else {
        Verdict::Pass
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half light, half shadow.
    fn reference() -> Vec<Vec3> {
        (0..64).map(|pixel| if pixel % 8 < 4 { Vec3::ONE } else { Vec3::splat(0.25) }).collect()
    }

    fn verdict(picture: &[Vec3]) -> Verdict {
        let without_shadow = vec![Vec3::ONE; 64];
        let of = |picture: Vec<Vec3>| figure(&[picture], &[reference()], &[reference()], &[true; 64]);
        let yardsticks = Yardsticks { easy: 1e-4, every_pixel: 1e-5, unshadowed: of(without_shadow).nmse2 };
        judge(&of(picture.to_vec()), &yardsticks)
    }

    #[test]
    fn a_right_picture_passes_and_wrong_ones_do_not() {
        assert_eq!(verdict(&reference()), Verdict::Pass);
        let noisy = |size: f32| -> Vec<Vec3> {
            let sign = |pixel: usize| if pixel.is_multiple_of(2) { size } else { -size };
            reference().iter().enumerate().map(|(pixel, value)| *value + sign(pixel)).collect()
        };
        // RMS irradiance is 0.73: noise of 0.01 is an NMSE₂ of 1.9e-4, twice the easy case's; 0.03 is 17 times.
        assert_eq!(verdict(&noisy(0.01)), Verdict::Pass);
        assert!(matches!(verdict(&noisy(0.03)), Verdict::Degraded(times) if times > 16.0 && times < 18.0));
        for (name, picture) in [
            ("black", vec![Vec3::ZERO; 64]),
            ("flat", vec![Vec3::splat(0.6); 64]),
            ("without shadow", vec![Vec3::ONE; 64]),
            ("shifted", (0..64).map(|pixel| reference()[(pixel / 8) * 8 + (pixel + 1) % 8]).collect()),
        ] {
            assert_eq!(verdict(&picture).word(), "fails", "{name}");
        }
    }

    #[test]
    fn no_better_than_without_shadow_fails_however_faint_the_shadow() {
        let yardsticks = Yardsticks { easy: 0.0, every_pixel: 0.0, unshadowed: 1e-3 };
        let of = |nmse2| judge(&Figure { nmse2, worst: 0.0 }, &yardsticks).word();
        assert_eq!([of(3e-5), of(5e-4), of(1e-3)], ["pass", "degraded", "fails"]);
        // No shadow is lost where there is none, or none that 64 samples can tell.
        for unshadowed in [0.0, 1e-6] {
            let figure = Figure { nmse2: 2e-5, worst: 0.0 };
            assert_eq!(judge(&figure, &Yardsticks { unshadowed, ..yardsticks }), Verdict::Pass);
        }
    }

    #[test]
    fn a_poor_picture_in_the_easy_case_excuses_nothing() {
        let of = |easy| {
            judge(
                &Figure { nmse2: 8e-3, worst: 0.0 },
                &Yardsticks { easy, every_pixel: 0.0, unshadowed: 0.5 },
            )
        };
        assert_eq!(of(0.3), Verdict::Degraded(8.0));
        assert_eq!(of(5e-4), Verdict::Degraded(16.0));
    }

    #[test]
    fn values_that_are_no_light_are_found() {
        let broken = |value: f32| {
            let mut picture = reference();
            picture[10].y = value;
            sound(&picture, 8)
        };
        assert_eq!(broken(0.0), Ok(()));
        assert_eq!(broken(f32::NAN), Err(Fault::NotFinite { x: 2, y: 1 }));
        assert_eq!(broken(f32::INFINITY), Err(Fault::NotFinite { x: 2, y: 1 }));
        assert_eq!(broken(-1e-20), Err(Fault::Negative { x: 2, y: 1, value: -1e-20 }));
    }

    #[test]
    fn leaks_into_the_dark_are_set_against_what_the_light_could_do() {
        let black = vec![Vec3::ZERO; 4];
        let of = |picture: &[Vec3], unshadowed: f32, mask: [bool; 4]| {
            figure(
                &[picture.to_vec()],
                std::slice::from_ref(&black),
                &[vec![Vec3::splat(unshadowed); 4]],
                &mask,
            )
            .nmse2
        };
        let mut leak = black.clone();
        leak[3] = Vec3::splat(0.5);
        assert_eq!(of(&black, 1.0, [true; 4]), 0.0);
        assert_eq!(of(&leak, 1.0, [true; 4]), 0.0625);
        assert_eq!(of(&leak, 0.0, [true; 4]), f64::INFINITY);
        assert_eq!(of(&leak, 0.0, [true, true, true, false]), 0.0);
    }

    #[test]
    fn several_pictures_are_judged_by_their_changes() {
        let (still, offset) = (vec![Vec3::ONE; 4], vec![Vec3::splat(1.1); 4]);
        let of = |pictures: [&Vec<Vec3>; 2]| {
            let references = [still.clone(), still.clone()];
            figure(&pictures.map(Clone::clone), &references, &references, &[true; 4]).nmse2
        };
        // Steadily wrong does not flicker.
        assert_eq!(of([&offset, &offset]), 0.0);
        // One change of 0.1 in two pictures of 1; rounding of 1.1 to single precision.
        assert!((of([&still, &offset]) - 0.005).abs() < 1e-6);
    }
}
