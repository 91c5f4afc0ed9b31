//! Methods: every combination of the stages.

use halflight_core::frame::LightSampling;
use halflight_core::scene::Scene;
use halflight_cpu::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight_cpu::irradiance::Shading;
use itertools::{Itertools as _, iproduct};

use crate::experiment::plan::word;

/// Combination of stages, each with its default constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// Refiner.
    pub refiner: RefinerConfig,
    /// Visibility backend.
    pub visibility: VisibilityConfig,
    /// Upsampler.
    pub upsampler: UpsamplerConfig,
    /// Quantity that is interpolated.
    pub shading: Shading,
}

/// Stage in which two methods differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Switch {
    /// Name of the stage.
    pub stage: &'static str,
    /// Choice that is set instead.
    pub to: String,
    /// Choice that was set.
    pub from: String,
}

impl Method {
    /// Returns every pixel by exact rays, which has no error but the noise of its light samples.
    pub fn every_pixel(shading: Shading) -> Self {
        Self {
            refiner: RefinerConfig::PerPixel,
            visibility: VisibilityConfig::Bvh,
            upsampler: UpsamplerConfig::all()[0],
            shading,
        }
    }

    /// Returns whether every pixel is a fragment, so that the upsampler has nothing to do.
    pub fn is_every_pixel(&self) -> bool {
        self.refiner == RefinerConfig::PerPixel
    }

    /// Returns whether its backend answers for the lights of all scenes: 4D rasterization does not know spheres.
    pub fn answers(&self, scenes: &[Scene]) -> bool {
        let sphere = |scene: &Scene| scene.lights.iter().any(|light| light.as_sphere().is_some());
        !(matches!(self.visibility, VisibilityConfig::Raster4d(_)) && scenes.iter().any(sphere))
    }

    /// Returns the light samples: shifted rows for 4D rasterization, which cannot answer jittered ones.
    pub fn sampling(&self) -> LightSampling {
        self.visibility.fit(LightSampling::default())
    }

    /// Returns the pipeline at a size, with these light samples.
    pub fn config(&self, [width, height]: [u32; 2], sampling: LightSampling) -> PipelineConfig {
        let &Self { refiner, visibility, upsampler, shading } = self;
        PipelineConfig {
            width,
            height,
            refiner,
            visibility,
            upsampler,
            shading,
            sampling,
            ..PipelineConfig::default()
        }
    }

    /// Returns the names of its stages: refiner, visibility, upsampler (none where every pixel is a fragment), shading.
    pub fn stages(&self) -> [String; 4] {
        let upsampler = if self.is_every_pixel() { "" } else { self.upsampler.name() };
        [
            self.refiner.name().to_string(),
            self.visibility.name().to_string(),
            upsampler.to_string(),
            word(self.shading),
        ]
    }

    /// Returns its name for people.
    pub fn label(&self) -> String {
        self.stages().iter().filter(|part| !part.is_empty()).join(" · ")
    }

    /// Returns its name in file names.
    pub fn slug(&self) -> String {
        self.stages().iter().filter(|part| !part.is_empty()).join("-")
    }

    /// Returns the switches from this method to another.
    pub fn switches(&self, to: &Self) -> Vec<Switch> {
        const STAGES: [&str; 4] = ["refiner", "visibility", "upsampler", "shading"];
        let pairs = self.stages().into_iter().zip(to.stages());
        STAGES
            .into_iter()
            .zip(pairs)
            .filter(|(_, (from, to))| from != to && !from.is_empty() && !to.is_empty())
            .map(|(stage, (from, to))| Switch { stage, to, from })
            .collect()
    }
}

/// Returns every refiner with every backend, upsampler and shading.
pub fn all() -> Vec<Method> {
    let refiners = RefinerConfig::NAMES.iter().filter_map(|name| RefinerConfig::named(name));
    let backends: Vec<_> =
        VisibilityConfig::NAMES.iter().filter_map(|name| VisibilityConfig::named(name)).collect();
    let methods = iproduct!(refiners, &backends, UpsamplerConfig::all(), [Shading::Sampled, Shading::Ratio])
        .map(|(refiner, &visibility, upsampler, shading)| Method { refiner, visibility, upsampler, shading });
    let once = |method: &Method| !method.is_every_pixel() || method.upsampler == UpsamplerConfig::all()[0];
    methods.filter(once).collect()
}

/// Returns every refiner with its best stages, and from there every other backend, upsampler and shading, one at a time.
pub fn few() -> Vec<Method> {
    let best = |method: &Method| Method {
        upsampler: match method.refiner {
            RefinerConfig::PerPixel => UpsamplerConfig::Bilinear(Default::default()),
            RefinerConfig::Lattice(_) => UpsamplerConfig::Lattice(Default::default()),
            _ => UpsamplerConfig::RbfRobust(Default::default()),
        },
        visibility: VisibilityConfig::Bvh,
        shading: Shading::default(),
        ..*method
    };
    all().into_iter().filter(|method| method.switches(&best(method)).len() <= 1).collect()
}

/// Returns switches as they are set: `visibility = bvh`.
pub fn set(switches: &[Switch]) -> String {
    let set = |switch: &Switch| format!("{} = {}", switch.stage, switch.to);
    switches.iter().map(set).join(", ")
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use halflight_core::light::AreaLight;

    use super::*;

    #[test]
    fn every_name_occurs_in_both_lists() {
        for methods in [all(), few()] {
            let has = |stage: usize, name: &str| methods.iter().any(|method| method.stages()[stage] == name);
            assert!(RefinerConfig::NAMES.iter().all(|name| has(0, name)));
            assert!(VisibilityConfig::NAMES.iter().all(|name| has(1, name)));
            assert!(UpsamplerConfig::NAMES.iter().all(|name| has(2, name)));
            assert!(has(3, "sampled") && has(3, "ratio"));
        }
    }

    #[test]
    fn counts_are_those_of_the_product_and_of_single_switches() {
        let (refiners, backends) = (RefinerConfig::NAMES.len() - 1, VisibilityConfig::NAMES.len());
        let upsamplers = UpsamplerConfig::all().len();
        assert_eq!(all().len(), refiners * backends * upsamplers * 2 + backends * 2);
        // The best itself, and each other value of one stage.
        assert_eq!(few().len(), refiners * (1 + backends - 1 + upsamplers - 1 + 1) + 1 + backends - 1 + 1);
    }

    #[test]
    fn rasterization_alone_has_no_answers_for_spheres() {
        let sphere = AreaLight::sphere(Vec3::Y, 0.5, Vec3::ONE);
        let scenes = |light: AreaLight| [Scene { lights: vec![light], ..Scene::default() }];
        for method in all() {
            let raster4d = method.visibility.name() == "raster4d";
            assert_eq!(method.answers(&scenes(sphere)), !raster4d);
            assert!(method.answers(&scenes(AreaLight::disk(Vec3::Y, Vec3::X, 0.5, Vec3::ONE))));
        }
    }

    #[test]
    fn switches_name_the_stages_that_differ() {
        let ratio = Method::every_pixel(Shading::Ratio);
        let switches = Method::every_pixel(Shading::Sampled).switches(&ratio);
        let expected = Switch { stage: "shading", to: "ratio".to_string(), from: "sampled".to_string() };
        assert_eq!(switches, [expected]);
        assert!(ratio.switches(&ratio).is_empty());
    }
}
