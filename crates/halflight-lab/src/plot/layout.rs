//! Layouts of charts of points.

use super::canvas::SIZE;

/// Sizes of a chart's parts, units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Width and height.
    pub(super) size: (u32, u32),
    /// Left, right, top and bottom of the plot.
    pub(super) plot: (i32, i32, i32, i32),
    /// Height of the title's letters.
    pub(super) title: i32,
    /// Height of the letters of labels and key.
    pub(super) label: i32,
    /// Height of the letters of ticks and notes.
    pub(super) tick: i32,
    /// Place of the key.
    pub(super) key: KeyPlace,
}

/// Place of a chart's key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum KeyPlace {
    /// Right of the plot, with titles of the groups and names of the front.
    Right,
    /// Between title and plot in two columns, entries only.
    Above,
}

impl Layout {
    /// Layout of a chart across a page, which is shown at 1,100 pixels: letters of 17 units have 13 pixels there.
    pub const PAGE: Self =
        Self { size: SIZE, plot: (100, 860, 72, 684), title: 24, label: 18, tick: 17, key: KeyPlace::Right };

    /// Layout of a chart in one of three columns, which is shown at 400 pixels: letters of 22 units have 14 pixels there.
    pub const COLUMN: Self = Self {
        size: (640, 600),
        plot: (76, 626, 172, 530),
        title: 30,
        label: 22,
        tick: 22,
        key: KeyPlace::Above,
    };
}
