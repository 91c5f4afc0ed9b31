//! Scenes for Halflight: scene files, OBJ and PLY meshes, and procedural generators.
//!
//! A scene file is TOML:
//!
//! ```
//! let text = r#"
//! description = "A box on the floor, lit from above"
//!
//! [camera]
//! eye = [0, 1.5, 4]
//! target = [0, 0.5, 0]
//! up = [0, 1, 0]          # optional, this is the default
//! fov_y_deg = 45
//!
//! [[light]]               # several are summed
//! corner = [-0.5, 3, -0.5]
//! edge_u = [1, 0, 0]
//! edge_v = [0, 0, 1]      # emits along cross(edge_u, edge_v): here down
//! radiance = [10, 10, 10] # W/m²/sr
//! two_sided = false       # optional, this is the default
//!
//! [[mesh]]
//! generator = "contact"   # or: file = "mesh.obj" (or .ply), relative to the scene file
//! transform = { translate = [0, 0, 0], rotate_deg = [0, 90, 0], scale = 1 } # all optional; scale, x, y, z, move
//! albedo = [0.7, 0.7, 0.7] # optional; replaces the mesh's own colours and textures
//!
//! [animation.camera]      # optional: what moves; at time 0 everything is as above
//! keys = [{ time = 4, eye = [1, 1.5, 4] }] # seconds; what a key leaves out stays as it was
//!
//! [[animation.light]]
//! light = 0               # optional where there is one light; counted from 0, as they follow in the file
//! axis = [0, 1, 0]        # what rotate_deg turns about; optional, this is the default
//! pivot = [0, 3, 0]       # where the axis passes through; optional, the middle of the light
//! keys = [{ time = 2, translate = [1, 0, 0] }, { time = 4, translate = [0, 0, 0], rotate_deg = 90 }]
//!
//! [[animation.mesh]]      # the same for a mesh, or:
//! sway = { amplitude = [0.1, 0, 0], period = 3, foot = 0.2 } # metres of the top; foot: optional, where it starts to bend
//! "#;
//! let loaded = halflight_scene::parse(text, "box.toml", ".".as_ref())?;
//! assert!(loaded.report.triangles() > 0);
//! let moved = loaded.animation.expect("it has one").at(&loaded.scene, 1.0);
//! assert_eq!(moved.camera.eye.x, 0.25);
//! # Ok::<(), halflight_scene::SceneError>(())
//! ```
//!
//! Every fault of a scene file, an OBJ, MTL or PLY file is a [`SceneError`] that names the file and the line or
//! element. What is merely not supported is said once, in [`LoadReport::warnings`]. Triangles without an area are
//! dropped and counted; missing normals are computed.

mod animation;
mod bundled;
mod clean;
mod error;
mod file;
pub mod generate;
mod load;
mod mtl;
mod obj;
mod ply;
mod polygon;
mod report;
mod section;
mod texture;
mod transform;

use std::path::Path;

use halflight_core::scene::Scene;

pub use animation::Animation;
pub use bundled::bundled;
pub use error::{Place, SceneError};
pub use report::{LoadReport, MeshReport};

/// A scene and what loading it did.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Ready to render: world space, clean, valid.
    pub scene: Scene,
    /// How it changes with time, if its file says so.
    pub animation: Option<Animation>,
    /// What was dropped, computed or left out.
    pub report: LoadReport,
}

/// Loads the scene file at `path`.
///
/// # Errors
/// Any [`SceneError`] but [`SceneError::UnknownScene`].
pub fn load(path: &Path) -> Result<Loaded, SceneError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| SceneError::Read { path: path.to_path_buf(), source })?;
    load::load(&text, &path.display().to_string(), path.parent().unwrap_or(Path::new("")))
}

/// Loads the bundled scene `name`, one of [`bundled`].
///
/// # Errors
/// [`SceneError::UnknownScene`] where there is none of that name.
pub fn load_bundled(name: &str) -> Result<Loaded, SceneError> {
    let text = bundled::text(name).ok_or_else(|| unknown(name))?;
    load::load(text, &format!("{name}.toml"), Path::new(""))
}

/// Loads `name_or_path`: a bundled scene, or else a scene file.
///
/// # Errors
/// [`SceneError::UnknownScene`] where it is neither, and whatever [`load`] finds.
pub fn resolve(name_or_path: &str) -> Result<Loaded, SceneError> {
    if bundled::text(name_or_path).is_some() {
        return load_bundled(name_or_path);
    }
    let path = Path::new(name_or_path);
    if path.is_file() { load(path) } else { Err(unknown(name_or_path)) }
}

/// Loads the scene that `text` describes. Faults call it `name`; paths in it are relative to `folder`.
///
/// # Errors
/// As for [`load`].
pub fn parse(text: &str, name: &str, folder: &Path) -> Result<Loaded, SceneError> {
    load::load(text, name, folder)
}

fn unknown(name: &str) -> SceneError {
    let bundled = bundled().iter().map(|&(name, _)| name).collect();
    SceneError::UnknownScene { name: name.to_string(), bundled }
}
