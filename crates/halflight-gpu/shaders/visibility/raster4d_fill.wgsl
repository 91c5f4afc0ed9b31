// Fills the cells of 4D rasterization, per triangle or per query: from counted cells to sorted lists.
//@ needs shared/query_batch visibility/raster4d visibility/raster4d_cells
//@ writes bins

// 0 for triangles, 1 for receivers.
override RECEIVERS: u32 = 0u;

@compute @workgroup_size(64)
fn fill(here: Lane) {
    let number = invocation(here);
    if RECEIVERS == 1u {
        let query = query_of(number);
        if query != NONE {
            let cell = atomicLoad(&bins[cells_of_queries() + query]);
            if cell != NONE {
                atomicStore(&bins[query_order() + atomicAdd(&bins[receiver_ends() + cell], 1u)], query);
            }
        }
    } else if number < TRIANGLES {
        for (var corner = 0u; corner < 4u * frame.sides; corner++) {
            let side = corner / 4u;
            let cells = atomicLoad(&bins[cells_of_triangles() + side * TRIANGLES + number]);
            let cell = cell_at_corner(cells, corner % 4u, side);
            if cell != NONE {
                atomicStore(&bins[triangle_order() + atomicAdd(&bins[TRIANGLE_ENDS + cell], 1u)], number);
            }
        }
    }
}
