//! One step of propagation: every cell receives flux from its six neighbours through its other five faces.
//!
//! A neighbour's intensity is taken in the direction of each face's middle, times the solid angle that the face has from the neighbour's middle; what arrives
//! at a face leaves the cell along the face's cosine lobe (Kaplanyan and Dachsbacher 2010 §4.2). In harmonics, with intensities that nowhere fall below 0,
//! no flux is lost or made: the solid angles of the thirty faces are the whole sphere.

use std::f32::consts::FRAC_1_PI;

use rayon::prelude::*;

use super::grid::{Blocking, CONSTANT, Grid, HARMONICS, LINEAR, LOBE_CONSTANT, LOBE_LINEAR, VALUES, Volume};
use crate::multiversion::multiversion;

/// Solid angle of the far face of a neighbour, 4 asin(1/10), sr.
const FAR: f32 = 0.400_669_7;

/// Solid angle of each of the other four, (4π/6 − far) / 4, sr.
const SIDE: f32 = 0.423_431_4;

/// Longest row of cells that is worked on at a time.
const ROW: usize = 64;

/// Way from a neighbour's middle to the middle of a face.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// Unit direction.
    direction: [f32; 3],
    /// Solid angle over π.
    weight: f32,
    /// Part of the light that surfaces across each axis block, in what they block of light along that axis: the direction over its part across the face
    /// between the neighbour and the cell.
    blocks: [f32; 3],
    /// Axis across the face, and the side on which it lies.
    axis: usize,
    side: f32,
}

/// Ways from the neighbour that lies `side` (1 or -1) along `axis` back: through a cell's far face and its four faces beside.
fn ways(axis: usize, side: f32) -> [Way; 5] {
    let mut ways = [Way { direction: [0.0; 3], weight: FAR * FRAC_1_PI, blocks: [0.0; 3], axis, side }; 5];
    ways[0].direction[axis] = side;
    let beside = [(1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)];
    // From the middle of the neighbour, one cell along the axis and half a cell to the side.
    let (along, across) = (2.0 / 5f32.sqrt(), 1.0 / 5f32.sqrt());
    for (way, (turn, to)) in ways[1..].iter_mut().zip(beside) {
        let other = (axis + turn) % 3;
        (way.axis, way.side, way.weight) = (other, to, SIDE * FRAC_1_PI);
        (way.direction[axis], way.direction[other]) = (along * side, across * to);
    }
    for way in &mut ways {
        way.blocks = way.direction.map(|part| (part / way.direction[axis]).abs());
    }
    ways
}

/// Computes what all cells receive in one step.
pub(super) fn step(grid: &Grid, from: &Volume, blocking: Option<&Blocking>, to: &mut Volume) {
    let [columns, rows, layers] = grid.cells;
    let (count, strides) = (grid.len(), grid.strides());
    // The cells at the ends stay empty, so that every other one has six neighbours.
    let row = |layer: usize, row: usize| layer * strides[2] + row * strides[1];
    let mut planes: Vec<&mut [f32]> = to.values.chunks_mut(count.max(1)).collect();
    let mut work: Vec<[&mut [f32]; VALUES]> = (0..layers)
        .map(|_| {
            std::array::from_fn(|value| {
                let (layer, rest) = std::mem::take(&mut planes[value]).split_at_mut(strides[2]);
                planes[value] = rest;
                layer
            })
        })
        .collect();
    let inner = work.iter_mut().enumerate().skip(1).take(layers.saturating_sub(2)).collect::<Vec<_>>();
    inner.into_par_iter().for_each(|(layer, out)| {
        for y in 1..rows.saturating_sub(1) {
            let mut x = 1;
            while x + 1 < columns {
                let length = ROW.min(columns - 1 - x);
                let cell = row(layer, y) + x;
                let at = y * strides[1] + x;
                for channel in 0..3 {
                    let mut sums = [[0.0f32; ROW]; HARMONICS];
                    for (axis, &stride) in strides.iter().enumerate() {
                        for side in [1.0, -1.0] {
                            // Light that travels towards +axis comes from the neighbour below.
                            let neighbour = if side > 0.0 { cell - stride } else { cell + stride };
                            let face = if side > 0.0 { cell } else { cell + stride };
                            let blocked = blocking.map(|blocking| {
                                let parts = &blocking.faces[axis];
                                [0, 1, 2].map(|axis| &parts[axis][face..face + length])
                            });
                            let source = [0, 1, 2, 3].map(|harmonic| {
                                &from.plane(channel * HARMONICS + harmonic)[neighbour..neighbour + length]
                            });
                            for way in &ways(axis, side) {
                                pass(way, source, blocked, &mut sums);
                            }
                        }
                    }
                    for (harmonic, sums) in sums.iter().enumerate() {
                        out[channel * HARMONICS + harmonic][at..at + length].copy_from_slice(&sums[..length]);
                    }
                }
                x += length;
            }
        }
    });
}

multiversion! {
    /// Adds what arrives on one way at a row of cells.
    fn pass(way: &Way, source: [&[f32]; 4], blocked: Option<[&[f32]; 3]>, sums: &mut [[f32; ROW]; HARMONICS]) {
        let length = source[0].len().min(ROW);
        let [constant, x, y, z] = source.map(|source| &source[..length]);
        let [dx, dy, dz] = way.direction.map(|d| d * LINEAR);
        let mut flux = [0.0f32; ROW];
        for cell in 0..length {
            let intensity = CONSTANT * constant[cell] + dx * x[cell] + dy * y[cell] + dz * z[cell];
            flux[cell] = intensity.max(0.0) * way.weight;
        }
        if let Some(blocked) = blocked {
            let [bx, by, bz] = blocked.map(|blocked| &blocked[..length]);
            let [wx, wy, wz] = way.blocks;
            for cell in 0..length {
                flux[cell] *= 1.0 - (wx * bx[cell] + wy * by[cell] + wz * bz[cell]).min(1.0);
            }
        }
        let linear = LOBE_LINEAR * way.side;
        for (sum, flux) in sums[0][..length].iter_mut().zip(&flux) {
            *sum += LOBE_CONSTANT * flux;
        }
        for (sum, flux) in sums[1 + way.axis][..length].iter_mut().zip(&flux) {
            *sum += linear * flux;
        }
    }
}
