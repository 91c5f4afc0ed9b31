// Rays by invocation: rays of one receiver are neighbouring invocations, and those of one word of its mask lie in one workgroup.

struct RayLane {
    // False for invocations that are left over.
    exists: bool,
    query: u32,
    // Number of the light sample.
    index: u32,
    // Word of the mask, in `wanted` and `visible`, and the sample's bit.
    word: u32,
    bit: u32,
    // Number of lanes that fill one word together.
    chunk: u32,
}

fn ray_at(here: Lane) -> RayLane {
    let group = group_of(here);
    let stride = frame.pattern.stride;
    var number = group * (64u / min(stride, 64u)) + here.index / min(stride, 64u);
    var index = here.index % min(stride, 64u);
    if stride > 64u {
        number = group / (stride / 64u);
        index = (group % (stride / 64u)) * 64u + here.index;
    }
    let query = query_of(number);
    let exists = query != NONE && index < frame.pattern.count;
    let word = query * frame.pattern.words + index / 32u;
    return RayLane(exists, query, index, word, 1u << (index & 31u), min(stride, 32u));
}
