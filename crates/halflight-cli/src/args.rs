//! Commands and options.

use std::ops::Range;
use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use halflight_cpu::config::{
    IndirectConfig, Named, Quality, RefinerConfig, UpsamplerConfig, VisibilityConfig,
};

use crate::paths::{HELP, OutputPath};

/// Soft shadows from area lights by multi-resolution screen-space fragments.
#[derive(Debug, Parser)]
#[command(name = "halflight", version, arg_required_else_help = true, after_help = EXAMPLES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXAMPLES: &str = "\
Examples:
  halflight scenes                                    the bundled scenes
  halflight render atrium                             writes atrium.png
  halflight render my/scene.toml --size 1280x960 --out image.exr --stats stats.json
  halflight reference atrium --samples 4096 --out truth.exr
  halflight compare image.exr truth.exr --error-map error.png";

const RENDER_EXAMPLES: &str = "\
Without --out, --png, --fragment-map, --voxel-error-map and --stats, the picture is written to SCENE.png in the current folder.

Examples:
  halflight render nave --upsampler delaunay --png nave.png --fragment-map fragments.png
  halflight render atrium --refiner per-pixel --samples 256 --shading sampled --out truth.exr
  halflight render atrium --visibility voxel --refiner per-pixel --voxel-error-map failures.png
  halflight render atrium --refiner sfvt-gass --set refiner.coarse_threshold=4 --set sampling.kind=grid
  halflight render --refiner nichols --print-config > nichols.toml    every constant, to edit
  halflight render atrium --config nichols.toml
  halflight render atrium --device gpu --refiner per-pixel --samples 64
  halflight render atrium --indirect gather --out image.exr            with the layers direct and indirect
  halflight render nave --frames 96 --fps 12 --png out/nave.png       out/nave-0000.png to out/nave-0095.png
  halflight render nave --frames 40..48 --out nave.exr --stats nave.json";

const REFERENCE_EXAMPLES: &str = "\
Examples:
  halflight reference atrium --samples 4096 --out truth.exr
  halflight reference atrium --samples 16384 --out truth.exr    adds to the samples of the first
  halflight reference atrium --indirect --samples 1024 --out truth.exr
  halflight compare image.exr truth.exr --layer indirect_irradiance";

const COMPARE: &str = "\
OpenEXR files of other programs can be compared as well: channels R, G, B (or Y alone) of 16 or 32 bits; alpha does not
take part. Pixel (x, y) is compared with pixel (x, y), as the data windows say; where one lies inside the other, the pixels
of the smaller one are compared. Pixels where the reference sees nothing (depth.Z is infinite) do not take part. What was
compared is said on standard error.";

const COMPARE_EXAMPLES: &str = "\
Examples:
  halflight compare image.exr truth.exr
  halflight compare image.exr truth.exr --json | jq .nmse2
  halflight compare image.exr truth.exr --error-map error.png --scale 0.1";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene: a picture, an image with all layers, a map of the fragments, statistics.
    #[command(after_help = format!("{HELP}\n\n{RENDER_EXAMPLES}"))]
    Render(Box<Render>),
    /// Compute a converged image that others are compared with; a stopped run goes on where it was.
    #[command(after_help = format!("{HELP}\n\n{REFERENCE_EXAMPLES}"))]
    Reference(Reference),
    /// Measure an image against a reference.
    #[command(after_help = format!("{COMPARE}\n\n{HELP}\n\n{COMPARE_EXAMPLES}"))]
    Compare(Compare),
    /// Tell what a scene holds: triangles, lights, materials, warnings, and the size of its BVH.
    Info(SceneArg),
    /// List the bundled scenes.
    Scenes,
    /// Print completions for a shell.
    #[command(
        after_help = "Example:\n  halflight completions bash > ~/.local/share/bash-completion/completions/halflight"
    )]
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

/// Devices to render with.
const DEVICES: &[&str] = if cfg!(feature = "gpu") { &["cpu", "gpu"] } else { &["cpu"] };

