//! A steel lattice tower: four tapering legs that meet in a shaft, arches between their feet, platforms and a
//! spire.
//!
//! Chords and braces are laced girders, so that there are bars of every width from a foot down to an inch.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::bars::{Girder, bar, lace, rod};
use super::builder::Builder;
use super::parameters::Parameters;
use super::shapes::{quarter, rectangle, swept, turned};

const FLOOR: u32 = 0;
const STEEL: u32 = 1;
const CONCRETE: u32 = 2;
const DECK: u32 = 3;
const PALETTE: [[f32; 3]; 4] =
    [[0.70, 0.69, 0.66], [0.50, 0.30, 0.19], [0.58, 0.56, 0.52], [0.40, 0.36, 0.32]];

/// Heights of the three platforms, of the point where the legs meet, and of the tip.
const FIRST: f32 = 7.6;
const SECOND: f32 = 15.2;
const MEET: f32 = 24.0;
const THIRD: f32 = 36.6;
const TIP: f32 = 42.0;
/// Triangles by default.
const TRIANGLES: u32 = 514_000;

/// Distance from the axis to the outer faces.
fn outer(y: f32) -> f32 {
    8.3 * (-y / 13.5).exp()
}

/// Distance from the axis to the inner faces of the legs; a hand's breadth is left between them where they
/// meet.
fn inner(y: f32) -> f32 {
    let width = 3.3 + (outer(MEET) - 0.12 - 3.3) * (y / MEET);
    outer(y) - width
}

/// A tower 42 m high on a floor 110 m wide, of very nearly `triangles` triangles: more of them mean more and
/// finer panels and closer lacing.
pub(super) fn tower(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let triangles = parameters.count("triangles", TRIANGLES, 10_000..=3_000_000)? as usize;
    parameters.finish()?;
    let fineness = (triangles as f32 / TRIANGLES as f32).sqrt();
    let mut tower = Tower { builder: Builder::new(), girders: Vec::new(), fineness };
    tower.builder.paint(FLOOR);
    tower.builder.floor(110.0, 8);
    tower.feet();
    tower.legs();
    tower.builder.paint(STEEL);
    tower.platform(FIRST, 0.45, inner(FIRST) * 0.8);
    tower.platform(SECOND, 0.35, inner(SECOND) * 0.7);
    tower.platform(MEET, 0.2, 0.0);
    tower.platform(THIRD, 0.4, 0.0);
    tower.frieze(FIRST, 0.9);
    tower.frieze(SECOND, 0.6);
    tower.arches();
    tower.spire();
    tower.builder.paint(STEEL);
    lace(&mut tower.builder, &tower.girders, triangles);
    Ok(tower.builder.finish(&PALETTE))
}

struct Tower {
    builder: Builder,
    girders: Vec<Girder>,
    /// Panels along a line relative to the default.
    fineness: f32,
}

impl Tower {
    fn count(&self, usual: f32) -> usize {
        (usual * self.fineness).round().max(1.0) as usize
    }

    /// Few panels need stout girders, many need slender ones.
    fn slender(&self, width: f32) -> f32 {
        width * self.fineness.powf(-0.5).clamp(0.6, 1.5)
    }

    fn girder(&mut self, ends: [Vec3; 2], side: Vec3, width: f32, flat: bool) {
        self.girders.push(Girder { ends, side, width, flat });
    }

    /// Two crossing flat girders between a bottom and a top edge, one before the other.
    fn cross(&mut self, bottom: [Vec3; 2], top: [Vec3; 2], width: f32) {
        let normal = (bottom[1] - bottom[0]).cross(top[0] - bottom[0]).normalize_or(Vec3::Y);
        for (ends, shift) in [([bottom[0], top[1]], 0.16), ([bottom[1], top[0]], -0.16)] {
            let side = normal.cross(ends[1] - ends[0]);
            self.girder(ends.map(|end| end + normal * (shift * width)), side, width, true);
        }
    }

    /// One panel of a square mast: chords at its corners, and on each face a cross and a girder along the
    /// top.
    fn cage(&mut self, bottom: [Vec3; 4], top: [Vec3; 4], width: f32) {
        let (chord, brace) = (self.slender(0.1 * width), self.slender(0.075 * width));
        for j in 0..4 {
            let k = (j + 1) % 4;
            self.girder([bottom[j], top[j]], bottom[k] - bottom[j], chord, false);
            let normal = (bottom[k] - bottom[j]).cross(top[j] - bottom[j]);
            self.girder([top[j], top[k]], normal.cross(top[k] - top[j]), brace, true);
            self.cross([bottom[j], bottom[k]], [top[j], top[k]], brace);
        }
    }

