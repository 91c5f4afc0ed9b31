//! Shaders of refiners.

use crate::bindings::Access::{Read, Write};
use crate::bindings::Slot;
use crate::programs::Program;

pub(crate) const PYRAMID: Program = Program {
    name: "pyramid",
    entry: "level",
    modules: &["shared/surface.wgsl", "shared/pyramid.wgsl", "pyramid.wgsl"],
    slots: &[(Slot::Position, Read), (Slot::Normal, Read), (Slot::Pyramid, Write)],
};

pub(crate) const FULL: Program = Program {
    name: "full",
    entry: "full",
    modules: &[
        "shared/surface.wgsl",
        "shared/hash.wgsl",
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "shared/query_mask.wgsl",
        "shared/append.wgsl",
        "refine/full.wgsl",
    ],
    slots: &[
        (Slot::Normal, Read),
        (Slot::Queries, Write),
        (Slot::Wanted, Write),
        (Slot::Counters, Write),
        (Slot::Samples, Write),
        (Slot::Owners, Write),
    ],
};

pub(crate) const NICHOLS_CHOOSE: Program = Program {
    name: "nichols: choose",
    entry: "choose",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/hash.wgsl",
        "shared/light.wgsl",
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "shared/query_mask.wgsl",
        "shared/append.wgsl",
        "shared/cells.wgsl",
        "shared/children.wgsl",
        "shared/place.wgsl",
        "shared/pyramid.wgsl",
        "refine/nichols_choose.wgsl",
    ],
    slots: &[
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Pyramid, Write),
        (Slot::Cells, Write),
        (Slot::Queries, Write),
        (Slot::Wanted, Write),
        (Slot::Counters, Write),
        (Slot::Samples, Write),
    ],
};

pub(crate) const NICHOLS_REUSE: Program = Program {
    name: "nichols: reuse",
    entry: "reuse",
    modules: &[
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "shared/cells.wgsl",
        "shared/votes.wgsl",
        "refine/nichols_reuse.wgsl",
    ],
    slots: &[
        (Slot::Cells, Read),
        (Slot::Queries, Read),
        (Slot::Wanted, Write),
        (Slot::Visible, Read),
        (Slot::Reused, Write),
        (Slot::Counters, Write),
    ],
};

pub(crate) const NICHOLS_MERGE: Program = Program {
    name: "nichols: merge",
    entry: "merge",
    modules: &["shared/counters.wgsl", "refine/nichols_merge.wgsl"],
    slots: &[(Slot::Wanted, Write), (Slot::Visible, Write), (Slot::Reused, Read), (Slot::Counters, Write)],
};

pub(crate) const NICHOLS_COMPARE: Program = Program {
    name: "nichols: compare",
    entry: "compare",
    modules: &[
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "shared/cells.wgsl",
        "shared/votes.wgsl",
        "refine/nichols_compare.wgsl",
    ],
    slots: &[
        (Slot::Cells, Write),
        (Slot::Queries, Read),
        (Slot::Wanted, Read),
        (Slot::Visible, Read),
        (Slot::Counters, Write),
    ],
};

pub(crate) const NICHOLS_SETTLE: Program = Program {
    name: "nichols: settle",
    entry: "settle",
    modules: &[
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "shared/cells.wgsl",
        "shared/children.wgsl",
        "shared/pyramid.wgsl",
        "refine/nichols_settle.wgsl",
    ],
    slots: &[(Slot::Pyramid, Write), (Slot::Cells, Write), (Slot::Queries, Write), (Slot::Counters, Write)],
};

pub(crate) const SFVT_CLASSIFY: Program = Program {
    name: "sfvt-gass: classify",
    entry: "classify",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/hash.wgsl",
        "shared/light.wgsl",
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "shared/query_mask.wgsl",
        "shared/append.wgsl",
        "shared/cells.wgsl",
        "shared/children.wgsl",
        "shared/place.wgsl",
        "shared/pyramid.wgsl",
        "refine/sfvt_classify.wgsl",
    ],
    slots: &[
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Pyramid, Write),
        (Slot::Cells, Write),
        (Slot::Queries, Write),
        (Slot::Wanted, Write),
        (Slot::Counters, Write),
        (Slot::Samples, Write),
    ],
};

pub(crate) const SFVT_JUDGE: Program = Program {
    name: "sfvt-gass: judge",
    entry: "judge",
    modules: &[
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "shared/cells.wgsl",
        "shared/children.wgsl",
        "refine/sfvt_judge.wgsl",
    ],
    slots: &[
        (Slot::Cells, Write),
        (Slot::Queries, Write),
        (Slot::Wanted, Read),
        (Slot::Visible, Read),
        (Slot::Counters, Write),
        (Slot::Samples, Write),
    ],
};

