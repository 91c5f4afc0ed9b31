//! Vectors of AVX2 and AVX-512.

use std::arch::x86_64::*;

use super::{Kernel, Lanes, Simd};

/// Constants of [`halflight_core::hash::sample_bits`].
const STEP: i32 = 0x9e37_79b9u32 as i32;
const MULTIPLIERS: [i32; 2] = [0x21f0_aaad, 0xd35a_2d97u32 as i32];

struct Avx2;
struct Avx512;

impl Simd for Avx2 {
    type Wide = Lanes8;
    type Eight = Lanes8;

    #[inline(always)]
    fn call<K: Kernel>(kernel: K) -> K::Output {
        // SAFETY: kernels of this instruction set only run where the CPU has it (`Isa::run`).
        unsafe { avx2(kernel) }
    }

    #[inline(always)]
    fn deposit(bits: u64, mask: u64) -> u64 {
        // SAFETY: as above.
        unsafe { _pdep_u64(bits, mask) }
    }
}

impl Simd for Avx512 {
    type Wide = Lanes16;
    type Eight = Lanes8;

    #[inline(always)]
    fn call<K: Kernel>(kernel: K) -> K::Output {
        // SAFETY: kernels of this instruction set only run where the CPU has it (`Isa::run`).
        unsafe { avx512(kernel) }
    }

    #[inline(always)]
    fn deposit(bits: u64, mask: u64) -> u64 {
        // SAFETY: as above.
        unsafe { _pdep_u64(bits, mask) }
    }
}

/// Runs a kernel compiled for AVX2. Callers ensure that the CPU has the features.
#[inline(never)]
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
pub(super) fn avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx2>()
}

/// Runs a kernel compiled for AVX-512. Callers ensure that the CPU has the features.
#[inline(never)]
#[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,bmi1,bmi2,popcnt,lzcnt")]
pub(super) fn avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx512>()
}

/// Defines methods that are one intrinsic each.
macro_rules! methods {
    ($($name:ident($($argument:ident: $type:ty),*) -> $result:ty = $value:expr;)*) => {
        $(
            #[inline(always)]
            fn $name($($argument: $type),*) -> $result {
                // SAFETY: this type is used by kernels of its instruction set alone, and these only run where the
                // processor has it (`Isa::run`). Loads and stores check their slice's length first.
                unsafe { $value }
            }
        )*
    };
}

#[derive(Clone, Copy)]
pub(crate) struct Lanes8(__m256);

impl Lanes for Lanes8 {
    const WIDTH: usize = 8;

    methods! {
        splat(value: f32) -> Self = Self(_mm256_set1_ps(value));
        load(from: &[f32]) -> Self = Self(_mm256_loadu_ps(from[..8].as_ptr()));
        store(self: Self, to: &mut [f32]) -> () = _mm256_storeu_ps(to[..8].as_mut_ptr(), self.0);
        add(self: Self, other: Self) -> Self = Self(_mm256_add_ps(self.0, other.0));
        sub(self: Self, other: Self) -> Self = Self(_mm256_sub_ps(self.0, other.0));
        mul(self: Self, other: Self) -> Self = Self(_mm256_mul_ps(self.0, other.0));
        div(self: Self, other: Self) -> Self = Self(_mm256_div_ps(self.0, other.0));
        min(self: Self, other: Self) -> Self = Self(_mm256_min_ps(self.0, other.0));
        max(self: Self, other: Self) -> Self = Self(_mm256_max_ps(self.0, other.0));
        abs(self: Self) -> Self = Self(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0));
        flip(self: Self, signs: Self) -> Self =
            Self(_mm256_xor_ps(self.0, _mm256_and_ps(signs.0, _mm256_set1_ps(-0.0))));
        select(self: Self, mask: u32, other: Self) -> Self = {
            let lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let chosen = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(mask as i32), lane), lane);
            Self(_mm256_blendv_ps(self.0, other.0, _mm256_castsi256_ps(chosen)))
        };
        truncate(self: Self) -> Self = Self(_mm256_round_ps::<{ _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC }>(self.0));
        run_of_bits(first: Self, end: Self, to: &mut [u32; 16]) -> () = {
            let (first, end) = (_mm256_cvttps_epi32(first.0), _mm256_cvttps_epi32(end.0));
            let all = _mm256_set1_epi32(-1);
            let bits = _mm256_andnot_si256(_mm256_sllv_epi32(all, end), _mm256_sllv_epi32(all, first));
            _mm256_storeu_si256(to.as_mut_ptr().cast(), bits);
        };
        jitter(key: u32, index: Self) -> (Self, Self) = {
            let (one, two) = (_mm256_set1_epi32(MULTIPLIERS[0]), _mm256_set1_epi32(MULTIPLIERS[1]));
            let step = _mm256_set1_epi32(STEP);
            let mut x = _mm256_mullo_epi32(_mm256_cvttps_epi32(index.0), step);
            x = _mm256_add_epi32(x, _mm256_set1_epi32(key as i32));
            x = _mm256_mullo_epi32(_mm256_xor_si256(x, _mm256_srli_epi32::<16>(x)), one);
            x = _mm256_mullo_epi32(_mm256_xor_si256(x, _mm256_srli_epi32::<15>(x)), two);
            x = _mm256_xor_si256(x, _mm256_srli_epi32::<15>(x));
            let low = _mm256_and_si256(x, _mm256_set1_epi32(0xffff));
            let (half, scale) = (_mm256_set1_ps(0.5), _mm256_set1_ps(1.0 / 65536.0));
            let high = _mm256_cvtepi32_ps(_mm256_srli_epi32::<16>(x));
            let (u, v) = (_mm256_add_ps(high, half), _mm256_add_ps(_mm256_cvtepi32_ps(low), half));
            (Self(_mm256_mul_ps(u, scale)), Self(_mm256_mul_ps(v, scale)))
        };
        least(self: Self) -> f32 = {
            let four = _mm_min_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
            let two = _mm_min_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)))
        };
        greatest(self: Self) -> f32 = {
            let four = _mm_max_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
            let two = _mm_max_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_max_ss(two, _mm_movehdup_ps(two)))
        };
        lt(self: Self, other: Self) -> u32 = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) as u32;
        le(self: Self, other: Self) -> u32 = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)) as u32;
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Lanes16(__m512);

