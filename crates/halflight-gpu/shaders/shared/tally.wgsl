// Rays of a workgroup, counted together.
//@ needs shared/counters

// Where traced rays are counted: 0 to refine, 1 for irradiance alone.
override PURPOSE: u32 = 1u;

var<workgroup> traced: atomic<u32>;
var<workgroup> skipped: atomic<u32>;

// Counts them, once all invocations have passed a barrier.
fn tally(here: Lane) {
    if here.index == 0u {
        let bucket = TALLY + group_of(here) % BUCKETS;
        atomicAdd(&counters[bucket + PURPOSE * BUCKETS], atomicLoad(&traced));
        atomicAdd(&counters[bucket + SKIPPED * BUCKETS], atomicLoad(&skipped));
    }
}