pub(crate) const SFVT_VALUE: Program = Program {
    name: "sfvt-gass: value",
    entry: "value",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/hash.wgsl",
        "shared/light.wgsl",
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "shared/sums.wgsl",
        "refine/sfvt_value.wgsl",
    ],
    slots: &[
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Queries, Read),
        (Slot::Wanted, Read),
        (Slot::Visible, Read),
        (Slot::Counters, Write),
        (Slot::Samples, Write),
    ],
};

pub(crate) const SFVT_FINALS: Program = Program {
    name: "sfvt-gass: finals",
    entry: "finals",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/hash.wgsl",
        "shared/light.wgsl",
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "shared/query_mask.wgsl",
        "shared/append.wgsl",
        "shared/cells.wgsl",
        "shared/place.wgsl",
        "refine/sfvt_finals.wgsl",
    ],
    slots: &[
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Cells, Write),
        (Slot::Queries, Write),
        (Slot::Wanted, Write),
        (Slot::Counters, Write),
        (Slot::Samples, Write),
    ],
};

pub(crate) const BREAKS: Program = Program {
    name: "breaks",
    entry: "find",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/rise.wgsl",
        "shared/breaks.wgsl",
        "refine/breaks.wgsl",
    ],
    slots: &[(Slot::Position, Read), (Slot::Normal, Read), (Slot::Breaks, Write)],
};

pub(crate) const BREAKS_GATHER: Program = Program {
    name: "breaks: gather",
    entry: "gather",
    modules: &["refine/breaks_gather.wgsl"],
    slots: &[(Slot::Breaks, Write)],
};

pub(crate) const LATTICE_LOOK: Program = Program {
    name: "lattice: look",
    entry: "look",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/rise.wgsl",
        "shared/breaks.wgsl",
        "shared/inside.wgsl",
        "shared/cells.wgsl",
        "shared/children.wgsl",
        "shared/corners.wgsl",
        "refine/lattice_look.wgsl",
    ],
    slots: &[(Slot::Position, Read), (Slot::Normal, Read), (Slot::Breaks, Read), (Slot::Cells, Write)],
};

pub(crate) const LATTICE_ASK: Program = Program {
    name: "lattice: ask",
    entry: "ask",
    modules: &[
        "shared/surface.wgsl",
        "shared/hash.wgsl",
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "shared/query_mask.wgsl",
        "shared/append.wgsl",
        "shared/cells.wgsl",
        "refine/lattice_ask.wgsl",
    ],
    slots: &[
        (Slot::Normal, Read),
        (Slot::Cells, Write),
        (Slot::Queries, Write),
        (Slot::Wanted, Write),
        (Slot::Counters, Write),
    ],
};

pub(crate) const LATTICE_VALUE: Program = Program {
    name: "lattice: value",
    entry: "value",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/hash.wgsl",
        "shared/light.wgsl",
        "shared/counters.wgsl",
        "shared/query.wgsl",
        "shared/sums.wgsl",
        "refine/lattice_value.wgsl",
    ],
    slots: &[
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Queries, Read),
        (Slot::Wanted, Read),
        (Slot::Visible, Read),
        (Slot::Counters, Write),
        (Slot::Samples, Write),
        (Slot::Fractions, Write),
    ],
};

pub(crate) const LATTICE_JUDGE: Program = Program {
    name: "lattice: judge",
    entry: "judge",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/hash.wgsl",
        "shared/light.wgsl",
        "shared/query.wgsl",
        "shared/place.wgsl",
        "shared/rise.wgsl",
        "shared/breaks.wgsl",
        "shared/inside.wgsl",
        "shared/cells.wgsl",
        "shared/children.wgsl",
        "shared/corners.wgsl",
        "shared/fractions.wgsl",
        "refine/lattice_judge.wgsl",
    ],
    slots: &[
        (Slot::Position, Read),
        (Slot::Normal, Read),
        (Slot::Breaks, Read),
        (Slot::Cells, Write),
        (Slot::Fractions, Read),
    ],
};

pub(crate) const LATTICE_MEND: Program = Program {
    name: "lattice: mend",
    entry: "mend",
    modules: &[
        "shared/surface.wgsl",
        "shared/receiver.wgsl",
        "shared/rise.wgsl",
        "shared/cells.wgsl",
        "shared/children.wgsl",
        "shared/corners.wgsl",
        "shared/fractions.wgsl",
        "refine/lattice_mend.wgsl",
    ],
    slots: &[(Slot::Position, Read), (Slot::Normal, Read), (Slot::Cells, Write), (Slot::Fractions, Read)],
};

pub(crate) const OWNERS: Program = Program {
    name: "owners",
    entry: "own",
    modules: &["shared/surface.wgsl", "shared/counters.wgsl", "shared/cells.wgsl", "owners.wgsl"],
    slots: &[(Slot::Normal, Read), (Slot::Cells, Read), (Slot::Owners, Write), (Slot::Counters, Write)],
};
