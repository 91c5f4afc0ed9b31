//! Lights of the emissive faces of a mesh.
//!
//! Triangles of one emissive material that meet at edges which are not sharp are an *emitter*. A flat emitter with a convex outline of at
//! most 12 corners becomes a light: a parallelogram where its outline is one, else a polygon. It emits from the front, the side from which
//! the corners of its faces run counterclockwise. Its triangles stay in the mesh, behind the light: they are flush with it
//! (`halflight_cpu::flush`), or the light is moved before them.

mod outline;
mod patches;
mod refusal;

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use halflight_core::light::AreaLight;
use halflight_core::scene::Mesh;

use crate::context::Context;
use crate::emission::Emission;
use outline::{Flat, outline};
use patches::{Welded, patches};
use refusal::{Refusal, Refusals};

/// Most lights of the emissive faces of a scene. Each light costs as much as an image of its own.
pub(crate) const MAX_LIGHTS: usize = 64;

/// Largest gap by which an outline of four corners misses a parallelogram, relative to its size: exporters write six decimals, and every
/// point of the light then lies within as much of the emitter.
const CLOSED: f64 = 1e-5;

/// Distance of a triangle before a light's plane, relative to the largest coordinate, up to which rendering takes both as flush: half of
/// `halflight_cpu::flush::FLUSH`, since the light's own coordinates are rounded as well.
const FLUSH: f64 = 16.0 / 16_777_216.0;

/// Returns the lights of a mesh in world space, in the order of their first triangles. `materials` has a material for each triangle,
/// `emission` the emission of each material; messages call the mesh `source`.
///
/// # Errors
/// Returns the reason why there is no light at all. Other emitters that cannot be lights are warnings.
pub(crate) fn lights(
    mesh: &Mesh,
    materials: &[u32],
    emission: &[Option<Emission>],
    source: &str,
    context: &mut Context,
) -> Result<Vec<AreaLight>, String> {
    let emission = |material: u32| emission.get(material as usize).and_then(Option::as_ref);
    let mut emissive: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (triangle, &material) in materials.iter().enumerate() {
        if emission(material).is_some() {
            emissive.entry(material).or_default().push(triangle);
        }
    }
    let mut lights: Vec<(usize, AreaLight)> = Vec::new();
    let mut refused: Vec<String> = Vec::new();
    for (material, triangles) in emissive {
        let Some(emission) = emission(material) else { continue };
        let welded = Welded::of(mesh, &triangles);
        let mut refusals = Refusals::default();
        for patch in patches(&welded) {
            let light = if emission.textured {
                Err(Refusal::Textured)
            } else {
                light(&welded, &patch, emission.radiance)
            };
            match light {
                Ok(light) => {
                    refusals.count();
                    lights.push((welded.first(&patch), light));
                }
                Err(refusal) => refusals.add(refusal, welded.corner(&patch)),
            }
        }
        refused.extend(refusals.message(emission, source));
    }
    if lights.is_empty() {
        let none = || format!("no face of `{source}` has a material with Ke above 0 and an area");
        return Err(refused.into_iter().next().unwrap_or_else(none));
    }
    refused.into_iter().for_each(|message| context.warn(message));
    lights.sort_by_key(|&(triangle, _)| triangle);
    Ok(lights.into_iter().map(|(_, light)| light).collect())
}

/// Light of an emitter.
fn light(welded: &Welded, patch: &[usize], radiance: Vec3) -> Result<AreaLight, Refusal> {
    let Flat { corners, size } = outline(welded, patch)?;
    let light = match corners[..] {
        [a, b, c, d] if closes([a, b, c, d], size) => AreaLight::parallelogram(a, b - a, d - a, radiance),
        _ => AreaLight::polygon(&corners, radiance).map_err(Refusal::Polygon)?,
    };
    light.validate(0)?;
    Ok(before_faces(light.visible(), welded, patch))
}

/// True if four corners are those of a parallelogram, but for the rounding of coordinates in files and in single precision.
fn closes(corners: [Vec3; 4], size: f64) -> bool {
    let largest = corners.iter().fold(0.0, |most: f32, corner| most.max(corner.abs().max_element()));
    let [a, b, c, d] = corners.map(Vec3::as_dvec3);
    (a - b + c - d).length() <= CLOSED * size + 4.0 * f64::from(f32::EPSILON * largest)
}

/// Light that lies before all corners of its emitter or flush with them. Faces that are flat only within the digits of their file would
/// hide parts of it otherwise.
fn before_faces(light: AreaLight, welded: &Welded, patch: &[usize]) -> AreaLight {
    let normal = light.vector_area().as_dvec3().normalize_or_zero();
    let origin = light.frame().origin.as_dvec3();
    let corners = || patch.iter().flat_map(|&triangle| welded.corners(triangle));
    let height = corners().map(|corner| (corner - origin).dot(normal)).fold(0.0, f64::max);
    let largest = corners().fold(0.0, |most: f64, corner: DVec3| most.max(corner.abs().max_element()));
    if height <= FLUSH * largest { light } else { light.moved((normal * height).as_vec3()) }
}
