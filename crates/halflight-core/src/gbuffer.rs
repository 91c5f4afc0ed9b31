//! What each pixel sees.

use glam::Vec3;

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
    /// Surface point, world space; zero where nothing is seen.
    pub position: Vec<Vec3>,
    /// Geometric unit normal towards the viewer, world space; zero where nothing is seen.
    pub normal: Vec<Vec3>,
    /// Linear RGB albedo; zero where nothing is seen.
    pub albedo: Vec<Vec3>,
    /// Triangle index in the scene's mesh, or [`NO_PRIMITIVE`].
    pub primitive: Vec<u32>,
    /// Diagonal of the scene's bounding box, metres: what ray offsets are relative to.
    pub scene_size: f32,
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
        let normal = self.normal[pixel];
        Some(Receiver { origin: offset_origin(self.position[pixel], normal, self.scene_size), normal })
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.depth.capacity() * 4
            + (self.position.capacity() + self.normal.capacity() + self.albedo.capacity()) * size_of::<Vec3>()
            + self.primitive.capacity() * 4
    }
}

/// Moves a surface point off its surface, far enough that no ray meets the surface it starts on.
///
/// Offsets of 1e-5 to 1e-3 of the scene agree within 0.1 % of all rays, none loses 16–20 %, 1e-2 leaks; hence 3e-5 of the
/// scene's diagonal. Far from the origin, single precision itself is coarser than that: a computed point is wrong by
/// about one unit in the last place of its largest coordinate, so the offset is at least eight of them.
#[inline]
pub fn offset_origin(position: Vec3, normal: Vec3, scene_size: f32) -> Vec3 {
    let rounding = position.abs().max_element() * (8.0 * f32::EPSILON);
    position + normal * rounding.max(scene_size * 3e-5)
}
