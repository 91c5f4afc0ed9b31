// Switches to tracing every pixel, once per level: if so many pixels are left that coarser cells do not pay
// off. Level 0 is then the only level.
//@ needs shared/choice shared/counters

// Fractions of the receivers in pending cells of level 1 and 2 above which every pixel is traced:
// `Budget::DENSE`.
override SHARE_1: f32 = 1.0;
override SHARE_2: f32 = 1.0;

@compute @workgroup_size(1)
fn decide() {
    let open = atomicExchange(&counters[CELLS_LEFT], 0u);
    let receivers = atomicExchange(&counters[PIXELS_SEEN], 0u);
    let share = select(SHARE_1, SHARE_2, frame.level == 2u);
    if chosen[0].every.count > 0u && f32(open << (2u * frame.level)) > share * f32(receivers) {
        chosen[0].pattern = chosen[0].every;
        chosen[0].coarsest = 0u;
    }
}
