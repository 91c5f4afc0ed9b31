// Shaft visibility, per workgroup of 64 neighbouring receivers: from their shaft to the light, whose
// triangles are gathered once, to visibility masks. An empty shaft is a certificate that all receivers are
// fully lit. If the triangles do not fit, the receivers are left to rays.
//@ needs shared/query shared/sortable shared/tally visibility/horizon visibility/triangle
//@ reads nodes queries
//@ writes wanted visible spilled

// Triangles that receivers share at most: each costs a ray about a third of what a node of the BVH does.
const LIST: u32 = 64u;
// Most nodes that are visited to find them.
const QUEUE: u32 = 512u;

// Convex hull of a box of receivers and the light, as in halflight-cpu/src/shaft/hull.rs: a box and, parallel
// to each axis, the planes that touch the receivers' box and the light's, x · first + y · second ≤ limit.
struct Hull {
    low: vec3<f32>,
    // Bound on the rounding errors of positions.
    slack: f32,
    high: vec3<f32>,
    receivers_low: vec3<f32>,
    receivers_high: vec3<f32>,
    sides: array<vec3<f32>, 12>,
}

// Bounding box of the receivers, in the order of `sortable`, the lower corner inverted.
var<workgroup> box_low: array<atomic<u32>, 3>;
var<workgroup> box_high: array<atomic<u32>, 3>;
var<workgroup> members: atomic<u32>;
var<workgroup> hull: Hull;
var<workgroup> queue: array<u32, QUEUE>;
var<workgroup> queued: atomic<u32>;
var<workgroup> list: array<u32, LIST>;
var<workgroup> listed: atomic<u32>;
// Range of nodes to visit next, and 1 if all triangles have fit so far.
var<workgroup> query_batch: vec3<u32>;
var<workgroup> first_spilled: u32;

@compute @workgroup_size(64)
fn beam(here: Lane) {
    let query = query_of(invocation(here));
    var receiver: Receiver;
    let is_member = wants(query);
    var place = 0u;
    if is_member {
        receiver = receiver_at(queries[query].pixel);
        place = atomicAdd(&members, 1u);
        for (var axis = 0u; axis < 3u; axis++) {
            atomicMax(&box_low[axis], ~sortable(receiver.origin[axis]));
            atomicMax(&box_high[axis], sortable(receiver.origin[axis]));
        }
    }
    workgroupBarrier();
    if here.index == 0u {
        start_gathering();
    }
    var nodes_left = workgroupUniformLoad(&query_batch);
    while nodes_left.x < nodes_left.y {
        for (var item = nodes_left.x + here.index; item < nodes_left.y; item += 64u) {
            visit(queue[item]);
        }
        workgroupBarrier();
        if here.index == 0u {
            let total = atomicLoad(&queued);
            let fits = total <= QUEUE && atomicLoad(&listed) <= LIST;
            query_batch = vec3(nodes_left.y, select(nodes_left.y, total, fits), u32(fits));
        }
        nodes_left = workgroupUniformLoad(&query_batch);
    }
    let fits = nodes_left.z == 1u;
    if here.index == 0u && !fits {
        first_spilled = 1u + atomicAdd(&spilled[0], atomicLoad(&members));
    }
    workgroupBarrier();
    if is_member && fits {
        answer(query, receiver);
    } else if is_member {
        atomicStore(&spilled[first_spilled + place], query);
    }
    workgroupBarrier();
    tally(here);
}

// True if a query wants a sample that may add light; other queries are answered at once.
fn wants(query: u32) -> bool {
    if query == NONE {
        return false;
    }
    let asked = queries[query];
    var count = 0u;
    for (var word = 0u; word < frame.pattern.words; word++) {
        count += countOneBits(wanted[query * frame.pattern.words + word]);
    }
    if asked.pixel != NONE && count > 0u {
        let receiver = receiver_at(asked.pixel);
        let lit = any(facing(receiver.origin) != vec3(0.0)) && corners_above(receiver.origin, receiver.normal) > 0u;
        if lit {
            return true;
        }
        atomicAdd(&skipped, count);
    }
    for (var word = 0u; word < frame.pattern.words; word++) {
        wanted[query * frame.pattern.words + word] = 0u;
        visible[query * frame.pattern.words + word] = 0u;
    }
    return false;
}

