//! Scenes that come with the crate.

/// Names and texts of the scene files in a list of names.
macro_rules! scenes {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../scenes/", $name, ".toml")))),*]
    };
}

const BUNDLED: &[(&str, &str)] = scenes![
    "atrium",
    "nave",
    "hairball",
    "tree",
    "tower",
    "toys",
    "coaster",
    "church",
    "garden",
    "living-room",
    "checkerboard",
    "gallery",
    "soup",
    "open-floor",
    "half-plane",
    "contact",
    "railing",
];

/// Names and texts of the bundled scene files. They use generators only, so that they need no other file.
pub fn bundled() -> &'static [(&'static str, &'static str)] {
    BUNDLED
}

/// The text of the bundled scene `name`.
pub(crate) fn text(name: &str) -> Option<&'static str> {
    BUNDLED.iter().find(|(known, _)| *known == name).map(|&(_, text)| text)
}
