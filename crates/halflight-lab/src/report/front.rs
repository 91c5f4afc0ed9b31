//! Front page of a report: findings in words, one chart a setting, and pictures side by side.

use halflight_cpu::refine::Quality;
use maud::{Markup, html};

use super::figure::{Figure, Place, charts};
use crate::analysis::families::{lattice_at, published};
use crate::analysis::findings::{self, Scene};
use crate::experiment::Experiment;
use crate::experiment::plan::Setting;
use crate::results::{Finished, Outcome, PictureKind, WINDOW};

/// Returns the front page. `figures` are all charts of the report; those of families are shown.
pub(super) fn front(experiment: &Experiment, outcome: &Outcome, figures: &[Figure]) -> Markup {
    let scenes = outcome.settings.iter().zip(outcome.names());
    let scenes: Vec<Scene> =
        scenes.map(|(setting, name)| Scene { name, rows: outcome.rows_of(setting) }).collect();
    let sentences = findings::sentences(&scenes);
    html! {
        section.front {
            @if let Some((losses, others)) = sentences.split_last() {
                p.findings { @for sentence in others { (sentence) " " } (losses) }
            }
            (charts(figures, &Place::Front))
            p.small {
                "Lines join the best rows of each family, dots are all others; lower left is better. ꟻLIP: 99th percentile over the \
                 pixels; grain: noise of penumbrae as a contrast. Of either, traces are seen in zoom from 0.03 on, noise at normal \
                 size from 0.15 on. Below: pictures, fourfold where the paper's differs most from the reference."
            }
            @for (setting, scene) in outcome.settings.iter().zip(&scenes) {
                (side_by_side(scene, setting, experiment.reference_of(setting).samples))
            }
        }
    }
}

/// Returns the lattice at quality `good`, the paper's method as published and the reference, magnified where the paper's
/// error is largest, beside the whole picture; nothing where either row is missing.
fn side_by_side(scene: &Scene, setting: &Setting, samples: u32) -> Markup {
    let (Some(ours), Some(theirs)) = (lattice_at(&scene.rows, Quality::Good), published(&scene.rows)) else {
        return html! {};
    };
    let path = |file: &str| format!("pictures/{}/{file}", setting.slug);
    let image = |row: &Finished| path(&PictureKind::Image.file(row));
    let shown = [
        ("Halflight: lattice at quality good", findings::caption(ours), image(ours)),
        ("Koa 2017: sfvt-gass, rbf-adaptive", findings::caption(theirs), image(theirs)),
        ("Reference", format!("{samples} samples at every pixel"), path("reference.png")),
    ];
    let [width, height] = setting.size;
    let [outline, crop] = styles(setting.size, theirs.worst);
    html! {
        div.columns {
            figure {
                figcaption { b { (scene.name) } br; (width) " × " (height) ", by the lattice" }
                div.whole { img src=(image(ours)) alt=(scene.name) loading="lazy"; div style=(outline) {} }
            }
            @for (name, words, file) in &shown {
                figure {
                    figcaption { b { (name) } br; (words) }
                    div.crop { img src=(file) alt=(name) style=(crop) loading="lazy"; }
                }
            }
        }
    }
}

/// Returns the styles of the outline of a window in a picture, and of the picture behind the window where that is shown
/// alone; all lengths are shares.
fn styles([width, height]: [u32; 2], [left, top]: [u32; 2]) -> [String; 2] {
    let percent = |part: u32, whole: u32| format!("{:.3}%", 100.0 * f64::from(part) / f64::from(whole));
    let [across, down] = [WINDOW[0].min(width), WINDOW[1].min(height)];
    let outline = format!(
        "left:{};top:{};width:{};height:{}",
        percent(left, width),
        percent(top, height),
        percent(across, width),
        percent(down, height)
    );
    let crop = format!(
        "left:-{};top:-{};width:{}",
        percent(left, across),
        percent(top, down),
        percent(width, across)
    );
    [outline, crop]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_is_placed_in_shares_of_the_picture() {
        let [outline, crop] = styles([288, 216], [72, 27]);
        assert_eq!(outline, "left:25.000%;top:12.500%;width:25.000%;height:25.000%");
        assert_eq!(crop, "left:-100.000%;top:-50.000%;width:400.000%");
    }
}
