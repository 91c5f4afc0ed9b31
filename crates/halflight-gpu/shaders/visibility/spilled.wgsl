// Queries that another backend left to rays, in place of the current batch.
//@ writes spilled

fn query_of(number: u32) -> u32 {
    if number < atomicLoad(&spilled[0]) {
        return atomicLoad(&spilled[1u + number]);
    }
    return NONE;
}
