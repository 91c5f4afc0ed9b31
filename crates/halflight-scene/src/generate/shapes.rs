//! Shapes of halls and trees: solids of revolution, swept mouldings, tubes, arches, vaults and pierced walls.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{Mat3, Vec2, Vec3};

use super::builder::Builder;

/// Bends sharper than this many degrees become edges, gentler ones are shaded smoothly.
const CREASE_DEG: f32 = 35.0;

/// Appends to `profile` a curve from its last point to `end`, bulging to the right by `bulge` of its length.
pub(super) fn curve_to(profile: &mut Vec<Vec2>, end: Vec2, bulge: f32, steps: usize) {
    let Some(&start) = profile.last() else { return };
    let chord = end - start;
    // A quadratic Bézier curve reaches half as far as its control point.
    let control = (start + end) / 2.0 + Vec2::new(chord.y, -chord.x) * (2.0 * bulge);
    profile.extend((1..=steps).map(|step| {
        let t = step as f32 / steps as f32;
        start.lerp(control, t).lerp(control.lerp(end, t), t)
    }));
}

/// Index ranges of `count` points (as first and last) between creases; `direction(i)` is the unit step from
/// point i.
fn smooth_runs(count: usize, direction: impl Fn(usize) -> Vec3) -> Vec<(usize, usize)> {
    let limit = CREASE_DEG.to_radians().cos();
    let mut runs = Vec::new();
    let mut first = 0;
    for point in 1..count {
        if point + 1 == count || direction(point - 1).dot(direction(point)) < limit {
            runs.push((first, point));
            first = point;
        }
    }
    runs
}

fn profile_runs(profile: &[Vec2]) -> Vec<(usize, usize)> {
    smooth_runs(profile.len(), |i| (profile[i + 1] - profile[i]).normalize_or_zero().extend(0.0))
}

/// Turns a profile of (radius, height) points, from bottom to top along the outside, around the y axis.
pub(super) fn turned(builder: &mut Builder, profile: &[Vec2], segments: usize) {
    for (first, last) in profile_runs(profile) {
        builder.ring(last - first, segments, |row, column| {
            let point = profile[first + row];
            let (sin, cos) = (column as f32 / segments as f32 * TAU).sin_cos();
            Vec3::new(point.x * cos, point.y, -point.x * sin)
        });
    }
}

/// Moves `profile` along the planar `path`; `side` is the unit normal of the path's plane.
///
/// A profile point (s, n) goes s along `side` and n along `side × direction of travel`. Seen along the
/// direction of travel with n up and s to the right, the profile runs clockwise around solid. Corners of the
/// path are mitred; a path that ends where it starts is a loop.
pub(super) fn swept(builder: &mut Builder, profile: &[Vec2], path: &[Vec3], side: Vec3) {
    if path.len() < 2 {
        return;
    }
    let last = path.len() - 1;
    let direction = |i: usize| (path[i + 1] - path[i]).normalize_or_zero();
    let looped = path[0].distance_squared(path[last]) < 1e-12;
    let normal = |i: usize| {
        let before = if i > 0 {
            i - 1
        } else if looped {
            last - 1
        } else {
            0
        };
        let after = if i < last {
            i
        } else if looped {
            0
        } else {
            last - 1
        };
        let (a, b) = (side.cross(direction(before)), side.cross(direction(after)));
        // The mitre is longer than 1 so that both neighbours keep their distance from the path.
        (a + b) / (1.0 + a.dot(b)).max(0.1)
    };
    let normals: Vec<Vec3> = (0..=last).map(normal).collect();
    for (start, end) in smooth_runs(path.len(), direction) {
        for (first, stop) in profile_runs(profile) {
            builder.sheet(end - start, stop - first, |row, column| {
                let point = profile[first + column];
                path[start + row] + side * point.x + normals[start + row] * point.y
            });
        }
    }
}

/// The closed profile of a rectangle for [`swept`], `width` along the side and from `low` to `high` outwards.
pub(super) fn rectangle(width: f32, low: f32, high: f32) -> [Vec2; 5] {
    let w = width / 2.0;
    [Vec2::new(-w, low), Vec2::new(-w, high), Vec2::new(w, high), Vec2::new(w, low), Vec2::new(-w, low)]
}

