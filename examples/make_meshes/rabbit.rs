//! A sitting rabbit, modelled as the zero surface of a blend of simple solids.
//!
//! The rabbit's own frame: the nose points along +x, up is +y, its feet stand
//! on y = 0, and it is about one unit high. Distances are negative inside.
//! The distances to ellipsoids and capsules and the blend follow Quilez,
//! "Distance functions" and "Smooth minimum".

use glam::{DVec3, dvec3};

/// A solid that the rabbit is made of.
enum Shape {
    /// An ellipsoid around `frame`'s origin.
    Ellipsoid { frame: Frame, radii: DVec3 },
    /// A capsule whose radius goes from `from.1` to `to.1`.
    Limb { from: (DVec3, f64), to: (DVec3, f64) },
    /// A leaf around `frame`'s origin: an ellipsoid curled around its long axis
    /// y and bent along it, so that the side towards +z is hollow.
    Leaf { frame: Frame, radii: DVec3, curl: f64, bend: f64 },
}

/// A solid, and the width of its blend with those before it.
struct Part {
    shape: Shape,
    blend: f64,
}

/// A position and three perpendicular unit axes.
struct Frame {
    origin: DVec3,
    axes: [DVec3; 3],
}

/// All parts of the rabbit, in the order in which they are merged.
pub struct Rabbit {
    /// Torso, limbs and tail: those in the middle, and one of each pair, at z > 0.
    body: Vec<Part>,
    /// Skull and face, given like `body` but in the frame of the turned head.
    head: Vec<Part>,
    head_frame: Frame,
    /// The ears in the head's frame, each with a pose of its own.
    ears: Vec<Part>,
}

/// The width of the blend of head and neck.
const NECK_BLEND: f64 = 0.09;
/// The height of the highest tufts of fur.
const FUR_HEIGHT: f64 = 0.0018;

impl Rabbit {
    pub fn new() -> Self {
        Self { body: body(), head: head(), head_frame: head_frame(), ears: ears() }
    }

    /// An approximation of the signed distance from the rabbit's surface.
    pub fn distance(&self, point: DVec3) -> f64 {
        let body = merge(f64::INFINITY, &self.body, mirror(point));
        let in_head = self.head_frame.local(point);
        let head = merge(f64::INFINITY, &self.head, mirror(in_head));
        let head = merge(head, &self.ears, in_head);
        let whole = smooth_min(body, head, NECK_BLEND) + fur(point);
        // The feet stand flat on the ground.
        whole.max(-point.y)
    }

    /// The weight of an error at a point. It is larger at the head and the ears, by which a coarse mesh is
    /// recognised as a rabbit.
    pub fn importance(&self, point: DVec3) -> f64 {
        let height = ((point.y - 0.45) / 0.2).clamp(0.0, 1.0);
        1.0 + 2.0 * height
    }
}

/// Torso, limbs and tail.
fn body() -> Vec<Part> {
    vec![
        // Rump and back, a broad egg that rises towards the shoulders.
        ellipsoid(dvec3(-0.13, 0.27, 0.0), dvec3(0.31, 0.255, 0.215), 0.35, 0.0),
        ellipsoid(dvec3(0.10, 0.32, 0.0), dvec3(0.17, 0.22, 0.165), 0.25, 0.12),
        ellipsoid(dvec3(-0.08, 0.10, 0.0), dvec3(0.27, 0.14, 0.17), 0.0, 0.10),
        limb((0.12, 0.40, 0.0), 0.135, (0.25, 0.52, 0.0), 0.10, 0.10),
        // Haunch and hind foot.
        ellipsoid(dvec3(-0.17, 0.195, 0.165), dvec3(0.185, 0.175, 0.105), -0.3, 0.035),
        limb((-0.26, 0.045, 0.20), 0.062, (0.05, 0.035, 0.225), 0.055, 0.03),
        // Front leg and paw.
        limb((0.17, 0.27, 0.085), 0.075, (0.225, 0.05, 0.088), 0.052, 0.05),
        ellipsoid(dvec3(0.255, 0.03, 0.09), dvec3(0.085, 0.05, 0.055), 0.0, 0.03),
        // Tail.
        ellipsoid(dvec3(-0.435, 0.20, 0.0), dvec3(0.085, 0.085, 0.08), 0.0, 0.03),
    ]
}

/// The head sits on the neck and looks aside, towards the camera.
fn head_frame() -> Frame {
    Frame::new(dvec3(0.275, 0.54, 0.0), 0.42, -0.12)
}

/// Skull and face; the origin is the middle of the skull.
fn head() -> Vec<Part> {
    vec![
        ellipsoid(dvec3(0.0, 0.0, 0.0), dvec3(0.165, 0.135, 0.12), -0.15, 0.0),
        ellipsoid(dvec3(0.115, -0.04, 0.0), dvec3(0.09, 0.075, 0.07), -0.2, 0.06),
        // Cheek, whisker pad and nose.
        ellipsoid(dvec3(0.04, -0.055, 0.065), dvec3(0.085, 0.075, 0.06), 0.0, 0.05),
        ellipsoid(dvec3(0.16, -0.06, 0.028), dvec3(0.045, 0.036, 0.034), 0.0, 0.02),
        ellipsoid(dvec3(0.198, -0.028, 0.0), dvec3(0.022, 0.017, 0.022), 0.0, 0.015),
        // Brow and eye.
        ellipsoid(dvec3(0.07, 0.055, 0.085), dvec3(0.05, 0.025, 0.025), -0.4, 0.03),
        ellipsoid(dvec3(0.078, 0.025, 0.098), dvec3(0.028, 0.028, 0.023), 0.0, 0.004),
    ]
}

