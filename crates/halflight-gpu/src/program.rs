//! Shader programs by their topmost modules. The modules themselves name what they need and bind (`shader.rs`).

/// A shader with one entry point, or two for rasterization.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Program {
    /// Name in errors, captures and tests.
    pub(crate) name: &'static str,
    /// Entry point; of two, the one that binds something.
    pub(crate) entry: &'static str,
    /// Files in `shaders/`, without their ending, that no other module of the program needs.
    pub(crate) modules: &'static [&'static str],
}

/// Declares the programs of a stage: `CONSTANT: "name" = entry point in "module", …;`.
macro_rules! programs {
    ($($program:ident: $name:literal = $entry:ident in $($module:literal),+;)+) => {
        $(const $program: $crate::program::Program = $crate::program::Program {
            name: $name,
            entry: stringify!($entry),
            modules: &[$($module),+],
        };)+

        /// Programs of this stage, for tests.
        #[cfg(test)]
        pub(crate) const PROGRAMS: &[$crate::program::Program] = &[$($program),+];
    };
}

pub(crate) use programs;
