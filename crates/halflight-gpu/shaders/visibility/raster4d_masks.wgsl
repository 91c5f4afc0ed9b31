// Removes hidden samples, per task: from a group of a cell's receivers, 32 samples each, and a run of the
// triangles over the cell, to masks.
//@ needs shared/light shared/query shared/receiver visibility/raster4d visibility/triangle
//@ reads queries rectangles bins_read
//@ writes seen

var<workgroup> origins: array<vec3<f32>, GROUP>;
var<workgroup> keys: array<u32, GROUP>;
var<workgroup> places: array<vec4<f32>, GROUP>;
var<workgroup> left: array<u32, GROUP>;
var<workgroup> hidden: array<atomic<u32>, GROUP>;
// Rectangle that is covered wherever the rectangle of a receiver with samples left is.
var<workgroup> within: vec4<f32>;
// Triangles that cover it, and their rectangles.
var<workgroup> list: array<u32, RUN>;
var<workgroup> list_places: array<vec4<f32>, RUN>;
var<workgroup> listed: atomic<u32>;
var<workgroup> list_length: u32;

@compute @workgroup_size(64)
fn take_hidden(here: Lane) {
    let task = group_of(here);
    if task >= bins_read[TASKS] {
        return;
    }
    let cell = cell_of(task);
    let runs = (bins_read[lengths() + cell] + RUN - 1u) / RUN;
    let part = task - bins_read[first_tasks() + cell];
    let word = part / runs % frame.pattern.words;
    let first = ends_before(receiver_ends(), cell) + part / runs / frame.pattern.words * GROUP;
    let count = min(bins_read[receiver_ends() + cell] - first, GROUP);
    var slot = 0u;
    if here.index < count {
        let query = bins_read[query_order() + first + here.index];
        let receiver = receiver_at(queries[query].pixel);
        let place = receiver_rectangle(local(receiver.origin, cell / (FRAMEBUFFER * FRAMEBUFFER)));
        slot = query * frame.pattern.words + word;
        origins[here.index] = receiver.origin;
        keys[here.index] = queries[query].key;
        places[here.index] = vec4(place.low, place.high);
        left[here.index] = atomicLoad(&seen[slot]);
    }
    workgroupBarrier();
    if here.index == 0u {
        var low = vec2(-MOST);
        var high = vec2(MOST);
        for (var receiver = 0u; receiver < count; receiver++) {
            if left[receiver] != 0u {
                low = max(low, places[receiver].xy);
                high = min(high, places[receiver].zw);
            }
        }
        within = vec4(low, high);
    }
    workgroupBarrier();
    gather(here.index, cell, part % runs);
    workgroupBarrier();
    if here.index == 0u {
        list_length = atomicLoad(&listed);
    }
    workgroupBarrier();
    for (var receiver = here.index / 32u; receiver < count; receiver += 2u) {
        let bit = 1u << (here.index & 31u);
        if (left[receiver] & bit) != 0u && is_hidden(receiver, word * 32u + (here.index & 31u)) {
            atomicOr(&hidden[receiver], bit);
        }
    }
    workgroupBarrier();
    if here.index < count && atomicLoad(&hidden[here.index]) != 0u {
        atomicAnd(&seen[slot], ~atomicLoad(&hidden[here.index]));
    }
}

// Upper bound on the extent of triangles' rectangles.
const MOST: f32 = 3e38;

// Index at which a cell's part of a list begins.
fn ends_before(ends: u32, cell: u32) -> u32 {
    if cell == 0u {
        return 0u;
    }
    return bins_read[ends + cell - 1u];
}

// Last cell whose first task is not after this one.
fn cell_of(task: u32) -> u32 {
    var low = 0u;
    var high = finest_cells();
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if bins_read[first_tasks() + middle] <= task {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

fn covers(other: vec4<f32>, place: vec4<f32>) -> bool {
    return all(other.xy <= place.xy) && all(place.zw <= other.zw);
}

// Lists the triangles of a run that may hide the light: of all those over a cell, level by level.
fn gather(lane: u32, cell: u32, run: u32) {
    let side = cell / (FRAMEBUFFER * FRAMEBUFFER);
    let at = vec2(cell % FRAMEBUFFER, (cell / FRAMEBUFFER) % FRAMEBUFFER);
    var level_first = side * CELLS;
    // Indices among the triangles over the cell: of this lane's next one, of the end of the run, and of a
    // level's first.
    var number = run * RUN + lane;
    let end = (run + 1u) * RUN;
    var before = 0u;
    for (var level = 0u; level < LEVELS; level++) {
        let over = level_first + (at.y >> level) * level_side(level) + (at.x >> level);
        level_first += level_side(level) * level_side(level);
        let begin = ends_before(TRIANGLE_ENDS, over);
        let length = bins_read[TRIANGLE_ENDS + over] - begin;
        for (; number < min(before + length, end); number += 64u) {
            let triangle = bins_read[triangle_order() + begin + number - before];
            let place = rectangles[side * TRIANGLES + triangle];
            if covers(place, within) {
                let next = atomicAdd(&listed, 1u);
                list[next] = triangle;
                list_places[next] = place;
            }
        }
        before += length;
    }
}

fn is_hidden(receiver: u32, sample: u32) -> bool {
    let origin = origins[receiver];
    let end = sample_point(sample, keys[receiver]);
    for (var at = 0u; at < list_length; at++) {
        if covers(list_places[at], places[receiver]) && meets(list[at], origin, end, end - origin) {
            return true;
        }
    }
    return false;
}
