//! Ear clipping.

use glam::DVec2;

use super::turn;

/// Clips the ears of a counter-clockwise polygon of at least three corners. Returns its triangles; the flag
/// is true if all of them are ears, and then they cover exactly the polygon.
pub(super) fn clip(flat: &[DVec2]) -> (Vec<[usize; 3]>, bool) {
    let mut triangles = Vec::with_capacity(flat.len() - 2);
    let mut left: Vec<usize> = (0..flat.len()).collect();
    let mut start = 0;
    let mut all = true;
    while left.len() > 3 {
        let count = left.len();
        let corner = |at: usize| flat[left[at % count]];
        let ear = (start..start + count).find(|&at| {
            let [a, b, c] = [corner(at + count - 1), corner(at), corner(at + 1)];
            turn(a, b, c) > 0.0
                && left.iter().all(|&other| {
                    let p = flat[other];
                    // Corners of the ear itself, also where the polygon touches itself there, are not inside.
                    p == a || p == b || p == c || !inside(p, a, b, c)
                })
        });
        // A polygon without an ear touches or crosses itself.
        all &= ear.is_some();
        let ear = ear.unwrap_or(start) % count;
        let [before, after] = [(ear + count - 1) % count, (ear + 1) % count];
        triangles.push([left[before], left[ear], left[after]]);
        left.remove(ear);
        start = ear;
    }
    let last = [left[0], left[1], left[2]];
    let [a, b, c] = last.map(|at| flat[at]);
    triangles.push(last);
    (triangles, all && turn(a, b, c) >= 0.0)
}

fn inside(p: DVec2, a: DVec2, b: DVec2, c: DVec2) -> bool {
    turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0
}
