// Traces visibility masks, per ray: from wanted samples to visible ones; samples below a horizon are removed,
// the others call `is_hidden`. Rays of one receiver are neighbouring invocations, so that they traverse the
// same nodes.
//@ needs shared/query shared/ray_lanes shared/tally visibility/horizon
//@ reads queries
//@ writes wanted visible

var<workgroup> wanted_words: array<atomic<u32>, 64>;
var<workgroup> visible_words: array<atomic<u32>, 64>;

@compute @workgroup_size(64)
fn masks(here: Lane) {
    let ray = ray_at(here);
    if ray.exists && (wanted[ray.word] & ray.bit) != 0u {
        let asked = queries[ray.query];
        if asked.pixel != NONE {
            let receiver = receiver_at(asked.pixel);
            let place = sample_place(ray.index, asked.key);
            let end = seen_point(seen_light(receiver.origin), place);
            if surrounded(receiver.origin) {
                atomicOr(&wanted_words[here.index / ray.chunk], ray.bit);
                atomicOr(&visible_words[here.index / ray.chunk], ray.bit);
                atomicAdd(&skipped, 1u);
            } else if adds_light(receiver, place, end) {
                atomicOr(&wanted_words[here.index / ray.chunk], ray.bit);
                atomicAdd(&traced, 1u);
                if !is_hidden(receiver, place, end) {
                    atomicOr(&visible_words[here.index / ray.chunk], ray.bit);
                }
            } else {
                atomicAdd(&skipped, 1u);
            }
        }
    }
    workgroupBarrier();
    if ray.exists && here.index % ray.chunk == 0u {
        wanted[ray.word] = atomicLoad(&wanted_words[here.index / ray.chunk]);
        visible[ray.word] = atomicLoad(&visible_words[here.index / ray.chunk]);
    }
    tally(here);
}
