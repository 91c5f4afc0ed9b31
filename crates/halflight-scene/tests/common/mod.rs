//! Scenes written to a folder of their own for each test.
#![allow(dead_code, reason = "every test crate uses its own part")]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs;
use std::path::PathBuf;

use halflight_scene::{Loaded, load};

/// Camera and light of a scene file, to which a `[[mesh]]` is appended.
pub(crate) const HEAD: &str = "\
[camera]
eye = [0, 1, 5]
target = [0, 0, 0]
fov_y_deg = 45

[[light]]
corner = [0, 3, 0]
edge_u = [1, 0, 0]
edge_v = [0, 0, 1]
radiance = [1, 1, 1]

";

/// A folder that only one test uses.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    /// Creates an empty folder, even if an earlier run left one. `name` must be the test's own.
    pub(crate) fn new(name: &str) -> Self {
        let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
        if path.exists() {
            fs::remove_dir_all(&path).unwrap();
        }
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// Writes a file, its folders included.
    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
        self
    }

    /// Writes and loads a scene with the given text behind [`HEAD`].
    pub(crate) fn load(&self, mesh: &str) -> Result<Loaded, String> {
        self.load_text(&format!("{HEAD}{mesh}"))
    }

    /// Writes and loads a scene; messages and warnings lose the folder's path.
    pub(crate) fn load_text(&self, text: &str) -> Result<Loaded, String> {
        let folder = format!("{}/", self.0.display());
        self.write("scene.toml", text);
        let mut loaded =
            load(&self.0.join("scene.toml")).map_err(|fault| fault.to_string().replace(&folder, ""))?;
        for warning in &mut loaded.report.warnings {
            *warning = warning.replace(&folder, "").replace(folder.trim_end_matches('/'), ".");
        }
        Ok(loaded)
    }

    /// Loads one mesh file, written first.
    pub(crate) fn load_mesh(&self, name: &str, content: impl AsRef<[u8]>) -> Result<Loaded, String> {
        self.write(name, content);
        self.load(&format!("[[mesh]]\nfile = \"{name}\"\n"))
    }

    /// Loads one mesh file, written first, as a smooth mesh.
    pub(crate) fn load_smooth(&self, name: &str, content: impl AsRef<[u8]>) -> Result<Loaded, String> {
        self.write(name, content);
        self.load(&format!("[[mesh]]\nfile = \"{name}\"\nsmooth = \"on\"\n"))
    }
}