impl Lanes for Lanes16 {
    const WIDTH: usize = 16;

    methods! {
        splat(value: f32) -> Self = Self(_mm512_set1_ps(value));
        load(from: &[f32]) -> Self = Self(_mm512_loadu_ps(from[..16].as_ptr()));
        store(self: Self, to: &mut [f32]) -> () = _mm512_storeu_ps(to[..16].as_mut_ptr(), self.0);
        add(self: Self, other: Self) -> Self = Self(_mm512_add_ps(self.0, other.0));
        sub(self: Self, other: Self) -> Self = Self(_mm512_sub_ps(self.0, other.0));
        mul(self: Self, other: Self) -> Self = Self(_mm512_mul_ps(self.0, other.0));
        div(self: Self, other: Self) -> Self = Self(_mm512_div_ps(self.0, other.0));
        min(self: Self, other: Self) -> Self = Self(_mm512_min_ps(self.0, other.0));
        max(self: Self, other: Self) -> Self = Self(_mm512_max_ps(self.0, other.0));
        abs(self: Self) -> Self = Self(_mm512_andnot_ps(_mm512_set1_ps(-0.0), self.0));
        flip(self: Self, signs: Self) -> Self =
            Self(_mm512_xor_ps(self.0, _mm512_and_ps(signs.0, _mm512_set1_ps(-0.0))));
        select(self: Self, mask: u32, other: Self) -> Self =
            Self(_mm512_mask_blend_ps(mask as u16, self.0, other.0));
        truncate(self: Self) -> Self =
            Self(_mm512_roundscale_ps::<{ _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC }>(self.0));
        run_of_bits(first: Self, end: Self, to: &mut [u32; 16]) -> () = {
            let (first, end) = (_mm512_cvttps_epi32(first.0), _mm512_cvttps_epi32(end.0));
            let all = _mm512_set1_epi32(-1);
            let bits = _mm512_andnot_si512(_mm512_sllv_epi32(all, end), _mm512_sllv_epi32(all, first));
            _mm512_storeu_si512(to.as_mut_ptr().cast(), bits);
        };
        jitter(key: u32, index: Self) -> (Self, Self) = {
            let (one, two) = (_mm512_set1_epi32(MULTIPLIERS[0]), _mm512_set1_epi32(MULTIPLIERS[1]));
            let step = _mm512_set1_epi32(STEP);
            let mut x = _mm512_mullo_epi32(_mm512_cvttps_epi32(index.0), step);
            x = _mm512_add_epi32(x, _mm512_set1_epi32(key as i32));
            x = _mm512_mullo_epi32(_mm512_xor_si512(x, _mm512_srli_epi32::<16>(x)), one);
            x = _mm512_mullo_epi32(_mm512_xor_si512(x, _mm512_srli_epi32::<15>(x)), two);
            x = _mm512_xor_si512(x, _mm512_srli_epi32::<15>(x));
            let low = _mm512_and_si512(x, _mm512_set1_epi32(0xffff));
            let (half, scale) = (_mm512_set1_ps(0.5), _mm512_set1_ps(1.0 / 65536.0));
            let high = _mm512_cvtepi32_ps(_mm512_srli_epi32::<16>(x));
            let (u, v) = (_mm512_add_ps(high, half), _mm512_add_ps(_mm512_cvtepi32_ps(low), half));
            (Self(_mm512_mul_ps(u, scale)), Self(_mm512_mul_ps(v, scale)))
        };
        least(self: Self) -> f32 = _mm512_reduce_min_ps(self.0);
        greatest(self: Self) -> f32 = _mm512_reduce_max_ps(self.0);
        lt(self: Self, other: Self) -> u32 = u32::from(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0));
        le(self: Self, other: Self) -> u32 = u32::from(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0));
    }
}
