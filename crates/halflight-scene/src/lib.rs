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
//! ## shape = "parallelogram" # optional; instead of corner and edges also:
//! ## shape = "disk", centre = [0, 3, 0], normal = [0, -1, 0], radius = 0.5
//! ## shape = "ellipse", centre = [0, 3, 0], axis_u = [0.5, 0, 0], axis_v = [0, 0, 0.3], from the centre; emits along their cross product
//! ## shape = "polygon", points = [[0, 3, 0], [1, 3, 0], [0.5, 3, 1]], convex; emits to where they run counterclockwise
//! ## shape = "sphere", centre = [0, 3, 0], radius = 0.2; emits to all sides
//! radiance = [10, 10, 10] # W/m²/sr
//! two_sided = false       # optional, this is the default
//! visible = false         # optional, this is the default; true: the camera sees the light
//! ## texture = "screen.png"  # optional: a texture that the radiance is multiplied with, its lower left at the corner, its rows along edge_u;
//! ##                          # "screen-####.png" is a video, of frames with numbers of four digits
//! ## texture_generator = "meadow" # optional, instead of a texture: a generated one of 160 × 90 texels, "meadow" or "checkerboard"
//! ## texture_frames = 24      # optional, of a generated texture: frames of a film that repeats; 1 is a still
//! ## texture_encoding = "auto" # optional: linear in HDR and EXR files, sRGB in others; or "linear", "srgb"
//! ## texture_fps = 24        # optional, of a video, which begins again after its last frame
//! ## texture_stretch = false # optional: true if the texture's aspect ratio is not the light's
//!
//! [[mesh]]
//! generator = "contact"   # or: file = "mesh.obj" (or .ply), relative to the scene file
//! transform = { translate = [0, 0, 0], rotate_deg = [0, 90, 0], scale = 1 } # all optional; scale, x, y, z, move
//! albedo = [0.7, 0.7, 0.7] # optional; replaces the mesh's own colours and textures
//! ## emissive = "lights"   # optional, of OBJ files: flat faces with emission (Ke) become lights; or "ignore", the default, without a warning
//! ## alpha = "map_d"        # optional, of a file without albedo: its alpha masks; "albedo": also the alpha of its textures; "none"
//! ## alpha_cutoff = 0.5     # optional: alpha, 0 to 1, from which on texels are solid
//! smooth = "auto"         # optional: smooth where the file or generator gives normals; "on": also where it gives none; "off"
//! ## specular = "auto"    # optional: glossy where the material library gives Pr or Pm; "phong": also by Ks and Ns; "off"
//! ## roughness = 0.3      # optional, 0 to 1: replaces that of all materials; its square is the α of GGX
//! ## metallic = 0         # optional, 0 to 1: how much the colour is reflectance instead of albedo
//! ## reflectance = [0.04, 0.04, 0.04] # optional, 0 to 1: at normal incidence, of what is not metal
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
//! Faults of scene files, and faults of OBJ and PLY files that leave no usable mesh, are [`SceneError`]s that
//! name the file and the line or element. Other content that is not supported or is dropped gives one warning
//! each in [`LoadReport::warnings`]: bad lines of MTL files, faces with a position that is not finite,
//! undefined indices of normals or texture coordinates, options of textures. Triangles without an area are
//! dropped and counted.
//!
//! Smooth surfaces are shaded by normals between those of their vertices ([`halflight_core::smooth`]). Where a file gives normals for some
//! vertices only, or with `smooth = "on"`, missing ones are computed: the mean of the faces around a vertex, without those beyond an edge
//! of more than `crease_deg` degrees (65; a key beside `smooth = "on"`). A mesh without any normals is flat with `"auto"`.
//!
//! Materials with an alpha mask ([`halflight_core::alpha`]) have holes. `map_d` names its image, whose alpha it is, or whose luminance where
//! the alpha is 255 everywhere. With `alpha = "albedo"` a material without `map_d` takes the alpha of its `map_Kd` or, in PLY files, of its texture.
//!
//! | file | what is read |
//! | --- | --- |
//! | OBJ | `v`, `vt`, `vn`, `f`, `usemtl`, `mtllib`; coordinates in double precision until the transform has been applied |
//! | MTL | `Kd`, `map_Kd` and `map_d` with `-s` and `-o`; `Pr`, `Pm` and `Ks` with them; `Ks` with `Ns`, and `Ke`, where the scene file asks |
//! | PLY | ASCII and binary; `vertex` with positions, normals and texture coordinates, `face` and `tristrips`; colours of faces (whole numbers are sRGB, others linear); textures by comments `TextureFile` |
//! | images | PNG, JPEG, TGA, BMP of at most 16384 × 16384 texels, kept in sRGB at four bytes a texel |
//!
//! Text is UTF-8, with or without a byte order mark, or UTF-16; lines end with LF, CR LF or CR.

