//! Triangulations cover their outlines exactly.

use super::*;

/// Triangulates an outline in the plane z = 0, rotated to all six axis directions and moved far away. Returns
/// the number of triangles and their area; each must have the outline's orientation.
fn area(outline: &[[f64; 2]]) -> (usize, f64) {
    let corners: Vec<u32> = (0..outline.len() as u32).collect();
    let mut found = Vec::new();
    let turns: [fn([f64; 2]) -> DVec3; 6] = [
        |[x, y]| DVec3::new(x, y, 0.0),
        |[x, y]| DVec3::new(y, 0.0, x),
        |[x, y]| DVec3::new(0.0, x, y),
        |[x, y]| DVec3::new(-x, y, 3.0),
        |[x, y]| DVec3::new(x, 3.0, y),
        |[x, y]| DVec3::new(65_536.0 + x, 32_768.0 + y, 0.0),
    ];
    for place in turns {
        let positions: Vec<Vec3> = outline.iter().map(|&point| place(point).as_vec3()).collect();
        let mut triangles = Vec::new();
        triangulate(&corners, &positions, &mut triangles);
        let facing = (place([1.0, 0.0]) - place([0.0, 0.0])).cross(place([0.0, 1.0]) - place([0.0, 0.0]));
        let mut area = 0.0;
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|at| positions[at as usize].as_dvec3());
            let twice = (b - a).cross(c - a).dot(facing);
            assert!(twice >= 0.0, "{triangle:?} of {outline:?} faces away");
            area += twice / 2.0;
        }
        found.push((triangles.len(), area));
    }
    // Coordinates are small multiples of powers of two in all tests: sums are exact, also far away.
    assert!(found.iter().all(|other| other.1 == found[0].1), "{found:?} {outline:?}");
    found[0]
}

/// Area by the shoelace formula.
fn shoelace(outline: &[[f64; 2]]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).map(|(a, b)| (a[0] * b[1] - b[0] * a[1]) / 2.0).sum()
}

/// Outlines that start at each corner, and with each corner repeated twice or three times.
fn variants(outline: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
    let count = outline.len();
    let mut all = Vec::new();
    for start in 0..count {
        let turned: Vec<_> = (0..count).map(|at| outline[(start + at) % count]).collect();
        let some = |times: &dyn Fn(usize) -> usize| -> Vec<[f64; 2]> {
            turned.iter().enumerate().flat_map(|(at, &point)| vec![point; times(at)]).collect()
        };
        all.push(some(&|at| if at == 0 { 2 } else { 1 }));
        all.push(some(&|at| 1 + (at + start) % 3));
        all.push(turned);
    }
    all
}

