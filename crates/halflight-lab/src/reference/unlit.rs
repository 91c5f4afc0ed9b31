//! Reasons why an image is black.

use glam::Vec3;
use halflight_core::gbuffer::{GBuffer, Receiver};
use halflight_core::light::{AreaLight, Shape};
use halflight_core::scene::Scene;
use halflight_cpu::unshadowed::unshadowed;

/// Returns why no light arrives in an image; `None` where some does.
///
/// A black image is a valid result, but relative errors against it are undefined, and a light that faces away is easily
/// overlooked.
pub fn unlit(scene: &Scene, gbuffer: &GBuffer, irradiance: &[Vec3]) -> Option<String> {
    if irradiance.iter().any(|&value| value != Vec3::ZERO) {
        return None;
    }
    let receivers: Vec<Receiver> =
        (0..gbuffer.pixels()).filter_map(|pixel| gbuffer.receiver(pixel)).collect();
    if receivers.is_empty() {
        return Some("the camera sees no surface".to_owned());
    }
    let lights = scene.lights.iter().enumerate();
    let reasons: Vec<String> =
        lights.map(|(index, light)| format!("light {index} {}", reason(scene, light, &receivers))).collect();
    Some(format!("no light reaches any visible surface: {}", reasons.join("; ")))
}

/// Returns why a light does not reach any of the receivers.
fn reason(scene: &Scene, light: &AreaLight, receivers: &[Receiver]) -> String {
    let black =
        scene.light_texture(light).is_some_and(|texture| texture.mean() * light.radiance == Vec3::ZERO);
    let normal = light.normal();
    let in_front = |receiver: &Receiver| {
        light.two_sided
            || light.as_sphere().is_some()
            || (receiver.origin - light.frame().origin).dot(normal) > 0.0
    };
    if light.radiance == Vec3::ZERO {
        "has no radiance".to_owned()
    } else if black {
        "has a black texture".to_owned()
    } else if !receivers.iter().any(in_front) {
        let (along, swap) = match light.shape {
            Shape::Parallelogram(_) => ("cross(edge_u, edge_v) = ", "swap edge_u and edge_v"),
            Shape::Ellipse(_) => ("its normal ", "turn the normal, or swap axis_u and axis_v"),
            Shape::Polygon(_) => ("its normal ", "reverse the order of its points"),
            // Spheres emit to everywhere and have been taken out.
            Shape::Sphere(_) => ("", "move it"),
        };
        format!(
            "emits along {along}({:.3}, {:.3}, {:.3}), away from all of them; {swap}, or set two_sided = true",
            normal.x, normal.y, normal.z
        )
    } else if !receivers.iter().any(|receiver| unshadowed(light, receiver.origin, receiver.normal) > 0.0) {
        "lies behind all surfaces that it emits towards".to_owned()
    } else {
        "is hidden by other surfaces everywhere".to_owned()
    }
}

#[cfg(test)]
mod tests {
    use halflight_core::light_texture::LightTexture;
    use halflight_cpu::prepared::PreparedScene;

    use super::*;

    /// Reason of a black image of the bundled scene `open-floor` after a change.
    fn said(change: impl Fn(&mut Scene)) -> String {
        let mut scene = halflight_scene::load_bundled("open-floor").unwrap().scene;
        change(&mut scene);
        let scene = PreparedScene::new(scene).unwrap();
        let seen = super::super::seen(&scene, [16, 12]);
        unlit(scene.scene(), &seen, &[Vec3::ZERO; 192]).unwrap()
    }

    #[test]
    fn every_reason_is_named() {
        assert!(said(|scene| scene.lights[0].radiance = Vec3::ZERO).contains("light 0 has no radiance"));
        let black = said(|scene| {
            let texture = LightTexture::new(1, 1, vec![Vec3::ZERO]).unwrap();
            scene.light_textures = vec![texture.into()];
            scene.lights[0] = scene.lights[0].textured(0);
        });
        assert!(black.contains("light 0 has a black texture"), "{black}");
        let disk = said(|scene| {
            scene.lights[0] = AreaLight::disk(Vec3::Y * 3.0, Vec3::Y, 1.0, Vec3::ONE);
        });
        assert!(disk.contains("emits along its normal (0.000, 1.000, 0.000), away from all"), "{disk}");
        let turned = said(|scene| scene.lights[0] = scene.lights[0].reversed());
        assert!(turned.contains("cross(edge_u, edge_v) = (0.000, 1.000, 0.000), away from all"), "{turned}");
        let below = said(|scene| {
            scene.lights[0] = scene.lights[0].transformed(|p| p.with_y(-1.0), |d| d).two_sided();
        });
        assert!(below.contains("lies behind all surfaces"), "{below}");
        assert!(said(|_| {}).contains("is hidden by other surfaces"));
        let up = said(|scene| scene.camera.target = scene.camera.eye + Vec3::new(0.0, 1.0, 0.1));
        assert_eq!(up, "the camera sees no surface");
    }

    #[test]
    fn an_image_with_light_is_not_unlit() {
        let light = [Vec3::ZERO, Vec3::Z];
        assert_eq!(unlit(&Scene::default(), &GBuffer::default(), &light), None);
    }
}
