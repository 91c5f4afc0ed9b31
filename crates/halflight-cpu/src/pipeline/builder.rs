//! Choice of stages and settings of a pipeline.

use std::sync::Arc;

use halflight_core::frame::LightSampling;
use halflight_core::pattern::Pattern;
use halflight_core::scene::{Mesh, Scene};
use halflight_core::stages::{Refiner, Unsupported, Upsampler, Visibility};
use halflight_core::subpixel;

use super::{
    Buffers, Image, MAX_SIZE, Pipeline, PipelineError, State, check_scene, check_supported, useful_threads,
};
use crate::bvh::Bvh;
use crate::flush;
use crate::indirect::Indirect;
use crate::irradiance::Shading;

/// Chooses stages and settings; every one has a default.
pub struct PipelineBuilder {
    pub(super) scene: Scene,
    pub(super) bvh: Arc<Bvh>,
    pub(super) rest: Arc<Mesh>,
    pub(super) size: (u32, u32),
    pub(super) refiner: Box<dyn Refiner>,
    pub(super) visibility: Box<dyn Visibility>,
    pub(super) upsampler: Box<dyn Upsampler>,
    pub(super) indirect: Option<Box<dyn Indirect>>,
    pub(super) shading: Shading,
    pub(super) sampling: LightSampling,
    pub(super) seed: u32,
    pub(super) antialias: u32,
    pub(super) threads: Option<usize>,
    pub(super) layers: bool,
    pub(super) fault: Option<PipelineError>,
}

impl PipelineBuilder {
    /// Makes building fail.
    pub(crate) fn failing(mut self, fault: PipelineError) -> Self {
        self.fault = Some(fault);
        self
    }

    /// Image size in pixels; 640 × 480 by default.
    pub fn size(mut self, width: u32, height: u32) -> Self {
        self.size = (width, height);
        self
    }

    /// The refiner; the default is that of [`RefinerConfig`](crate::config::RefinerConfig).
    pub fn refiner(mut self, refiner: impl Refiner + 'static) -> Self {
        self.refiner = Box::new(refiner);
        self
    }

    /// The visibility backend; [`Beam::or_rays`](crate::beam::Beam::or_rays) by default.
    pub fn visibility(mut self, visibility: impl Visibility + 'static) -> Self {
        self.visibility = Box::new(visibility);
        self
    }

    /// The upsampler; [`upsample::Lattice`](crate::upsample::Lattice) by default.
    pub fn upsampler(mut self, upsampler: impl Upsampler + 'static) -> Self {
        self.upsampler = Box::new(upsampler);
        self
    }

    /// The refiner, already boxed.
    pub fn boxed_refiner(mut self, refiner: Box<dyn Refiner>) -> Self {
        self.refiner = refiner;
        self
    }

    /// The visibility backend, already boxed.
    pub fn boxed_visibility(mut self, visibility: Box<dyn Visibility>) -> Self {
        self.visibility = visibility;
        self
    }

    /// The upsampler, already boxed.
    pub fn boxed_upsampler(mut self, upsampler: Box<dyn Upsampler>) -> Self {
        self.upsampler = upsampler;
        self
    }

    /// Indirect light; none by default.
    pub fn indirect(self, indirect: impl Indirect + 'static) -> Self {
        self.boxed_indirect(Some(Box::new(indirect)))
    }

    /// Indirect light, already boxed, or none.
    pub fn boxed_indirect(mut self, indirect: Option<Box<dyn Indirect>>) -> Self {
        self.indirect = indirect;
        self
    }

    /// Quantity that is interpolated; [`Shading::Ratio`] by default.
    pub fn shading(mut self, shading: Shading) -> Self {
        self.shading = shading;
        self
    }

    /// Light samples: how many, placed how, shared by whom.
    pub fn sampling(mut self, sampling: LightSampling) -> Self {
        self.sampling = sampling;
        self
    }

    /// Seed of all randomness; 0 by default.
    pub fn seed(mut self, seed: u32) -> Self {
        self.seed = seed;
        self
    }

    /// Sub-samples of pixels that see several surfaces: 1 (off, the default), 4, 8 or 16. [`Image::radiance`] is filled where they are more
    /// than one. Only for G-buffers of the pipeline's own.
    pub fn antialias(mut self, sub_samples: u32) -> Self {
        self.antialias = sub_samples;
        self
    }

    /// Worker threads of the pipeline's own, as far as they are [useful](useful_threads); by default rayon's global ones.
    /// The image does not depend on it.
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = Some(threads);
        self
    }

    /// Also fill the layers of [`Image`] that cost time: `visibility` and `level`.
    pub fn layers(mut self, layers: bool) -> Self {
        self.layers = layers;
        self
    }

    /// Checks that everything fits together.
    ///
    /// # Errors
    /// The first thing that does not; see [`PipelineError`].
    pub fn build(mut self) -> Result<Pipeline, PipelineError> {
        if let Some(fault) = self.fault.take() {
            return Err(fault);
        }
        let (width, height) = self.size;
        if !(1..=MAX_SIZE).contains(&width) || !(1..=MAX_SIZE).contains(&height) {
            return Err(PipelineError::Size { width, height });
        }
        check_scene(&self.scene)?;
        let pattern = self.sampling.pattern()?;
        subpixel::offsets(self.antialias)?;
        self.check_patterns(self.visibility.as_ref(), pattern)?;
        check_supported(self.visibility.as_ref(), &self.scene.lights)?;
        let pool = match self.threads {
            Some(threads) => {
                Some(rayon::ThreadPoolBuilder::new().num_threads(useful_threads(threads)).build()?)
            }
            None => None,
        };
        let flush;
        (self.scene.lights, flush) = flush::separate_lights(&self.scene, Some(&self.bvh));
        let (buffers, image) = (Buffers::default(), Image::default());
        Ok(Pipeline { state: State { builder: self, pattern, flush, index: 0, buffers, image }, pool })
    }

    /// Checks that `visibility` answers all patterns that frames ask for.
    pub(super) fn check_patterns(
        &self,
        visibility: &dyn Visibility,
        full: Pattern,
    ) -> Result<(), Unsupported> {
        self.refiner.patterns(full).into_iter().try_for_each(|pattern| visibility.supports(pattern))?;
        let points = self.indirect.iter().flat_map(|stage| stage.patterns(full));
        points.into_iter().try_for_each(|pattern| visibility.supports(pattern))?;
        // Masks of sub-samples are full ones, whatever the refiner asks for.
        if self.antialias > 1 { visibility.supports(full) } else { Ok(()) }
    }
}
