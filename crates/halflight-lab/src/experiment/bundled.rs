//! Experiments that come with the program.

macro_rules! experiments {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../experiments/", $name, ".toml")))),*]
    };
}

/// Names and texts of all bundled experiments.
pub const EXPERIMENTS: &[(&str, &str)] = experiments![
    "default",
    "flicker",
    "gpu",
    "indirect",
    "indirect-flicker",
    "koa-fig15",
    "koa-fig16",
    "koa-fig17",
    "koa-fig7",
    "koa-fig8",
    "koa-table1",
    "koa16-fig6",
    "koa16-table1",
    "lattice",
    "light-samples",
    "nichols-fig10",
    "nichols-fig3",
    "nichols-fig6",
    "nichols-fig8",
    "nichols-fig9",
    "nichols-flicker",
    "nichols-pareto",
    "pareto",
    "rivals",
    "scaling-pixels",
    "scaling-samples",
    "scaling-triangles",
    "targets",
    "thresholds",
    "tiles",
    "visibility",
    "voxel",
    "wang-table1",
    "wang-table2",
    "wang-table3",
    "wang-table4",
    "wang-table5",
    "wang-table6",
    "wang-table7",
    "wang-table8",
];

/// Returns the text of a bundled experiment.
pub fn text(name: &str) -> Option<&'static str> {
    EXPERIMENTS.iter().find(|(known, _)| *known == name).map(|&(_, text)| text)
}

#[cfg(test)]
mod tests {
    use super::super::{Experiment, plan};
    use super::*;

    #[test]
    fn all_parse_and_expand() {
        let counts: Vec<(&str, usize, usize)> = EXPERIMENTS
            .iter()
            .map(|&(name, text)| {
                let experiment = Experiment::parse(text, &format!("{name}.toml")).unwrap();
                assert_eq!(experiment.name, name);
                let (settings, rows) = plan::plan(&experiment).unwrap();
                (name, settings.len(), rows.len())
            })
            .collect();
        // Counted by hand from the files' axes.
        let expected = [
            ("default", 3, 2 * 5 * 2 + 6 * 2 + 2 + 4 + 3 * 2 + 1 + 4 * 3 + 4 + 4 + 3),
            ("flicker", 3, 2 + 2 * 5 * 2 + 4 + 1 + 3),
            ("gpu", 2 * 2, 4 * 2 + 2 + 2 * 4 * 2 + 1 + 2),
            ("indirect", 3, 1),
            ("indirect-flicker", 2, 1),
            ("koa-fig15", 1, 2 + 2),
            ("koa-fig16", 2, 2 + 2),
            ("koa-fig17", 7, 3 + 3),
            ("koa-fig7", 1, 2 * 5),
            ("koa-fig8", 1, 3),
            ("koa-table1", 3, 1 + 2 + 2 + 3),
            ("koa16-fig6", 1, 3),
            ("koa16-table1", 1, 1 + 2 + 1),
            ("lattice", 4, 4 + 4 + 4 * 2 + 3),
            ("light-samples", 3, 2 * 3 + 2 * (2 * 3 + 1) + 2 * (2 * 2 + 1)),
            ("nichols-fig10", 2, 5 * 5 + 4),
            ("nichols-fig3", 1, 2),
            ("nichols-fig6", 3, 1),
            ("nichols-fig8", 2, 1 + 1 + 2 + 1 + 1 + 2),
            ("nichols-fig9", 1, 2),
            ("nichols-flicker", 1, 2 * 2 + 2 * 2 + 2),
            ("nichols-pareto", 2, 5 + 3 + 4 + 3 * 2),
            ("pareto", 5, 8 * 2 + 5 * 2 + 4 + 1 + 3 + 20 + 2 * 2 * 3 + 4 + 1 + 5 + 4 * 3 + 2 + 4 + 4),
            ("rivals", 5, 3 + 3 + 4 + 3 + 5),
            ("scaling-pixels", 2 * 4, 3),
            ("scaling-samples", 2, 3 * 4 + 2 * 4),
            ("scaling-triangles", 3 * 6, 3 + 2),
            ("targets", 8, 1 + 2 * 4 + 6 + 5 + 2 * 2 + 2 + 1 + 1),
            ("thresholds", 1, (6 + 5 + 1 + 3) * 10 + 6),
            ("tiles", 2, 3 * 2),
            ("visibility", 4, 3 * 4),
            ("voxel", 4, 2 * 6 + 3 + 4 * 2 + 2 * 2 + 1),
            ("wang-table1", 6, 3),
            ("wang-table2", 3, 6),
            ("wang-table3", 5, 2),
            ("wang-table4", 4, 3 * 4),
            ("wang-table5", 4 * 5, 3),
            ("wang-table6", 4, 4),
            ("wang-table7", 5, 1),
            ("wang-table8", 5, 2 + 7 + 7),
        ];
        assert_eq!(counts, expected);
    }

    #[test]
    fn names_are_those_of_the_files() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
            .collect();
        files.sort();
        let mut names: Vec<&str> = EXPERIMENTS.iter().map(|&(name, _)| name).collect();
        names.sort_unstable();
        assert_eq!(files, names);
    }
}
