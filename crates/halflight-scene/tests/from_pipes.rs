//! Scene files that are no plain files.
#![cfg(unix)]

mod common;

use std::process::Command;

use common::{Folder, HEAD};
use halflight_scene::{load, resolve};

#[test]
fn scenes_come_from_pipes_with_paths_relative_to_the_current_folder() {
    let folder = Folder::new("pipes");
    let mesh = folder.0.join("a.obj");
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let pipe = folder.0.join("scene.fifo");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    // Paths are not relative to the folder of the pipe.
    for (file, found) in [(mesh.to_str().unwrap(), true), ("a.obj", false)] {
        let text = format!("{HEAD}[[mesh]]\nfile = \"{file}\"\n");
        let loaded = std::thread::scope(|threads| {
            threads.spawn(|| std::fs::write(&pipe, &text).unwrap());
            resolve(pipe.to_str().unwrap())
        });
        assert_eq!(loaded.is_ok(), found, "{file}");
    }
}

#[test]
fn folders_and_missing_files_are_refused_in_words() {
    let folder = Folder::new("no_files");
    let path = folder.0.display().to_string();
    let fault = resolve(&path).unwrap_err().to_string();
    assert!(fault.starts_with(&format!("cannot read {path}: ")), "{fault}");
    assert!(
        resolve("no/such/scene.toml")
            .unwrap_err()
            .to_string()
            .starts_with("there is no scene `no/such/scene.toml`")
    );
    assert!(load("no/such/scene.toml".as_ref()).is_err());
    // A folder where a mesh should be, or a library or a texture.
    for name in ["a.obj", "a.ply"] {
        std::fs::create_dir(folder.0.join(name)).unwrap();
        let fault = folder.load(&format!("[[mesh]]\nfile = \"{name}\"\n")).unwrap_err();
        assert!(fault.starts_with(&format!("cannot read {name}: ")), "{fault}");
    }
    std::fs::create_dir(folder.0.join("a.mtl")).unwrap();
    std::fs::create_dir(folder.0.join("a.png")).unwrap();
    folder.write("b.mtl", "newmtl a\nmap_Kd a.png\n");
    let obj = "mtllib a.mtl\nmtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    let warnings = folder.load_mesh("b.obj", obj).unwrap().report.warnings;
    assert!(
        warnings.iter().all(|warning| warning.contains(" is missing in ")) && warnings.len() == 2,
        "{warnings:?}"
    );
}
