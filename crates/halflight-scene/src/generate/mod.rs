//! Procedural meshes: buildings, foliage, lattices, toys and small scenes with a closed-form answer.
//!
//! Every generator is deterministic: equal names and parameters give equal meshes, bit for bit. World space
//! is in metres, y up; floors lie at y = 0.
//!
//! | name | what it is | parameters, with defaults |
//! | --- | --- | --- |
//! | `atrium` | arcaded court of two storeys, 67 k triangles, 28.5 × 14 × 12 m along x | `detail` 1: divisions of round things |
//! | `nave` | vaulted church, 75 k triangles, 32 × 15 × 13 m along x | `detail` 1 |
//! | `hairball` | ball of thin tubes over a floor | `triangles` 100000, up to 2.85 M; `thickness` (by count): radius in metres; `seed` 1 |
//! | `tree` | trunk, branches, twigs and leaves, 367 k triangles, 9 m high | `leaves` 12: on each twig; `seed` 4 |
//! | `soup` | triangles of all sizes and shapes strewn in a ball over a floor | `triangles` 100000, from 100 to 3 M; `seed` 1 |
//! | `tower` | steel lattice tower, 42 m high | `triangles` 514000, from 10 k to 3 M |
//! | `toys` | blocks, balls, cones, drums, rings and cars on a floor | `triangles` 263000, from 10 k to 3 M; `seed` 1 |
//! | `coaster` | roller-coaster of rails, sleepers and struts, 56 m long | `triangles` 1096000, from 100 k to 3 M |
//! | `church` | village church from outside with graves and a fence, 240 k triangles | `detail` 1: tiles and divisions along a line |
//! | `furnished` | a small furnished scene, up to 40 k triangles on a floor | `kind` "objects": or `table`, `bookcase`, `chairs`, `stairs`, `plants`, `corner`, `wires`, `conference`; `walls` 0: 1 to 4 of the back, the sides and a ceiling; `seed` 1 |
//! | `garden` | shrubs of alpha-masked leaves before a wall, 3 k triangles, 4 m wide | `leaves` 1200: of all shrubs; `seed` 1 |
//! | `gallery` | hall with a polished floor, sculptures and pendant lamps' shades, 32 k triangles, 14 × 6 × 4.4 m along x | none |
//! | `living-room` | furnished room before a screen's place on its wall, 21 k triangles, 6 × 5 × 2.6 m | `seed` 1: of books and leaves |
//! | `open-floor` | a square floor | `size` 20: metres across; `cells` 8: quads across |
//! | `half-plane` | the floor, and a sheet above x < 0 | floor's; `height` 2; `extent` 100 |
//! | `contact` | the floor, and a box on it | floor's; `width` 1; `height` 1; `depth` 1 |
//! | `railing` | the floor, and bars between two rails | floor's; `bars` 25; `length` 4; `height` 1; `thickness` 0.02 × height |

mod atrium;
mod bars;
mod builder;
mod church;
mod churchyard;
mod coaster;
mod columns;
mod furnished;
mod furniture;
mod gallery;
mod garden;
mod hairball;
mod living_room;
mod nave;
mod parameters;
mod plain;
mod random;
mod roofs;
pub(crate) mod screen;
mod shapes;
mod soup;
#[cfg(test)]
mod tests;
mod tower;
mod toy_shapes;
mod toys;
mod track;
mod tree;

use halflight_core::scene::Mesh;

use parameters::Parameters;

/// Error of generating a mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GenerateError {
    /// Unknown generator.
    #[error("unknown generator `{name}`; known are {}", known.join(", "))]
    UnknownGenerator {
        /// Requested name.
        name: String,
        /// Names of all generators.
        known: Vec<&'static str>,
    },
    /// Unknown parameter.
    #[error("generator `{generator}` has no parameter `{key}`; it has {}", known.join(", "))]
    UnknownParameter {
        /// Name of the generator.
        generator: &'static str,
        /// Key given.
        key: String,
        /// Keys of this generator.
        known: Vec<&'static str>,
    },
    /// Parameter of the wrong type or out of range.
    #[error("parameter `{key}` of generator `{generator}` is {found}, expected {expected}")]
    BadParameter {
        /// Name of the generator.
        generator: &'static str,
        /// Key of the parameter.
        key: &'static str,
        /// Value given.
        found: String,
        /// Description of valid values.
        expected: String,
    },
}

type Generator = fn(&mut Parameters) -> Result<Mesh, GenerateError>;

const NAMES: [&str; 17] = [
    "atrium",
    "church",
    "coaster",
    "contact",
    "furnished",
    "gallery",
    "garden",
    "hairball",
    "half-plane",
    "living-room",
    "nave",
    "open-floor",
    "railing",
    "soup",
    "tower",
    "toys",
    "tree",
];

/// Generators in the order of `NAMES`.
const GENERATORS: [Generator; NAMES.len()] = [
    atrium::atrium,
    church::church,
    coaster::coaster,
    plain::contact,
    furnished::furnished,
    gallery::gallery,
    garden::garden,
    hairball::hairball,
    plain::half_plane,
    living_room::living_room,
    nave::nave,
    plain::open_floor,
    plain::railing,
    soup::soup,
    tower::tower,
    toys::toys,
    tree::tree,
];

/// Names of all generators, sorted.
pub fn names() -> &'static [&'static str] {
    &NAMES
}

/// Builds the mesh `name` with the given parameters; those left out take their defaults.
///
/// # Errors
/// [`GenerateError`] for a name, key or value that the generators do not know or accept.
pub fn generate(name: &str, parameters: toml::Table) -> Result<Mesh, GenerateError> {
    let Some(index) = NAMES.iter().position(|known| *known == name) else {
        return Err(GenerateError::UnknownGenerator { name: name.to_owned(), known: NAMES.to_vec() });
    };
    GENERATORS[index](&mut Parameters::new(NAMES[index], parameters))
}
