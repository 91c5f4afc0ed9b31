//! `halflight info`, `halflight scenes` and `halflight completions`.

use std::fmt::Write;

use clap::CommandFactory;

use halflight_lab::program::print;

use crate::Outcome;
use crate::args::{Cli, SceneArg};
use crate::scene::{self, Ready};

pub(crate) fn run(args: &SceneArg) -> Outcome {
    let Ready { prepared, animation, report, flush } = scene::load(&args.scene)?;
    let (scene, bvh) = (prepared.scene(), prepared.bvh());
    let mut out = String::new();
    writeln!(out, "triangles  {} ({} vertices)", scene.mesh.triangle_count(), scene.mesh.positions.len())?;
    for mesh in &report.meshes {
        write!(out, "  {:<9} {}", mesh.triangles, mesh.source)?;
        if mesh.zero_area_dropped > 0 {
            write!(out, ", {} without an area dropped", mesh.zero_area_dropped)?;
        }
        if mesh.normals_computed > 0 {
            write!(out, ", {} normals computed", mesh.normals_computed)?;
        }
        match mesh.lights {
            0 => {}
            1 => write!(out, ", 1 light of emissive faces")?,
            lights => write!(out, ", {lights} lights of emissive faces")?,
        }
        writeln!(out)?;
    }
    if let Some((low, high)) = scene.mesh.bounds() {
        writeln!(out, "bounds     {low} to {high} m, diagonal {:.3} m", bvh.diagonal())?;
    }
    writeln!(out, "materials  {}", scene.mesh.materials.len())?;
    writeln!(out, "textures   {}", scene.mesh.textures.len())?;
    for texture in &scene.mesh.textures {
        writeln!(out, "  {}x{}", texture.width, texture.height)?;
    }
    for (index, light) in scene.lights.iter().enumerate() {
        let texture = light.texture.and_then(|place| scene.light_textures.get(place.index as usize));
        let texture = texture.map(|texture| (texture.width(), texture.height()));
        let form = match light.as_sphere() {
            Some(sphere) => format!("centre {}, sphere of radius {} m", sphere.centre, sphere.radius),
            None => format!("centre {}, towards {}", light.centre(), light.normal()),
        };
        writeln!(
            out,
            "light {index}    {form}, {:.3} m², radiance {} W/m²/sr{}{}{}{}",
            light.area(),
            light.radiance,
            if light.two_sided { ", two-sided" } else { "" },
            if light.visible { ", visible" } else { "" },
            texture.map_or(String::new(), |(width, height)| format!(", texture of {width}x{height} texels")),
            match flush.iter().find(|flush| flush.light as usize == index).map(|flush| flush.triangles.len())
            {
                None => String::new(),
                Some(1) => ", flush with 1 triangle".to_owned(),
                Some(triangles) => format!(", flush with {triangles} triangles"),
            }
        )?;
    }
    let camera = &scene.camera;
    writeln!(out, "camera     at {} towards {}, {}° high", camera.eye, camera.target, camera.fov_y_deg)?;
    if let Some(animation) = animation {
        writeln!(out, "animation  {animation}")?;
    }
    let (bytes, ms) = (bvh.bytes() as f64 / f64::from(1 << 20), bvh.build_time().as_secs_f64() * 1e3);
    writeln!(out, "BVH  {bytes:.1} MiB, built in {ms:.1} ms")?;
    writeln!(out, "warnings   {}", report.warnings.len() + flush.len())?;
    Ok(print(&out)?)
}

pub(crate) fn scenes() -> Outcome {
    let mut out = String::new();
    for &(name, text) in halflight_scene::bundled() {
        writeln!(out, "{name:<12} {}", description(text))?;
    }
    Ok(print(&out)?)
}

/// Prints the completions of a shell.
pub(crate) fn completions(shell: clap_complete::Shell) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "halflight", &mut script);
    Ok(print(&String::from_utf8_lossy(&script))?)
}

/// Returns the description in a scene file.
fn description(text: &str) -> String {
    let file: Option<toml::Table> = text.parse().ok();
    let description = file.as_ref().and_then(|file| file.get("description")?.as_str());
    description.unwrap_or_default().to_owned()
}
