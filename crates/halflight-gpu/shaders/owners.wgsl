// Finds the level of the cell that contains each pixel, per pixel: from cells to levels, NONE where no cell
// contains it. Also counts cells and samples by level.
//@ needs shared/cells shared/counters shared/surface
//@ writes owners

// Number of levels, from pixels to the coarsest cells.
const LEVELS: u32 = 8u;

// True if cells have samples of their own; the lattice counts its samples when it requests them.
override COUNTED: bool = true;

var<workgroup> counts: array<atomic<u32>, 8>;
var<workgroup> additional: atomic<u32>;
var<workgroup> top: atomic<u32>;

@compute @workgroup_size(8, 8)
fn own(here: Tile) {
    if here.at.x < frame.width && here.at.y < frame.height {
        var owner = NONE;
        for (var level = 0u; level <= frame.coarsest; level++) {
            let cell = here.at.xy >> vec2(level);
            let kept = cells[cell_index(level, cell)].kept;
            if kept == 0u {
                continue;
            }
            owner = level;
            if all(cell << vec2(level) == here.at.xy) {
                atomicAdd(&counts[level], 1u);
                atomicMax(&top, level);
                if kept == KEPT_MORE {
                    atomicAdd(&additional, additional_samples(here.at.xy, level));
                }
            }
        }
        owners[here.at.y * frame.width + here.at.x] = owner;
    }
    workgroupBarrier();
    if here.lane < LEVELS {
        let bucket = TALLY + here.lane * BUCKETS + (here.workgroup.x + 7u * here.workgroup.y) % BUCKETS;
        let count = atomicLoad(&counts[here.lane]);
        if count > 0u {
            atomicAdd(&counters[bucket + CELLS_PER_LEVEL * BUCKETS], count);
        }
        let samples = count + select(0u, atomicLoad(&additional), here.lane == 0u);
        if COUNTED && samples > 0u {
            atomicAdd(&counters[bucket + SAMPLES_PER_LEVEL * BUCKETS], samples);
        }
    }
    if here.lane == 0u {
        atomicMax(&counters[TOP], atomicLoad(&top));
    }
}

fn additional_samples(corner: vec2<u32>, level: u32) -> u32 {
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
