//! Triangulation of an outline by a constrained Delaunay triangulation.

use std::collections::HashMap;

use glam::DVec2;
use halflight_core::hash::mix;
use spade::handles::{DirectedEdgeHandle, FixedVertexHandle};
use spade::{
    ConstrainedDelaunayTriangulation, HierarchyHintGenerator, Intersection, LineIntersectionIterator, Point2,
    Triangulation, mitigate_underflow,
};

use super::turn;

type Net = ConstrainedDelaunayTriangulation<Point2<f64>, (), (), (), HierarchyHintGenerator<f64>>;

/// Triangulates a polygon that may touch itself; `None` if it crosses itself or its coordinates are out of
/// range.
pub(super) fn triangulate(flat: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    // Corners with equal positions become one point.
    let mut known = HashMap::with_capacity(flat.len());
    let mut places = Vec::with_capacity(flat.len());
    let outline: Vec<usize> = (0..flat.len())
        .map(|corner| {
            // Adding zero turns -0 into 0, an equal position.
            let place = flat[corner] + 0.0;
            *known.entry(place.to_array().map(f64::to_bits)).or_insert_with(|| {
                places.push((corner, mitigate_underflow(Point2::new(place.x, place.y))));
                places.len() - 1
            })
        })
        .collect();
    let mut edges: Vec<[usize; 2]> = outline
        .iter()
        .copied()
        .zip(outline.iter().copied().cycle().skip(1))
        .map(|(from, to)| [from, to])
        .filter(|[from, to]| from != to)
        .collect();
    // In a random order the work is n log n whatever the outline; in its own order each edge of a tall comb
    // would cross most of the triangles of the others (Guibas, Knuth and Sharir 1992; Shewchuk and Brown
    // 2015).
    let mut order: Vec<usize> = (0..places.len()).collect();
    shuffle(&mut order);
    shuffle(&mut edges);
    if !begin_with_a_triangle(&mut order, |place| flat[places[place].0]) {
        return None;
    }
    let mut net = Net::new();
    let mut handles = vec![FixedVertexHandle::from_index(0); places.len()];
    let mut corners = Vec::with_capacity(places.len());
    for place in order {
        let (corner, point) = places[place];
        handles[place] = net.insert(point).ok()?;
        corners.push(corner);
    }
    if net.num_vertices() != places.len() {
        return None;
    }
    let edges: Vec<[FixedVertexHandle; 2]> =
        edges.into_iter().map(|ends| ends.map(|place| handles[place])).collect();
    for &[from, to] in &edges {
        if !net.exists_constraint(from, to) && net.try_add_constraint(from, to).is_empty() {
            return None;
        }
    }

    // Number of times that the outline follows each directed edge.
    let mut along = vec![0i32; 2 * net.num_undirected_edges()];
    for [from, to] in edges {
        for part in LineIntersectionIterator::new_from_handles(&net, from, to) {
            if let Intersection::EdgeOverlap(edge) = part {
                along[edge.index()] += 1;
            }
        }
    }
    // Winding numbers, from the outside inwards.
    let mut windings: Vec<Option<i32>> = vec![None; net.num_all_faces()];
    windings[net.outer_face().index()] = Some(0);
    let mut open: Vec<_> = net.directed_edges().filter(DirectedEdgeHandle::is_outer_edge).collect();
    while let Some(edge) = open.pop() {
        let Some(outside) = windings[edge.face().index()] else { continue };
        let across = edge.rev();
        let inside = &mut windings[across.face().index()];
        if inside.is_none() {
            // The winding number left of an edge is one more than right of it.
            *inside = Some(outside + along[across.index()] - along[edge.index()]);
            open.extend([across.next(), across.prev()]);
        }
    }
    let mut triangles = Vec::with_capacity(flat.len());
    for face in net.inner_faces() {
        let winding = windings[face.index()].unwrap_or(0);
        let [a, b, c] = face.vertices().map(|vertex| corners[vertex.index()]);
        match winding {
            0 => {}
            1.. => triangles.push([a, b, c]),
            ..0 => triangles.push([c, b, a]),
        }
    }
    Some(triangles)
}

/// Shuffles items in a reproducible random order (Fisher and Yates).
fn shuffle<T>(items: &mut [T]) {
    for at in (1..items.len()).rev() {
        let random = mix(at as u32) as usize;
        items.swap(at, random % (at + 1));
    }
}

/// Moves the corners of a large triangle to the front, first of all the one farthest from the line through
/// the other two. Locating a point is slow as long as all points before it lie on one line; the hint
/// generator's sparser levels begin with the first point, too. Returns true if there is such a triangle.
fn begin_with_a_triangle(order: &mut [usize], point: impl Fn(usize) -> DVec2) -> bool {
    let mut bring = |to: usize, measure: &dyn Fn(DVec2) -> f64| {
        let measures = order.iter().map(|&place| measure(point(place))).enumerate();
        if let Some((at, _)) = measures.max_by(|a, b| a.1.total_cmp(&b.1)) {
            order.swap(to.min(at), at);
        }
        order.get(to).map_or(DVec2::ZERO, |&place| point(place))
    };
    let a = bring(1, &|p| p.x);
    let b = bring(2, &|p| p.distance_squared(a));
    turn(a, b, bring(0, &|p| turn(a, b, p).abs())) != 0.0
}
