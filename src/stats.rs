//! Counters, and the statistics that `-stats` prints.

use crate::math::aabb::Aabb;
use serde::{Serialize, Serializer};
use std::fmt;
use std::time::Duration;

/// The events that the course's program counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Camera rays, reflected rays and refracted rays.
    pub non_shadow_rays: u64,
    /// Rays towards lights.
    pub shadow_rays: u64,
    /// Tests of a ray against a primitive.
    pub intersections: u64,
    /// Steps from one grid cell to the next, or out of the grid.
    pub cells_traversed: u64,
}

impl Counts {
    /// Returns the number of rays of every kind.
    pub fn rays(&self) -> u64 {
        self.non_shadow_rays + self.shadow_rays
    }

    /// Returns the sum with the counts of another thread.
    pub fn merge(self, other: Self) -> Self {
        Self {
            non_shadow_rays: self.non_shadow_rays + other.non_shadow_rays,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            intersections: self.intersections + other.intersections,
            cells_traversed: self.cells_traversed + other.cells_traversed,
        }
    }
}

/// The time that each stage took.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Timings {
    /// Reading the scene and its meshes.
    #[serde(serialize_with = "seconds")]
    pub reading: Duration,
    /// Building the world and its grid.
    #[serde(serialize_with = "seconds")]
    pub building: Duration,
    /// Casting the rays.
    #[serde(serialize_with = "seconds")]
    pub rendering: Duration,
    /// Writing the pictures.
    #[serde(serialize_with = "seconds")]
    pub writing: Duration,
}

fn seconds<S: Serializer>(time: &Duration, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(time.as_secs_f64())
}

/// The times of a scene that was rendered several times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Repeats {
    /// The number of renders.
    pub times: usize,
    /// The minimum.
    #[serde(serialize_with = "seconds")]
    pub least: Duration,
    /// The middle time, or the mean of the two middle times.
    #[serde(serialize_with = "seconds")]
    pub median: Duration,
    /// The maximum minus the minimum.
    #[serde(serialize_with = "seconds")]
    pub spread: Duration,
}

impl Repeats {
    /// Summarizes the times of the first render and of the others.
    pub fn of(first: Duration, others: Vec<Duration>) -> Self {
        let mut times = others;
        times.push(first);
        times.sort();
        let (least, most) = (times[0], times[times.len() - 1]);
        let median = (times[(times.len() - 1) / 2] + times[times.len() / 2]) / 2;
        Self { times: times.len(), least, median, spread: most - least }
    }
}

impl fmt::Display for Repeats {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        line(f, "rendered", format!("{} times", self.times))?;
        line(f, "least", ms(self.least))?;
        line(f, "median", ms(self.median))?;
        line(f, "spread", ms(self.spread))
    }
}

fn line(f: &mut fmt::Formatter, label: &str, value: String) -> fmt::Result {
    writeln!(f, "  {label:<27}{value}")
}

fn ms(time: Duration) -> String {
    format!("{:.3} ms", time.as_secs_f64() * 1e3)
}

/// The course's statistics block, followed by a block with the time of each stage. `Display` prints both. The
/// first has the course's format byte for byte, except that its time has milliseconds.
#[derive(Clone, Debug)]
pub struct Report {
    /// The picture's width and height in pixels.
    pub size: [usize; 2],
    /// The bounding box of the finite primitives. `None` if the scene has no finite primitives.
    pub bounds: Option<Aabb>,
    /// The number of cells along each axis. `None` without a grid.
    pub grid: Option<[usize; 3]>,
    /// The events that were counted.
    pub counts: Counts,
    /// The time that each stage took.
    pub timings: Timings,
    /// The number of threads that rendered.
    pub threads: usize,
    /// The standard error of the colours in levels, if each pixel has several samples.
    pub standard_error: Option<f64>,
    /// The name of the course's edition. `None` for the 2004 edition, whose statistics are the first block.
    pub edition: Option<&'static str>,
}

