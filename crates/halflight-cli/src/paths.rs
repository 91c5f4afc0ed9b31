//! Paths of outputs, checked before any work is done for them.

use std::error::Error;
use std::path::{Path, PathBuf};

use halflight_lab::program::say;
use halflight_metrics::{check_output, is_same_file, is_standard_output};

/// Option that asks for an output, and the path that is given.
pub(crate) type OutputPath = (&'static str, PathBuf);

/// Description of the paths of outputs for `--help`.
pub(crate) const HELP: &str = "\
Outputs are written as by cp: symbolic links, hard links and permissions of files that are there stay; named pipes and
devices are written to; a link that leads nowhere has its target created. `-` is standard output, for one output of a
command. No output may be what another output writes, or a scene, mesh, configuration or image that is read.";

/// Refuses outputs that cannot be written, that lead to the same file, or that would overwrite one of the `inputs`.
pub(crate) fn check(outputs: &[OutputPath], inputs: &[PathBuf]) -> Result<(), Box<dyn Error>> {
    for (index, (option, path)) in outputs.iter().enumerate() {
        check_output(path)?;
        if let Some((other, _)) = outputs[..index].iter().find(|(_, other)| is_same_file(path, other)) {
            return Err(format!(
                "{other} and {option} both write to {}: give them different files",
                shown(path)
            )
            .into());
        }
        // `-` is standard input there.
        let is_read = |input: &&PathBuf| input.as_os_str() != "-" && is_same_file(path, input);
        if let Some(input) = inputs.iter().find(is_read) {
            return Err(format!(
                "{option} would overwrite {}, which is read: give another file",
                input.display()
            )
            .into());
        }
    }
    Ok(())
}

/// Says which files were written.
pub(crate) fn say_written(paths: &[PathBuf]) {
    paths
        .iter()
        .filter(|path| !is_standard_output(path))
        .for_each(|path| say(&format!("wrote {}", path.display())));
}

/// Returns a path for messages.
pub(crate) fn shown(path: &Path) -> String {
    if is_standard_output(path) { "standard output".to_owned() } else { path.display().to_string() }
}
