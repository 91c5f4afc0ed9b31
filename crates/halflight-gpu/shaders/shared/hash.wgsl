// Hash functions, the only source of randomness: bit for bit those of halflight-core/src/hash.rs.

fn mix32(value: u32) -> u32 {
    var x = value;
    x ^= x >> 16u;
    x *= 0x21f0aaadu;
    x ^= x >> 15u;
    x *= 0xd35a2d97u;
    return x ^ (x >> 15u);
}

fn fold(state: u32, value: u32) -> u32 {
    return mix32(state ^ mix32(value + 0x9e3779b9u));
}

fn sample_bits(key: u32, index: u32) -> u32 {
    return mix32(key + index * 0x9e3779b9u);
}

const SHARE_RECEIVER: u32 = 0u;
const SHARE_FRAGMENT: u32 = 1u;

// Pattern key of a receiver by the frame's sharing rule. `frame.key` already includes seed, frame and light.
fn pattern_key(fragment: u32, pixel: u32) -> u32 {
    switch frame.sharing {
        case SHARE_RECEIVER: { return fold(frame.key, pixel); }
        case SHARE_FRAGMENT: { return fold(frame.key, fragment); }
        default: { return fold(frame.key, 0u); }
    }
}
