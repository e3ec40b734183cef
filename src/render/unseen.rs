//! What few samples of a pixel are likely to miss, so that adaptive sampling does not rely on them: what is known of the
//! picture without casting a ray.
//!
//! The outlines of all objects are projected onto the pixels: those edges of triangles that are not inside a surface, and
//! those of spheres and ellipsoids. What is narrower than a pixel may be visible in a part of it that no sample has hit.
//! The part that it covers is p at most, so that the variance of a sample is at most p (1 - p). What materials may show
//! beside what a sample has seen, such as highlights and mirrored or refracted images, has no such bounds; there is a
//! guess for each kind.
//!
//! All of this is part of what the picture means, since it decides where samples are taken, but not of its expected value.

use super::request::Request;
use crate::camera::{Camera, Eye, Projection};
use crate::memory::{self, NoMemory};
use crate::primitive::shape::Form;
use crate::scene::material::{Material, Phong};
use crate::trace::Effects;
use crate::world::{SurfacePoint, World};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;
use std::ops::Range;

/// What samples may miss in a picture.
pub struct Unseen {
    width: usize,
    /// The variance that each material may hide.
    hidden: Vec<f64>,
    outlines: Vec<Outline>,
    spots: Vec<Spot>,
}

/// The same for some rows.
pub struct UnseenRows {
    width: usize,
    first_row: usize,
    variances: Vec<f32>,
}

/// A straight part of an outline in the picture, in pixels from its lower left corner.
struct Outline {
    ends: [DVec2; 2],
    /// The width of what is beside it, if it is narrower than a pixel.
    width: f64,
}

/// A sphere or ellipsoid that is smaller than some pixels: its box in the picture.
struct Spot {
    min: DVec2,
    max: DVec2,
}

/// The square of a number of levels, the steps from one byte to the next.
const fn square_of_levels(levels: f64) -> f64 {
    (levels / 255.0) * (levels / 255.0)
}

/// The variances that are assumed where an outline is, and where a sample sees a mirror, clear glass, a highlight that is
/// narrow, or a texture. They were chosen by `examples/sampling_marks`.
const AT_OUTLINE: f64 = square_of_levels(16.0);
const IN_MIRROR: f64 = square_of_levels(6.0);
const IN_GLASS: f64 = square_of_levels(8.0);
const IN_HIGHLIGHT: f64 = square_of_levels(4.0);
const IN_TEXTURE: f64 = square_of_levels(6.0);

/// The exponent from which highlights are narrow.
const NARROW: f64 = 40.0;

/// Two triangles with an edge in common are one surface if the cosine of the angle of their normals is above this.
const ONE_SURFACE: f64 = 0.8;

/// A sphere whose diameter is smaller than this number of pixels is a spot.
const SPOT: f64 = 2.0;

/// How far an outline may be off, in pixels.
const ERROR: f64 = 1.0 / 16.0;

impl Unseen {
    /// For the whole picture of a request.
    pub fn new(camera: &Camera, world: &World, request: &Request) -> Result<Self, NoMemory> {
        let mut unseen = Self {
            width: request.size[0],
            hidden: hidden(&world.materials, &request.effects)?,
            outlines: vec![],
            spots: vec![],
        };
        let screen = Screen::new(camera, request.size);
        unseen.add_triangles(world, &screen)?;
        for (center, linear, _) in world.shapes.iter().filter_map(Form::unit_sphere_maps) {
            unseen.add_ellipsoid(center, linear, &screen)?;
        }
        Ok(unseen)
    }

    /// The variance that a sample may hide that sees this surface.
    pub fn hidden_by(&self, surface: &SurfacePoint) -> f64 {
        self.hidden.get(surface.material).copied().unwrap_or(0.0)
    }

    /// The same in these rows.
    pub fn rows(&self, rows: Range<usize>) -> Result<UnseenRows, NoMemory> {
        let mut variances = memory::filled(0.0f32, self.width * rows.len())?;
        let mut covered = |[x, y]: [usize; 2], part: f64| {
            let place = &mut variances[(y - rows.start) * self.width + x];
            // Covered parts are positive, and a place without any that is marked is negative.
            *place = if part > 0.0 { place.max(0.0) + part as f32 } else if *place > 0.0 { *place } else { -1.0 };
        };
        for outline in &self.outlines {
            outline.cover(self.width, &rows, &mut covered);
        }
        for spot in &self.spots {
            spot.cover(self.width, &rows, &mut covered);
        }
        for place in &mut variances {
            let part = f64::from(place.clamp(0.0, 0.5));
            let least = if *place == 0.0 { 0.0 } else { AT_OUTLINE };
            *place = (part * (1.0 - part)).max(least) as f32;
        }
        Ok(UnseenRows { width: self.width, first_row: rows.start, variances })
    }

