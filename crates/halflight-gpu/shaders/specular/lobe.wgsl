// The lobe of a surface point: how much of the light from each direction it reflects towards the viewer
// (halflight-cpu/src/specular/lobe.rs).

const PI: f32 = 3.14159265;

// Least α, and least cosine between normal and view.
const LEAST_ALPHA: f32 = 5e-4;
const LEAST_COSINE: f32 = 1e-4;

struct Lobe {
    normal: vec3<f32>,
    view: vec3<f32>,
    // Unit direction of which a mirror would show the light.
    mirrored: vec3<f32>,
    // α².
    alpha_squared: f32,
    // Angle that the lobe subtends where it is narrowest, radians.
    width: f32,
    // Cosine of the angle between normal and view.
    cosine: f32,
}

fn lobe_of(normal: vec3<f32>, view: vec3<f32>, roughness: f32) -> Lobe {
    let alpha = max(roughness * roughness, LEAST_ALPHA);
    let towards = dot3(normal, view);
    let cosine = max(towards, LEAST_COSINE);
    return Lobe(normal, view, normal * (2.0 * towards) - view, alpha * alpha, 2.0 * alpha * max(cosine, 0.1), cosine);
}

// The lobe times the cosine of incidence, without the Fresnel term, and Schlick's weight, for unit radiance along the
// unit direction `to`, 1/sr.
fn lobe_reflected(lobe: Lobe, to: vec3<f32>) -> vec2<f32> {
    let incidence = max(dot3(lobe.normal, to), 0.0);
    let between = lobe.view + to;
    // At grazing incidence from behind, the half vector may vanish.
    let squared = max(dot3(between, between), 1.2e-38);
    let along = dot3(lobe.normal, between);
    // Sines instead of 1 − cos², which cancels in narrow lobes.
    let across = cross3(lobe.normal, between);
    let spread = (dot3(across, across) + lobe.alpha_squared * along * along) / squared;
    let distribution = lobe.alpha_squared / PI / max(spread * spread, 1.2e-38);
    let masking = 1.0 / (smith(lobe, incidence) * smith(lobe, lobe.cosine));
    let left = clamp(1.0 - dot3(lobe.view, between) / sqrt(squared), 0.0, 1.0);
    let fourth = (left * left) * (left * left);
    return vec2(distribution * masking * incidence, fourth * left);
}

fn smith(lobe: Lobe, cosine: f32) -> f32 {
    return cosine + sqrt(lobe.alpha_squared + (1.0 - lobe.alpha_squared) * cosine * cosine);
}
