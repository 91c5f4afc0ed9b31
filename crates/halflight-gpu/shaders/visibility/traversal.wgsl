// Any-hit traversal of obvhs's compressed wide BVH (Ylitie et al. 2017), per ray.
//
// Who uses it decides what a triangle is hit by: `stops`, true if the open segment along `d` between two points ends at a
// triangle.
//@ reads nodes

// Most levels of the BVH; deeper ones are refused when a scene is uploaded.
const STACK: u32 = 32u;

// True if the open segment between two points ends at a triangle under the node `root`.
fn traverse(root: u32, origin: vec3<f32>, end: vec3<f32>) -> bool {
    if arrayLength(&nodes) < 5u * root + 5u {
        return false;
    }
    let d = end - origin;
    // No component is zero, so that no reciprocal is infinite: boxes are padded by far more than this moves
    // the end.
    let steep = abs(d) < vec3(1e-30);
    let inverse = 1.0 / select(d, vec3(1e-30), steep);
    // Order of a node's slots along the ray.
    let octant = select(4u, 0u, d.x < 0.0) | select(2u, 0u, d.y < 0.0) | select(1u, 0u, d.z < 0.0);
    // Traversal stack: a first node and, from bit 24 on, the remaining nodes of its group; in the low bits,
    // the slots that are nodes.
    var stack: array<vec2<u32>, STACK>;
    var waiting = 0u;
    var group = vec2(root, 0x80000000u);
    loop {
        let hits = group.y;
        let bit = firstLeadingBit(hits);
        group.y &= ~(1u << bit);
        if group.y > 0x00ffffffu {
            stack[min(waiting, STACK - 1u)] = group;
            waiting += 1u;
        }
        let slot = (bit - 24u) ^ octant;
        let node = 5u * (group.x + countOneBits(hits & ~(0xffffffffu << slot)));
        let head = nodes[node];
        let links = nodes[node + 1u];
        let mask = node_hits(node, head, links, origin, inverse, d, octant);
        group = vec2(links.x, (mask & 0xff000000u) | (head.w >> 24u));
        var triangles_left = mask & 0x00ffffffu;
        while triangles_left != 0u {
            let triangle = firstLeadingBit(triangles_left);
            triangles_left &= ~(1u << triangle);
            if stops(links.y + triangle, origin, end, d) {
                return true;
            }
        }
        if group.y <= 0x00ffffffu {
            if waiting == 0u {
                return false;
            }
            waiting -= 1u;
            group = stack[min(waiting, STACK - 1u)];
        }
    }
    return false;
}

// Mask of the children of a node that a segment enters: nodes from bit 24 on, triangles below.
fn node_hits(
    node: u32,
    head: vec4<u32>,
    links: vec4<u32>,
    origin: vec3<f32>,
    inverse: vec3<f32>,
    d: vec3<f32>,
    octant: u32,
) -> u32 {
    let start = (bitcast<vec3<f32>>(head.xyz) - origin) * inverse;
    let exponents = vec3(head.w & 0xffu, (head.w >> 8u) & 0xffu, (head.w >> 16u) & 0xffu);
    let step = bitcast<vec3<f32>>(exponents << vec3(23u)) * inverse;
    let x = nodes[node + 2u];
    let y = nodes[node + 3u];
    let z = nodes[node + 4u];
    return half_hits(links.z, vec3(x.x, y.x, z.x), vec3(x.z, y.z, z.z), start, step, d, octant)
        | half_hits(links.w, vec3(x.y, y.y, z.y), vec3(x.w, y.w, z.w), start, step, d, octant);
}

// Mask of four of the eight children that a segment enters.
fn half_hits(
    kinds: u32,
    low: vec3<u32>,
    high: vec3<u32>,
    start: vec3<f32>,
    step: vec3<f32>,
    d: vec3<f32>,
    octant: u32,
) -> u32 {
    let backward = d < vec3(0.0);
    let near = select(low, high, backward);
    let far = select(high, low, backward);
    let enter_x = vec4<f32>(unpack4xU8(near.x)) * step.x + start.x;
    let enter_y = vec4<f32>(unpack4xU8(near.y)) * step.y + start.y;
    let enter_z = vec4<f32>(unpack4xU8(near.z)) * step.z + start.z;
    let leave_x = vec4<f32>(unpack4xU8(far.x)) * step.x + start.x;
    let leave_y = vec4<f32>(unpack4xU8(far.y)) * step.y + start.y;
    let leave_z = vec4<f32>(unpack4xU8(far.z)) * step.z + start.z;
    let enter = max(max(enter_x, enter_y), max(enter_z, vec4(0.0)));
    let leave = min(min(leave_x, leave_y), min(leave_z, vec4(1.0)));
    let inside = enter <= leave;
    // Nodes have both bits 3 and 4 of their kind set, triangles have not; a node's slot is permuted by the
    // octant.
    let is_node = ((kinds & (kinds << 1u)) & 0x10101010u) >> 4u;
    let places = (kinds ^ ((octant * 0x01010101u) & (is_node * 0xffu))) & 0x1f1f1f1fu;
    let counts = (kinds >> 5u) & 0x07070707u;
    var mask = 0u;
    for (var child = 0u; child < 4u; child++) {
        let at = child * 8u;
        let bits = ((counts >> at) & 0xffu) << ((places >> at) & 0xffu);
        mask |= select(0u, bits, inside[child]);
    }
    return mask;
}