    /// Adds the edges of triangles that are not inside a surface.
    fn add_triangles(&mut self, world: &World, screen: &Screen) -> Result<(), NoMemory> {
        let edges = Edges::new(world)?;
        let mut facings: Vec<Facing> = memory::with_room(world.triangles.len())?;
        facings.extend((0..world.triangles.len()).map(|triangle| Facing::new(world, triangle, screen)));
        for triangle in 0..world.triangles.len() {
            let is_shown = |k: usize| edges.is_outline(world, &facings, triangle, k);
            let shown = [0, 1, 2].map(is_shown);
            if shown == [false; 3] || !world.may_be_hit(triangle as u32) {
                continue;
            }
            let corners = world.corners(triangle);
            let on_screen = corners.map(|corner| screen.project(corner));
            let [Some(a), Some(b), Some(c)] = on_screen else {
                self.add_clipped(corners, shown, screen)?;
                continue;
            };
            let lengths = [(a, b), (b, c), (c, a)].map(|(a, b)| a.distance(b));
            let area = 0.5 * (b - a).perp_dot(c - a).abs();
            let narrowness = 1.0 - 2.0 * area / lengths.into_iter().fold(0.0, f64::max);
            let shown_length: f64 = (0..3).filter(|&k| shown[k]).map(|k| lengths[k]).sum();
            let width = if narrowness > 0.0 { narrowness * area / shown_length } else { 0.0 };
            for (k, ends) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
                if shown[k] && screen.may_show(&ends) {
                    memory::push(&mut self.outlines, Outline { ends, width })?;
                }
            }
        }
        Ok(())
    }

    /// Adds the edges of a triangle that is partly behind the eye.
    fn add_clipped(&mut self, [a, b, c]: [DVec3; 3], shown: [bool; 3], screen: &Screen) -> Result<(), NoMemory> {
        for (k, ends) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
            let clipped = screen.clip(ends).filter(|ends| shown[k] && screen.may_show(ends));
            if let Some(ends) = clipped {
                memory::push(&mut self.outlines, Outline { ends, width: 0.0 })?;
            }
        }
        Ok(())
    }

    /// Adds the image of the unit sphere under `p -> center + linear p`.
    fn add_ellipsoid(&mut self, center: DVec3, linear: DMat3, screen: &Screen) -> Result<(), NoMemory> {
        let Some([middle, right, up]) = outline_of_ellipsoid(center, linear, screen) else { return Ok(()) };
        let at = |angle: f64| screen.project(middle + libm::cos(angle) * right + libm::sin(angle) * up);
        let Some(seen) = screen.project(middle) else { return Ok(()) };
        let ends = [right, -right, up, -up].map(|way| screen.project(middle + way));
        let [Some(a), Some(b), Some(c), Some(d)] = ends else { return Ok(()) };
        // The box of an ellipse with these conjugate half axes.
        let half = (0.25 * ((a - b) * (a - b) + (c - d) * (c - d))).to_array().map(f64::sqrt);
        let half = DVec2::from_array(half);
        if 2.0 * half.min_element() < SPOT {
            let spot = Spot { min: seen - half, max: seen + half };
            return memory::push(&mut self.spots, spot);
        }
        // So many sides that they are off by the error that is allowed.
        let sides = (PI / (2.0 * ERROR / half.max_element()).sqrt()).ceil().clamp(8.0, 1e4) as usize;
        let corner = |side: usize| at(2.0 * PI * side as f64 / sides as f64);
        for side in 0..sides {
            let Some(ends) = corner(side).zip(corner(side + 1)) else { continue };
            let ends = ends.into();
            if screen.may_show(&ends) {
                memory::push(&mut self.outlines, Outline { ends, width: 0.0 })?;
            }
        }
        Ok(())
    }
}

impl UnseenRows {
    /// The variance of the samples in a pixel, for all that is known without them.
    pub fn variance(&self, [column, row]: [usize; 2]) -> f64 {
        let place = row.checked_sub(self.first_row).map(|row| row * self.width + column);
        place.and_then(|place| self.variances.get(place)).map_or(0.0, |&variance| f64::from(variance))
    }
}

/// The variance that each material may hide.
fn hidden(materials: &[Material], effects: &Effects) -> Result<Vec<f64>, NoMemory> {
    let mut hidden: Vec<f64> = memory::with_room(materials.len())?;
    for material in materials {
        let variance = match material {
            Material::Phong(phong) => hidden_by_phong(phong, effects),
            Material::Texture(texture) => {
                texture.children.iter().filter_map(|&child| hidden.get(child)).fold(IN_TEXTURE, |a, b| a.max(*b))
            }
        };
        hidden.push(variance);
    }
    Ok(hidden)
}

