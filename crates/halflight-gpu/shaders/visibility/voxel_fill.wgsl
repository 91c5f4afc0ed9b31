// Conservative voxelization, per triangle: from triangles to voxels, as in
// halflight-cpu/src/voxel/rasterize.rs. Each triangle is clipped to the view frustum, and then to every texel
// that it may touch. One invocation processes a small triangle. For a large one, a workgroup processes a band
// of rows, four invocations per row.
//@ needs visibility/voxel_space
//@ reads triangles
//@ writes voxels large

// 0 to fill small triangles and list large ones, 1 to fill the large ones.
override LARGE: u32 = 0u;

// Most texels per side of a small triangle.
const SMALL: u32 = 8u;

// Most corners of a clipped triangle: three, and one more for each plane that may cut one off.
const CORNERS: u32 = 9u;

// Least and greatest X / depth, Y / depth and depth of a part of a triangle.
struct Extent {
    low: vec3<f32>,
    high: vec3<f32>,
}

@compute @workgroup_size(64)
fn fill(here: Lane) {
    let task = group_of(here);
    var triangle = task * 64u + here.index;
    if LARGE == 1u {
        if task >= atomicLoad(&large[0]) * bands() {
            return;
        }
        triangle = atomicLoad(&large[1u + task / bands()]);
    }
    let range = depth_range(atomicLoad(&voxels[NEAR]), atomicLoad(&voxels[FAR]), atomicLoad(&voxels[DEEPEST]));
    if triangle >= TRIANGLES || range.x >= range.y {
        return;
    }
    // The whole image first, to find the texels, then these one by one.
    var low = vec2(0.0);
    var high = vec2(f32(RESOLUTION));
    var first = vec2(0u);
    var every = 1u;
    var width = 1u;
    var count = 0u;
    for (var step = 0u; step <= count; step++) {
        let texel = first + vec2((step - 1u) % width * every, (step - 1u) / width);
        if step > 0u {
            low = vec2<f32>(texel) - slack();
            high = vec2<f32>(texel) + 1.0 + slack();
        }
        let part = cut(triangle, low, high, range);
        if part.low.z > part.high.z {
            continue;
        }
        if step > 0u {
            set_slices(texel.y * RESOLUTION + texel.x, slices(vec2(part.low.z, part.high.z), range));
            continue;
        }
        first = texels(part.low.xy - slack());
        let size = texels(part.high.xy + slack()) - first + 1u;
        width = size.x;
        count = size.x * size.y;
        if LARGE == 1u {
            let row = task % bands() * BAND + here.index / 4u;
            let is_in = row >= first.y && row - first.y < size.y && here.index % 4u < size.x;
            first = vec2(first.x + here.index % 4u, row);
            every = 4u;
            width = (size.x - min(here.index % 4u, size.x) + 3u) / 4u;
            count = select(0u, width, is_in);
        } else if max(size.x, size.y) > SMALL {
            atomicStore(&large[1u + atomicAdd(&large[0], 1u)], triangle);
            return;
        }
    }
}

// Margin of a voxel beyond its border, in voxels: more than the rounding error of a point on it, so that
// every voxel that the CPU sets is set.
fn slack() -> f32 {
    return f32(RESOLUTION) / 1048576.0;
}

// Part of a triangle between two depths and some columns and rows of the image.
fn cut(triangle: u32, low: vec2<f32>, high: vec2<f32>, range: vec2<f32>) -> Extent {
    var planes = array(
        vec4(0.0, 0.0, 1.0, -range.x),
        vec4(0.0, 0.0, -1.0, range.y),
        vec4(1.0, 0.0, -low.x, 0.0),
        vec4(-1.0, 0.0, high.x, 0.0),
        vec4(0.0, 1.0, -low.y, 0.0),
        vec4(0.0, -1.0, high.y, 0.0),
    );
    var corners: array<vec3<f32>, CORNERS>;
    var count = 3u;
    for (var corner = 0u; corner < 3u; corner++) {
        corners[corner] = place(triangles[3u * triangle + corner].xyz);
    }
    for (var at = 0u; at < 6u; at++) {
        let plane = planes[at];
        var kept: array<vec3<f32>, CORNERS>;
        var kept_count = 0u;
        var before = corners[max(count, 1u) - 1u];
        var before_side = dot3(plane.xyz, before) + plane.w;
        for (var corner = 0u; corner < count; corner++) {
            let after = corners[corner];
            let after_side = dot3(plane.xyz, after) + plane.w;
            // Rounding can cut off more corners than there are planes; a dropped corner lies within rounding
            // of its neighbours.
            if (before_side < 0.0) != (after_side < 0.0) && kept_count < CORNERS {
                kept[kept_count] = before + (after - before) * (before_side / (before_side - after_side));
                kept_count++;
            }
            if after_side >= 0.0 && kept_count < CORNERS {
                kept[kept_count] = after;
                kept_count++;
            }
            before = after;
            before_side = after_side;
        }
        corners = kept;
        count = kept_count;
    }
    var part = Extent(vec3(3e38), vec3(-3e38));
    for (var corner = 0u; corner < count; corner++) {
        let p = vec3(corners[corner].xy / corners[corner].z, corners[corner].z);
        part = Extent(min(part.low, p), max(part.high, p));
    }
    return part;
}

fn texels(at: vec2<f32>) -> vec2<u32> {
    return vec2<u32>(clamp(at, vec2(0.0), vec2(f32(RESOLUTION - 1u))));
}

// First and last slice that an interval of depths touches.
fn slices(depths: vec2<f32>, range: vec2<f32>) -> vec2<u32> {
    let at = (depths - range.x) * density(range) + vec2(-slack(), slack());
    return vec2<u32>(clamp(at, vec2(0.0), vec2(f32(BITS - 1u))));
}

fn set_slices(texel: u32, ends: vec2<u32>) {
    let first = first_voxel() + texel * texel_words();
    for (var word = ends.x / 32u; word <= ends.y / 32u; word++) {
        let after = NONE << (max(ends.x, word * 32u) - word * 32u);
        let until = NONE >> (31u - min(ends.y - word * 32u, 31u));
        // Most bits are set already.
        if (atomicLoad(&voxels[first + word]) & after & until) != (after & until) {
            atomicOr(&voxels[first + word], after & until);
        }
    }
}
