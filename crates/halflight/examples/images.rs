//! Images in files: a rendered image as OpenEXR with its layers, read again, compared with a better one, and as PNG.
//!
//! `cargo run --example images [FOLDER]` writes `image.exr`, `image.png` and `error.png`.

use std::error::Error;
use std::path::PathBuf;

use halflight::config::{PipelineConfig, RefinerConfig};
use halflight::frame::LightSampling;
use halflight::image::{ExrFile, picture};
use halflight::metrics::{self, Image};
use halflight::prepared::PreparedScene;
use halflight::scene_file;

const WIDTH: u32 = 240;
const HEIGHT: u32 = 160;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map_or_else(PathBuf::new, PathBuf::from);
    let scene = PreparedScene::new(scene_file::load_bundled("contact")?.scene)?;

    // `layers` also fills the image's visible fraction and levels.
    let config = PipelineConfig { width: WIDTH, height: HEIGHT, ..PipelineConfig::default() };
    let mut pipeline = config.builder(&scene).layers(true).build()?;
    pipeline.render()?;
    let (image, gbuffer) = (pipeline.image(), pipeline.gbuffer());

    // Layers are named; `radiance` is the default one as well, which every program shows.
    let mut file = ExrFile::new(WIDTH, HEIGHT, Default::default());
    file.add_light(&image.irradiance, &gbuffer.albedo);
    file.add_geometry(gbuffer);
    file.add_plane("visibility", "Y", image.visibility.clone());
    let path = folder.join("image.exr");
    file.write(&path)?;

    // 32-bit floats are kept without loss.
    let read = ExrFile::read(&path)?;
    let irradiance = read.layer("irradiance")?;
    assert_eq!(irradiance, image.irradiance);
    println!("{}: {} channels", path.display(), read.channels.len());

    // The reference: every pixel with 1,024 light samples of its own.
    let reference = PipelineConfig {
        refiner: RefinerConfig::PerPixel,
        upsampler: RefinerConfig::PerPixel.upsampler(),
        sampling: LightSampling { count: 1024, ..config.sampling },
        ..config
    };
    let mut reference = reference.builder(&scene).build()?;
    reference.render()?;

    // NMSE₂: squared error over squared image, of the pixels that see something.
    let seen: Vec<bool> = (0..gbuffer.pixels()).map(|pixel| gbuffer.is_receiver(pixel)).collect();
    let image = Image::new(WIDTH, HEIGHT, &irradiance)?.with_mask(&seen)?;
    let reference = Image::new(WIDTH, HEIGHT, &reference.image().irradiance)?.with_mask(&seen)?;
    println!("NMSE2 {:.1e}", metrics::compare(image, reference)?.nmse2);

    let shown = picture::image(&irradiance, &read.layer("albedo")?, picture::EXPOSURE);
    metrics::write_png(&folder.join("image.png"), WIDTH, HEIGHT, &shown)?;
    let errors = picture::error(image, reference, picture::ERROR_SCALE)?;
    metrics::write_png(&folder.join("error.png"), WIDTH, HEIGHT, &errors)?;
    Ok(())
}