const SQUARE: &[[f64; 2]] = &[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
const PENTAGON: &[[f64; 2]] = &[[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [2.0, 2.0], [0.0, 2.0]];
const ARROW: &[[f64; 2]] = &[[0.0, 0.0], [4.0, -3.0], [1.0, 0.0], [4.0, 3.0]];
const U: &[[f64; 2]] =
    &[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [2.0, 3.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
const POINTS_ON_EDGES: &[[f64; 2]] =
    &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0]];
/// A square with a square hole on a bridge of two edges, and one with two holes from one corner.
const KEYHOLE: &[[f64; 2]] = &[
    [0.0, 0.0],
    [4.0, 0.0],
    [4.0, 4.0],
    [0.0, 4.0],
    [0.0, 0.0],
    [1.0, 1.0],
    [1.0, 3.0],
    [3.0, 3.0],
    [3.0, 1.0],
    [1.0, 1.0],
];
const TWO_HOLES: &[[f64; 2]] = &[
    [0.0, 0.0],
    [8.0, 0.0],
    [8.0, 8.0],
    [0.0, 8.0],
    [0.0, 0.0],
    [1.0, 2.0],
    [1.0, 4.0],
    [2.0, 4.0],
    [2.0, 2.0],
    [1.0, 2.0],
    [0.0, 0.0],
    [2.0, 1.0],
    [4.0, 2.0],
    [4.0, 1.0],
    [2.0, 1.0],
];
/// Two squares that touch at a corner, and a square whose hole touches its edge.
const TOUCHING: &[[f64; 2]] =
    &[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [4.0, 2.0], [4.0, 4.0], [2.0, 4.0], [2.0, 2.0], [0.0, 2.0]];
const HOLE_AT_EDGE: &[[f64; 2]] = &[
    [0.0, 0.0],
    [2.0, 0.0],
    [1.0, 1.0],
    [2.0, 2.0],
    [3.0, 1.0],
    [2.0, 0.0],
    [4.0, 0.0],
    [4.0, 4.0],
    [0.0, 4.0],
];
/// Spike that goes out and comes back.
const SPIKE: &[[f64; 2]] = &[[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];

#[test]
fn areas_are_those_of_the_shoelace() {
    for outline in
        [SQUARE, PENTAGON, ARROW, U, POINTS_ON_EDGES, KEYHOLE, TWO_HOLES, TOUCHING, HOLE_AT_EDGE, SPIKE]
    {
        let expected = shoelace(outline);
        assert!(expected > 0.0);
        for outline in variants(outline) {
            assert_eq!(area(&outline).1, expected, "{outline:?}");
            // Small polygons are triangulated by the constrained Delaunay method as well.
            let flat: Vec<DVec2> = outline.iter().copied().map(DVec2::from_array).collect();
            let found = constrained::triangulate(&flat).unwrap();
            let areas = found.iter().map(|triangle| triangle.map(|at| flat[at]));
            assert!(areas.clone().all(|[a, b, c]| turn(a, b, c) > 0.0), "{outline:?}");
            assert_eq!(areas.map(|[a, b, c]| turn(a, b, c) / 2.0).sum::<f64>(), expected, "{outline:?}");
        }
    }
    // One triangle for every corner but two.
    for (outline, triangles) in [(SQUARE, 2), (PENTAGON, 3), (ARROW, 2), (U, 6), (POINTS_ON_EDGES, 5)] {
        assert_eq!(area(outline).0, triangles);
    }
}

#[test]
fn long_outlines_keep_their_area() {
    // Comb, spiral, saw-toothed ring with a bridge, stairs: each with more corners than are clipped by ears.
    let teeth = (0..200).flat_map(|tooth| {
        let x = 2.0 * f64::from(tooth);
        [[400.0 - x, 1.0], [399.5 - x, 64.0], [399.0 - x, 64.0], [398.5 - x, 1.0]]
    });
    let comb: Vec<_> = [[0.0, 0.0], [400.0, 0.0]].into_iter().chain(teeth).collect();
    let side = |turn: i32| 4.0 * f64::from(100 - turn / 2);
    let mut spiral = vec![[0.0, 0.0]];
    let mut at = [0.0, 0.0];
    for turn in 0..100 {
        let [x, y] = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][turn as usize % 4];
        at = [at[0] + x * side(turn), at[1] + y * side(turn)];
        spiral.push(at);
    }
    // Back along a line one to the left.
    let back: Vec<_> = (1..spiral.len() - 1)
        .rev()
        .map(|corner| {
            let [x, y] = spiral[corner];
            let [dx, dy] = [[-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [1.0, 1.0]][(corner - 1) % 4];
            [x + dx, y + dy]
        })
        .collect();
    let end = spiral[spiral.len() - 1];
    spiral.push([end[0] + 1.0, end[1]]);
    spiral.extend(back);
    spiral.push([0.0, 1.0]);
    let stairs: Vec<_> = (0..100)
        .flat_map(|step| [[f64::from(step), f64::from(step)], [f64::from(step + 1), f64::from(step)]])
        .chain([[100.0, 100.0], [0.0, 100.0]])
        .collect();
    let hole =
        |x: f64| [[x, 0.0], [x, 1.0], [x + 1.0, 2.0], [x + 2.0, 1.0], [x + 1.0, 0.5], [x, 1.0], [x, 0.0]];
    let holes: Vec<_> = (0..40)
        .flat_map(|at| hole(4.0 * f64::from(at)))
        .chain([[160.0, 0.0], [160.0, 4.0], [0.0, 4.0]])
        .collect();
    for outline in [comb, spiral, stairs, holes] {
        let expected = shoelace(&outline);
        assert!(expected > 0.0 && outline.len() > MAX_EARS);
        assert_eq!(area(&outline).1, expected, "{outline:?}");
        let twice: Vec<_> = outline.iter().flat_map(|&point| [point, point]).collect();
        assert_eq!(area(&twice).1, expected);
    }
}

#[test]
fn a_nearly_round_outline_keeps_its_area() {
    // Rounded to a multiple of 2^-23, as files with seven digits are: hundreds of corners turn the wrong way
    // by a hair.
    let count = 20_000;
    let round = |value: f64| (value * f64::from(1 << 23)).round() / f64::from(1 << 23);
    let outline: Vec<_> = (0..count)
        .map(|at| std::f64::consts::TAU * f64::from(at) / f64::from(count))
        .map(|angle| [round(angle.cos()), round(angle.sin())])
        .collect();
    let positions: Vec<Vec3> = outline.iter().map(|&[x, y]| DVec3::new(x, 0.0, -y).as_vec3()).collect();
    let corners: Vec<u32> = (0..count as u32).collect();
    let mut triangles = Vec::new();
    triangulate(&corners, &positions, &mut triangles);
    let twice = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|at| positions[at as usize].as_dvec3());
        (b - a).cross(c - a).y
    };
    assert!(triangles.iter().all(|triangle| twice(triangle) >= 0.0));
    let area: f64 = triangles.iter().map(|triangle| twice(triangle) / 2.0).sum();
    // Sums of 20,000 numbers below 1.
    assert!((area - shoelace(&outline)).abs() < 1e-10, "{area}");
    assert_eq!(triangles.len(), corners.len() - 2);
}

#[test]
fn outlines_that_cross_themselves_or_have_no_area_are_no_trouble() {
    let star: Vec<_> = (0..101)
        .map(|at| f64::from(at) * 50.0 * std::f64::consts::TAU / 101.0)
        .map(|angle| [angle.cos(), angle.sin()])
        .collect();
    let line: Vec<_> = (0..100).map(|at| [f64::from(at), 0.0]).collect();
    let huge = [[0.0, 0.0], [1e300, 0.0], [1e300, 1e300], [5e299, 1e200], [0.0, 1e300]];
    let tiny = huge.map(|point| point.map(|coordinate| coordinate * 1e-320 * 1e-290));
    let bow = vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    for outline in [star, line.clone(), vec![[1.0, 1.0]; 50], huge.to_vec(), tiny.to_vec(), bow] {
        let positions: Vec<Vec3> = outline.iter().map(|&[x, y]| DVec3::new(x, y, x).as_vec3()).collect();
        let corners: Vec<u32> = (0..outline.len() as u32).collect();
        let mut triangles = Vec::new();
        triangulate(&corners, &positions, &mut triangles);
        assert!(triangles.as_flattened().iter().all(|&corner| (corner as usize) < outline.len()));
    }
    let mut triangles = Vec::new();
    for corners in [&[][..], &[0], &[0, 1], &[0, 0, 1, 1], &[0, 1, 0, 1]] {
        triangulate(corners, &[Vec3::X, Vec3::Y], &mut triangles);
    }
    assert!(triangles.iter().all(|[a, b, c]| a == b || b == c || a == c), "{triangles:?}");
}
