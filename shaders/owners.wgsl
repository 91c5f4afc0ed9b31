// The level of the cell that each pixel lies in, NONE where it lies in none; and what is counted of cells.
//@ needs shared/cells shared/counters shared/surface
//@ writes owners

// Levels from pixels to the coarsest cells.
const LEVELS: u32 = 8u;

// Whether cells have samples of their own; those of the lattice are counted when they are asked for.
override COUNTED: bool = true;

var<workgroup> counts: array<atomic<u32>, 8>;
var<workgroup> top: atomic<u32>;

@compute @workgroup_size(8, 8)
fn own(
    @builtin(global_invocation_id) at: vec3<u32>,
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    if at.x < frame.width && at.y < frame.height {
        var owner = NONE;
        for (var level = 0u; level <= frame.coarsest; level++) {
            let cell = at.xy >> vec2(level);
            let kept = cells[cell_index(level, cell)].kept;
            if kept == 0u {
                continue;
            }
            owner = level;
            if all(cell << vec2(level) == at.xy) {
                atomicAdd(&counts[level], 1u);
                atomicMax(&top, level);
                if kept == KEPT_MORE {
                    atomicAdd(&counts[0], further_samples(at.xy, level));
                }
            }
        }
        owners[at.y * frame.width + at.x] = owner;
    }
    workgroupBarrier();
    if COUNTED && lane < LEVELS {
        let bucket = TALLY + (PER_LEVEL + lane) * BUCKETS + (workgroup.x + 7u * workgroup.y) % BUCKETS;
        let count = atomicLoad(&counts[lane]);
        if count > 0u {
            atomicAdd(&counters[bucket], count);
        }
    }
    if lane == 0u {
        atomicMax(&counters[TOP], atomicLoad(&top));
    }
}

fn further_samples(corner: vec2<u32>, level: u32) -> u32 {
    let half = 1u << (level - 1u);
    var count = 0u;
    for (var sample = 0u; sample < 3u; sample++) {
        let at = corner + half * vec2(sample & 1u, sample >> 1u);
        if at.x < frame.width && at.y < frame.height && is_receiver(at.y * frame.width + at.x) {
            count += 1u;
        }
    }
    return count;
}
