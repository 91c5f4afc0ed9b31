//! What each pixel sees.

use glam::{DVec3, Vec3};

/// Marks a pixel that sees no geometry.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// A receiver: where shadow rays of a pixel start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Surface point moved off its surface along the geometric normal, world space.
    pub origin: Vec3,
    /// Geometric unit normal, towards the viewer.
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
    /// Linear RGB albedo; zero where nothing is seen.
    pub albedo: Vec<Vec3>,
    /// Triangle index in the scene's mesh, or [`NO_PRIMITIVE`].
    pub primitive: Vec<u32>,
}

impl GBuffer {
    /// Sets the size and makes every pixel see nothing; keeps the memory.
    pub fn reset(&mut self, width: u32, height: u32) {
        let pixels = width as usize * height as usize;
        self.width = width;
        self.height = height;
        self.depth.resize(pixels, f32::INFINITY);
        self.position.resize(pixels, Vec3::ZERO);
        self.normal.resize(pixels, Vec3::ZERO);
        self.albedo.resize(pixels, Vec3::ZERO);
        self.primitive.resize(pixels, NO_PRIMITIVE);
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

    /// Whether the pixel sees geometry, and so receives light.
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
        Some(Receiver { origin: self.position[pixel], normal: self.normal[pixel] })
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.depth.capacity() * 4
            + (self.position.capacity() + self.normal.capacity() + self.albedo.capacity()) * size_of::<Vec3>()
            + self.primitive.capacity() * 4
    }
}

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
/// It does not depend on the size of the scene. Chosen by the tests of flat, curved and distant meshes, none of which shades
/// itself from 6 u on; a sheet that lies 32 units in the last place above a surface shades it.
#[inline]
pub fn receiver_origin(point: DVec3, normal: Vec3, extent: f32) -> Vec3 {
    const UNIT: f64 = 1.0 / 16_777_216.0;
    let size = point.abs().max_element() + f64::from(extent) * (1.0 / 4096.0);
    (point + normal.as_dvec3() * (12.0 * UNIT * size)).as_vec3()
}