#[derive(Debug, Args)]
pub(crate) struct SceneArg {
    /// A bundled scene (see `halflight scenes`) or the path of a scene file; - reads one from standard input.
    pub(crate) scene: String,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct Render {
    /// A bundled scene (see `halflight scenes`) or the path of a scene file; - reads one from standard input.
    #[arg(required_unless_present = "print_config")]
    pub(crate) scene: Option<String>,
    #[command(flatten)]
    pub(crate) choices: Choices,
    /// Worker threads; all cores by default. The image does not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// Frames of the scene's animation: N are 0 to N-1, A..B are A to B-1. Each goes to files of its own, with its number
    /// before the ending: image.png becomes image-0000.png; standard output, pipes and devices take one after another.
    /// Frames know nothing of each other and share their light samples, so that nothing flickers but what moves.
    #[arg(long, value_name = "N|A..B", value_parser = frames, help_heading = "Animation")]
    pub(crate) frames: Option<Range<u32>>,
    /// Frames a second; frame 0 is the scene as it stands.
    #[arg(long, value_name = "X", default_value_t = 24.0, value_parser = fps, requires = "frames", help_heading = "Animation")]
    pub(crate) fps: f64,
    /// Image with all layers, OpenEXR.
    #[arg(long, value_name = "F.exr", help_heading = "Output")]
    pub(crate) out: Option<PathBuf>,
    /// Tone-mapped picture.
    #[arg(long, value_name = "F.png", help_heading = "Output")]
    pub(crate) png: Option<PathBuf>,
    /// Picture of the fragments, a colour a level: cyan for single pixels, white for 128 × 128. With several lights,
    /// those of the last.
    #[arg(long, value_name = "F.png", help_heading = "Output")]
    pub(crate) fragment_map: Option<PathBuf>,
    /// Picture of the receivers that voxel marching gets wrong by more than a tenth of the light, a colour a cause: red and
    /// yellow too dark, by the receiver's own voxels or others; blue and green too bright, by what is out of view or
    /// missed. Needs --visibility voxel and --refiner per-pixel. The picture is of the last light, counts are of all.
    #[arg(long, alias = "failure-map", value_name = "F.png", help_heading = "Output")]
    pub(crate) voxel_error_map: Option<PathBuf>,
    /// Configuration, fragments, rays and times as JSON; with --voxel-error-map, counts of failures.
    #[arg(long, value_name = "F.json", help_heading = "Output")]
    pub(crate) stats: Option<PathBuf>,
    /// Print the configuration that the options make, as TOML, and stop.
    #[arg(long, help_heading = "Output")]
    pub(crate) print_config: bool,
    /// Factor on the radiance in the picture.
    #[arg(long, value_name = "X", default_value_t = halflight_image::picture::EXPOSURE, value_parser = positive, help_heading = "Output")]
    pub(crate) exposure: f32,
}

impl Render {
    /// Returns the options that ask for outputs, with the paths that are given.
    pub(crate) fn outputs(&self) -> Vec<OutputPath> {
        let options = [
            ("--out", &self.out),
            ("--png", &self.png),
            ("--fragment-map", &self.fragment_map),
            ("--voxel-error-map", &self.voxel_error_map),
            ("--stats", &self.stats),
        ];
        options.into_iter().filter_map(|(option, path)| Some((option, path.clone()?))).collect()
    }
}

/// Returns the parser of a stage's name. Former names are read and not listed.
fn names<T: Named>() -> PossibleValuesParser {
    let all = T::NAMES.iter().zip(T::OLD_NAMES);
    all.map(|(&name, old)| PossibleValue::new(name).aliases(old.iter().copied())).into()
}

/// Returns the parser of a number of sub-samples.
fn sub_samples() -> impl TypedValueParser<Value = u32> {
    PossibleValuesParser::new(["1", "4", "8", "16"]).try_map(|count| count.parse::<u32>())
}

/// Options that choose the stages of a pipeline.
#[derive(Clone, Debug, Args)]
pub(crate) struct Choices {
    /// Size in pixels [default: 640x480].
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<(u32, u32)>,
    /// Device that renders: the CPU, or the fastest GPU with a driver for Vulkan, Direct3D 12 or Metal, which has
    /// no certificates and no triangulation.
    #[arg(long, default_value = "cpu", value_parser = PossibleValuesParser::new(DEVICES))]
    pub(crate) device: String,
    /// Quality of the picture, as bounds on NMSE₂ and on visible noise: the lattice with as many light samples and as fine cells as they
    /// take. draft: 3e-4 and a tenth of the local brightness; good: 1e-4 and a twenty-fifth, clean at 4× zoom; final: 1e-5 and a
    /// seventieth [default: good, unless samples or other stages are chosen].
    #[arg(long, value_name = "QUALITY", value_parser = PossibleValuesParser::new(Quality::ALL.map(Quality::name)), conflicts_with_all = ["refiner", "upsampler", "shading", "samples"])]
    pub(crate) quality: Option<String>,
    /// NMSE₂ to come down to, without a bound on visible noise: the lattice with as many light samples and as fine cells as that takes. What
    /// is to be expected is among the statistics.
    #[arg(long, value_name = "NMSE2", value_parser = target, conflicts_with_all = ["refiner", "upsampler", "shading", "samples", "quality"])]
    pub(crate) error: Option<f32>,
    /// Interpolate only where it is certified that no thin shadow is missed. The lattice with a backend that certifies:
    /// bvh, beam or auto.
    #[arg(long, conflicts_with_all = ["refiner", "upsampler", "shading"])]
    pub(crate) certify: bool,
    /// Which fragments the image is made of; a name brings the refiner's own constants and an upsampler that fits it
    /// [default: lattice, at a quality].
    #[arg(long, value_parser = names::<RefinerConfig>())]
    pub(crate) refiner: Option<String>,
    /// Backend that answers shadow rays; auto is beam where few triangles lie between receivers and light, and bvh elsewhere [default: auto].
    #[arg(long, value_parser = names::<VisibilityConfig>())]
    pub(crate) visibility: Option<String>,
    /// Interpolation of pixels between fragments [default: lattice with the lattice, bilinear with per-pixel, else rbf-robust].
    /// GPUs interpolate the lattice's cells by lattice only, and no others.
    #[arg(long, value_parser = names::<UpsamplerConfig>())]
    pub(crate) upsampler: Option<String>,
    /// Quantity that is interpolated: irradiance, or the visible fraction [default: ratio].
    #[arg(long, value_parser = ["sampled", "ratio"])]
    pub(crate) shading: Option<String>,
    /// Indirect light: what surfaces reflect diffusely onto each other, by light propagation volumes (lpv) or gathered from lit points of the
    /// surfaces (gather). On the CPU only [default: none].
    #[arg(long, value_parser = names::<IndirectConfig>())]
    pub(crate) indirect: Option<String>,
    /// Light samples of a full mask, 1 to 4096 [default: as many as the quality or the error target takes; 64 without one].
    #[arg(long, value_name = "N")]
    pub(crate) samples: Option<u32>,
    /// Placement of light samples in their strata [default: jittered; shifted-rows for raster4d, which needs rows].
    #[arg(long, value_parser = ["grid", "shifted-rows", "jittered"])]
    pub(crate) pattern: Option<String>,
    /// Sharing of light samples, for refiners that leave the choice [default: fragment].
    #[arg(long, value_parser = ["receiver", "fragment", "frame"])]
    pub(crate) sharing: Option<String>,
    /// Seed of all randomness [default: 0].
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u32>,
    /// Sub-samples of pixels that see several surfaces, 1 for none [default: 8 on the CPU at the qualities good and final, else 1]. A GPU
    /// renders that many frames, shifted by parts of a pixel, and one more.
    #[arg(long, value_name = "N", value_parser = sub_samples())]
    pub(crate) antialias: Option<u32>,
    /// Start from a configuration file (TOML or JSON) with all or some of the keys that --print-config shows; options
    /// take precedence.
    #[arg(long, value_name = "F.toml")]
    pub(crate) config: Option<PathBuf>,
    /// Set any key of the configuration, such as refiner.coarse_threshold=4; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) settings: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct Reference {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    /// Light samples a pixel and light, rounded up to a multiple of 512; with --indirect, rays over the hemisphere of each pixel.
    #[arg(long, value_name = "N", default_value_t = 4096)]
    pub(crate) samples: u32,
    /// Size in pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "640x480")]
    pub(crate) size: (u32, u32),
    /// Sub-samples of every pixel, over which the light samples are shared out; 1 for its centre alone. They are those of `halflight render
    /// --antialias`.
    #[arg(long, value_name = "N", value_parser = sub_samples(), default_value = "1")]
    pub(crate) antialias: u32,
    /// Indirect light of exactly one diffuse reflection, in the place of direct light: the layers indirect_irradiance and indirect.
    #[arg(long, conflicts_with = "antialias")]
    pub(crate) indirect: bool,
    /// Seed of the light samples. Must not be that of images to be compared with it.
    #[arg(long, value_name = "N", default_value_t = halflight_lab::reference::SEED)]
    pub(crate) seed: u32,
    /// Worker threads; all cores by default. The image does not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// Image with all layers, OpenEXR.
    #[arg(long, value_name = "F.exr")]
    pub(crate) out: PathBuf,
    /// Folder for the state that a stopped run goes on from [default: that of --out].
    #[arg(long, value_name = "DIR")]
    pub(crate) cache: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Compare {
    /// The image, OpenEXR.
    pub(crate) image: PathBuf,
    /// The reference that it is measured against, OpenEXR.
    pub(crate) reference: PathBuf,
    /// Layer that is compared, such as radiance [default: irradiance where both files have it, or else indirect_irradiance, otherwise
    /// R, G, B without a layer's name].
    #[arg(long)]
    pub(crate) layer: Option<String>,
    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,
    /// Picture of the error.
    #[arg(long, value_name = "F.png")]
    pub(crate) error_map: Option<PathBuf>,
    /// Error, as a share of the reference's largest value, that is brightest in the picture.
    #[arg(long, value_name = "X", default_value_t = halflight_image::picture::ERROR_SCALE, value_parser = positive, requires = "error_map")]
    pub(crate) scale: f32,
}

/// Parses a size written `640x480`.
fn size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X', '×']);
    let sides = sides.and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)));
    sides.ok_or_else(|| "expected WIDTHxHEIGHT in pixels, such as 1280x960".to_owned())
}

