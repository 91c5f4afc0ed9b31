// Computes the trust in a cell's sample, per cell of a level: the degree to which the cell lies on one
// surface (halflight-cpu/src/upsample/nearby.rs).
//@ needs shared/cells shared/query shared/tangent
//@ reads samples
//@ writes trusts

// Weight of a sample whose cell lies on several surfaces: it only counts where there is no other.
const MIXED: f32 = 1e-4;

@compute @workgroup_size(8, 8)
fn trust(@builtin(global_invocation_id) at: vec3<u32>) {
    let size = level_size(frame.level);
    if at.x >= size.x || at.y >= size.y {
        return;
    }
    let place = cell_index(frame.level, at.xy);
    if cells[place].kept == 0u {
        return;
    }
    let sample = samples[place];
    let own = tangent_at(sample.pixel);
    let quarter = 0.25 * f32(1u << frame.level);
    var least = 1.0;
    for (var corner = 0u; corner < 4u; corner++) {
        let off = vec2(select(-quarter, quarter, (corner & 1u) == 1u), select(-quarter, quarter, corner > 1u));
        let other = min(vec2<u32>(max(sample.at + off, vec2(0.0))), vec2(frame.width, frame.height) - 1u);
        let pixel = other.y * frame.width + other.x;
        if is_receiver(pixel) {
            least = min(least, agreement(own, tangent_at(pixel)));
        }
    }
    trusts[place] = max(least, MIXED);
}
