//! Shaders of the visibility backends.

use crate::bindings::Access::{Read, Write};
use crate::bindings::Slot;
use crate::programs::Program;

/// The masks, by the hierarchy.
pub(crate) const BVH_MASKS: Program = Program {
    name: "masks",
    entry: "masks",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/hash.wgsl",
        "shared/light.wgsl",
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "visibility/horizon.wgsl",
        "visibility/triangle.wgsl",
        "visibility/bvh.wgsl",
        "visibility/at_hand.wgsl",
        "visibility/masks.wgsl",
    ],
    slots: &[
        (Slot::Nodes, Read),
        (Slot::Triangles, Read),
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Queries, Read),
        (Slot::Wanted, Write),
        (Slot::Visible, Write),
        (Slot::Counters, Write),
    ],
};

/// The masks by what is in shafts, but for what has no room.
pub(crate) const BEAM: Program = Program {
    name: "beam",
    entry: "beam",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/hash.wgsl",
        "shared/light.wgsl",
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "visibility/horizon.wgsl",
        "visibility/triangle.wgsl",
        "visibility/at_hand.wgsl",
        "visibility/beam.wgsl",
    ],
    slots: &[
        (Slot::Nodes, Read),
        (Slot::Triangles, Read),
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Queries, Read),
        (Slot::Wanted, Write),
        (Slot::Visible, Write),
        (Slot::Counters, Write),
        (Slot::Spilled, Write),
    ],
};

pub(crate) const SPILL: Program = Program {
    name: "spill",
    entry: "spill",
    modules: &["shared/arguments.wgsl", "visibility/spill.wgsl"],
    slots: &[(Slot::Arguments, Write), (Slot::Spilled, Write)],
};

/// The masks of what was left to rays.
pub(crate) const SPILLED_MASKS: Program = Program {
    name: "spilled masks",
    entry: "masks",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/hash.wgsl",
        "shared/light.wgsl",
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "visibility/horizon.wgsl",
        "visibility/triangle.wgsl",
        "visibility/bvh.wgsl",
        "visibility/spilled.wgsl",
        "visibility/masks.wgsl",
    ],
    slots: &[
        (Slot::Nodes, Read),
        (Slot::Triangles, Read),
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Queries, Read),
        (Slot::Wanted, Write),
        (Slot::Visible, Write),
        (Slot::Counters, Write),
        (Slot::Spilled, Write),
    ],
};
