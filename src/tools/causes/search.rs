//! Judges mistakes by the pixels that they make right.
//!
//! A pixel is right if it is the picture's colour up to rounding, or up to one level more. A mistake is accepted if it
//! makes most of the wrong pixels right, and shows wherever it can. It is all that is wrong if few other pixels differ,
//! nearly all of them at edges, where a tracer in single precision sees the neighbouring surface.

use super::finding::Finding;
use super::mistakes::Mistake;
use super::window::{part, part_of_rows};
use crate::picture::{Color, FloatPicture, Picture, Window};
use crate::tools::compare::{EdgeMap, Rgb, Tolerance, colors, largest_channel_difference};
use std::borrow::Cow;
use std::cell::LazyCell;
use std::rc::Rc;

/// The largest error of a colour in single precision, in levels.
const ROUNDING: f64 = 1.0 / 64.0;
/// The largest share of all pixels that single precision changes by more than one level at edges.
const AT_EDGES: f64 = 0.005;
/// The largest such share elsewhere.
const ELSEWHERE: f64 = 0.001;
/// The largest share of all pixels that single precision changes by one level more than rounding.
const BY_A_LEVEL: f64 = 0.01;
/// The largest such share if a mistake explains the other differences. Other tracers compute their own way.
pub const BY_A_LEVEL_AND_MISTAKE: f64 = 0.2;
/// The smallest share of the wrong pixels that a mistake makes right, and the smallest share of the pixels changed by
/// it. A change that is only similar to the mistake leaves an error in the same pixels.
const MIN_SHARES: [f64; 2] = [0.6, 0.75];
/// The smallest such shares of a mistake that makes nearly all right that it changes. Other mistakes show in the rest.
const MIN_SHARES_IF_PRECISE: [f64; 2] = [1.0 / 3.0, 0.98];
/// The smallest such shares if hardly any pixel is visibly wrong. Many mistakes make half of the pixels right that are
/// wrong by a level.
const MIN_SHARES_BY_A_LEVEL: [f64; 2] = [0.9, 0.75];
/// The largest share of the pixels changed by a mistake that may be right without it. A mistake shows where it can.
const MAX_CONTRADICTED: f64 = 0.03;
/// The largest such share for rays that hit the surface that they leave. Rounding spares some of them.
const MAX_CONTRADICTED_BY_ROUNDING: f64 = 0.2;
/// Every mistake of another kind must leave at least this many times as many wrong pixels.
const MIN_LEAD: f64 = 2.0;

/// A picture, and the bytes of its pixels if rounding changes its colours.
pub struct Made {
    picture: Picture,
    low: Vec<Rgb>,
    high: Vec<Rgb>,
}

impl Made {
    pub fn new(made: &FloatPicture) -> Self {
        let moved = |levels: f64| {
            let pixel = |color: &Color| color.to_array().map(|channel| (255.0 * channel + levels) as u8);
            made.colors.iter().map(pixel).collect()
        };
        Self { picture: made.to_picture(), low: moved(-ROUNDING), high: moved(ROUNDING) }
    }

    /// Returns the part in a window.
    pub fn in_window(&self, window: Window) -> Self {
        let width = self.picture.width() as usize;
        let [low, high] = [&self.low, &self.high].map(|pixels| part_of_rows(pixels, width, window));
        Self { picture: part(&self.picture, window), low, high }
    }

    /// Returns the levels by which a pixel differs by more than rounding.
    fn levels(&self, at: usize, pixel: Rgb) -> u8 {
        let levels = |channel: usize| {
            let (byte, low, high) = (pixel[channel], self.low[at][channel], self.high[at][channel]);
            low.saturating_sub(byte).max(byte.saturating_sub(high))
        };
        levels(0).max(levels(1)).max(levels(2))
    }

    /// Returns the levels by which the pixels of a picture differ by more than rounding.
    pub fn all_levels(&self, picture: &Picture) -> Vec<u8> {
        colors(picture).iter().enumerate().map(|(at, &pixel)| self.levels(at, pixel)).collect()
    }

    /// Returns true if the pictures are equal up to rounding.
    pub fn is_like(&self, other: &Self) -> bool {
        colors(&other.picture).iter().enumerate().all(|(at, &pixel)| self.levels(at, pixel) == 0)
    }
}

