// Counts the rays of a workgroup together.
//@ needs shared/counters

// Counter for traced rays: 0 to refine, 1 for irradiance alone.
override PURPOSE: u32 = 1u;

var<workgroup> traced: atomic<u32>;
var<workgroup> skipped: atomic<u32>;

// Adds the workgroup's counts, after all invocations have passed a barrier.
fn tally(here: Lane) {
    if here.index == 0u {
        let bucket = TALLY + group_of(here) % BUCKETS;
        atomicAdd(&counters[bucket + PURPOSE * BUCKETS], atomicLoad(&traced));
        atomicAdd(&counters[bucket + SKIPPED * BUCKETS], atomicLoad(&skipped));
    }
}
