// Queries to a visibility backend. Their masks have `frame.pattern.words` words each, at query × words in
// `wanted` and `visible`.

struct Query {
    // Pixel of the receiver; NONE for an empty query.
    pixel: u32,
    // Key of the light-sample pattern.
    key: u32,
    // Number of samples before those below a horizon are removed.
    asked: u32,
    // Index in `samples` of the query's value, or NONE.
    place: u32,
}

// Value at a position of the image.
struct Sample {
    // In pixels; pixel (i, j) has its centre at (i + 0.5, j + 0.5).
    at: vec2<f32>,
    // Negative where undefined.
    value: f32,
    // Representative pixel, whose surface the sample has.
    pixel: u32,
}

const NO_VALUE: f32 = -1.0;
