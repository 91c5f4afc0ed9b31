//! Devices that render the rows of an experiment: the CPU, or a GPU.

#[cfg(feature = "gpu")]
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::stats::FrameStats;
#[cfg(feature = "gpu")]
use halflight_cpu::pipeline::Image;
use halflight_cpu::pipeline::Pipeline;
use halflight_cpu::prepared::PreparedScene;
#[cfg(feature = "gpu")]
use halflight_gpu::{Gpu, GpuError, Inputs, Renderer};
use halflight_image::picture;

use crate::experiment::plan::Row;

/// Device that renders rows.
#[derive(Clone, Debug, Default)]
pub enum Device {
    /// The CPU.
    #[default]
    Cpu,
    /// A GPU.
    #[cfg(feature = "gpu")]
    Gpu(Arc<Gpu>),
}

impl Device {
    /// Names that [`Device::open`] knows.
    pub const NAMES: &[&str] = if cfg!(feature = "gpu") { &["cpu", "gpu"] } else { &["cpu"] };

    /// Opens the device of a name.
    ///
    /// # Errors
    /// No such device exists, or the program was built without it.
    pub fn open(name: &str) -> Result<Self> {
        match name {
            "cpu" => Ok(Self::Cpu),
            #[cfg(feature = "gpu")]
            "gpu" => Ok(Self::Gpu(Arc::new(Gpu::find()?))),
            _ => bail!("this program was built without that device: see --help"),
        }
    }

    /// Returns the device's name in `results.csv`, with that of the adapter for a GPU.
    pub fn name(&self) -> String {
        match self {
            Self::Cpu => "cpu".to_string(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => {
                let info = gpu.adapter.get_info();
                format!("gpu: {}, {}", info.name, info.backend)
            }
        }
    }

    /// Makes a row's renderer; `None` where this device lacks stages of the row.
    ///
    /// # Errors
    /// The row cannot be rendered.
    pub(super) fn machine(&self, row: &Row, scene: &PreparedScene) -> Result<Option<Machine>> {
        match self {
            Self::Cpu => {
                let pipeline = row.builder(scene).build().with_context(|| row.named())?;
                Ok(Some(Machine::Cpu(Box::new(pipeline))))
            }
            #[cfg(feature = "gpu")]
            Self::Gpu(_) if row.rival.is_some() => Ok(None),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => match Renderer::new(&gpu.device, &gpu.queue, scene.scene(), &row.config) {
                Ok(renderer) => Ok(Some(Machine::Gpu(Box::new(OnGpu {
                    gpu: Arc::clone(gpu),
                    renderer,
                    stats: FrameStats::default(),
                    image: Image::default(),
                })))),
                Err(GpuError::Unsupported { .. }) => Ok(None),
                Err(source) => Err(source.into()),
            },
        }
    }
}

/// Renderer of a row.
pub(super) enum Machine {
    Cpu(Box<Pipeline>),
    #[cfg(feature = "gpu")]
    Gpu(Box<OnGpu>),
}

/// Renderer on a GPU, and its last frame.
#[cfg(feature = "gpu")]
pub(super) struct OnGpu {
    gpu: Arc<Gpu>,
    renderer: Renderer,
    stats: FrameStats,
    image: Image,
}

impl Machine {
    /// Renders frame 0 and returns its statistics: every repetition does the same work.
    pub(super) fn render(&mut self, row: &Row) -> Result<FrameStats> {
        match self {
            Self::Cpu(pipeline) => {
                pipeline.set_frame_index(0);
                let image = pipeline.render();
                Ok(image.with_context(|| row.named())?.stats.clone())
            }
            #[cfg(feature = "gpu")]
            Self::Gpu(on) => {
                let stats = on.gpu.render(&mut on.renderer, &Inputs::default())?;
                if stats.lost > 0 {
                    bail!("{}: {} queries did not fit into the device's buffers", row.label(), stats.lost);
                }
                on.stats = stats.frame;
                Ok(on.stats.clone())
            }
        }
    }

    /// Reads back what the accessors below return.
    pub(super) fn fetch(&mut self) -> Result<()> {
        match self {
            Self::Cpu(_) => Ok(()),
            #[cfg(feature = "gpu")]
            Self::Gpu(on) => {
                (on.image, _) = on.gpu.download(&on.renderer)?;
                Ok(())
            }
        }
    }

    /// Returns the irradiance of the last frame.
    pub(super) fn irradiance(&self) -> &[Vec3] {
        match self {
            Self::Cpu(pipeline) => &pipeline.image().irradiance,
            #[cfg(feature = "gpu")]
            Self::Gpu(on) => &on.image.irradiance,
        }
    }

    /// Returns the statistics of the last frame.
    pub(super) fn stats(&self) -> &FrameStats {
        match self {
            Self::Cpu(pipeline) => &pipeline.image().stats,
            #[cfg(feature = "gpu")]
            Self::Gpu(on) => &on.stats,
        }
    }

    /// Returns the map of the fragments.
    pub(super) fn fragment_map(&self, gbuffer: &GBuffer) -> Vec<[u8; 3]> {
        match self {
            Self::Cpu(pipeline) => picture::fragment_map(pipeline.fragments(), gbuffer),
            #[cfg(feature = "gpu")]
            Self::Gpu(on) => picture::level_map(&on.image.level, gbuffer),
        }
    }
}
