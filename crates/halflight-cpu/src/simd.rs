//! Vectors of single-precision numbers whose width is chosen at run time.
//!
//! A [`Kernel`] is written once over the [`Lanes`] of a [`Simd`] level and compiled for each; [`Isa::run`] enters the
//! version for an instruction set that the processor was found to have. No operation is fused or approximate, so all
//! versions give the same bits.

#![allow(unsafe_code)]

mod baseline;
#[cfg(target_arch = "x86_64")]
mod x86;

/// A vector of `WIDTH` numbers. Comparisons give one bit a lane, lane 0 lowest.
pub(crate) trait Lanes: Copy {
    /// Number of lanes.
    const WIDTH: usize;
    /// One bit for each lane.
    const ALL: u32 = ((1u64 << Self::WIDTH) - 1) as u32;

    fn splat(value: f32) -> Self;
    /// The first `WIDTH` numbers of `from`, which has at least as many.
    fn load(from: &[f32]) -> Self;
    /// Into the first `WIDTH` numbers of `to`, which has at least as many.
    fn store(self, to: &mut [f32]);
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    /// `self < other ? self : other`.
    fn min(self, other: Self) -> Self;
    /// `self > other ? self : other`.
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    /// Flips the sign bit of `self` where that of `signs` is set.
    fn flip(self, signs: Self) -> Self;
    /// Lanes of `other` where `mask` has a bit, of `self` elsewhere.
    fn select(self, mask: u32, other: Self) -> Self;
    fn lt(self, other: Self) -> u32;
    fn le(self, other: Self) -> u32;
}

/// The vectors of one instruction set.
pub(crate) trait Simd: 'static {
    /// The widest.
    type Wide: Lanes;
    /// Eight lanes, for data that comes in eights.
    type Eight: Lanes;
}

/// Work that is compiled for every instruction set. `run` and what it calls must be `#[inline(always)]`.
pub(crate) trait Kernel {
    /// What it gives.
    type Output;
    fn run<S: Simd>(self) -> Self::Output;
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// An instruction set that this processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Isa(Level);

impl Isa {
    /// What every processor of the architecture has.
    pub const BASELINE: Self = Self(Level::Baseline);

    /// All that this processor has, narrowest first.
    pub fn available() -> impl Iterator<Item = Self> {
        let mut levels = [Some(Self::BASELINE), None, None];
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            let avx2 = has!("avx2") && has!("bmi1") && has!("bmi2") && has!("popcnt") && has!("lzcnt");
            let avx512 = avx2 && has!("avx512f") && has!("avx512dq") && has!("avx512bw") && has!("avx512vl");
            levels[1] = avx2.then_some(Self(Level::Avx2));
            levels[2] = avx512.then_some(Self(Level::Avx512));
        }
        levels.into_iter().flatten()
    }

    /// The widest that this processor has.
    pub fn best() -> Self {
        Self::available().last().unwrap_or(Self::BASELINE)
    }

    /// Runs the kernel's version for this instruction set.
    #[inline]
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Level::Baseline => kernel.run::<baseline::Baseline>(),
            // SAFETY: an `Isa` with this level is only made where its features were detected.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { x86::avx2(kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { x86::avx512(kernel) },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation over awkward numbers, results side by side.
    struct Everything;

    impl Kernel for Everything {
        type Output = Vec<u32>;
        #[inline(always)]
        fn run<S: Simd>(self) -> Vec<u32> {
            let mut out = all::<S::Eight>();
            out.extend(all::<S::Wide>());
            out
        }
    }

    #[inline(always)]
    fn all<L: Lanes>() -> Vec<u32> {
        let numbers =
            [0.0, -0.0, 1.5, -2.25, 1e-20, 3e30, -7.0, 0.1, 1.0 / 3.0, -1e-3, 5.0, 9.0, 1e9, 2.0, -4.0, 8.0];
        let mut out = Vec::new();
        let mut push = |bits: &mut dyn Iterator<Item = u32>| out.extend(bits);
        for shift in 0..16 {
            let rotated: Vec<f32> = (0..16).map(|lane| numbers[(lane + shift) % 16]).collect();
            // 16 numbers whatever the width, so that all levels give equally long lists.
            for half in (0..16).step_by(L::WIDTH) {
                let (a, b) = (L::load(&numbers[half..]), L::load(&rotated[half..]));
                let mut store = |value: L| {
                    let mut slots = [0.0f32; 16];
                    value.store(&mut slots);
                    push(&mut slots[..L::WIDTH].iter().map(|x| x.to_bits()));
                };
                store(a.min(b));
                store(a.max(b));
                store(a.abs());
                store(a.flip(b));
                store(a.select(0b1001_0110_0101_1010 >> half & L::ALL, b));
                // NaN of 0/0 and ∞−∞ has no fixed sign bit: only defined results are compared.
                store(a.add(b));
                store(a.sub(b));
                store(a.mul(b));
                store(b.max(L::splat(0.5)).div(L::splat(3.0)));
                let (less, at_most) = (a.lt(b), a.le(b));
                for lane in 0..L::WIDTH {
                    push(&mut [less >> lane & 1, at_most >> lane & 1].into_iter());
                }
                assert_eq!((less | at_most) & !L::ALL, 0);
            }
        }
        out
    }

    #[test]
    fn all_instruction_sets_give_the_same_bits() {
        let sorted = |isa: Isa| {
            let mut bits = isa.run(Everything);
            bits.sort_unstable();
            bits
        };
        let expected = sorted(Isa::BASELINE);
        assert!(expected.len() > 4000);
        for isa in Isa::available() {
            assert_eq!(sorted(isa), expected, "{isa:?}");
        }
    }
}
