// Geometric discontinuities of cells, level by level: two words per cell. The first is the bits of the
// largest depth derivative, plus one, or 0 where the cell holds no receiver; the second is the bits of the
// largest curvature. Bits of positive floats are ordered as the floats.
//@ writes pyramid

// Finite stand-in for infinity, where a receiver borders on the background.
const ENDLESS: f32 = 1.7e38;

fn pyramid_has_receiver(index: u32) -> bool {
    return atomicLoad(&pyramid[2u * index]) != 0u;
}

fn pyramid_depth(index: u32) -> f32 {
    return bitcast<f32>(max(atomicLoad(&pyramid[2u * index]), 1u) - 1u);
}

fn pyramid_curvature(index: u32) -> f32 {
    return bitcast<f32>(atomicLoad(&pyramid[2u * index + 1u]));
}
