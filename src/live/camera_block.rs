//! The camera's block of scene text.

use crate::scene::Camera;
use glam::DVec3;

/// The block, from which the same camera is read: all digits of its numbers are there.
pub fn camera_block(camera: &Camera) -> String {
    let view = |center, direction, up| {
        format!("    center {}\n    direction {}\n    up {}", Vector(center), Vector(direction), Vector(up))
    };
    match *camera {
        Camera::Orthographic { center, direction, up, size } => {
            format!("OrthographicCamera {{\n{}\n    size {size}\n}}\n", view(center, direction, up))
        }
        Camera::Perspective { center, direction, up, angle } => {
            format!("PerspectiveCamera {{\n{}\n    angle {angle}\n}}\n", view(center, direction, up))
        }
    }
}

struct Vector(DVec3);

impl std::fmt::Display for Vector {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {} {}", self.0.x, self.0.y, self.0.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse_camera;

    #[test]
    fn the_same_camera_is_read_from_its_block() {
        let center = DVec3::new(0.1 + 0.2, -1e-300, 1e9 / 7.0);
        let (direction, up) = (DVec3::new(1e100, 0.0, -1.0 / 3.0), DVec3::new(0.0, 1.0, 5e-324));
        for camera in [
            Camera::Orthographic { center, direction, up, size: 1.0 / 7.0 },
            Camera::Perspective { center, direction, up, angle: 30.000000000000004 },
        ] {
            assert_eq!(parse_camera(&camera_block(&camera)).unwrap(), camera);
        }
    }
}