/// The two ears; the one away from the camera stands more upright.
fn ears() -> Vec<Part> {
    vec![ear(-1.0, 0.72, 0.18), ear(1.0, 0.46, 0.24)]
}

/// An ear on one side (-1 or 1 along z), tilted back and outwards by angles.
fn ear(side: f64, back: f64, out: f64) -> Part {
    let root = dvec3(-0.04, 0.09, 0.055 * side);
    let up = dvec3(-libm::sin(back), libm::cos(back), side * libm::sin(out)).normalize();
    // The hollow looks to the front and a little to the ear's own side.
    let front = dvec3(0.95, 0.0, 0.32 * side);
    let across = up.cross(front).normalize();
    let frame = Frame { origin: root + up * 0.142, axes: [across, up, across.cross(up)] };
    let shape = Shape::Leaf { frame, radii: dvec3(0.072, 0.180, 0.032), curl: 8.0, bend: 0.5 };
    Part { shape, blend: 0.025 }
}

/// An ellipsoid whose x axis is raised by an angle.
fn ellipsoid(center: DVec3, radii: DVec3, pitch: f64, blend: f64) -> Part {
    Part { shape: Shape::Ellipsoid { frame: Frame::new(center, 0.0, pitch), radii }, blend }
}

/// A capsule of two radii, from one end to the other.
fn limb(from: (f64, f64, f64), radius: f64, to: (f64, f64, f64), end_radius: f64, blend: f64) -> Part {
    Part { shape: Shape::Limb { from: (from.into(), radius), to: (to.into(), end_radius) }, blend }
}

impl Frame {
    /// A frame whose x axis is turned from +x towards -z and then raised.
    fn new(origin: DVec3, yaw: f64, pitch: f64) -> Self {
        let flat = dvec3(libm::cos(yaw), 0.0, -libm::sin(yaw));
        let x = flat * libm::cos(pitch) + DVec3::Y * libm::sin(pitch);
        let z = flat.cross(DVec3::Y);
        Self { origin, axes: [x, z.cross(x), z] }
    }

    fn local(&self, point: DVec3) -> DVec3 {
        let offset = point - self.origin;
        DVec3::from(self.axes.map(|axis| axis.dot(offset)))
    }
}

impl Shape {
    fn distance(&self, point: DVec3) -> f64 {
        match self {
            Self::Ellipsoid { frame, radii } => ellipsoid_distance(frame.local(point), *radii),
            Self::Limb { from, to } => limb_distance(point, *from, *to),
            Self::Leaf { frame, radii, curl, bend } => {
                let local = frame.local(point);
                let lift = curl * local.x * local.x - bend * local.y * local.y;
                ellipsoid_distance(local - DVec3::Z * lift, *radii)
            }
        }
    }
}

/// The distance from an ellipsoid, exact to first order near its surface.
fn ellipsoid_distance(point: DVec3, radii: DVec3) -> f64 {
    let scaled = (point / radii).length();
    let slope = (point / (radii * radii)).length();
    if slope == 0.0 { -radii.min_element() } else { scaled * (scaled - 1.0) / slope }
}

fn limb_distance(point: DVec3, (from, start): (DVec3, f64), (to, end): (DVec3, f64)) -> f64 {
    let axis = to - from;
    let along = ((point - from).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
    (point - from - axis * along).length() - (start + (end - start) * along)
}

/// Merges parts one after the other into what is there.
fn merge(start: f64, parts: &[Part], point: DVec3) -> f64 {
    parts.iter().fold(start, |whole, part| smooth_min(whole, part.shape.distance(point), part.blend))
}

/// The smaller of two distances, rounded where they differ by less than `blend`.
fn smooth_min(a: f64, b: f64, blend: f64) -> f64 {
    let overlap = (blend - (a - b).abs()).max(0.0);
    let rounding = if overlap > 0.0 { overlap * overlap / (4.0 * blend) } else { 0.0 };
    a.min(b) - rounding
}

/// The point's image on the side of z > 0, where the paired parts are given.
fn mirror(point: DVec3) -> DVec3 {
    dvec3(point.x, point.y, point.z.abs())
}

/// Shallow tufts of fur: waves in unrelated directions, all nearly perpendicular to the direction of the fur,
/// which is back and downwards.
fn fur(point: DVec3) -> f64 {
    const WAVES: [DVec3; 5] = [
        dvec3(-31.0, 67.0, 83.0),
        dvec3(42.0, -61.0, 97.0),
        dvec3(-57.0, 93.0, -38.0),
        dvec3(29.0, -38.0, -112.0),
        dvec3(-49.0, 101.0, 21.0),
    ];
    WAVES.iter().map(|wave| libm::sin(wave.dot(point))).sum::<f64>() * (FUR_HEIGHT / WAVES.len() as f64)
}