// Computes the mask of one receiver.
fn answer(query: u32, receiver: Receiver) {
    let count = atomicLoad(&listed);
    let asked = queries[query];
    let all_above =
        corners_above(receiver.origin, receiver.normal) == 4u && frame.outline.x == PARALLELOGRAM;
    for (var word = 0u; word < frame.pattern.words; word++) {
        let slot = query * frame.pattern.words + word;
        var left = wanted[slot];
        var above = left;
        var seen = left;
        if count > 0u || !all_above {
            while left != 0u {
                let index = word * 32u + firstTrailingBit(left);
                let bit = left & (~left + 1u);
                left ^= bit;
                let place = sample_place(index, asked.key);
                let end = light_point(place);
                if !adds_light(receiver, place, end) {
                    above ^= bit;
                    seen ^= bit;
                } else if is_hidden(receiver.origin, end, count) {
                    seen ^= bit;
                }
            }
        }
        atomicAdd(&traced, countOneBits(above));
        atomicAdd(&skipped, countOneBits(wanted[slot] ^ above));
        wanted[slot] = above;
        visible[slot] = seen;
    }
}

fn is_hidden(origin: vec3<f32>, end: vec3<f32>, count: u32) -> bool {
    for (var at = 0u; at < count; at++) {
        if meets(list[at], origin, end, end - origin) {
            return true;
        }
    }
    return false;
}

// Builds the hull of the receivers and starts at the root.
fn start_gathering() {
    if atomicLoad(&members) == 0u || arrayLength(&nodes) < 5u {
        query_batch = vec3(0u, 0u, 1u);
        return;
    }
    let low = vec3(
        sorted(~atomicLoad(&box_low[0])),
        sorted(~atomicLoad(&box_low[1])),
        sorted(~atomicLoad(&box_low[2])),
    );
    let high = vec3(
        sorted(atomicLoad(&box_high[0])),
        sorted(atomicLoad(&box_high[1])),
        sorted(atomicLoad(&box_high[2])),
    );
    make_hull(low, high);
    queue[0] = 0u;
    atomicStore(&queued, 1u);
    query_batch = vec3(0u, 1u, 1u);
}

fn make_hull(low: vec3<f32>, high: vec3<f32>) {
    let light = light_bounds();
    let sizes = max(max(abs(low), abs(high)), max(abs(light.low), abs(light.high)));
    // 2⁻²⁰ of the largest coordinate.
    let slack = max(max(sizes.x, sizes.y), max(sizes.z, frame.largest)) * 9.5367431640625e-7;
    hull.slack = slack;
    hull.low = min(low, light.low) - slack;
    hull.high = max(high, light.high) + slack;
    hull.receivers_low = low;
    hull.receivers_high = high;
    for (var side = 0u; side < 12u; side++) {
        let i = (side / 4u + 1u) % 3u;
        let j = (side / 4u + 2u) % 3u;
        let upper = vec2((side & 2u) != 0u, (side & 1u) != 0u);
        let p = select(vec2(low[i], low[j]), vec2(high[i], high[j]), upper);
        let q = select(vec2(light.low[i], light.low[j]), vec2(light.high[i], light.high[j]), upper);
        hull.sides[side] = plane_through(p, q, upper, slack);
    }
}

// The line through two corresponding corners supports both boxes if its normal points away from both; else
// there is no plane.
fn plane_through(p: vec2<f32>, q: vec2<f32>, upper: vec2<bool>, slack: f32) -> vec3<f32> {
    var across = vec2(q.y - p.y, p.x - q.x);
    let size = sqrt(across.x * across.x + across.y * across.y);
    if size > 0.0 && all(across != vec2(0.0)) {
        across = across / size;
        if (across.x > 0.0) != upper.x {
            across = -across;
        }
        if (across.x > 0.0) == upper.x && (across.y > 0.0) == upper.y {
            let limit = max(across.x * p.x + across.y * p.y, across.x * q.x + across.y * q.y);
            return vec3(across, limit + 4.0 * slack);
        }
    }
    return vec3(0.0, 0.0, 1e30);
}

