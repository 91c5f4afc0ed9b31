// Stream compaction, per workgroup of 64: invocations that want a slot get consecutive ones, in their order.
//@ needs shared/counters

var<workgroup> append_marks: array<atomic<u32>, 2>;
var<workgroup> append_first: u32;

// Slot of this invocation; NONE if it wants none or no room is left. All invocations of a workgroup must call
// this function, once.
fn append(lane: u32, wants: bool, counter: u32, capacity: u32) -> u32 {
    if wants {
        atomicOr(&append_marks[lane >> 5u], 1u << (lane & 31u));
    }
    workgroupBarrier();
    let low = atomicLoad(&append_marks[0]);
    let high = atomicLoad(&append_marks[1]);
    if lane == 0u {
        append_first = atomicAdd(&counters[counter], countOneBits(low) + countOneBits(high));
    }
    workgroupBarrier();
    let before = (1u << (lane & 31u)) - 1u;
    var slot = append_first;
    if lane < 32u {
        slot += countOneBits(low & before);
    } else {
        slot += countOneBits(low) + countOneBits(high & before);
    }
    if !wants {
        return NONE;
    }
    if slot >= capacity {
        atomicAdd(&counters[OVERFLOW], 1u);
        return NONE;
    }
    return slot;
}

// Bucket in which a workgroup counts its samples at pixels.
fn pixel_bucket(workgroup: vec3<u32>) -> u32 {
    return TALLY + SAMPLES_PER_LEVEL * BUCKETS + (workgroup.x + 7u * workgroup.y) % BUCKETS;
}

// Number of slots that the workgroup wanted.
fn appended() -> u32 {
    return countOneBits(atomicLoad(&append_marks[0])) + countOneBits(atomicLoad(&append_marks[1]));
}
