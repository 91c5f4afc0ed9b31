// Traces visibility masks, per ray: from wanted samples to visible ones; samples below a horizon are removed,
// the others call `is_hidden`. Rays of one receiver are neighbouring invocations, so that they traverse the
// same nodes.
//@ needs shared/query shared/tally visibility/horizon
//@ reads queries
//@ writes wanted visible

var<workgroup> wanted_words: array<atomic<u32>, 64>;
var<workgroup> visible_words: array<atomic<u32>, 64>;

@compute @workgroup_size(64)
fn masks(here: Lane) {
    let group = group_of(here);
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
    // Number of lanes that fill one word together.
    let chunk = min(stride, 32u);
    if exists && index < frame.pattern.count && (wanted[word] & bit) != 0u {
        let asked = queries[query];
        if asked.pixel != NONE {
            let receiver = receiver_at(asked.pixel);
            let place = sample_place(index, asked.key);
            let end = seen_point(seen_light(receiver.origin), place);
            if surrounded(receiver.origin) {
                atomicOr(&wanted_words[here.index / chunk], bit);
                atomicOr(&visible_words[here.index / chunk], bit);
                atomicAdd(&skipped, 1u);
            } else if adds_light(receiver, place, end) {
                atomicOr(&wanted_words[here.index / chunk], bit);
                atomicAdd(&traced, 1u);
                if !is_hidden(receiver, place, end) {
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
    tally(here);
}
