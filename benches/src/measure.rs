//! Timing: contestants take turns, so that disturbances affect all of them.

use crate::contestant::{Contestant, FlatRay};
use crate::stage::Rays;
use cpu_time::ThreadTime;

/// The kinds of rays, in the order of the tables.
pub const KINDS: [&str; 3] = ["camera", "shadow", "incoherent"];

/// Two hits that are farther apart than this count as different. The rabbit is 0.15 high.
const ELSEWHERE: f64 = 1e-4;

/// A median, and the spread of the measurements.
#[derive(Clone, Copy, Debug)]
pub struct Median {
    pub value: f64,
    /// Half the interquartile range over the median.
    pub spread: f64,
}

impl Median {
    /// The summary of at least one measurement.
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let at = |part: f64| values[(part * (values.len() - 1) as f64).round() as usize];
        let value = at(0.5);
        Self { value, spread: 0.5 * (at(0.75) - at(0.25)) / value }
    }
}

/// The results of one contestant, and its speed.
pub struct Outcome {
    /// Millions of rays per second, by [`KINDS`].
    pub speed: [Median; 3],
    /// The number of rays that hit, by [`KINDS`].
    pub hits: [usize; 3],
    /// The number of rays whose hit differs from the first contestant's, by [`KINDS`]: one hits and the other
    /// misses, or they hit at different points.
    pub differing: [usize; 3],
}

/// Casts all rays with each contestant in turn, `rounds` times. The results are compared with those of the
/// first contestant.
pub fn race(contestants: &[&dyn Contestant], rays: &Rays, rounds: usize) -> Vec<Outcome> {
    let answers: Vec<_> = contestants.iter().map(|contestant| answers(*contestant, rays)).collect();
    let mut speeds = vec![[const { Vec::new() }; 3]; contestants.len()];
    for _ in 0..rounds {
        for (contestant, speeds) in contestants.iter().zip(&mut speeds) {
            for (kind, speeds) in speeds.iter_mut().enumerate() {
                speeds.push(speed(*contestant, rays, kind));
            }
        }
    }
    let outcome = |(answered, speeds): (&[Vec<f64>; 3], [Vec<f64>; 3])| Outcome {
        speed: speeds.map(Median::of),
        hits: std::array::from_fn(|kind| answered[kind].iter().filter(|&&t| t < f64::INFINITY).count()),
        differing: std::array::from_fn(|kind| differences(&answered[kind], &answers[0][kind])),
    };
    answers.iter().zip(speeds).map(outcome).collect()
}

fn of_kind(rays: &Rays, kind: usize) -> &[FlatRay] {
    [&rays.camera, &rays.shadow, &rays.incoherent][kind]
}

/// The distance to each ray's hit, by kind; zero for a query for any hit. This is not timed, but warms the
/// caches.
fn answers(contestant: &dyn Contestant, rays: &Rays) -> [Vec<f64>; 3] {
    std::array::from_fn(|kind| {
        let rays = of_kind(rays, kind);
        if KINDS[kind] != "shadow" {
            return contestant.distances(rays);
        }
        let hits = contestant.hits(rays);
        hits.into_iter().map(|hit| if hit { 0.0 } else { f64::INFINITY }).collect()
    })
}

fn differences(one: &[f64], other: &[f64]) -> usize {
    let same = |a: f64, b: f64| a == b || (a - b).abs() <= ELSEWHERE;
    one.iter().zip(other).filter(|&(&a, &b)| !same(a, b)).count()
}

/// Millions of rays of a kind per second of this thread's time.
fn speed(contestant: &dyn Contestant, rays: &Rays, kind: usize) -> f64 {
    let rays = of_kind(rays, kind);
    let start = ThreadTime::now();
    let hits =
        if KINDS[kind] == "shadow" { contestant.count_any(rays) } else { contestant.count_closest(rays) };
    std::hint::black_box(hits);
    1e-6 * rays.len() as f64 / start.elapsed().as_secs_f64()
}

/// The result of `build`, and the median of the milliseconds of this thread's time that it took in `rounds`
/// runs.
pub fn built<T>(rounds: usize, mut build: impl FnMut() -> T) -> (T, Median) {
    let mut times = vec![];
    loop {
        let start = ThreadTime::now();
        let made = build();
        times.push(1e3 * start.elapsed().as_secs_f64());
        if times.len() >= rounds {
            return (made, Median::of(times));
        }
    }
}
