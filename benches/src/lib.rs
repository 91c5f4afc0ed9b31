//! Shared setup of the benches: bundled scenes at 640 × 480, ready to render.

use halflight::prepared::PreparedScene;
use std::sync::Arc;

use halflight::bvh::Bvh;
use halflight::config::{Named, PipelineConfig, RefinerConfig};
use halflight::pipeline::Pipeline;
use halflight::scene::Scene;

/// Image width of all benches.
pub const WIDTH: u32 = 640;
/// Image height of all benches.
pub const HEIGHT: u32 = 480;

/// A bundled scene and its BVH.
///
/// # Errors
/// An error if no scene of this name is bundled, or it cannot be loaded.
pub fn scene(name: &str) -> Result<(Arc<Scene>, Arc<Bvh>), Box<dyn std::error::Error>> {
    let scene = halflight::scene_file::load_bundled(name)?.scene;
    let bvh = Bvh::build(&scene.mesh)?;
    Ok((Arc::new(scene), Arc::new(bvh)))
}

/// Pipeline with the defaults of a refiner, after a warm-up frame.
///
/// # Errors
/// An error if the refiner's name is unknown or the pipeline cannot be built.
pub fn warm(
    scene: &Arc<Scene>,
    bvh: &Arc<Bvh>,
    refiner: &str,
) -> Result<Pipeline, Box<dyn std::error::Error>> {
    let refiner = RefinerConfig::named(refiner).ok_or("no refiner of this name")?;
    let config = PipelineConfig { width: WIDTH, height: HEIGHT, refiner, ..PipelineConfig::default() };
    let mut pipeline =
        config.builder(&PreparedScene::with_bvh(Scene::clone(scene), Arc::clone(bvh))?).build()?;
    pipeline.render()?;
    Ok(pipeline)
}
