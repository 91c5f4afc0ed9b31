// Sums the squared luminance of the image, per tile: the normalisation of errors.
//@ needs shared/tiles
//@ reads image

@compute @workgroup_size(8, 8)
fn measure(here: Tile) {
    var bright = 0.0;
    if here.at.x < frame.width && here.at.y < frame.height {
        bright = luminance(image[here.at.y * frame.width + here.at.x].xyz);
    }
    add_up(here, bright * bright);
}
