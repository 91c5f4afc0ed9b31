// Answers queries: takes out what lies below a horizon and asks `occluded` for the rest. An invocation is a ray, and those of
// one receiver are neighbours, so that they go through the same nodes.
//@ needs shared/counters shared/query visibility/horizon
//@ reads queries
//@ writes wanted visible

// Where traced rays are counted: 0 to refine, 1 for irradiance alone.
override PURPOSE: u32 = 1u;

var<workgroup> wanted_words: array<atomic<u32>, 64>;
var<workgroup> visible_words: array<atomic<u32>, 64>;
var<workgroup> traced: atomic<u32>;
var<workgroup> skipped: atomic<u32>;

@compute @workgroup_size(64)
fn masks(here: Lane) {
    let group = here.workgroup.y * here.workgroups.x + here.workgroup.x;
    let stride = frame.pattern.stride;
    var number = group * (64u / min(stride, 64u)) + here.index / min(stride, 64u);
    var index = here.index % min(stride, 64u);
    if stride > 64u {
        number = group / (stride / 64u);
        index = (group % (stride / 64u)) * 64u + here.index;
    }
    let query = query_of(number);
    let exists = query != NONE;
    let word = query * frame.pattern.words + index / 32u;
    let bit = 1u << (index & 31u);
    // Lanes that fill one word together.
    let chunk = min(stride, 32u);
    if exists && index < frame.pattern.count && (wanted[word] & bit) != 0u {
        let asked = queries[query];
        if asked.pixel != NONE {
            let receiver = receiver_at(asked.pixel);
            let end = sample_point(index, asked.key);
            if adds_light(receiver, end) {
                atomicOr(&wanted_words[here.index / chunk], bit);
                atomicAdd(&traced, 1u);
                if !is_hidden(receiver, sample_place(index, asked.key), end) {
                    atomicOr(&visible_words[here.index / chunk], bit);
                }
            } else {
                atomicAdd(&skipped, 1u);
            }
        }
    }
    workgroupBarrier();
    if exists && here.index % chunk == 0u && index < frame.pattern.count {
        wanted[word] = atomicLoad(&wanted_words[here.index / chunk]);
        visible[word] = atomicLoad(&visible_words[here.index / chunk]);
    }
    if here.index == 0u {
        let bucket = TALLY + group % BUCKETS;
        atomicAdd(&counters[bucket + PURPOSE * BUCKETS], atomicLoad(&traced));
        atomicAdd(&counters[bucket + SKIPPED * BUCKETS], atomicLoad(&skipped));
    }
}
