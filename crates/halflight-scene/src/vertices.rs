//! Vertices: one for every combination of a position and other attributes of face corners.

use std::collections::HashMap;

/// Position, counted from 1, and two numbers that distinguish its vertices.
pub(crate) type Corner = [u32; 3];

const NONE: u32 = u32::MAX;

/// Most vertices of a position that are compared one by one. Further ones are found by a hash, so that no
/// position is slow.
const CHAIN: usize = 16;

/// Vertices in the order in which faces first use them.
#[derive(Default)]
pub(crate) struct Vertices {
    pub(crate) corners: Vec<Corner>,
    /// For every vertex, another one at its position, or [`NONE`].
    next: Vec<u32>,
    /// For every position, its latest vertex.
    latest: Vec<u32>,
    others: HashMap<Corner, u32>,
}

impl Vertices {
    /// Declares that `count` positions are defined.
    pub(crate) fn define(&mut self, count: usize) {
        self.latest.resize(count, NONE);
    }

    /// Vertex of `corner`.
    pub(crate) fn of(&mut self, corner: Corner) -> u32 {
        let new = self.corners.len() as u32;
        let position = corner[0] as usize;
        let mut link = NONE;
        // Positions that are defined later have no chain.
        if let Some(latest) = position.checked_sub(1).and_then(|at| self.latest.get_mut(at)) {
            let mut at = *latest;
            let mut left = CHAIN;
            while at != NONE && left > 0 {
                if self.corners[at as usize] == corner {
                    return at;
                }
                at = self.next[at as usize];
                left -= 1;
            }
            if left > 0 {
                link = std::mem::replace(latest, new);
                self.corners.push(corner);
                self.next.push(link);
                return new;
            }
        }
        let found = *self.others.entry(corner).or_insert(new);
        if found == new {
            self.corners.push(corner);
            self.next.push(link);
        }
        found
    }
}
