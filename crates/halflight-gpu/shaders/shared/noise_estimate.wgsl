// Noise of a mask from its differing neighbours (halflight-cpu/src/refine/target.rs).

// Expected squared error over the fraction of differing neighbouring samples, as on the CPU.
const NOISE: f32 = 0.12;

// Relative growth of the noise where all samples of the rarer kind are isolated, as on the CPU.
const ALONE: f32 = 1.1;

struct Noise {
    // Expected squared error of the visible fraction.
    variance: f32,
    // Fraction of differing neighbouring samples.
    disagreement: f32,
}

// Numbers of samples and of pairs of neighbours.
struct Neighbours {
    lit: u32,
    count: u32,
    pairs: u32,
    // Pairs of which one sample is visible.
    differ: u32,
}

// Noise of a mask whose differing pairs weigh `weight` of a `whole`.
fn noise_of(found: Neighbours, weight: f32, whole: f32) -> Noise {
    if found.lit == 0u || found.lit == found.count || whole <= 0.0 {
        return Noise(0.0, 0.0);
    }
    let rarer = f32(min(found.lit, found.count - found.lit));
    let alone = clamp((f32(found.differ) / rarer - 1.0) / 3.0, 0.0, 1.0);
    let variance = NOISE * (1.0 + ALONE * alone) * weight / whole;
    return Noise(variance, f32(found.differ) / f32(max(found.pairs, 1u)));
}
