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
        if asked.pixel != NONE && is_hidden_solidly(position[asked.pixel].xyz, sample_place(ray.index, asked.key)) {
            atomicOr(&hidden_words[here.index / ray.chunk], ray.bit);
        }
    }
    workgroupBarrier();
    if ray.exists && here.index % ray.chunk == 0u {
        visible[ray.word] &= ~atomicLoad(&hidden_words[here.index / ray.chunk]);
    }
}

fn is_hidden_solidly(origin: vec3<f32>, place: vec2<f32>) -> bool {
    let end = seen_point(seen_light(origin), place);
    if !is_sphere() {
        return occluded_solidly(origin, end);
    }
    if surrounded(origin) {
        return false;
    }
    let stop = before_sphere(origin, end);
    return any(stop != origin) && occluded_solidly(origin, stop);
}
