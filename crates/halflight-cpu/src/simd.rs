//! SIMD vectors of single-precision numbers whose width is selected at run time.
//!
//! A `Kernel` is written once over the `Lanes` of a `Simd` level and compiled for each; `Isa::run` enters the
//! version for an instruction set that the CPU was found to have. No operation is fused or approximate, so
//! all versions give identical bits.

#![allow(unsafe_code)]

mod baseline;
#[cfg(target_arch = "x86_64")]
mod x86;

/// Vector of `WIDTH` numbers. Comparisons return one bit per lane, lane 0 lowest.
pub(crate) trait Lanes: Copy {
    /// Number of lanes.
    const WIDTH: usize;
    /// Mask of all lanes.
    const ALL: u32 = ((1u64 << Self::WIDTH) - 1) as u32;

    fn splat(value: f32) -> Self;
    /// Loads the first `WIDTH` numbers of `from`, which has at least as many.
    fn load(from: &[f32]) -> Self;
    /// Stores into the first `WIDTH` numbers of `to`, which has at least as many.
    fn store(self, to: &mut [f32]);
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    /// Returns `self < other ? self : other`.
    fn min(self, other: Self) -> Self;
    /// Returns `self > other ? self : other`.
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    /// Flips the sign bit of `self` where that of `signs` is set.
    fn flip(self, signs: Self) -> Self;
    /// Returns the lanes of `other` where `mask` has a bit, of `self` elsewhere.
    fn select(self, mask: u32, other: Self) -> Self;
    /// Rounds towards 0, for positive numbers that fit 32 bits.
    fn truncate(self) -> Self;
    /// Writes one word per lane, with bits `first .. end` set, into the first `WIDTH` words of `to`. Both
    /// bounds are integers, not negative, and clamped to 32.
    fn run_of_bits(first: Self, end: Self, to: &mut [u32; 16]);
    /// Random positions of samples in their strata, by the samples' integer indices:
    /// `unit_pair(sample_bits(key, index))` of [`halflight_core::hash`].
    fn jitter(key: u32, index: Self) -> (Self, Self);
    /// Least of all lanes, none of them NaN.
    fn least(self) -> f32;
    /// Greatest of all lanes, none of them NaN.
    fn greatest(self) -> f32;
    fn lt(self, other: Self) -> u32;
    fn le(self, other: Self) -> u32;
}

/// Vector types of one instruction set.
pub(crate) trait Simd: 'static {
    /// Widest vector.
    type Wide: Lanes;
    /// Vector of eight lanes, for data in groups of eight.
    type Eight: Lanes;

    /// Runs a kernel as a separate function: code that several kernels share is then compiled once for each
    /// instruction set.
    fn call<K: Kernel>(kernel: K) -> K::Output;

    /// Scatters the lowest bits of `bits` to the positions of the set bits of `mask` (PDEP).
    fn deposit(bits: u64, mask: u64) -> u64;
}

/// Code that is compiled for every instruction set. `run` and the functions it calls must be
/// `#[inline(always)]`.
pub(crate) trait Kernel {
    /// Result of the kernel.
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

/// Instruction set that this CPU has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Isa(Level);

impl Isa {
    /// Instruction set that every CPU of the architecture has.
    pub const BASELINE: Self = Self(Level::Baseline);

    /// Instruction sets of this CPU, narrowest first.
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

    /// Widest instruction set of this CPU.
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

    /// Sixteen numbers, many of them edge cases.
    const NUMBERS: [f32; 16] =
        [0.0, -0.0, 1.5, -2.25, 1e-20, 3e30, -7.0, 0.1, 0.3333, -1e-3, 5.0, 9.0, 1e9, 2.0, -4.0, 8.0];

    /// Kernel that collects the results of every operation on [`NUMBERS`] and on their rotation by `turn`, as
    /// bits, sixteen for each.
    struct Everything {
        turn: usize,
    }

    impl Kernel for Everything {
        type Output = [Vec<[u32; 16]>; 2];
        #[inline(always)]
        fn run<S: Simd>(self) -> Self::Output {
            [results::<S::Eight>(self.turn), results::<S::Wide>(self.turn)]
        }
    }

    #[inline(always)]
    fn results<L: Lanes>(turn: usize) -> Vec<[u32; 16]> {
        let mut turned = NUMBERS;
        turned.rotate_left(turn);
        let mut out = vec![[0; 16]; 16];
        for at in (0..16).step_by(L::WIDTH) {
            let (a, b) = (L::load(&NUMBERS[at..]), L::load(&turned[at..]));
            let mask = 0b1001_0110_0101_1010 >> at & L::ALL;
            let vectors = [
                a.add(b),
                a.sub(b),
                a.mul(b),
                b.abs().max(L::splat(0.5)).div(L::splat(3.0)),
                a.min(b),
                a.max(b),
                a.abs(),
                a.flip(b),
                a.select(mask, b),
                L::splat(NUMBERS[turn]),
                a.abs().min(L::splat(1e9)).truncate(),
            ];
            for (slots, vector) in out.iter_mut().zip(vectors) {
                let mut numbers = [0.0; 16];
                vector.store(&mut numbers);
                for lane in 0..L::WIDTH {
                    slots[at + lane] = numbers[lane].to_bits();
                }
            }
            let count = |x: L| x.max(L::splat(0.0)).min(L::splat(70.0)).truncate();
            let mut bits = [0; 16];
            L::run_of_bits(count(a), count(b), &mut bits);
            out[11][at..at + L::WIDTH].copy_from_slice(&bits[..L::WIDTH]);
            let (du, dv) = L::jitter(turn as u32, count(a));
            for (slots, vector) in out[14..].iter_mut().zip([du, dv]) {
                let mut numbers = [0.0; 16];
                vector.store(&mut numbers);
                for lane in 0..L::WIDTH {
                    slots[at + lane] = numbers[lane].to_bits();
                }
            }
            for (slots, bits) in out[12..].iter_mut().zip([a.lt(b), a.le(b)]) {
                assert_eq!(bits & !L::ALL, 0);
                for lane in 0..L::WIDTH {
                    slots[at + lane] = bits >> lane & 1;
                }
            }
        }
        out
    }

    #[test]
    fn all_instruction_sets_give_the_same_bits() {
        for turn in 0..16 {
            let [expected, _] = Isa::BASELINE.run(Everything { turn });
            assert_eq!(expected[0][3], (NUMBERS[3] + NUMBERS[(3 + turn) % 16]).to_bits());
            for isa in Isa::available() {
                let [eight, wide] = isa.run(Everything { turn });
                assert_eq!(eight, expected, "{isa:?}, eight lanes, {turn}");
                assert_eq!(wide, expected, "{isa:?}, all lanes, {turn}");
            }
        }
    }
}