pub(crate) const RULE: &str = "********************************************";

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let rays = self.counts.rays();
        let [width, height] = self.size;
        let pixels = width * height;
        writeln!(f, "{RULE}\nRAY TRACING STATISTICS")?;
        line(f, "total time", clock(self.timings.rendering))?;
        line(f, "num pixels", format!("{pixels} ({width}x{height})"))?;
        line(f, "scene bounds", self.bounds.map_or("NULL".into(), |b| corners(&b)))?;
        line(f, "num grid cells", self.grid.map_or("NULL".into(), cells))?;
        line(f, "num non-shadow rays", self.counts.non_shadow_rays.to_string())?;
        line(f, "num shadow rays", self.counts.shadow_rays.to_string())?;
        line(f, "total intersections", self.counts.intersections.to_string())?;
        line(f, "total cells traversed", self.counts.cells_traversed.to_string())?;
        line(f, "rays per second", ratio(rays as f64, self.timings.rendering.as_secs_f64()))?;
        line(f, "rays per pixel", ratio(rays as f64, pixels as f64))?;
        line(f, "intersections per ray", ratio(self.counts.intersections as f64, rays as f64))?;
        line(f, "cells traversed per ray", ratio(self.counts.cells_traversed as f64, rays as f64))?;
        writeln!(f, "{RULE}")?;
        self.edition.map_or(Ok(()), |edition| line(f, "edition", edition.into()))?;
        for (label, time) in [
            ("reading", self.timings.reading),
            ("building", self.timings.building),
            ("rendering", self.timings.rendering),
            ("writing", self.timings.writing),
        ] {
            line(f, label, ms(time))?;
        }
        line(f, "threads", self.threads.to_string())?;
        self.standard_error.map_or(Ok(()), |error| line(f, "standard error", format!("{error:.3} levels")))
    }
}

/// Formats the time as `H:MM:SS.mmm`, with unpadded hours.
fn clock(time: Duration) -> String {
    let ms = time.as_millis();
    let (s, m, h) = (ms / 1000, ms / 60_000, ms / 3_600_000);
    format!("{h}:{:02}:{:02}.{:03}", m % 60, s % 60, ms % 1000)
}

fn corners(b: &Aabb) -> String {
    let point = |p: glam::DVec3| format!("{:.6} {:.6} {:.6}", p.x, p.y, p.z);
    format!("{}  -> {}", point(b.min), point(b.max))
}

fn cells([x, y, z]: [usize; 3]) -> String {
    format!("{} ({x}x{y}x{z})", x * y * z)
}

/// Formats the quotient with one decimal. 0 / 0 gives 0.0, where the course's program would print `nan`.
fn ratio(part: f64, whole: f64) -> String {
    format!("{:.1}", if part == 0.0 { 0.0 } else { part / whole })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn report() -> Report {
        Report {
            size: [200, 100],
            bounds: Some(Aabb { min: DVec3::new(-0.191055, 0.067364, -1.0), max: DVec3::ONE }),
            grid: Some([10, 10, 7]),
            counts: Counts {
                non_shadow_rays: 20000,
                shadow_rays: 10000,
                intersections: 45000,
                cells_traversed: 9000,
            },
            timings: Timings { rendering: Duration::from_micros(62_500), ..Timings::default() },
            threads: 2,
            standard_error: None,
            edition: None,
        }
    }

    #[test]
    fn the_standard_error_stands_below_the_times() {
        assert!(report().to_string().ends_with("  threads                    2\n"));
        let text = Report { standard_error: Some(0.12345), ..report() }.to_string();
        assert!(
            text.ends_with("  threads                    2\n  standard error             0.123 levels\n")
        );
    }

    #[test]
    fn repeats_have_the_least_the_median_and_the_spread() {
        let of = |first, others: &[u64]| {
            let others = others.iter().map(|&ms| Duration::from_millis(ms)).collect();
            Repeats::of(Duration::from_millis(first), others)
        };
        let [least, median, spread] = [2, 4, 9].map(Duration::from_millis);
        assert_eq!(of(11, &[4, 2]), Repeats { times: 3, least, median, spread });
        assert_eq!(of(3, &[11, 5, 2]), Repeats { times: 4, least, median, spread });
        assert_eq!(of(2, &[]), Repeats { times: 1, least, median: least, spread: Duration::ZERO });
    }

    #[test]
    fn hours_are_not_padded() {
        assert_eq!(clock(Duration::from_millis(3_723_004)), "1:02:03.004");
        assert_eq!(clock(Duration::from_secs(36_000)), "10:00:00.000");
    }
}
