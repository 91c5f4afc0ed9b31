//! Which of two ways is the quicker here: both are tried and timed while they work, since their answers are the same.

use std::sync::Mutex;
use std::sync::PoisonError;

/// How a group is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    Beams,
    Rays,
}

/// Groups in a row that share what they learn.
pub(super) const LAP: usize = 32;

/// Groups before the slower way is tried again while the other is no more than half as quick again, and at most.
const AGAIN: std::ops::RangeInclusive<f32> = 12.0..=192.0;

/// What is left of an older comparison after each new one.
const FADE: f32 = 0.85;

/// A time may be this many times that of its neighbours before it is taken for another program's doing.
const OUTLIER: f32 = 16.0;

/// What the two ways have cost of late, nanoseconds a query. Costs of neighbouring groups are alike, those of one way in two
/// places are not: so the slower way is held against what the quicker one has just cost beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Race {
    /// Fading sums over the same places.
    beams: f32,
    rays: f32,
    /// Mean over the last groups that went the quicker way.
    lately: f32,
    /// Groups since the slower one was tried.
    since: u32,
}

impl Race {
    fn quicker(&self) -> Way {
        if self.beams <= self.rays { Way::Beams } else { Way::Rays }
    }

    /// The way that the next group goes.
    pub(super) fn next(&mut self) -> Way {
        let quicker = self.quicker();
        if self.lately == 0.0 {
            return quicker;
        }
        let (low, high) = (self.beams.min(self.rays), self.beams.max(self.rays));
        let ratio = if high > 0.0 { high / low.max(f32::MIN_POSITIVE) } else { 0.0 };
        self.since += 1;
        if self.since as f32 > (AGAIN.start() * (ratio / 1.5).powi(2)).min(*AGAIN.end()) {
            return if quicker == Way::Beams { Way::Rays } else { Way::Beams };
        }
        quicker
    }

    /// Learns how long a group took.
    pub(super) fn took(&mut self, way: Way, nanoseconds: f32) {
        let quicker = self.quicker();
        // Never zero, which stands for nothing.
        let time = nanoseconds.max(1.0);
        if self.lately == 0.0 {
            self.lately = time;
            return;
        }
        let time = time.min(OUTLIER * self.lately);
        if way == quicker {
            self.lately = 0.5 * (self.lately + time);
            return;
        }
        self.since = 0;
        let (beams, rays) = if way == Way::Beams { (time, self.lately) } else { (self.lately, time) };
        (self.beams, self.rays) = (FADE * self.beams + beams, FADE * self.rays + rays);
        if self.quicker() != quicker {
            self.lately = time;
        }
    }
}

/// Races by how many samples a query asks for, in powers of two.
#[derive(Debug, Default)]
pub(super) struct Races([Mutex<Race>; 13]);

impl Races {
    fn of(&self, samples: usize) -> &Mutex<Race> {
        &self.0[(samples.max(1).ilog2() as usize).min(self.0.len() - 1)]
    }

    /// What is known.
    pub(super) fn state(&self, samples: usize) -> Race {
        *self.of(samples).lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What the next ones start from.
    pub(super) fn set(&self, samples: usize, race: Race) {
        *self.of(samples).lock().unwrap_or_else(PoisonError::into_inner) = race;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Groups that went by rays of a thousand whose ways take so long.
    fn run(race: &mut Race, beams: f32, rays: f32) -> u32 {
        (0..1000)
            .map(|_| {
                let way = race.next();
                race.took(way, if way == Way::Rays { rays } else { beams });
                u32::from(way == Way::Rays)
            })
            .sum()
    }

    #[test]
    fn the_quicker_one_gets_nearly_all_and_the_other_is_not_forgotten() {
        let mut race = Race::default();
        let slower = run(&mut race, 100.0, 200.0);
        assert!((40..=60).contains(&slower), "{slower}");
        // Where things change it changes its mind.
        let slower = run(&mut race, 400.0, 200.0);
        assert!(slower > 800, "{slower}");
        // What takes ten times as long is hardly tried.
        let slower = run(&mut Race::default(), 100.0, 1000.0);
        assert!((5..=8).contains(&slower), "{slower}");
    }

    #[test]
    fn places_that_cost_more_do_not_speak_for_one_way() {
        // Easy and hard places by turns, in which rays take twice as long.
        let mut race = Race::default();
        let mut slower = 0;
        for place in 0..100 {
            let cost = if place % 2 == 0 { 10.0 } else { 1000.0 };
            for _ in 0..20 {
                let way = race.next();
                race.took(way, if way == Way::Rays { 2.0 * cost } else { cost });
                slower += u32::from(way == Way::Rays);
            }
        }
        assert!(slower < 200, "{slower}");
    }

    #[test]
    fn an_interruption_does_not_decide() {
        let mut race = Race::default();
        run(&mut race, 100.0, 190.0);
        race.took(Way::Beams, 1e6);
        assert_eq!(race.next(), Way::Beams);
    }
}
