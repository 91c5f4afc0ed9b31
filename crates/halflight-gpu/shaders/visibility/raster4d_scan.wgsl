// Prefix sum over cells, in one workgroup: from counts to the start of each cell's list. Filling the cells
// then advances each start to the cell's end.
//@ needs shared/arguments shared/counters visibility/raster4d
//@ writes bins

// 0 for triangles, 1 for receivers, whose tasks are counted as well.
override RECEIVERS: u32 = 0u;

// Most tasks: more do not fit into a dispatch, and the receivers then count as overflow.
const MOST: u32 = SIDE * SIDE;

var<workgroup> sums: array<vec2<u32>, 256>;

@compute @workgroup_size(256)
fn scan(@builtin(local_invocation_index) lane: u32) {
    let is_receivers = RECEIVERS == 1u;
    let count = select(frame.sides * CELLS, finest_cells(), is_receivers);
    let first = select(TRIANGLE_ENDS, receiver_ends(), is_receivers);
    let run = (count + 255u) / 256u;
    let begin = min(lane * run, count);
    let end = min(begin + run, count);
    var sum = vec2(0u);
    for (var cell = begin; cell < end; cell++) {
        let size = atomicLoad(&bins[first + cell]);
        sum = added(sum, vec2(size, tasks(cell, size)));
    }
    sums[lane] = sum;
    workgroupBarrier();
    if lane == 0u {
        var total = vec2(0u);
        for (var other = 0u; other < 256u; other++) {
            let own = sums[other];
            sums[other] = total;
            total = added(total, own);
        }
        if is_receivers {
            if total.y == MOST {
                atomicAdd(&counters[OVERFLOW], total.x);
                total.y = 0u;
            }
            atomicStore(&bins[TASKS], total.y);
            set_size(5u, total.y);
        }
    }
    workgroupBarrier();
    sum = sums[lane];
    for (var cell = begin; cell < end; cell++) {
        let size = atomicLoad(&bins[first + cell]);
        atomicStore(&bins[first + cell], sum.x);
        if is_receivers {
            atomicStore(&bins[first_tasks() + cell], sum.y);
        }
        sum = added(sum, vec2(size, tasks(cell, size)));
    }
}

fn added(sum: vec2<u32>, more: vec2<u32>) -> vec2<u32> {
    return vec2(sum.x + more.x, sum.y + min(more.y, MOST - sum.y));
}

// Number of workgroups for a finest cell with so many receivers: groups of receivers, times words of their
// masks, times runs of triangles over the cell.
fn tasks(cell: u32, receivers: u32) -> u32 {
    if RECEIVERS == 0u {
        return 0u;
    }
    let runs = (atomicLoad(&bins[lengths() + cell]) + RUN - 1u) / RUN;
    let groups = (receivers + GROUP - 1u) / GROUP * frame.pattern.words;
    if groups > MOST / max(runs, 1u) {
        return MOST;
    }
    return groups * runs;
}
