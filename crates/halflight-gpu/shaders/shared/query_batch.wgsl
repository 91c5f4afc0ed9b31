// Queries of the current batch: all from the first to the last are answered.
//@ needs shared/counters

fn query_of(number: u32) -> u32 {
    let query = atomicLoad(&counters[FIRST]) + number;
    return select(NONE, query, query < atomicLoad(&counters[END]));
}
