// Visibility of 32 light samples in a neighbourhood: visible from some cell, hidden from some cell.
//@ needs shared/cells
//@ reads wanted visible

override INTERLEAVED: bool = false;

struct Votes {
    lit: u32,
    unlit: u32,
}

fn votes_around(level: u32, cell: vec2<u32>, word: u32) -> Votes {
    // Of interleaved cells only every other one has traced the same samples.
    let reach = select(1u, 2u, INTERLEAVED);
    let low = cell - min(cell, vec2(reach));
    let high = min(cell + reach + 1u, level_size(level));
    var votes = Votes(0u, 0u);
    for (var y = low.y; y < high.y; y++) {
        for (var x = low.x; x < high.x; x++) {
            let other = cells[cell_index(level, vec2(x, y))];
            if other.state == RENDERED {
                let at = other.slot * frame.pattern.words + word;
                votes.lit |= wanted[at] & visible[at];
                votes.unlit |= wanted[at] & ~visible[at];
            }
        }
    }
    return votes;
}