    fn legs(&mut self) {
        for (low, high, panels) in [(0.5, FIRST, 6.0), (FIRST, SECOND, 7.0), (SECOND, MEET, 9.0)] {
            let panels = self.count(panels);
            let at = |panel: usize| low + (high - low) * panel as f32 / panels as f32;
            for (x, z) in [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)] {
                let corners = |y: f32| {
                    let (o, i) = (outer(y), inner(y));
                    [[o, o], [i, o], [i, i], [o, i]].map(|[a, b]| Vec3::new(x * a, y, z * b))
                };
                for panel in 0..panels {
                    let (y, next) = (at(panel), at(panel + 1));
                    self.cage(corners(y), corners(next), outer(y) - inner(y));
                }
            }
        }
        let panels = self.count(16.0);
        // Panels get lower as the shaft gets narrower.
        let at = |panel: usize| {
            let t = panel as f32 / panels as f32;
            MEET + (THIRD - MEET) * t * (1.25 - 0.25 * t)
        };
        let corners = |y: f32| {
            [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]
                .map(|[x, z]| Vec3::new(x * outer(y), y, z * outer(y)))
        };
        for panel in 0..panels {
            self.cage(corners(at(panel)), corners(at(panel + 1)), 1.6 * outer(at(panel)));
        }
    }

    /// Concrete under the four legs.
    fn feet(&mut self) {
        self.builder.paint(CONCRETE);
        let middle = (outer(0.5) + inner(0.5)) / 2.0;
        for (x, z) in [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)] {
            let foot = Vec3::new(x * middle, -0.1, z * middle);
            self.builder.block(foot, Vec3::new(4.6, 0.4, 4.6));
            self.builder.block(foot, Vec3::new(4.1, 0.7, 4.1));
        }
    }

    /// A deck that reaches `over` beyond the faces, with a hole `hole` from the axis and a railing.
    fn platform(&mut self, y: f32, over: f32, hole: f32) {
        let edge = outer(y) + over;
        self.builder.paint(DECK);
        if hole > 0.0 {
            let middle = (edge + hole) / 2.0;
            let path = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]
                .map(|[x, z]| Vec3::new(x * middle, y, z * middle));
            let half = (edge - hole) / 2.0;
            swept(&mut self.builder, &rectangle(0.24, -half, half), &path, Vec3::Y);
        } else {
            self.builder.block(Vec3::Y * (y - 0.12), Vec3::new(2.0 * edge, 0.24, 2.0 * edge));
        }
        self.builder.paint(STEEL);
        let (rail, top) = (edge - 0.05, y + 0.62);
        let posts = self.count(2.0 * rail / 0.3).max(2);
        for (along, out) in
            [(Vec3::X, Vec3::Z), (Vec3::Z, -Vec3::X), (-Vec3::X, -Vec3::Z), (-Vec3::Z, Vec3::X)]
        {
            let at = |t: f32, height: f32| along * (rail * (2.0 * t - 1.0)) + out * rail + Vec3::Y * height;
            for post in 0..posts {
                let t = post as f32 / posts as f32;
                bar(&mut self.builder, [at(t, y), at(t, top)], along, [0.03, 0.03]);
            }
            for height in [top, y + 0.3] {
                bar(&mut self.builder, [at(0.0, height), at(1.0, height)], out, [0.05, 0.04]);
            }
        }
    }

    /// A band of crosses, `depth` high, under a platform from leg to leg on every face.
    fn frieze(&mut self, y: f32, depth: f32) {
        let (high, low) = (y - 0.2, y - 0.2 - depth);
        let (width, bays) = (self.slender(0.14 * depth), self.count(6.0));
        for turn in 0..4 {
            let node = |k: usize, y: f32| {
                let x = (2.0 * k as f32 / bays as f32 - 1.0) * inner(y);
                quarter(turn, Vec3::new(x, y, outer(y) - 0.1))
            };
            for k in 0..bays {
                let (bottom, top) = ([node(k, low), node(k + 1, low)], [node(k, high), node(k + 1, high)]);
                self.cross(bottom, top, width);
            }
            for y in [low, high] {
                self.girder([node(0, y), node(bays, y)], Vec3::Y, width, true);
            }
        }
    }

    /// A round arch on every face from leg to leg, two ribs with struts between them.
    fn arches(&mut self) {
        const FOOT: f32 = 2.0;
        let segments = self.count(20.0).max(3);
        for turn in 0..4 {
            let node = |k: usize, grown: f32| {
                let (sin, cos) = (PI * k as f32 / segments as f32).sin_cos();
                let y = FOOT + (FIRST - 2.2 - FOOT + grown) * sin;
                quarter(turn, Vec3::new(-(inner(FOOT) + 0.15 + grown) * cos, y, outer(y) - 0.15))
            };
            let width = self.slender(0.13);
            for k in 0..segments {
                let (low, high) = ([node(k, 0.0), node(k + 1, 0.0)], [node(k, 0.55), node(k + 1, 0.55)]);
                let side = high[0] - low[0];
                self.girder(low, side, width, true);
                self.girder(high, side, width, true);
                self.cross(low, high, 0.6 * width);
            }
        }
    }

    /// The cabin over the third platform, its dome and the mast.
    fn spire(&mut self) {
        let (half, foot) = (outer(THIRD) * 0.8, Vec3::Y * (THIRD + 0.1));
        self.builder.paint(DECK);
        self.builder.block(foot, Vec3::new(2.0 * half, 1.3, 2.0 * half));
        self.builder.paint(STEEL);
        let sides = self.count(24.0).max(8);
        let steps = self.count(8.0).max(2);
        let mut dome = vec![Vec2::new(0.0, 0.0), Vec2::new(half, 0.0)];
        dome.extend((1..=steps).map(|step| {
            let (sin, cos) = (0.5 * PI * step as f32 / steps as f32).sin_cos();
            Vec2::new(if step == steps { 0.0 } else { half * cos }, 1.3 * half * sin)
        }));
        let mut part = Builder::new();
        part.paint(STEEL);
        turned(&mut part, &dome, sides);
        self.builder.place(&part, |p| p + foot + Vec3::Y * 1.25);
        let mast = foot + Vec3::Y * 1.5;
        rod(&mut self.builder, [mast, Vec3::Y * (TIP - 1.6)], 0.09, sides / 2);
        rod(&mut self.builder, [mast, Vec3::Y * TIP], 0.045, sides / 2);
    }
}