/// Largest number of frames of one run: at 24 a second they last for eleven hours.
const MAX_FRAMES: usize = 1_000_000;

/// Parses frames written `48` or `10..20`.
fn frames(text: &str) -> Result<Range<u32>, String> {
    let range = match text.split_once("..") {
        Some((from, to)) => from.parse().ok().zip(to.parse().ok()),
        None => text.parse().ok().map(|count| (0, count)),
    };
    let range = range.map(|(from, to)| from..to).filter(|range| !range.is_empty());
    let range = range.ok_or_else(|| {
        "expected a number of frames, such as 48, or a range A..B, such as 10..20".to_owned()
    })?;
    match range.len() {
        0..=MAX_FRAMES => Ok(range),
        many => Err(format!("{many} frames are more than {MAX_FRAMES}: render them in parts, A..B")),
    }
}

fn fps(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value| (1e-3..=1e6).contains(value));
    value.ok_or_else(|| "expected frames a second from 0.001 to 1000000".to_owned())
}

fn target(text: &str) -> Result<f32, String> {
    let target = positive(text)?;
    if target < 1.0 { Ok(target) } else { Err("expected less than 1, such as 1e-4".to_owned()) }
}

fn positive(text: &str) -> Result<f32, String> {
    let value = text.parse().ok().filter(|value: &f32| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| "expected a number above 0".to_owned())
}
