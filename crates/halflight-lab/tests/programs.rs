//! The laboratory's programs: outputs, limits, and settings without light.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::PathBuf;
use std::process::{Command, Output};

const EXPERIMENT: &str = r#"
title = "t"
description = "d"
size = [16, 12]
repetitions = 1
reference = { samples = 512, seed = 7 }
scene = [{ name = "contact" }]
[[grid]]
refiners = [{ name = "per-pixel" }]
upsamplers = ["bilinear"]
shadings = ["ratio"]
samples = [4]
"#;

/// An empty folder with the experiment.
fn folder(test: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("programs-{test}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("tiny.toml"), EXPERIMENT).unwrap();
    folder
}

/// Runs a line of a shell, in which the programs are `$ABLATE` and `$EXACTNESS`.
fn shell(folder: &PathBuf, line: &str) -> Output {
    let mut command = Command::new("sh");
    command.arg("-c").arg(line).current_dir(folder);
    command.env("ABLATE", env!("CARGO_BIN_EXE_halflight-ablate"));
    command.env("EXACTNESS", env!("CARGO_BIN_EXE_halflight-exactness"));
    command.output().unwrap()
}

/// The message of a run that must fail with an error in words.
fn refused(folder: &PathBuf, line: &str) -> String {
    let output = shell(folder, line);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{line}: {said}");
    let errors: Vec<&str> = said.lines().filter(|line| line.starts_with("error: ")).collect();
    assert!(errors.len() == 1 && !said.contains("panicked"), "{line}: {said}");
    errors[0].to_owned()
}

#[test]
fn tables_and_reports_go_through_links_and_state_is_kept() {
    let folder = folder("links");
    fs::create_dir_all(folder.join("out")).unwrap();
    for name in ["results.csv", "report.html", "state.jsonl"] {
        symlink(format!("../stored-{name}"), folder.join("out").join(name)).unwrap();
    }
    for _ in 0..2 {
        let output = shell(&folder, "\"$ABLATE\" tiny.toml --out out");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        for name in ["results.csv", "report.html", "state.jsonl"] {
            assert!(fs::symlink_metadata(folder.join("out").join(name)).unwrap().is_symlink(), "{name}");
            assert!(fs::metadata(folder.join(format!("stored-{name}"))).unwrap().len() > 100, "{name}");
        }
    }
    // Another experiment sets the rows aside.
    fs::write(folder.join("tiny.toml"), EXPERIMENT.replace("[4]", "[9]")).unwrap();
    assert!(shell(&folder, "\"$ABLATE\" tiny.toml --out out").status.success());
    assert!(fs::symlink_metadata(folder.join("out/state.jsonl")).unwrap().is_symlink());
    assert!(fs::read_to_string(folder.join("out/state.jsonl.old")).unwrap().lines().count() == 2);
}

#[test]
fn what_cannot_work_is_refused_in_words() {
    let folder = folder("refused");
    fs::write(folder.join("plain"), "before").unwrap();
    let dark = "[camera]\neye = [0, 1.5, 4]\ntarget = [0, 0.5, 0]\nfov_y_deg = 45\n[[light]]\ncorner = [0, 3, 0]\n\
        edge_u = [0, 0, 1]\nedge_v = [1, 0, 0]\nradiance = [9, 9, 9]\n[[mesh]]\ngenerator = \"contact\"\n";
    fs::write(folder.join("dark.toml"), dark).unwrap();
    for (line, words) in [
        ("\"$ABLATE\" tiny.toml --out plain", "plain"),
        ("\"$ABLATE\" tiny.toml --out plain/a", "plain/a"),
        ("\"$EXACTNESS\" --out plain --pairs 1 --certificates 0", "cannot write plain"),
        (
            "\"$ABLATE\" tiny.toml --scene dark.toml --out o",
            "dark: no light reaches any visible surface: light 0 emits",
        ),
        ("\"$ABLATE\" tiny.toml --scene dark.toml --out o", "relative to a black reference are undefined"),
    ] {
        let message = refused(&folder, line);
        assert!(message.contains(words), "{line}: {message}");
    }
    if cfg!(target_os = "linux") {
        for (line, words) in [
            ("\"$ABLATE\" --list > /dev/full", "cannot write to standard output"),
            (
                "ulimit -v 3145728; \"$ABLATE\" tiny.toml --size 20000x20000 --out o",
                "20000x20000 pixels takes about",
            ),
            (
                "ulimit -v 3145728; \"$ABLATE\" tiny.toml --size 4294967295x4294967295 --out o",
                "4294967295x4294967295",
            ),
        ] {
            let message = refused(&folder, line);
            assert!(message.contains(words), "{line}: {message}");
        }
    }
    assert_eq!(fs::read(folder.join("plain")).unwrap(), b"before");
    assert!(!folder.join("o/results.csv").exists());
}