/// The pixels of a wrong picture that a picture leaves wrong.
#[derive(Clone, Copy, Debug, Default)]
struct Rest {
    differing: u64,
    differing_at_edges: u64,
    /// By more than rounding.
    beyond_rounding: u64,
    /// By more than one level.
    visible: u64,
    visible_at_edges: u64,
}

impl Rest {
    fn of(wrong: &Picture, made: &Made) -> Self {
        let mut rest = Self::default();
        let width = wrong.width() as usize;
        let pairs = colors(wrong).iter().zip(colors(&made.picture)).enumerate();
        let mut edges = None;
        for (at, (&pixel, &right)) in pairs.filter(|(_, (pixel, right))| pixel != right) {
            let edges = edges.get_or_insert_with(|| EdgeMap::new(&made.picture));
            let is_at_edge = u64::from(edges.is_near_edge(at % width, at / width));
            let is_visible = u64::from(largest_channel_difference(pixel, right) > 1);
            rest.differing += 1;
            rest.differing_at_edges += is_at_edge;
            rest.beyond_rounding += u64::from(made.levels(at, pixel) > 0);
            rest.visible += is_visible;
            rest.visible_at_edges += is_visible * is_at_edge;
        }
        rest
    }

    /// Returns true if a tracer in single precision leaves that much visibly wrong in a picture of this many pixels.
    fn is_hardly_visible(&self, pixels: f64) -> bool {
        let elsewhere = self.visible - self.visible_at_edges;
        self.visible_at_edges as f64 <= AT_EDGES * pixels && elsewhere as f64 <= ELSEWHERE * pixels
    }

    /// Returns true if also no more than this share of the pixels is wrong by a level.
    fn is_small(&self, pixels: f64, by_a_level: f64) -> bool {
        let by_level = self.beyond_rounding.saturating_sub(self.visible) as f64;
        self.is_hardly_visible(pixels) && by_level <= by_a_level * pixels
    }

    /// Returns the number of wrong pixels. The visible ones count twice.
    fn size(&self) -> u64 {
        self.beyond_rounding + self.visible
    }
}

/// Mistakes made together that explain at least part of a difference.
struct Candidate {
    mistakes: Vec<Mistake>,
    made: Rc<Made>,
    rest: Rest,
    /// The share of the wrong pixels that they make right.
    share: f64,
}

/// The search for the cause of one picture.
pub struct Search<'p> {
    wrong: Cow<'p, Picture>,
    reference: Rc<Made>,
    /// The levels by which each pixel differs from the reference by more than rounding.
    differences: Vec<u8>,
    whole: Rest,
    /// A pixel is wrong if it differs by more levels than that besides rounding: one if many pixels do, or else none.
    level: u8,
    candidates: Vec<Candidate>,
    /// The mistakes tried in this picture, one by one and together.
    tried: Vec<Vec<Mistake>>,
    /// The single mistakes tried that show, also in windows.
    shown: Vec<Mistake>,
}

impl<'p> Search<'p> {
    pub fn new(wrong: Cow<'p, Picture>, reference: Rc<Made>) -> Self {
        let (whole, differences) = (Rest::of(&wrong, &reference), reference.all_levels(&wrong));
        let level = u8::from(!whole.is_hardly_visible(differences.len() as f64));
        Self { wrong, reference, differences, whole, level, candidates: vec![], tried: vec![], shown: vec![] }
    }

    pub fn reference(&self) -> &Made {
        &self.reference
    }