mod alpha;
mod animation;
mod bundled;
mod camera;
mod clean;
mod context;
mod emission;
mod emitters;
mod error;
mod faces;
mod file;
mod folders;
pub mod generate;
mod library;
mod light_shape;
mod light_texture;
mod load;
mod model;
mod mtl;
mod normals;
mod obj;
mod ply;
mod polygon;
mod report;
mod section;
mod specular;
mod text;
mod texture;
mod transform;
mod vertices;

use std::io::Read;
use std::path::Path;

use halflight_core::scene::Scene;

pub use animation::Animation;
pub use bundled::bundled;
pub use error::{Place, SceneError};
pub use report::{LoadReport, MeshReport};

/// Scene and the results of loading it.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Scene ready to render: world space, clean, valid.
    pub scene: Scene,
    /// Animation of the scene, if its file has one.
    pub animation: Option<Animation>,
    /// Report of dropped, computed and ignored content.
    pub report: LoadReport,
}

/// Loads the scene file at `path`. Paths in it are relative to its folder; where it is a pipe, a terminal or
/// anything else below `/dev` or `/proc`, to the current one.
///
/// # Errors
/// Any [`SceneError`] but [`SceneError::UnknownScene`].
pub fn load(path: &Path) -> Result<Loaded, SceneError> {
    let unreadable = |source| SceneError::Read { path: path.to_path_buf(), source };
    let bytes = std::fs::read(path).map_err(unreadable)?;
    let plain = path.is_file() && !["/dev", "/proc"].iter().any(|folder| path.starts_with(folder));
    let folder = path.parent().filter(|_| plain).unwrap_or(Path::new(""));
    load_bytes(bytes, &path.display().to_string(), folder)
}

/// Loads the scene file from standard input. Paths in it are relative to the current folder.
fn load_standard_input() -> Result<Loaded, SceneError> {
    let mut bytes = Vec::new();
    std::io::stdin()
        .lock()
        .read_to_end(&mut bytes)
        .map_err(|source| SceneError::Read { path: "standard input".into(), source })?;
    load_bytes(bytes, "standard input", Path::new(""))
}

fn load_bytes(bytes: Vec<u8>, name: &str, folder: &Path) -> Result<Loaded, SceneError> {
    let text = String::from_utf8(text::decode(bytes)).map_err(|fault| {
        let read = &fault.as_bytes()[..fault.utf8_error().valid_up_to()];
        let line = 1 + read.iter().filter(|&&byte| byte == b'\n').count();
        let message = "not valid TOML: the text is not UTF-8".to_string();
        SceneError::Invalid { file: name.to_string(), place: Place::Line(line), message }
    })?;
    load::load(&text, name, folder)
}

/// Loads the bundled scene `name`, one of [`bundled`].
///
/// # Errors
/// [`SceneError::UnknownScene`] if there is no scene of that name.
pub fn load_bundled(name: &str) -> Result<Loaded, SceneError> {
    let text = bundled::text(name).ok_or_else(|| unknown(name))?;
    load::load(text, &format!("{name}.toml"), Path::new(""))
}

/// Loads `name_or_path`: a bundled scene, `-` for standard input, or else a scene file, which may be a pipe.
///
/// # Errors
/// [`SceneError::UnknownScene`] if it is none of them, and all errors of [`load`].
pub fn resolve(name_or_path: &str) -> Result<Loaded, SceneError> {
    if bundled::text(name_or_path).is_some() {
        return load_bundled(name_or_path);
    }
    let path = Path::new(name_or_path);
    match name_or_path {
        "-" => load_standard_input(),
        _ if path.exists() => load(path),
        _ => Err(unknown(name_or_path)),
    }
}

/// Loads the scene that `text` describes. Error messages call it `name`; paths in it are relative to
/// `folder`.
///
/// # Errors
/// See [`load`].
pub fn parse(text: &str, name: &str, folder: &Path) -> Result<Loaded, SceneError> {
    load::load(text, name, folder)
}

fn unknown(name: &str) -> SceneError {
    let bundled = bundled().iter().map(|&(name, _)| name).collect();
    SceneError::UnknownScene { name: name.to_string(), bundled }
}
