//! Shaders of upsamplers.

use crate::bindings::Access::{Read, Write};
use crate::bindings::Slot;
use crate::programs::Program;

pub(crate) const COPY: Program = Program {
    name: "copy",
    entry: "copy",
    modules: &["shared/surface.wgsl", "shared/query.wgsl", "upsample/copy.wgsl"],
    slots: &[(Slot::Normal, Read), (Slot::Samples, Read), (Slot::Plane, Write)],
};

pub(crate) const BILINEAR: Program = Program {
    name: "bilinear",
    entry: "bilinear",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/tangent.wgsl",
        "shared/query.wgsl",
        "shared/counters.wgsl",
        "upsample/bilinear.wgsl",
    ],
    slots: &[
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Owners, Read),
        (Slot::Samples, Read),
        (Slot::Texels, Write),
        (Slot::Counters, Write),
        (Slot::Plane, Write),
    ],
};

pub(crate) const RBF: Program = Program {
    name: "rbf",
    entry: "rbf",
    modules: &[
        "shared/surface.wgsl",
        "shared/query.wgsl",
        "shared/cells.wgsl",
        "shared/field.wgsl",
        "upsample/rbf.wgsl",
    ],
    slots: &[
        (Slot::Normal, Read),
        (Slot::Owners, Read),
        (Slot::Cells, Read),
        (Slot::Samples, Read),
        (Slot::Plane, Write),
    ],
};

pub(crate) const TRUST: Program = Program {
    name: "trust",
    entry: "trust",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/tangent.wgsl",
        "shared/query.wgsl",
        "shared/cells.wgsl",
        "upsample/trust.wgsl",
    ],
    slots: &[
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Cells, Read),
        (Slot::Samples, Read),
        (Slot::Trusts, Write),
    ],
};

pub(crate) const ROBUST: Program = Program {
    name: "rbf-robust",
    entry: "robust",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/tangent.wgsl",
        "shared/query.wgsl",
        "shared/cells.wgsl",
        "shared/field.wgsl",
        "upsample/robust.wgsl",
    ],
    slots: &[
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Owners, Read),
        (Slot::Cells, Read),
        (Slot::Samples, Read),
        (Slot::Trusts, Read),
        (Slot::Plane, Write),
    ],
};

pub(crate) const LATTICE: Program = Program {
    name: "lattice",
    entry: "lattice",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/rise.wgsl",
        "shared/corners.wgsl",
        "shared/query.wgsl",
        "upsample/lattice.wgsl",
    ],
    slots: &[
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Owners, Read),
        (Slot::Samples, Read),
        (Slot::Plane, Write),
    ],
};
