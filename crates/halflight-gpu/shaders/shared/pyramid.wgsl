// Discontinuities of geometry: two words a cell, level by level. The first is the bits of the largest depth derivative, plus one, or
// 0 where the cell holds no receiver; the second the bits of the largest curvature. Bits of positive floats have their order.
//@ writes pyramid

// Stands for infinity, where a receiver borders on nothing.
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
