// Mean of a light's texture as a receiver sees it without occluders (halflight-cpu/src/textured/seen.rs).
//@ needs shared/light
//@ reads emitted

// Grids of cells, of 4, 8, 16, 32 and 64 a side, one after another; the first two are taken as a whole.
const COARSEST_SIDE: u32 = 4u;
const GRIDS: u32 = 5u;
const UNIFORM: u32 = 2u;

// Least distance of a receiver in sizes of a cell.
const DISTANCE: f32 = 4.0;

fn grid_side(grid: u32) -> u32 {
    return COARSEST_SIDE << grid;
}

// Index of a grid's first cell: Σ 16 · 4^k of those before it.
fn grid_first(grid: u32) -> u32 {
    return frame.texture.x - 1u + COARSEST_SIDE * COARSEST_SIDE * ((1u << (2u * grid)) - 1u) / 3u;
}

fn seen(origin: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let towards = facing(origin);
    if all(towards == vec3(0.0)) {
        return vec3(1.0);
    }
    let lengths = light_lengths();
    let longest = max(lengths.x, lengths.y);
    let near = light_distance(origin);
    for (var grid = 0u; grid < UNIFORM; grid++) {
        if longest / f32(grid_side(grid)) * DISTANCE <= near {
            return seen_from_afar(grid, origin, normal, towards);
        }
    }
    return seen_from_nearby(longest, origin, normal, towards);
}

fn cell_centre(grid: u32, cell: vec2<u32>) -> vec3<f32> {
    return light_point((vec2<f32>(cell) + 0.5) / f32(grid_side(grid)));
}

fn cell_emission(grid: u32, cell: vec2<u32>) -> vec3<f32> {
    return emitted[grid_first(grid) + cell.y * grid_side(grid) + cell.x].xyz;
}

// Mean over the cells of a grid by their geometry terms.
fn seen_from_afar(grid: u32, origin: vec3<f32>, normal: vec3<f32>, towards: vec3<f32>) -> vec3<f32> {
    var sum = vec3(0.0);
    var all = 0.0;
    let side = grid_side(grid);
    for (var index = 0u; index < side * side; index++) {
        let cell = vec2(index % side, index / side);
        let term = geometry_term(cell_centre(grid, cell) - origin, normal, towards);
        sum += cell_emission(grid, cell) * term;
        all += term;
    }
    return mean_of(sum, all);
}

// Mean over cells that are the finer, the nearer they are.
fn seen_from_nearby(longest: f32, origin: vec3<f32>, normal: vec3<f32>, towards: vec3<f32>) -> vec3<f32> {
    var sum = vec3(0.0);
    var all = 0.0;
    // Grid, column and row of the cells that wait: each division leaves three more than there were, on four levels.
    var waiting: array<vec3<u32>, 16>;
    for (var first = 0u; first < COARSEST_SIDE * COARSEST_SIDE; first++) {
        waiting[0] = vec3(0u, first % COARSEST_SIDE, first / COARSEST_SIDE);
        var count = 1u;
        while count > 0u {
            count--;
            let grid = waiting[count].x;
            let cell = waiting[count].yz;
            let size = longest / f32(grid_side(grid));
            let to = cell_centre(grid, cell) - origin;
            if grid + 1u < GRIDS && size * size * (DISTANCE * DISTANCE) > dot3(to, to) {
                waiting[count] = vec3(grid + 1u, 2u * cell + vec2(1u, 1u));
                waiting[count + 1u] = vec3(grid + 1u, 2u * cell + vec2(0u, 1u));
                waiting[count + 2u] = vec3(grid + 1u, 2u * cell + vec2(1u, 0u));
                waiting[count + 3u] = vec3(grid + 1u, 2u * cell);
                count += 4u;
            } else {
                let term = geometry_term(to, normal, towards) * (size * size);
                sum += cell_emission(grid, cell) * term;
                all += term;
            }
        }
    }
    return mean_of(sum, all);
}

// The mean; that of the whole texture where all geometry terms are 0.
fn mean_of(sum: vec3<f32>, all: f32) -> vec3<f32> {
    if all > 0.0 {
        return sum / all;
    }
    let mean = frame.mean_radiance.xyz / max(frame.radiance, vec3(1e-30));
    return select(mean, vec3(0.0), frame.radiance <= vec3(0.0));
}