fn hidden_by_phong(phong: &Phong, effects: &Effects) -> f64 {
    let square = |color: DVec3| color.max_element().min(1.0).powi(2);
    let highlight = if phong.exponent >= NARROW { IN_HIGHLIGHT * square(phong.specular) } else { 0.0 };
    let secondary = IN_MIRROR * square(phong.reflective) + IN_GLASS * square(phong.transparent);
    highlight + if effects.bounces > 0 { secondary } else { 0.0 }
}

/// The picture that things are projected onto.
struct Screen {
    eye: Eye,
    is_perspective: bool,
    axes: [DVec3; 2],
    size: DVec2,
}

impl Screen {
    fn new(camera: &Camera, size: [usize; 2]) -> Self {
        let (eye, is_perspective) = match camera.projection() {
            Projection::Perspective(eye) => (eye, true),
            Projection::Orthographic(eye) => (eye, false),
        };
        let axes = [eye.right, eye.up].map(|axis| axis / axis.length_squared());
        Self { eye, is_perspective, axes, size: DVec2::from_array(size.map(|side| side as f64)) }
    }

    /// Where a point is in the picture; none if it is not ahead of the eye.
    fn project(&self, point: DVec3) -> Option<DVec2> {
        let point = point - self.eye.center;
        let across = DVec2::new(point.dot(self.axes[0]), point.dot(self.axes[1]));
        let depth = if self.is_perspective { point.dot(self.eye.direction) } else { 1.0 };
        let at = across / depth + self.eye.middle + 0.5;
        (depth > 0.0 && at.is_finite()).then_some(at)
    }

    /// The part of an edge that is ahead of the eye; none if there is none.
    fn clip(&self, [a, b]: [DVec3; 2]) -> Option<[DVec2; 2]> {
        let depths = [a, b].map(|point| (point - self.eye.center).dot(self.eye.direction));
        // Something nearer than this share of the edge's extent is beside the picture.
        let nearest = 1e-9 * (depths[0] - depths[1]).abs();
        if depths[0].max(depths[1]) <= nearest {
            return None;
        }
        let ahead = |from: usize, point: DVec3, other: DVec3| {
            let share = (nearest - depths[from]) / (depths[1 - from] - depths[from]);
            if depths[from] >= nearest { point } else { point + share * (other - point) }
        };
        let (a, b) = (ahead(0, a, b), ahead(1, b, a));
        Some([self.project(a)?, self.project(b)?])
    }

    /// Whether a line may have a part in the picture.
    fn may_show(&self, [a, b]: &[DVec2; 2]) -> bool {
        let (min, max) = (a.min(*b) - ERROR, a.max(*b) + ERROR);
        max.cmpge(DVec2::ZERO).all() && min.cmple(self.size).all()
    }

    /// The way from a point to the eye, with an eye infinitely far away in parallel views.
    fn to_eye(&self, point: DVec3) -> DVec3 {
        if self.is_perspective { self.eye.center - point } else { -self.eye.direction }
    }
}

/// The outline of the image of the unit sphere as an ellipse in space: its middle and two conjugate half axes. None if
/// the eye is inside.
fn outline_of_ellipsoid(center: DVec3, linear: DMat3, screen: &Screen) -> Option<[DVec3; 3]> {
    // In the space of the unit sphere the outline is a circle.
    let to_eye = linear.inverse() * screen.to_eye(center);
    let square = to_eye.length_squared();
    let (middle, radius) = if screen.is_perspective {
        if square.is_nan() || square <= 1.0 {
            return None;
        }
        (to_eye / square, (1.0 - 1.0 / square).sqrt())
    } else {
        (DVec3::ZERO, 1.0)
    };
    let right = to_eye.try_normalize()?.any_orthonormal_vector();
    let up = to_eye.normalize().cross(right);
    Some([center + linear * middle, linear * (radius * right), linear * (radius * up)])
}