// True if a box overlaps the hull.
fn reaches(low: vec3<f32>, high: vec3<f32>) -> bool {
    if any(low > hull.high) || any(high < hull.low) {
        return false;
    }
    for (var side = 0u; side < 12u; side++) {
        let plane = hull.sides[side];
        let i = (side / 4u + 1u) % 3u;
        let j = (side / 4u + 2u) % 3u;
        let x = select(high[i], low[i], plane.x > 0.0);
        let y = select(high[j], low[j], plane.y > 0.0);
        if plane.x * x + plane.y * y > plane.z {
            return false;
        }
    }
    return true;
}

// True if a triangle may hide the light: it overlaps the hull, and its plane separates some receivers from
// some of the light.
fn may_hide(triangle: u32) -> bool {
    let a = triangles[3u * triangle];
    let b = triangles[3u * triangle + 1u];
    let c = triangles[3u * triangle + 2u];
    if any(min(min(a.xyz, b.xyz), c.xyz) > hull.high) || any(max(max(a.xyz, b.xyz), c.xyz) < hull.low) {
        return false;
    }
    for (var side = 0u; side < 12u; side++) {
        let plane = hull.sides[side];
        let i = (side / 4u + 1u) % 3u;
        let j = (side / 4u + 2u) % 3u;
        let first = plane.x * a[i] + plane.y * a[j];
        let second = plane.x * b[i] + plane.y * b[j];
        let third = plane.x * c[i] + plane.y * c[j];
        if min(min(first, second), third) > plane.z {
            return false;
        }
    }
    let up = vec3(a.w, b.w, c.w);
    let middle = (hull.receivers_low + hull.receivers_high) * 0.5;
    let extent = (hull.receivers_high - hull.receivers_low) * 0.5;
    let receivers = dot3(up, middle - a.xyz);
    let spread = dot3(abs(up), extent);
    let light = light_heights(up, a.xyz);
    let least = min(receivers - spread, light.x);
    let most = max(receivers + spread, light.y);
    let error = (abs(up.x) + abs(up.y) + abs(up.z)) * 8.0 * hull.slack;
    return least <= error && most >= -error;
}

// Visits the children of a node.
fn visit(index: u32) {
    let node = 5u * index;
    let head = nodes[node];
    let links = nodes[node + 1u];
    let start = bitcast<vec3<f32>>(head.xyz);
    let exponents = vec3(head.w & 0xffu, (head.w >> 8u) & 0xffu, (head.w >> 16u) & 0xffu);
    let step = bitcast<vec3<f32>>(exponents << vec3(23u));
    for (var child = 0u; child < 8u; child++) {
        let shift = 8u * (child & 3u);
        let kind = (select(links.z, links.w, child > 3u) >> shift) & 0xffu;
        if kind == 0u {
            continue;
        }
        // Lower bounds are in the first two words of an axis, upper bounds in the others.
        let word = child / 4u;
        let x = nodes[node + 2u];
        let y = nodes[node + 3u];
        let z = nodes[node + 4u];
        let low = (vec3(x[word], y[word], z[word]) >> vec3(shift)) & vec3(0xffu);
        let high = (vec3(x[word + 2u], y[word + 2u], z[word + 2u]) >> vec3(shift)) & vec3(0xffu);
        if !reaches(start + vec3<f32>(low) * step, start + vec3<f32>(high) * step) {
            continue;
        }
        if (kind & 0x18u) == 0x18u {
            let place = countOneBits((head.w >> 24u) & ((1u << child) - 1u));
            push_node(links.x + place);
        } else {
            let first = links.y + (kind & 0x1fu);
            for (var triangle = first; triangle < first + countOneBits(kind >> 5u); triangle++) {
                if may_hide(triangle) {
                    push_triangle(triangle);
                }
            }
        }
    }
}

fn push_node(node: u32) {
    let place = atomicAdd(&queued, 1u);
    if place < QUEUE {
        queue[place] = node;
    }
}

fn push_triangle(triangle: u32) {
    let place = atomicAdd(&listed, 1u);
    if place < LIST {
        list[place] = triangle;
    }
}
