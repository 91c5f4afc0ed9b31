use glam::Vec3;

use super::grid::{Blocking, CONSTANT, Grid, LINEAR, Volume};
use super::propagate::step;

fn grid() -> Grid {
    Grid::new(Vec3::ZERO, Vec3::splat(16.0), 16).expect("grid")
}

#[test]
fn no_flux_is_lost_or_made_where_none_is_cut_off() {
    let grid = grid();
    assert_eq!(grid.size, 1.0);
    let [mut from, mut to] = [Volume::default(), Volume::default()];
    from.reset(&grid);
    to.reset(&grid);
    // Mostly even intensity, so that no direction falls below 0.
    let cell = grid.cell(Vec3::splat(8.5)).unwrap();
    for (normal, flux) in
        [(Vec3::X, 3.0), (Vec3::NEG_X, 2.0), (Vec3::Y, 2.0), (Vec3::NEG_Y, 2.0), (Vec3::Z, 2.0)]
    {
        from.deposit(cell, Vec3::new(flux, 2.0 * flux, 0.0), normal);
    }
    let before = from.flux();
    assert!((before[0] - 11.0).abs() < 1e-5 && (before[1] - 22.0).abs() < 1e-5, "{before:?}");
    step(&grid, &from, None, &mut to);
    let after = to.flux();
    for channel in 0..3 {
        assert!((after[channel] - before[channel]).abs() <= 1e-5 * before[0], "{before:?} {after:?}");
    }
    // A cut-off lobe makes flux: what it cuts off is negative.
    from.reset(&grid);
    from.deposit(cell, Vec3::ONE, Vec3::X);
    step(&grid, &from, None, &mut to);
    assert!(to.flux()[0] > 1.001, "{:?}", to.flux());
}

#[test]
fn light_goes_where_it_is_sent() {
    let grid = grid();
    let [mut from, mut to, mut sum] = [Volume::default(), Volume::default(), Volume::default()];
    [&mut from, &mut to, &mut sum].into_iter().for_each(|volume| volume.reset(&grid));
    from.deposit(grid.cell(Vec3::new(4.5, 8.5, 8.5)).unwrap(), Vec3::ONE, Vec3::X);
    for _ in 0..8 {
        step(&grid, &from, None, &mut to);
        std::mem::swap(&mut from, &mut to);
        sum.add(&from);
    }
    let at = |x: f32, normal: Vec3| sum.irradiance(&grid, Vec3::new(x, 8.5, 8.5), normal).x;
    let (towards, away) = (at(8.5, Vec3::NEG_X), at(8.5, Vec3::X));
    assert!(towards > 1.3 * away, "{towards} {away}");
    assert!(towards > at(12.5, Vec3::NEG_X) && at(12.5, Vec3::NEG_X) > 0.0);
    // As much to one side as to the other.
    let beside = |z: f32| sum.irradiance(&grid, Vec3::new(8.5, 8.5, z), Vec3::NEG_X).x;
    assert!((beside(6.5) / beside(10.5) - 1.0).abs() < 1e-4);
}

#[test]
fn a_known_field_is_looked_up() {
    let grid = grid();
    let mut sum = Volume::default();
    sum.reset(&grid);
    // Radiance 2 from everywhere: intensity 2 · 1.5 · side² in every direction. Irradiance: π times the radiance.
    let cells = grid.len();
    sum.values[..cells].fill(2.0 * 1.5 / CONSTANT);
    for normal in [Vec3::X, Vec3::Y, Vec3::ONE.normalize()] {
        let found = sum.irradiance(&grid, Vec3::new(5.3, 6.1, 9.9), normal);
        assert!((found.x / (2.0 * std::f32::consts::PI) - 1.0).abs() < 1e-4 && found.y == 0.0, "{found}");
    }
    // Light that travels along +x, in band 1 alone, adds to receivers that look along -x.
    sum.values[cells..2 * cells].fill(1.0 / LINEAR);
    let at = |normal| sum.irradiance(&grid, Vec3::splat(8.0), normal).x;
    assert!(at(Vec3::NEG_X) > at(Vec3::Y) && at(Vec3::Y) > at(Vec3::X));
}

#[test]
fn a_wall_blocks() {
    use crate::indirect::points::{Point, Points};
    let grid = grid();
    let mut points = Points::default();
    // One point a cell, in the plane x = 8, on corners of the cells.
    for y in 0..17 {
        for z in 0..17 {
            let position = Vec3::new(8.01, y as f32, z as f32);
            points.points.push(Point {
                position,
                normal: Vec3::X,
                area: 1.0,
                origins: [position; 2],
                shading: Vec3::X,
                albedo: Vec3::ONE,
                turned: false,
            });
        }
    }
    let mut blocking = Blocking::default();
    blocking.fill(&grid, &points);
    let behind = |blocking: Option<&Blocking>| {
        let [mut from, mut to, mut sum] = [Volume::default(), Volume::default(), Volume::default()];
        [&mut from, &mut to, &mut sum].into_iter().for_each(|volume| volume.reset(&grid));
        from.deposit(grid.cell(Vec3::new(5.5, 8.5, 8.5)).unwrap(), Vec3::ONE, Vec3::X);
        for _ in 0..8 {
            step(&grid, &from, blocking, &mut to);
            std::mem::swap(&mut from, &mut to);
            sum.add(&from);
        }
        sum.irradiance(&grid, Vec3::new(10.5, 8.5, 8.5), Vec3::NEG_X).x
    };
    let (open, shut) = (behind(None), behind(Some(&blocking)));
    assert!(open > 0.0 && shut < 0.02 * open, "{open} {shut}");
}

#[test]
fn grids_are_anchored_in_whole_cells() {
    let grid = |low: f32| Grid::new(Vec3::splat(low), Vec3::splat(low + 10.0), 32).unwrap();
    let still = grid(0.0);
    for shift in [0.01, 0.1, 1.0, -3.7] {
        let moved = grid(shift);
        assert_eq!(moved.size, still.size);
        let cells = (moved.low - still.low) / still.size;
        assert!((cells - cells.round()).abs().max_element() < 1e-3, "{cells}");
    }
    assert!(Grid::new(Vec3::ZERO, Vec3::ZERO, 32).is_none());
    assert!(Grid::new(Vec3::splat(1e7), Vec3::splat(1e7 + 1.0), 32).is_none());
    // Flat scenes have a grid as well.
    assert!(Grid::new(Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0), 32).is_some());
}