/// A round tube through `path` with the radius at each point; a radius of zero closes an end to a tip.
pub(super) fn tube(builder: &mut Builder, path: &[(Vec3, f32)], sides: usize) {
    if path.len() < 2 {
        return;
    }
    let last = path.len() - 1;
    let tangent = |i: usize| (path[(i + 1).min(last)].0 - path[i.max(1) - 1].0).normalize_or(Vec3::Y);
    // The frame is carried along without turning about the path, so that the tube does not twist.
    let mut across = tangent(0).any_orthonormal_vector();
    let frames: Vec<Mat3> = (0..=last)
        .map(|i| {
            let along = tangent(i);
            across = (across - along * along.dot(across)).normalize_or(along.any_orthonormal_vector());
            Mat3::from_cols(across, along.cross(across), along)
        })
        .collect();
    builder.ring(last, sides, |row, column| {
        let (sin, cos) = (column as f32 / sides as f32 * TAU).sin_cos();
        let (centre, radius) = path[row];
        centre + frames[row] * Vec3::new(cos, sin, 0.0) * radius
    });
}

/// An arch over `-half ≤ x ≤ half` that rises by `rise` from y = 0, as `2 × steps + 1` points from left to
/// right.
///
/// The arch is pointed where it is higher than half its span, and otherwise a half circle or ellipse.
pub(super) fn arch(half: f32, rise: f32, steps: usize) -> Vec<Vec2> {
    // Each side of a pointed arch is a circle that leaves the springing line vertically and meets the other
    // side on the axis: its centre lies `offset` beyond the axis.
    let offset = (rise * rise - half * half) / (2.0 * half);
    let pointed = offset > 1e-3 * half;
    let sweep = if pointed { rise.atan2(offset) } else { FRAC_PI_2 };
    let side = |angle: f32| {
        if pointed {
            let radius = half + offset;
            Vec2::new((radius * angle.cos() - offset).max(0.0), radius * angle.sin())
        } else {
            Vec2::new(half * angle.cos(), rise * angle.sin())
        }
    };
    let steps = steps as i32;
    (-steps..=steps)
        .map(|step| {
            let from_crown = step.unsigned_abs() as f32 / steps as f32;
            let point = if step == 0 { Vec2::new(0.0, rise) } else { side(sweep * (1.0 - from_crown)) };
            Vec2::new(point.x * step.signum() as f32, point.y)
        })
        .collect()
}

/// Section of a groin vault over a rectangle with these half sides, its span scaled to -1 … 1.
///
/// Both crossing vaults and the groins between them share it, so that they meet.
pub(super) fn vault_section(half: Vec2, rise: f32, steps: usize) -> Vec<Vec2> {
    let longer = half.max_element();
    arch(longer, rise, steps).into_iter().map(|point| Vec2::new(point.x / longer, point.y)).collect()
}

/// The underside of a groin vault over `|x| ≤ half.x`, `|z| ≤ half.y`, of [`vault_section`].
pub(super) fn groin_vault(builder: &mut Builder, half: Vec2, rise: f32, steps: usize) {
    let section = vault_section(half, rise, steps);
    let columns = section.len() - 1;
    let rows = steps.div_ceil(2);
    // Webs over +x, +z, -x and -z: each is the first, turned, with the sides exchanged.
    for (sin, cos, length, width) in [
        (0.0, 1.0, half.x, half.y),
        (1.0, 0.0, half.y, half.x),
        (0.0, -1.0, half.x, half.y),
        (-1.0, 0.0, half.y, half.x),
    ] {
        builder.sheet(rows, columns, |row, column| {
            let point = section[columns - column];
            let groin = point.x.abs();
            let (x, z) = ((groin + (1.0 - groin) * row as f32 / rows as f32) * length, point.x * width);
            Vec3::new(cos * x - sin * z, point.y, sin * x + cos * z)
        });
    }
}

/// An opening around x = 0: from `sill` straight up to `spring`, closed by an [`arch`].
#[derive(Clone, Copy)]
pub(super) struct Opening {
    pub(super) half: f32,
    pub(super) sill: f32,
    pub(super) spring: f32,
    pub(super) rise: f32,
}

/// Fill of an [`Opening`].
#[derive(Clone, Copy)]
pub(super) enum Behind {
    /// The wall is pierced and has a back.
    Air,
    /// The opening is a recess that ends in this material.
    Material(u32),
}

