//! G-buffers: the nearest surface at each pixel.

use std::ops::RangeInclusive;

use glam::{DVec3, Vec3};

use crate::camera::{Camera, View};
use crate::limits::MAX_COORDINATE;
use crate::specular::SurfaceSpecular;

/// Marks a pixel that sees no geometry.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// A receiver: where shadow rays of a pixel start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Surface point moved off its surface along the geometric normal, world space.
    pub origin: Vec3,
    /// Unit shading normal, towards the viewer, by which light is weighted: the geometric one on flat surfaces.
    pub normal: Vec3,
}

/// One entry a pixel, row by row from the top left, sampled at pixel centres.
#[derive(Clone, Debug, Default)]
pub struct GBuffer {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Distance along the view direction, metres; infinite where nothing is seen.
    pub depth: Vec<f32>,
    /// Surface point moved off its surface by [`receiver_origin`], where shadow rays start, world space; zero where nothing
    /// is seen.
    pub position: Vec<Vec3>,
    /// Geometric unit normal towards the viewer, world space; zero where nothing is seen.
    pub normal: Vec<Vec3>,
    /// Unit shading normal, on the side of the geometric one, world space; zero where nothing is seen. Empty where no surface of the
    /// scene is smooth: see [`GBuffer::shading_normals`].
    pub shading: Vec<Vec3>,
    /// Linear RGB albedo, of diffuse reflection; zero where nothing is seen.
    pub albedo: Vec<Vec3>,
    /// Specular reflection. Empty where no surface of the scene is glossy.
    pub specular: Vec<SurfaceSpecular>,
    /// Triangle index in the scene's mesh, or [`NO_PRIMITIVE`].
    pub primitive: Vec<u32>,
}

/// Faults of a G-buffer that a caller brings.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GBufferError {
    /// A layer has another number of entries than the image has pixels.
    #[error("the G-buffer's {layer} has {found} entries, expected one a pixel: {expected}")]
    Length {
        /// Name of the layer.
        layer: &'static str,
        /// Its number of entries.
        found: usize,
        /// Number of pixels.
        expected: usize,
    },
    /// A pixel that sees a surface has no usable point, normal or depth.
    #[error("the G-buffer's {layer} at pixel ({x}, {y}) is {fault}")]
    Pixel {
        /// Name of the layer.
        layer: &'static str,
        /// Column from the left.
        x: u32,
        /// Row from the top.
        y: u32,
        /// Reason, and the valid range.
        fault: &'static str,
    },
    /// The image has another size.
    #[error("the G-buffer has {}x{} pixels, the image {}x{}", found.0, found.1, expected.0, expected.1)]
    Size {
        /// Width and height of the G-buffer.
        found: (u32, u32),
        /// Width and height of the image.
        expected: (u32, u32),
    },
}

/// Lengths that count as 1.
const UNIT_LENGTH: RangeInclusive<f32> = 0.999..=1.001;

