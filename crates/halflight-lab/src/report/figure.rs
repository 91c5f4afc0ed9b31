//! Charts on the page.

use maud::{Markup, html};

/// Chart on the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Figure {
    /// Path from the page, without ending.
    pub(super) path: String,
    /// Title.
    pub(super) title: String,
    /// Place on the page.
    pub(super) place: Place,
}

/// Place of a chart on the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Front page.
    Front,
    /// Charts of the whole experiment.
    Experiment,
    /// Section of the setting with this slug.
    Setting(String),
    /// Indirect light of the setting with this slug.
    Indirect(String),
}

/// Returns the charts of a place.
pub(super) fn charts(figures: &[Figure], place: &Place) -> Markup {
    html! {
        div.charts {
            @for Figure { path, title, .. } in figures.iter().filter(|figure| figure.place == *place) {
                figure {
                    a href={ (path) ".svg" } { img src={ (path) ".png" } alt=(title) loading="lazy"; }
                }
            }
        }
    }
}