/// A wall with one opening: its front is at z = 0 and faces +z, and it goes `depth` back.
///
/// The wall covers `|x| ≤ half` and `low ≤ y ≤ high`, has no ends, top or bottom, and `steps` as in [`arch`].
pub(super) fn pierced_wall(
    builder: &mut Builder,
    half: f32,
    [low, high]: [f32; 2],
    opening: Opening,
    (depth, behind): (f32, Behind),
    steps: usize,
) {
    let soffit: Vec<Vec2> = arch(opening.half, opening.rise, steps)
        .into_iter()
        .map(|point| Vec2::new(point.x, point.y + opening.spring))
        .collect();
    let spans = soffit.len() - 1;
    // A flat field between two heights over the arch's points, facing +z at `z` or, turned round, -z.
    let field = |builder: &mut Builder, z: f32, front: bool, bounds: &dyn Fn(Vec2) -> [f32; 2]| {
        builder.sheet(1, spans, |row, column| {
            let point = soffit[if front { column } else { spans - column }];
            Vec3::new(point.x, bounds(point)[row], z)
        });
    };
    let face = |builder: &mut Builder, z: f32, front: bool| {
        for (left, right) in [(-half, -opening.half), (opening.half, half)] {
            let ends = if front { [left, right] } else { [right, left] };
            builder.sheet(1, 2, |row, column| {
                let x = ends[0] + (ends[1] - ends[0]) * column as f32 / 2.0;
                Vec3::new(x, [low, high][row], z)
            });
        }
        field(builder, z, front, &|point| [point.y, high]);
        if opening.sill > low {
            field(builder, z, front, &|_| [low, opening.sill]);
        }
    };
    face(builder, 0.0, true);

    // Counter-clockwise around the opening: the sill where there is one, the right jamb, the arch, the left
    // jamb.
    let corner = |x: f32| Vec2::new(x, opening.sill);
    let mut outline: Vec<Vec2> = Vec::with_capacity(2 * spans);
    if opening.sill > low {
        outline.extend(soffit[..spans].iter().map(|point| corner(point.x)));
    }
    outline.push(corner(opening.half));
    outline.extend(soffit.iter().rev());
    outline.push(corner(-opening.half));
    for (first, last) in profile_runs(&outline) {
        builder.sheet(1, last - first, |row, column| outline[first + column].extend([0.0, -depth][row]));
    }
    match behind {
        Behind::Air => face(builder, -depth, false),
        Behind::Material(material) => {
            let wall = builder.paint(material);
            field(builder, -depth, true, &|point| [opening.sill, point.y]);
            builder.paint(wall);
        }
    }
}

/// A moulding that follows the arch of an opening on the wall's front.
pub(super) fn hood(builder: &mut Builder, opening: Opening, steps: usize) {
    let path: Vec<Vec3> = arch(opening.half + 0.15, opening.rise + 0.18, steps)
        .into_iter()
        .map(|p| Vec3::new(p.x, opening.spring + p.y, 0.0))
        .collect();
    let profile = [[-0.05, 0.08], [0.05, 0.08], [0.1, 0.0], [-0.05, -0.04]];
    swept(builder, &profile.map(Vec2::from_array), &path, Vec3::Z);
}

/// A mullion and bars in a window whose glass lies at `z`.
pub(super) fn mullion(builder: &mut Builder, window: Opening, z: f32) {
    let top = window.spring + 0.97 * window.rise;
    builder.block(Vec3::new(0.0, window.sill - 0.02, z), Vec3::new(0.1, top - window.sill, 0.16));
    let reach = 2.0 * window.half + 0.04;
    for y in [window.sill + 0.35 * (window.spring - window.sill), window.spring - 0.1] {
        builder.block(Vec3::new(0.0, y, z), Vec3::new(reach, 0.08, 0.1));
    }
}

/// Rotates by quarter turns about the y axis, exactly: +z goes to +x.
pub(super) fn quarter(turns: usize, p: Vec3) -> Vec3 {
    match turns % 4 {
        0 => p,
        1 => Vec3::new(p.z, p.y, -p.x),
        2 => Vec3::new(-p.x, p.y, -p.z),
        _ => Vec3::new(-p.z, p.y, p.x),
    }
}
