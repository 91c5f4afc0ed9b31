//! Textures on lights: factors of a light's radiance, by texels, and their means over parts of the light.

mod levels;

use std::sync::OnceLock;

use glam::{DVec4, Vec2, Vec2Swizzles, Vec3, Vec4};

use levels::Levels;

/// Factors of a light's radiance over its area: linear RGB, constant inside each texel.
///
/// Texture coordinates are those of the light's unit square ([`AreaLight::point`](crate::light::AreaLight::point)): (0, 0) is the lower left of the
/// texture and lies at the corner of a parallelogram, its rows run along `edge_u`, and `edge_v` points to its upper edge. Seen from the emitting
/// side the texture is not mirrored.
#[derive(Debug)]
pub struct LightTexture {
    width: u32,
    height: u32,
    texels: Vec<Vec3>,
    /// Summed-area table, from when it is first read.
    sums: OnceLock<Vec<DVec4>>,
    /// Coarser levels, from when they are first read.
    levels: OnceLock<Levels>,
}

/// Why texels are no texture of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LightTextureError {
    /// No texels, or another number of them.
    #[error("a texture of {width}x{height} texels cannot be made of {texels}")]
    Size {
        /// Width in texels.
        width: u32,
        /// Height in texels.
        height: u32,
        /// Number of texels given.
        texels: usize,
    },
    /// A factor is negative, infinite or NaN.
    #[error("texel {x}, {y} from the top left is negative or not finite")]
    Value {
        /// Column, from the left.
        x: u32,
        /// Row, from the top.
        y: u32,
    },
}

impl LightTexture {
    /// Creates a texture from `width · height` texels, row by row from the top.
    ///
    /// # Errors
    /// The number of texels is another one or 0, or one is negative or not finite.
    pub fn new(width: u32, height: u32, texels: Vec<Vec3>) -> Result<Self, LightTextureError> {
        if texels.is_empty() || width as usize * height as usize != texels.len() {
            return Err(LightTextureError::Size { width, height, texels: texels.len() });
        }
        if let Some(at) = texels.iter().position(|texel| !(texel.is_finite() && texel.min_element() >= 0.0)) {
            return Err(LightTextureError::Value { x: at as u32 % width, y: at as u32 / width });
        }
        Ok(Self { width, height, texels, sums: OnceLock::new(), levels: OnceLock::new() })
    }

    /// Width in texels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in texels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The factors of the texels, row by row from the top.
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }

    /// The factors of all texels where they are one and the same.
    pub fn uniform(&self) -> Option<Vec3> {
        self.texels.iter().all(|&texel| texel == self.texels[0]).then(|| self.texels[0])
    }

    /// Factors at a point of the unit square.
    pub fn at(&self, uv: Vec2) -> Vec3 {
        let place = |at: f32, count: u32| ((at * count as f32) as u32).min(count - 1);
        let (x, y) = (place(uv.x, self.width), self.height - 1 - place(uv.y, self.height));
        self.texels[y as usize * self.width as usize + x as usize]
    }

    /// Mean factors.
    pub fn mean(&self) -> Vec3 {
        self.mean_over(Vec2::ZERO, Vec2::ONE).truncate()
    }

    /// Mean factors in a rectangle of the unit square, and the mean of the sum of their squares. Texels that lie in it partly count with their
    /// part.
    pub fn mean_over(&self, low: Vec2, high: Vec2) -> Vec4 {
        let area = f64::from(high.x - low.x) * f64::from(high.y - low.y);
        let texels = area * f64::from(self.width) * f64::from(self.height);
        let sum =
            self.sum_below(high.x, high.y) - self.sum_below(low.x, high.y) - self.sum_below(high.x, low.y)
                + self.sum_below(low.x, low.y);
        if texels > 0.0 { (sum / texels).max(DVec4::ZERO).as_vec4() } else { Vec4::ZERO }
    }

    /// Means over the cells of a grid, in rows from v = 0 on; see [`Self::mean_over`].
    pub fn cells(&self, columns: u16, rows: u16) -> impl Iterator<Item = Vec4> + '_ {
        let part = |index: u16, count: u16| f32::from(index) / f32::from(count);
        (0..rows).flat_map(move |row| {
            (0..columns).map(move |column| {
                let low = Vec2::new(part(column, columns), part(row, rows));
                let high = Vec2::new(part(column + 1, columns), part(row + 1, rows));
                self.mean_over(low, high)
            })
        })
    }

    /// Mean factors in the square with sides of `side` around a point of the unit square, without its parts outside, from means over squares of
    /// texels of which it is at most two wide and high: exact for whole ones of these, smooth over the rest.
    pub fn mean_around(&self, uv: Vec2, side: f32) -> Vec3 {
        let size = Vec2::new(self.width as f32, self.height as f32);
        let half = Vec2::splat(0.5 * side);
        let (low, high) =
            ((uv - half).clamp(Vec2::ZERO, Vec2::ONE), (uv + half).clamp(Vec2::ZERO, Vec2::ONE));
        let (top, bottom) = ((1.0 - high.y) * size.y, (1.0 - low.y) * size.y);
        let (low, high) = (Vec2::new(low.x * size.x, top), Vec2::new(high.x * size.x, bottom));
        self.levels().mean(&self.texels, low, high, side * size.max_element())
    }

    /// Means over squares of 2, 4, 8 … texels a side, one level after another, rows from the top; each has half as many columns and rows as the
    /// one before, rounded up.
    pub fn coarser_levels(&self) -> &[Vec3] {
        self.levels().means()
    }

    /// Places of the first values of the texels, 0, and of each level of [`Self::coarser_levels`], where these follow the texels.
    pub fn level_places(&self) -> impl Iterator<Item = u32> + '_ {
        self.levels().places(self.texels.len())
    }

    fn levels(&self) -> &Levels {
        self.levels.get_or_init(|| Levels::new(self.width, self.height, &self.texels))
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.texels.capacity() * size_of::<Vec3>()
            + self.sums.get().map_or(0, |sums| sums.capacity() * size_of::<DVec4>())
            + self.levels.get().map_or(0, Levels::bytes)
    }

    /// Sum over the texels left of and below a point of the unit square, in texels. It is bilinear inside each texel.
    fn sum_below(&self, u: f32, v: f32) -> DVec4 {
        let sums = self.sums.get_or_init(|| self.table());
        let columns = self.width as usize + 1;
        let place = |at: f32, count: u32| {
            let at = f64::from(at.clamp(0.0, 1.0)) * f64::from(count);
            let whole = at.floor().min(f64::from(count - 1));
            (whole as usize, at - whole)
        };
        let ((x, s), (y, t)) = (place(u, self.width), place(v, self.height));
        let row = |y: usize| sums[y * columns + x] * (1.0 - s) + sums[y * columns + x + 1] * s;
        row(y) * (1.0 - t) + row(y + 1) * t
    }

    /// Sums over the texels below and left of every corner of the texels, corners in rows from the bottom.
    fn table(&self) -> Vec<DVec4> {
        let (width, height) = (self.width as usize, self.height as usize);
        let mut sums = vec![DVec4::ZERO; (width + 1) * (height + 1)];
        for y in 0..height {
            let mut row = DVec4::ZERO;
            for x in 0..width {
                let texel = self.texels[(height - 1 - y) * width + x];
                row += texel.as_dvec3().extend(texel.as_dvec3().length_squared());
                sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
            }
        }
        sums
    }
}

