// Makes one channel of a textured light the value of all samples, per sample. Samples that no query has answered have
// the same value in all channels.
//@ needs shared/query
//@ reads channels
//@ writes samples

// 0 red, 1 green, 2 blue.
override CHANNEL: u32 = 0u;

// True if the smoothed values count, which follow the others.
override SMOOTHED: bool = false;

@compute @workgroup_size(64)
fn channel(here: Lane) {
    let place = invocation(here);
    if place >= arrayLength(&samples) {
        return;
    }
    let found = channels[place + select(0u, arrayLength(&channels) / 2u, SMOOTHED)];
    if found.w != 0.0 {
        samples[place].value = found[CHANNEL];
    }
}