    /// Returns a search in a window of the picture that knows the best single mistake. `reference` is the reference's
    /// part.
    pub fn in_window(&self, window: Window, reference: Rc<Made>) -> Search<'static> {
        let mut search = Search::new(Cow::Owned(part(&self.wrong, window)), reference);
        search.level = self.level;
        if let Some(best) = self.best_of(1) {
            search.add(&best.mistakes, Rc::new(best.made.in_window(window)), best.share);
        }
        search
    }

    fn add(&mut self, mistakes: &[Mistake], made: Rc<Made>, share: f64) {
        let rest = Rest::of(&self.wrong, &made);
        self.candidates.push(Candidate { mistakes: mistakes.to_vec(), made, rest, share });
    }

    /// Tries mistakes whose picture differs by `changes` from the reference.
    pub fn try_mistakes(&mut self, mistakes: &[Mistake], made: &Rc<Made>, changes: &[u8]) {
        if mistakes.len() == 1 {
            self.add_shown(mistakes);
        }
        // Count the pixels that are wrong, remain wrong, are changed, become or remain right, and become wrong.
        let (mut wrong, mut left, mut changed, mut right, mut contradicted) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (at, (&before, &change)) in self.differences.iter().zip(changes).enumerate() {
            let after = made.levels(at, colors(&self.wrong)[at]);
            let [is_wrong, is_left, is_changed] = [before, after, change].map(|levels| levels > self.level);
            wrong += f64::from(is_wrong);
            left += f64::from(is_left);
            changed += f64::from(is_changed);
            right += f64::from(is_changed && !is_left);
            contradicted += f64::from(is_changed && is_left && !is_wrong);
        }
        // The quotients are NaN if nothing is wrong or changed.
        let (share, precision) = (1.0 - left / wrong, right / changed);
        let explains =
            |[min_share, min_precision]: [f64; 2]| share >= min_share && precision >= min_precision;
        let max_contradicted = match mistakes {
            [Mistake::NoEpsilon { .. }] => MAX_CONTRADICTED_BY_ROUNDING,
            _ => MAX_CONTRADICTED,
        };
        let is_meant = match self.level {
            0 => explains(MIN_SHARES_BY_A_LEVEL),
            _ => explains(MIN_SHARES) || explains(MIN_SHARES_IF_PRECISE),
        };
        if is_meant && contradicted <= max_contradicted * changed + ELSEWHERE * self.pixels() {
            self.add(mistakes, made.clone(), share);
        }
    }

    fn pixels(&self) -> f64 {
        self.differences.len() as f64
    }

    /// Returns the levels by which each pixel differs by more than rounding from the picture of the best single mistake,
    /// or else from the reference.
    pub fn left(&self) -> Vec<u8> {
        self.best_of(1).map_or(&self.reference, |best| &best.made).all_levels(&self.wrong)
    }

    /// Returns the mistakes that may explain more of a larger picture than all others: single ones that the best one
    /// does not lead, and better pairs.
    pub fn likely(&self) -> impl Iterator<Item = &[Mistake]> {
        let size = |candidate: &Candidate| candidate.rest.size() as f64;
        let single = self.best_of(1).map_or(self.whole.size() as f64, size);
        let best = self.best_of(2).map_or(0.0, size);
        // A window at an edge shows more than its share of the pixels that single precision changes.
        let at_edges = AT_EDGES * self.pixels() + 2.0;
        let is_likely = move |candidate: &&Candidate| match candidate.mistakes.len() {
            1 => size(candidate) <= MIN_LEAD * (single + at_edges),
            _ => size(candidate) <= (MIN_LEAD * (best + at_edges)).min(single / MIN_LEAD + at_edges),
        };
        self.candidates.iter().filter(is_likely).map(|candidate| candidate.mistakes.as_slice())
    }

    /// Returns the single mistakes tried that show, also in windows.
    pub fn shown(&self) -> &[Mistake] {
        &self.shown
    }

    /// Adds single mistakes that show in a window.
    pub fn add_shown(&mut self, mistakes: &[Mistake]) {
        for &mistake in mistakes {
            if !self.shown.contains(&mistake) {
                self.shown.push(mistake);
            }
        }
    }

    /// Returns the single mistake that explains the most.
    pub fn best(&self) -> Option<Mistake> {
        self.best_of(1).map(|best| best.mistakes[0])
    }

    /// Returns the best of the candidates with at most this many mistakes, the first of several equally good ones.
    fn best_of(&self, most: usize) -> Option<&Candidate> {
        let all = self.candidates.iter().filter(|candidate| candidate.mistakes.len() <= most);
        all.min_by_key(|candidate| (candidate.rest.size(), candidate.rest.differing))
    }

    /// Returns true if the answer is final.
    pub fn is_settled(&self) -> bool {
        // Mistakes in the finished picture are tried first. They may resemble others.
        let has_tried_others = || self.shown.iter().any(|mistake| !mistake.is_of_pixels());
        match self.finding() {
            Finding::Equal { pixels: 0, .. } => true,
            Finding::Equal { .. } | Finding::Rounding { .. } => has_tried_others(),
            _ => false,
        }
    }

    /// Returns the answer of the mistakes tried so far.
    pub fn finding(&self) -> Finding {
        let whole = &self.whole;
        let is_rounding = whole.is_small(self.pixels(), BY_A_LEVEL);
        for best in [1, 2].into_iter().filter_map(|count| self.best_of(count)) {
            let rest = &best.rest;
            // No mistake is needed if rounding explains the difference, unless the mistake gives the very picture.
            let is_better = !is_rounding || rest.differing == 0 || 10 * rest.size() <= whole.size();
            if is_better && rest.is_small(self.pixels(), BY_A_LEVEL_AND_MISTAKE) {
                return Finding::Equal {
                    cause: best.mistakes[0],
                    also: best.mistakes[1..].to_vec(),
                    same: self.same(best),
                    pixels: rest.differing,
                    by_more_than_one_level: rest.visible,
                    at_edges: rest.differing_at_edges,
                };
            }
        }
        match self.best_of(1).filter(|best| self.leads(best)) {
            _ if is_rounding => Finding::Rounding {
                pixels: whole.differing,
                at_edges: whole.differing_at_edges,
                tolerance: tolerance(whole),
            },
            Some(best) => Finding::Part { cause: best.mistakes[0], share: best.share },
            None => Finding::Unknown { tried: self.shown.len() },
        }
    }

    /// Returns the single mistakes other than the best, each with its picture.
    fn others<'s>(&'s self, best: &'s Candidate) -> impl Iterator<Item = (Mistake, &'s Candidate)> {
        let is_other = |mistake: Mistake| best.mistakes.iter().all(|named| !named.is_akin(mistake));
        self.candidates.iter().filter_map(move |other| match other.mistakes[..] {
            [mistake] if is_other(mistake) => Some((mistake, other)),
            _ => None,
        })
    }

    /// Returns the other mistakes whose picture is the same up to rounding.
    fn same(&self, best: &Candidate) -> Vec<Mistake> {
        let mut same: Vec<Mistake> = vec![];
        for (mistake, _) in self.others(best).filter(|(_, other)| other.made.is_like(&best.made)) {
            if !same.iter().any(|named| named.is_akin(mistake)) {
                same.push(mistake);
            }
        }
        same
    }

    /// Returns true if no mistake of another kind explains about as much.
    fn leads(&self, best: &Candidate) -> bool {
        let bound = MIN_LEAD * best.rest.size() as f64;
        let leads_over =
            |other: &Candidate| other.rest.size() as f64 >= bound || other.made.is_like(&best.made);
        self.others(best).all(|(_, other)| leads_over(other))
    }
}

