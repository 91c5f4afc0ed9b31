//! Scene files from standard input.
#![cfg(unix)]

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

const SCENE: &str = "\
[camera]
eye = [0, 3, 3]
target = [0, 0, 0]
fov_y_deg = 40

[[light]]
corner = [-0.5, 2, -0.5]
edge_u = [1, 0, 0]
edge_v = [0, 0, 1]
radiance = [1, 1, 1]

[[mesh]]
file = \"floor.obj\"
";

#[test]
fn scenes_come_from_standard_input_with_paths_relative_to_the_current_folder() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("standard-input");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("scenes")).unwrap();
    fs::write(folder.join("floor.obj"), "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nf 3 2 1\n").unwrap();
    fs::write(folder.join("scenes/scene.toml"), SCENE).unwrap();
    for (name, picture) in [("-", "image.png"), ("/dev/stdin", "stdin.png")] {
        // By a pipe, and by a file that lies elsewhere.
        for redirected in [false, true] {
            let _ = fs::remove_file(folder.join(picture));
            let mut command = Command::new(env!("CARGO_BIN_EXE_halflight"));
            command.args(["render", name, "--size", "16x12"]).current_dir(&folder).stderr(Stdio::piped());
            let input = fs::File::open(folder.join("scenes/scene.toml")).unwrap();
            command.stdin(if redirected { input.into() } else { Stdio::piped() });
            let mut child = command.spawn().unwrap();
            if let Some(mut pipe) = child.stdin.take() {
                pipe.write_all(SCENE.as_bytes()).unwrap();
            }
            let output = child.wait_with_output().unwrap();
            assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
            assert!(folder.join(picture).is_file(), "{name}");
        }
    }
}