/// Texture of a light, in the coordinates of the light's unit square.
#[derive(Clone, Copy, Debug)]
pub struct PlacedTexture<'a> {
    pub(crate) texture: &'a LightTexture,
    pub(crate) transposed: bool,
}

impl PlacedTexture<'_> {
    /// Factors of the light's radiance at a point of the unit square.
    #[inline]
    pub fn at(&self, uv: Vec2) -> Vec3 {
        self.texture.at(if self.transposed { uv.yx() } else { uv })
    }

    /// Factors of the texels, row by row from the top of the texture.
    pub fn texels(&self) -> &[Vec3] {
        self.texture.texels()
    }

    /// Width and height of the texture in texels.
    pub fn size(&self) -> [u32; 2] {
        [self.texture.width, self.texture.height]
    }

    /// True if the rows of the texture run along the second coordinate of the unit square.
    pub fn is_transposed(&self) -> bool {
        self.transposed
    }

    /// Mean factors.
    pub fn mean(&self) -> Vec3 {
        self.texture.mean()
    }

    /// Mean factors in a rectangle of the unit square; see [`LightTexture::mean_over`].
    pub fn mean_over(&self, low: Vec2, high: Vec2) -> Vec4 {
        match self.transposed {
            false => self.texture.mean_over(low, high),
            true => self.texture.mean_over(low.yx(), high.yx()),
        }
    }

    /// Mean factors in a square; see [`LightTexture::mean_around`].
    pub fn mean_around(&self, uv: Vec2, side: f32) -> Vec3 {
        self.texture.mean_around(if self.transposed { uv.yx() } else { uv }, side)
    }

    /// Means over squares of texels; see [`LightTexture::coarser_levels`].
    pub fn coarser_levels(&self) -> &[Vec3] {
        self.texture.coarser_levels()
    }

    /// Places of levels; see [`LightTexture::level_places`].
    pub fn level_places(&self) -> impl Iterator<Item = u32> + '_ {
        self.texture.level_places()
    }

    /// Mean factors in the cells of a grid, in rows from v = 0 on, and the means of the sum of their squares.
    pub fn cells(&self, columns: u16, rows: u16) -> Vec<Vec4> {
        if !self.transposed {
            return self.texture.cells(columns, rows).collect();
        }
        let cells: Vec<Vec4> = self.texture.cells(rows, columns).collect();
        let (columns, rows) = (usize::from(columns), usize::from(rows));
        (0..rows * columns).map(|at| cells[at % columns * rows + at / columns]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two columns and three rows, of red 1 … 6 from the top left.
    fn ramp() -> LightTexture {
        LightTexture::new(2, 3, (1..=6).map(|red| Vec3::new(red as f32, 0.5, 0.0)).collect()).unwrap()
    }

    #[test]
    fn the_lower_left_is_the_last_row() {
        let texture = ramp();
        assert_eq!(texture.at(Vec2::new(0.1, 0.1)).x, 5.0);
        assert_eq!(texture.at(Vec2::new(0.9, 0.1)).x, 6.0);
        assert_eq!((texture.at(Vec2::new(0.1, 0.9)).x, texture.at(Vec2::ONE).x), (1.0, 2.0));
    }

    #[test]
    fn means_are_those_of_the_texels() {
        let texture = ramp();
        assert_eq!(texture.mean(), Vec3::new(3.5, 0.5, 0.0));
        // Cells of two texels, then parts of texels: the lower right quarter is 6 and half of 4.
        let columns: Vec<f32> = texture.cells(2, 1).map(|mean| mean.x).collect();
        assert_eq!(columns, [3.0, 4.0]);
        let quarters: Vec<f32> = texture.cells(2, 2).map(|mean| mean.x).collect();
        let expected = [(5.0 + 1.5) / 1.5, (6.0 + 2.0) / 1.5, (1.0 + 1.5) / 1.5, (2.0 + 2.0) / 1.5];
        assert!(quarters.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{quarters:?}");
        let square = Vec3::new(5.0, 0.5, 0.0).length_squared();
        let found = texture.mean_over(Vec2::ZERO, Vec2::new(0.5, 1.0 / 3.0)).w;
        assert!((found / square - 1.0).abs() < 1e-5, "{found} {square}");
        assert_eq!(texture.mean_over(Vec2::ONE, Vec2::ONE), Vec4::ZERO);
    }

    #[test]
    fn means_around_points_are_those_of_squares_of_texels() {
        // 13 columns and 9 rows, of which no level has a whole number of squares.
        let texels: Vec<Vec3> =
            (0..13 * 9).map(|at| Vec3::new((at * at % 31) as f32, (at % 13) as f32, 1.0)).collect();
        let texture = LightTexture::new(13, 9, texels).unwrap();
        assert_eq!(texture.coarser_levels().len(), 7 * 5 + 4 * 3 + 2 * 2 + 1);
        // All of it, whatever the level, but for the level's squares.
        let all = texture.mean_around(Vec2::splat(0.5), 1.0);
        assert!((all - texture.mean()).abs().max_element() < 1e-4, "{all} {}", texture.mean());
        // Squares smaller than texels: exact.
        for uv in [Vec2::new(0.31, 0.72), Vec2::new(0.99, 0.01), Vec2::new(0.5, 0.5)] {
            let side = 0.1;
            let low = (uv - 0.5 * side).clamp(Vec2::ZERO, Vec2::ONE);
            let high = (uv + 0.5 * side).clamp(Vec2::ZERO, Vec2::ONE);
            let (found, exact) = (texture.mean_around(uv, side), texture.mean_over(low, high).truncate());
            assert!((found - exact).abs().max_element() < 1e-3, "{uv}: {found} {exact}");
        }
        // Squares without an extent that numbers can tell.
        for at in 0..1000u32 {
            let uv = Vec2::new((at * 7919 % 1009) as f32 / 1009.0, (at * 104_729 % 997) as f32 / 997.0);
            for side in [0.0, 1e-20, 1e-9, 1e-7] {
                let off = texture.mean_around(uv, side) - texture.at(uv);
                assert!(off.abs().max_element() < 1e-3, "{uv} {side}: {off}");
            }
        }
        // Means of many squares that tile the texture are its mean: what lies in none counts for no other.
        let tiles = (0..64).map(|at| Vec2::new(at as f32 % 8.0 + 0.5, (at / 8) as f32 + 0.5) / 8.0);
        let mean = tiles.map(|uv| texture.mean_around(uv, 0.125)).sum::<Vec3>() / 64.0;
        assert!((mean / texture.mean() - 1.0).abs().max_element() < 1e-4, "{mean} {}", texture.mean());
        let wide = LightTexture::new(300, 2, vec![Vec3::splat(0.25); 600]).unwrap();
        assert_eq!(wide.mean_around(Vec2::new(0.4, 0.9), 0.3), Vec3::splat(0.25));
    }

    #[test]
    fn bad_texels_are_refused() {
        let error = |width, height, texels| LightTexture::new(width, height, texels).unwrap_err();
        assert_eq!(error(0, 0, vec![]), LightTextureError::Size { width: 0, height: 0, texels: 0 });
        assert_eq!(error(2, 1, vec![Vec3::ONE]), LightTextureError::Size { width: 2, height: 1, texels: 1 });
        for bad in [-1.0, f32::NAN, f32::INFINITY] {
            let texels = vec![Vec3::ONE, Vec3::ONE, Vec3::new(0.0, bad, 0.0), Vec3::ONE];
            assert_eq!(error(2, 2, texels), LightTextureError::Value { x: 0, y: 1 });
        }
        assert_eq!(ramp().uniform(), None);
        assert_eq!(LightTexture::new(1, 2, vec![Vec3::X; 2]).unwrap().uniform(), Some(Vec3::X));
    }
}