/// Returns a tolerance with round numbers that accepts a difference.
fn tolerance(rest: &Rest) -> Tolerance {
    let rounds = (1..).flat_map(|power| [1, 2, 5].map(|digit| digit * 10_u64.pow(power)));
    let pixels =
        if rest.visible == 0 { 0 } else { rounds.take(30).find(|&n| n >= rest.visible).unwrap_or(u64::MAX) };
    Tolerance { levels: 1.0, pixels }
}

/// Tries all of these mistakes in each search that has not tried them. Skips those that cannot be seen in the reference.
pub fn try_all<'m>(
    all: impl IntoIterator<Item = &'m [Mistake]>,
    make: impl Fn(&[Mistake]) -> Option<FloatPicture>,
    searches: &mut [&mut Search],
) {
    let Some(reference) = searches.first().map(|search| search.reference.clone()) else { return };
    let own = LazyCell::new(|| make(&[Mistake::Unchanged]).map(|own| Made::new(&own)));
    let shows = |mistakes: &[Mistake], made: &Made| {
        let is_own = || own.as_ref().is_some_and(|own| own.is_like(made));
        !reference.is_like(made) && (mistakes == [Mistake::Unchanged] || !is_own())
    };
    for mistakes in all {
        let is_new = |search: &&mut &mut Search| !search.tried.iter().any(|tried| tried == mistakes);
        let mut searches: Vec<&mut &mut Search> = searches.iter_mut().filter(is_new).collect();
        if searches.is_empty() {
            continue;
        }
        searches.iter_mut().for_each(|search| search.tried.push(mistakes.to_vec()));
        let made = make(mistakes).map(|made| Rc::new(Made::new(&made)));
        if let Some(made) = made.filter(|made| shows(mistakes, made)) {
            let changes = reference.all_levels(&made.picture);
            searches.iter_mut().for_each(|search| search.try_mistakes(mistakes, &made, &changes));
        }
    }
}
