// Takes out light samples that triangles with alpha masks hide, per ray: of those that a backend has left visible
// (halflight-cpu/src/alpha_masked.rs).
//@ needs shared/light shared/query shared/query_batch shared/ray_lanes visibility/solid_hits
//@ reads queries position
//@ writes visible

var<workgroup> hidden_words: array<atomic<u32>, 64>;

@compute @workgroup_size(64)
fn hide(here: Lane) {
    let ray = ray_at(here);
    if ray.exists && (visible[ray.word] & ray.bit) != 0u {
        let asked = queries[ray.query];
        if asked.pixel != NONE && occluded_solidly(position[asked.pixel].xyz, sample_point(ray.index, asked.key)) {
            atomicOr(&hidden_words[here.index / ray.chunk], ray.bit);
        }
    }
    workgroupBarrier();
    if ray.exists && here.index % ray.chunk == 0u {
        visible[ray.word] &= ~atomicLoad(&hidden_words[here.index / ray.chunk]);
    }
}
