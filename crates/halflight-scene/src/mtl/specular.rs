//! Specular reflection of a library's materials.

use std::ops::RangeInclusive;
use std::path::Path;

use glam::Vec3;
use halflight_core::scene::Specular;

use crate::context::Context;
use crate::library::{Definition, Written};
use crate::text::shown;

/// Specular reflection of a material: by its roughness and metallicity, `Pr` and `Pm`; otherwise, where they are wanted, by `Ks` and `Ns`.
pub(super) fn specular(material: &Definition, path: &Path, context: &mut Context) -> Option<Specular> {
    let phong = context.phong;
    let mut values = Values { path, context };
    if material.roughness.is_some() || material.metallic.is_some() {
        let given = Specular::default();
        let roughness = values.number("Pr", material.roughness.as_ref(), 0.0..=1.0);
        let metallic = values.number("Pm", material.metallic.as_ref(), 0.0..=1.0);
        let ks = values.colour(material.ks.as_ref());
        return Some(Specular {
            roughness: roughness.unwrap_or(given.roughness),
            metallic: metallic.unwrap_or(0.0),
            reflectance: if ks == Vec3::ZERO { given.reflectance } else { ks },
        });
    }
    // Illumination models 0 and 1 have no highlight.
    let highlight = !matches!(material.illumination, Some(model) if model < 2.0);
    if !phong || !highlight {
        return None;
    }
    let ks = values.colour(material.ks.as_ref());
    if ks == Vec3::ZERO {
        return None;
    }
    // The exponent of a Blinn-Phong lobe is that of GGX's distribution near its middle where α² = 2 / (n + 2) (Walter and others 2007).
    let exponent = values.number("Ns", material.ns.as_ref(), 0.0..=f32::MAX).unwrap_or(0.0);
    Some(Specular { roughness: (2.0 / (exponent + 2.0)).powf(0.25), metallic: 0.0, reflectance: ks })
}

/// Values that are used, with warnings about those that are unfit.
struct Values<'a> {
    path: &'a Path,
    context: &'a mut Context,
}

impl Values<'_> {
    /// Number of a statement, within its range; none where it is missing or faulty.
    fn number(
        &mut self,
        name: &str,
        written: Option<&Written<f32>>,
        range: RangeInclusive<f32>,
    ) -> Option<f32> {
        let written = written?;
        let Some(value) = written.value else {
            self.warn(name, written, "expected a finite number; the line is left out");
            return None;
        };
        let clamped = value.clamp(*range.start(), *range.end());
        if clamped != value {
            let within = if *range.end() == 1.0 { "from 0 to 1" } else { "from 0" };
            self.warn(name, written, &format!("expected a number {within}; {clamped} is used"));
        }
        Some(clamped)
    }

    /// Colour of `Ks`, within 0 to 1; black where it is missing or faulty.
    fn colour(&mut self, written: Option<&Written<Vec3>>) -> Vec3 {
        let Some(written) = written else { return Vec3::ZERO };
        let Some(value) = written.value else {
            self.warn("Ks", written, "expected one or three finite numbers; the line is left out");
            return Vec3::ZERO;
        };
        let clamped = value.clamp(Vec3::ZERO, Vec3::ONE);
        if clamped != value {
            let [r, g, b] = clamped.to_array();
            self.warn("Ks", written, &format!("expected numbers from 0 to 1; {r} {g} {b} is used"));
        }
        clamped
    }

    fn warn<T>(&mut self, name: &str, written: &Written<T>, message: &str) {
        let (path, line, text) = (self.path.display(), written.line, shown(&written.text));
        self.context.warn(format!("{path}:{line}: `{name} {text}`, {message}"));
    }
}
