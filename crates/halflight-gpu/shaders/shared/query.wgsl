// Questions to a visibility backend. Its masks are `frame.pattern.words` words long, at query × words in `wanted` and `visible`.

struct Query {
    // The receiver; NONE asks nothing.
    pixel: u32,
    // Of the light-sample pattern.
    key: u32,
    // Samples asked for, before those below a horizon were taken out.
    asked: u32,
    // Where in `samples` the value goes.
    place: u32,
}

// A value at a place of the image.
struct Sample {
    // In pixels; pixel (i, j) has its centre at (i + 0.5, j + 0.5).
    at: vec2<f32>,
    // Below 0 where there is none.
    value: f32,
    // The pixel whose surface stands for it.
    pixel: u32,
}

const NO_VALUE: f32 = -1.0;