/// Surface points of a caller's G-buffer, one a pixel, row by row from the top left.
#[derive(Clone, Copy, Debug)]
pub enum SurfacePoints<'a> {
    /// World-space points.
    Positions(&'a [Vec3]),
    /// Distances along the view direction, metres.
    Depths(&'a [f32]),
}

/// Layer and fault of a pixel that sees something, if any; `layer` is the one that the point comes from.
fn surface_fault(
    layer: &'static str,
    normal: Vec3,
    point: DVec3,
    depth: f32,
    albedo: Vec3,
) -> Option<(&'static str, &'static str)> {
    // Points that were moved off surfaces at the limit lie a little beyond it.
    let farthest = 1.001 * f64::from(MAX_COORDINATE);
    if !UNIT_LENGTH.contains(&normal.length()) {
        Some(("normal", "not of length 1"))
    } else if !(0.0..farthest).contains(&point.abs().max_element()) {
        Some((layer, "not finite or 1e8 m or more from the origin"))
    } else if !(f32::MIN_POSITIVE..=f32::MAX).contains(&depth) {
        Some(("depth", "not in front of the camera"))
    } else if !(albedo.is_finite() && albedo.min_element() >= 0.0) {
        Some(("albedo", "negative or not finite"))
    } else {
        None
    }
}

impl GBuffer {
    /// Returns the G-buffer that a renderer of the caller's has drawn of `camera`'s view.
    ///
    /// `normals` are geometric unit normals towards the viewer, world space; zero where nothing is seen. `albedo` is linear RGB, 1
    /// where there is none. Points are moved off their surfaces by [`given_origin`]. Triangles are not known: every pixel has a
    /// number of its own, and refiners and upsamplers compare pixels by where their surfaces lie. Points must be rounded no worse
    /// than single precision does.
    ///
    /// # Errors
    /// A layer has the wrong length; or a pixel that sees something has a point, normal or albedo that cannot be used.
    pub fn from_surfaces(
        camera: &Camera,
        (width, height): (u32, u32),
        points: SurfacePoints,
        normals: &[Vec3],
        albedo: Option<&[Vec3]>,
    ) -> Result<Self, GBufferError> {
        let expected = width as usize * height as usize;
        let (layer, found) = match points {
            SurfacePoints::Positions(points) => ("position", points.len()),
            SurfacePoints::Depths(depths) => ("depth", depths.len()),
        };
        let lengths =
            [(layer, found), ("normal", normals.len()), ("albedo", albedo.map_or(expected, <[Vec3]>::len))];
        if let Some(&(layer, found)) = lengths.iter().find(|(_, found)| *found != expected) {
            return Err(GBufferError::Length { layer, found, expected });
        }
        let view = View::new(camera, width, height);
        let mut gbuffer = Self::default();
        gbuffer.reset(width, height);
        for (pixel, &normal) in normals.iter().enumerate() {
            if normal == Vec3::ZERO {
                continue;
            }
            let (x, y) = (pixel as u32 % width, pixel as u32 / width);
            let (point, depth) = match points {
                SurfacePoints::Positions(points) => {
                    let point = points[pixel].as_dvec3();
                    (point, (point - view.eye.as_dvec3()).dot(view.forward) as f32)
                }
                SurfacePoints::Depths(depths) => {
                    let d = view.direction(x as usize, y as usize).as_dvec3();
                    (view.eye.as_dvec3() + d * f64::from(depths[pixel]), depths[pixel])
                }
            };
            let albedo = albedo.map_or(Vec3::ONE, |albedo| albedo[pixel]);
            if let Some((layer, fault)) = surface_fault(layer, normal, point, depth, albedo) {
                return Err(GBufferError::Pixel { layer, x, y, fault });
            }
            gbuffer.depth[pixel] = depth;
            gbuffer.position[pixel] = given_origin(point, normal, depth);
            gbuffer.normal[pixel] = normal;
            gbuffer.albedo[pixel] = albedo;
            gbuffer.primitive[pixel] = pixel as u32;
        }
        Ok(gbuffer)
    }

    /// Adds shading normals, by which light is weighted instead of by the geometric ones: unit length, world space, on the side of
    /// the geometric normal, one a pixel; unused where nothing is seen.
    ///
    /// # Errors
    /// The layer has the wrong length; or a normal is not of length 1 or points away from the viewer's side of the surface.
    pub fn with_shading_normals(mut self, normals: &[Vec3]) -> Result<Self, GBufferError> {
        self.shading = normals.to_vec();
        self.validate_shading()?;
        for (shading, &primitive) in self.shading.iter_mut().zip(&self.primitive) {
            if primitive == NO_PRIMITIVE {
                *shading = Vec3::ZERO;
            }
        }
        Ok(self)
    }

    /// Adds specular reflection, one a pixel; unused where nothing is seen.
    ///
    /// # Errors
    /// The layer has the wrong length; or a reflectance or roughness lies outside 0 … 1.
    pub fn with_specular(mut self, specular: &[SurfaceSpecular]) -> Result<Self, GBufferError> {
        self.specular = specular.to_vec();
        self.validate_specular()?;
        Ok(self)
    }

    fn validate_specular(&self) -> Result<(), GBufferError> {
        let (found, expected) = (self.specular.len(), self.pixels());
        if found != expected {
            return Err(GBufferError::Length { layer: "specular reflection", found, expected });
        }
        let unit = |value: f32| (0.0..=1.0).contains(&value);
        let fits = |surface: &SurfaceSpecular| {
            unit(surface.roughness) && surface.f0.to_array().into_iter().all(unit)
        };
        let faulty = |&pixel: &usize| self.is_receiver(pixel) && !fits(&self.specular[pixel]);
        match (0..expected).find(faulty) {
            None => Ok(()),
            Some(pixel) => {
                let (x, y) = (pixel as u32 % self.width, pixel as u32 / self.width);
                let fault = "outside 0 to 1 in reflectance or roughness";
                Err(GBufferError::Pixel { layer: "specular reflection", x, y, fault })
            }
        }
    }

    fn validate_shading(&self) -> Result<(), GBufferError> {
        let (found, expected) = (self.shading.len(), self.pixels());
        if found != expected {
            return Err(GBufferError::Length { layer: "shading normal", found, expected });
        }
        for pixel in (0..expected).filter(|&pixel| self.is_receiver(pixel)) {
            let fault = if !UNIT_LENGTH.contains(&self.shading[pixel].length()) {
                "not of length 1"
            } else if self.shading[pixel].dot(self.normal[pixel]) < 0.0 {
                "on the other side of the surface than its normal"
            } else {
                continue;
            };
            let (x, y) = (pixel as u32 % self.width, pixel as u32 / self.width);
            return Err(GBufferError::Pixel { layer: "shading normal", x, y, fault });
        }
        Ok(())
    }

    /// Checks that every layer has one entry a pixel and that pixels which see something have finite points, unit normals and a
    /// positive depth.
    ///
    /// # Errors
    /// The first fault found.
    pub fn validate(&self) -> Result<(), GBufferError> {
        let expected = self.width as usize * self.height as usize;
        let lengths = [
            ("depth", self.depth.len()),
            ("position", self.position.len()),
            ("normal", self.normal.len()),
            ("albedo", self.albedo.len()),
            ("primitive", self.primitive.len()),
        ];
        if let Some((layer, found)) = lengths.into_iter().find(|(_, found)| *found != expected) {
            return Err(GBufferError::Length { layer, found, expected });
        }
        for pixel in (0..expected).filter(|&pixel| self.is_receiver(pixel)) {
            let (point, normal) = (self.position[pixel].as_dvec3(), self.normal[pixel]);
            let fault = surface_fault("position", normal, point, self.depth[pixel], self.albedo[pixel]);
            if let Some((layer, fault)) = fault {
                let (x, y) = (pixel as u32 % self.width, pixel as u32 / self.width);
                return Err(GBufferError::Pixel { layer, x, y, fault });
            }
        }
        if !self.specular.is_empty() {
            self.validate_specular()?;
        }
        if self.shading.is_empty() { Ok(()) } else { self.validate_shading() }
    }

    /// Sets the size and makes every pixel see nothing; keeps the memory.
    pub fn reset(&mut self, width: u32, height: u32) {
        let pixels = width as usize * height as usize;
        self.width = width;
        self.height = height;
        self.depth.resize(pixels, f32::INFINITY);
        self.position.resize(pixels, Vec3::ZERO);
        self.normal.resize(pixels, Vec3::ZERO);
        self.shading.clear();
        self.specular.clear();
        self.albedo.resize(pixels, Vec3::ZERO);
        self.primitive.resize(pixels, NO_PRIMITIVE);
    }

    /// Shading normals, one a pixel: the geometric ones where no surface is smooth.
    #[inline]
    pub fn shading_normals(&self) -> &[Vec3] {
        if self.shading.is_empty() { &self.normal } else { &self.shading }
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.primitive.len()
    }

    /// Index of pixel (x, y).
    #[inline]
    pub fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    /// Returns true if the pixel sees geometry, and so receives light.
    #[inline]
    pub fn is_receiver(&self, pixel: usize) -> bool {
        self.primitive[pixel] != NO_PRIMITIVE
    }

    /// The receiver at a pixel, or `None` where nothing is seen.
    #[inline]
    pub fn receiver(&self, pixel: usize) -> Option<Receiver> {
        if !self.is_receiver(pixel) {
            return None;
        }
        Some(Receiver { origin: self.position[pixel], normal: self.shading_normals()[pixel] })
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.depth.capacity() * 4
            + (self.position.capacity()
                + self.normal.capacity()
                + self.shading.capacity()
                + self.albedo.capacity())
                * size_of::<Vec3>()
            + self.specular.capacity() * size_of::<SurfaceSpecular>()
            + self.primitive.capacity() * 4
    }
}

/// Half a unit in the last place of single precision at 1: u = 2⁻²⁴.
const UNIT: f64 = 1.0 / 16_777_216.0;

/// Returns where shadow rays of a surface point start: the point, moved along the unit normal by a bound on what rounding
/// does to it and to the surfaces next to it. World space, metres.
///
/// `extent` is the largest extent of the point's triangle along any axis. With u = 2⁻²⁴ the offset is
/// 12 u · (largest coordinate + extent / 4096), 6 to 12 units in the last place of the largest coordinate:
///
/// | part | covers |
/// | --- | --- |
/// | 2 u | rounding of the point's coordinates, and of the sum with the offset |
/// | 4 u | corners of triangles around it, which may rise above its own triangle's plane by as much as they are rounded |
/// | rest | models whose own arithmetic has added to that |
/// | extent | points near the world's origin, whose neighbours' corners are not |
///
/// The offset does not depend on the size of the scene. Chosen by the tests of flat, curved and distant meshes, none of which shades
/// itself from 6 u on; a sheet that lies 32 units in the last place above a surface shades it.
#[inline]
pub fn receiver_origin(point: DVec3, normal: Vec3, extent: f32) -> Vec3 {
    let size = point.abs().max_element() + f64::from(extent) * (1.0 / 4096.0);
    (point + normal.as_dvec3() * (12.0 * UNIT * size)).as_vec3()
}

/// Returns where shadow rays of a surface point start whose triangle is not known: as [`receiver_origin`], by an offset of
/// u · (12 · largest coordinate + 8 · depth) with u = 2⁻²⁴, which also covers the rounding of depths to single precision.
#[inline]
pub fn given_origin(point: DVec3, normal: Vec3, depth: f32) -> Vec3 {
    let offset = UNIT * (12.0 * point.abs().max_element() + 8.0 * f64::from(depth));
    (point + normal.as_dvec3() * offset).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (4, 3);

    fn floor() -> (Camera, Vec<f32>, Vec<Vec3>) {
        let camera = Camera { eye: Vec3::Y, target: Vec3::new(0.0, 0.0, -2.0), ..Camera::default() };
        let view = View::new(&camera, SIZE.0, SIZE.1);
        let hits = |pixel: usize| {
            let d = view.direction(pixel % 4, pixel / 4);
            if d.y < 0.0 { (-1.0 / d.y, Vec3::Y) } else { (0.0, Vec3::ZERO) }
        };
        let (depths, normals) = (0..12).map(hits).unzip();
        (camera, depths, normals)
    }

    #[test]
    fn points_and_depths_give_the_same_surfaces() {
        let (camera, depths, normals) = floor();
        let view = View::new(&camera, SIZE.0, SIZE.1);
        let point = |pixel: usize| view.eye + view.direction(pixel % 4, pixel / 4) * depths[pixel];
        let points: Vec<Vec3> = (0..12).map(point).collect();
        let by_depth =
            GBuffer::from_surfaces(&camera, SIZE, SurfacePoints::Depths(&depths), &normals, None).unwrap();
        let by_point =
            GBuffer::from_surfaces(&camera, SIZE, SurfacePoints::Positions(&points), &normals, None).unwrap();
        by_depth.validate().unwrap();
        assert!((0..12).any(|pixel| by_depth.is_receiver(pixel)));
        for (pixel, &normal) in normals.iter().enumerate() {
            assert_eq!(by_depth.is_receiver(pixel), normal != Vec3::ZERO);
            assert_eq!(by_point.is_receiver(pixel), by_depth.is_receiver(pixel));
            let (a, b) = (by_depth.position[pixel], by_point.position[pixel]);
            assert!(a.distance(b) < 1e-6, "{a} {b}");
            assert!(
                !by_depth.is_receiver(pixel) || (by_depth.depth[pixel] - by_point.depth[pixel]).abs() < 1e-5
            );
        }
    }

    #[test]
    fn faults_are_named() {
        let (camera, depths, normals) = floor();
        let of = |depths: &[f32], normals: &[Vec3], albedo: Option<&[Vec3]>| {
            GBuffer::from_surfaces(&camera, SIZE, SurfacePoints::Depths(depths), normals, albedo).unwrap_err()
        };
        let length = GBufferError::Length { layer: "normal", found: 11, expected: 12 };
        assert_eq!(of(&depths, &normals[1..], None), length);
        let pixel = |layer, fault| GBufferError::Pixel { layer, x: 3, y: 2, fault };
        let changed = |value| [&depths[..11], &[value]].concat();
        assert_eq!(
            of(&changed(f32::NAN), &normals, None),
            pixel("depth", "not finite or 1e8 m or more from the origin")
        );
        assert_eq!(of(&changed(-1.0), &normals, None), pixel("depth", "not in front of the camera"));
        let long = [&normals[..11], &[Vec3::Y * 2.0]].concat();
        assert_eq!(of(&depths, &long, None), pixel("normal", "not of length 1"));
        let dark = [&[Vec3::ONE; 11][..], &[-Vec3::ONE]].concat();
        assert_eq!(of(&depths, &normals, Some(&dark)), pixel("albedo", "negative or not finite"));
        let mut gbuffer =
            GBuffer::from_surfaces(&camera, SIZE, SurfacePoints::Depths(&depths), &normals, None).unwrap();
        let shading = |normal: Vec3| gbuffer.clone().with_shading_normals(&[normal; 12]);
        assert_eq!(shading(Vec3::new(0.6, 0.8, 0.0)).unwrap().shading_normals()[11].x, 0.6);
        let first = (0..12).find(|&pixel| gbuffer.is_receiver(pixel)).unwrap() as u32;
        let fault_of =
            |fault| GBufferError::Pixel { layer: "shading normal", x: first % 4, y: first / 4, fault };
        assert_eq!(shading(Vec3::X * 2.0).unwrap_err(), fault_of("not of length 1"));
        let other_side = "on the other side of the surface than its normal";
        assert_eq!(shading(-Vec3::Y).unwrap_err(), fault_of(other_side));
        gbuffer.depth[11] = 0.0;
        assert_eq!(gbuffer.validate().unwrap_err(), pixel("depth", "not in front of the camera"));
    }
}