impl Outline {
    /// Tells the pixels of the rows that the line touches, and the part of each that is covered by what is beside it.
    fn cover(&self, width: usize, rows: &Range<usize>, covered: &mut impl FnMut([usize; 2], f64)) {
        let [low, high] = if self.ends[0].y <= self.ends[1].y { self.ends } else { [self.ends[1], self.ends[0]] };
        let (way, length) = (high - low, low.distance(high));
        for y in within(low.y - ERROR, high.y + ERROR, rows) {
            let share = |y: f64| if way.y > 0.0 { ((y - low.y) / way.y).clamp(0.0, 1.0) } else { 0.0 };
            let (from, to) = (share(y as f64), share((y + 1) as f64));
            let (from, to) = if way.y > 0.0 { (from, to) } else { (0.0, 1.0) };
            let [a, b] = [low.x + from * way.x, low.x + to * way.x];
            let (left, right) = (a.min(b), a.max(b));
            let in_row = length * (to - from);
            for x in within(left - ERROR, right + ERROR, &(0..width)) {
                let inside = (right.min((x + 1) as f64) - left.max(x as f64)).max(0.0);
                let part = if right > left { inside / (right - left) } else if inside_pixel(left, x) { 1.0 } else { 0.0 };
                covered([x, y], self.width * in_row * part);
            }
        }
    }
}

fn inside_pixel(at: f64, pixel: usize) -> bool {
    at.floor() == pixel as f64
}

/// Those of some columns or rows that have a part between two places.
fn within(from: f64, to: f64, pixels: &Range<usize>) -> Range<usize> {
    // Numbers that are too large or small for an integer become the nearest one.
    let (first, last) = (from.floor() as i64, to.floor() as i64);
    let end = usize::try_from(last.saturating_add(1)).unwrap_or(0).min(pixels.end);
    usize::try_from(first).unwrap_or(0).max(pixels.start)..end
}

impl Spot {
    /// Tells the pixels of the rows that its box touches, and the part of each that it covers, if it covers as much of all
    /// parts of its box.
    fn cover(&self, width: usize, rows: &Range<usize>, covered: &mut impl FnMut([usize; 2], f64)) {
        let inside = |axis: usize, pixel: usize| {
            let (from, to) = (self.min[axis].max(pixel as f64), self.max[axis].min((pixel + 1) as f64));
            (to - from).max(0.0)
        };
        for y in within(self.min.y - ERROR, self.max.y + ERROR, rows) {
            for x in within(self.min.x - ERROR, self.max.x + ERROR, &(0..width)) {
                covered([x, y], PI / 4.0 * inside(0, x) * inside(1, y));
            }
        }
    }
}

/// Whether and how a triangle faces the eye.
struct Facing {
    normal: DVec3,
    is_front: bool,
}

impl Facing {
    fn new(world: &World, triangle: usize, screen: &Screen) -> Self {
        let [a, b, c] = world.corners(triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        Self { normal, is_front: normal.dot(screen.to_eye(a)) > 0.0 }
    }
}

/// The triangles at each edge.
struct Edges {
    /// For each vertex the first of the edges that begin at it, and the number of all edges.
    starts: Vec<u32>,
    /// The other end of each edge, and a triangle.
    edges: Vec<(u32, u32)>,
}

/// The ends of a side of a triangle, the smaller one first.
fn side(triangle: &[u32; 3], k: usize) -> [u32; 2] {
    let [a, b] = [triangle[k], triangle[(k + 1) % 3]];
    [a.min(b), a.max(b)]
}

impl Edges {
    fn new(world: &World) -> Result<Self, NoMemory> {
        let mut starts = memory::filled(0u32, world.vertices.len() + 1)?;
        let sides = || world.triangles.iter().zip(0u32..).flat_map(|(t, id)| [0, 1, 2].map(|k| (side(t, k), id)));
        for ([start, _], _) in sides() {
            starts[start as usize + 1] += 1;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut edges = memory::filled((0u32, 0u32), 3 * world.triangles.len())?;
        let mut next = memory::copied(&starts)?;
        for ([start, end], triangle) in sides() {
            let place = &mut next[start as usize];
            edges[*place as usize] = (end, triangle);
            *place += 1;
        }
        Ok(Self { starts, edges })
    }

    /// Whether a side of a triangle is not inside a surface: there are not just two triangles at it, or they have different
    /// materials, or one is seen from the front and the other from behind, or they meet at an angle.
    fn is_outline(&self, world: &World, facings: &[Facing], triangle: usize, k: usize) -> bool {
        let [start, end] = side(&world.triangles[triangle], k);
        let range = self.starts[start as usize] as usize..self.starts[start as usize + 1] as usize;
        let mut others = self.edges[range].iter().filter(|edge| edge.0 == end && edge.1 != triangle as u32);
        let (Some(&(_, other)), None) = (others.next(), others.next()) else { return true };
        let [one, another] = [&facings[triangle], &facings[other as usize]];
        one.is_front != another.is_front
            || one.normal.dot(another.normal) < ONE_SURFACE
            || world.material_of(triangle as u32) != world.material_of(other)
    }
}

#[cfg(test)]
mod tests;
