//! Outlines of flat emitters.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use super::patches::Welded;
use super::refusal::Refusal;

/// Largest distance of a corner from the emitter's plane, relative to its size: that of polygons (`halflight_core::light::Polygon`).
const FLAT: f64 = 1e-4;

/// Largest distance of a point of the outline from the line between its neighbours, relative to the emitter's size, at which it is no
/// corner: exporters write six decimals.
const STRAIGHT: f64 = 1e-5;

/// Outline of a flat emitter.
pub(super) struct Flat {
    /// Corners, counterclockwise as seen from the front, the first one of the first triangle that has one.
    pub(super) corners: Vec<Vec3>,
    /// Largest distance of a point from the first, metres.
    pub(super) size: f64,
}

/// Returns the outline of an emitter.
///
/// # Errors
/// The emitter is not flat, has no area, or its outline is not one closed line.
pub(super) fn outline(welded: &Welded, patch: &[usize]) -> Result<Flat, Refusal> {
    let size = flat_size(welded, patch)?;
    let around = follow(welded, patch)?;
    let point = |number: u32| welded.points[number as usize].as_dvec3();
    let mut corners: Vec<u32> = Vec::new();
    for (index, &at) in around.iter().enumerate() {
        let before = corners.last().or(around.last()).copied().unwrap_or(at);
        let after = around[(index + 1) % around.len()];
        if !is_straight(point(before), point(at), point(after), STRAIGHT * size) {
            corners.push(at);
        }
    }
    let corners = corners.into_iter().map(|number| welded.points[number as usize]).collect();
    Ok(Flat { corners, size })
}

/// Size of an emitter, if it is flat.
fn flat_size(welded: &Welded, patch: &[usize]) -> Result<f64, Refusal> {
    let corners = || patch.iter().map(|&triangle| welded.corners(triangle));
    let origin = corners().next().map_or(DVec3::ZERO, |[first, ..]| first);
    let area: DVec3 = corners().map(|[a, b, c]| (b - a).cross(c - a)).sum();
    let size = corners().flatten().map(|corner| (corner - origin).length()).fold(0.0, f64::max);
    let normal = area.normalize_or_zero();
    let away = corners().flatten().map(|corner| (corner - origin).dot(normal).abs()).fold(0.0, f64::max);
    // The area of a closed surface is zero.
    let turned = corners().any(|[a, b, c]| (b - a).cross(c - a).dot(normal) <= 0.0);
    if turned || away > FLAT * size { Err(Refusal::Curved) } else { Ok(size) }
}

/// Points around an emitter, from the first corner of its first triangle that lies on the outline.
fn follow(welded: &Welded, patch: &[usize]) -> Result<Vec<u32>, Refusal> {
    // Numbers of triangles on the left of an edge.
    let mut left: HashMap<[u32; 2], u32> = HashMap::new();
    let edges = || {
        let triangles = patch.iter().map(|&triangle| welded.triangles[triangle]);
        triangles.flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
    };
    for edge in edges() {
        *left.entry(edge).or_default() += 1;
    }
    if left.values().any(|&count| count > 1) {
        return Err(Refusal::Overlap);
    }
    let mut after = HashMap::new();
    for [from, to] in edges().filter(|&[from, to]| !left.contains_key(&[to, from])) {
        if after.insert(from, to).is_some() {
            return Err(Refusal::Holes);
        }
    }
    let mut around = Vec::with_capacity(after.len());
    let mut next = edges().map(|[from, _]| from).find(|from| after.contains_key(from));
    while let Some(at) = next {
        around.push(at);
        // Every point is left once, so that the walk ends.
        next = after.remove(&at).filter(|to| after.contains_key(to));
    }
    if after.is_empty() { Ok(around) } else { Err(Refusal::Holes) }
}

/// True if `at` lies between its neighbours, within `distance` of the line through them.
fn is_straight(before: DVec3, at: DVec3, after: DVec3, distance: f64) -> bool {
    let along = after - before;
    let forward = (at - before).dot(after - at) > 0.0;
    forward && (at - before).cross(along).length() <= distance * along.length()
}
